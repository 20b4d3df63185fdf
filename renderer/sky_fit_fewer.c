// sky_fit_fewer.c - fewer lights out of many, at once, for drafts: the weakest
// is put into the one that it changes least.  A fit finds better ones.
#include <math.h>
#include <string.h>

#include "renderer/sky.h"

static double energy_of(const struct sky_light *l)
{
    return (l->radiance[0] + l->radiance[1] + l->radiance[2]) *
           sky_lobe_omega(l->lambda);
}

// Length of a lobe's mean direction: coth k - 1 / k, with k = 2 / lambda^2.
static double mean_cosine(double lambda)
{
    const double k = 2 / (lambda * lambda);
    return k < 1e-3 ? k / 3 : 1 / tanh(k) - 1 / k;
}

// Its inverse, to a few percent (Banerjee, Dhillon, Ghosh and Sra 2005, eq 4.4
// for three dimensions).
static double width_of(double r)
{
    const double k = r * (3 - r * r) / fmax(1 - r * r, 1e-9);
    return sqrt(2 / fmax(k, 1e-6));
}

// Ward's criterion (1963): how far the two lie from their mean, by energy.
static double cost(const struct sky_light *weak, const struct sky_light *l)
{
    const double e[2] = {energy_of(weak), energy_of(l)};
    double cosine = 0;
    for (int k = 0; k < 3; k++)
        cosine += weak->direction[k] * l->direction[k];
    const double dw = weak->lambda - l->lambda;
    return e[1] / (e[0] + e[1] + 1e-300) * (1 - cosine + 0.25 * dw * dw);
}

// Energies add up, and so do mean directions, which say the width.
static void merge(struct sky_light *into, const struct sky_light *l)
{
    const double e[2] = {energy_of(into), energy_of(l)}, all = e[0] + e[1];
    const double w[2] = {e[0] / all * mean_cosine(into->lambda),
                         e[1] / all * mean_cosine(l->lambda)};
    double mean[3], r = 0;
    for (int k = 0; k < 3; k++) {
        mean[k] = w[0] * into->direction[k] + w[1] * l->direction[k];
        r += mean[k] * mean[k];
    }
    r = sqrt(r);
    const double omega[2] = {sky_lobe_omega(into->lambda),
                             sky_lobe_omega(l->lambda)};
    if (r > 1e-6) { // else opposite ones: the stronger stays where it is
        into->lambda = width_of(r);
        for (int k = 0; k < 3; k++)
            into->direction[k] = mean[k] / r;
    }
    for (int c = 0; c < 3; c++)
        into->radiance[c] =
            (into->radiance[c] * omega[0] + l->radiance[c] * omega[1]) /
            sky_lobe_omega(into->lambda);
}

static int weakest(const struct sky_fit *f)
{
    int at = 0;
    for (int j = 1; j < f->count; j++)
        if (energy_of(&f->light[j]) < energy_of(&f->light[at]))
            at = j;
    return at;
}

// By falling energy, as a fit has them.
static void sort(struct sky_fit *f)
{
    for (int i = 1; i < f->count; i++) {
        const struct sky_light l = f->light[i];
        const double e = energy_of(&l);
        int j = i;
        for (; j > 0 && energy_of(&f->light[j - 1]) < e; j--)
            f->light[j] = f->light[j - 1];
        f->light[j] = l;
    }
}

void sky_fit_fewer(const struct sky_fit *from, int lights, struct sky_fit *out)
{
    *out = *from;
    while (out->count > lights && out->count > 1) {
        const int weak = weakest(out);
        const struct sky_light l = out->light[weak];
        out->light[weak] = out->light[--out->count];
        int best = 0;
        for (int j = 1; j < out->count; j++)
            if (cost(&l, &out->light[j]) < cost(&l, &out->light[best]))
                best = j;
        if (energy_of(&l) > 0)
            merge(&out->light[best], &l);
    }
    sort(out);
}
