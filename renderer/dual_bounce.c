// dual_bounce.c - weights over the inclination, and sums with them.
#include "renderer/dual_bounce.h"

#include <math.h>

static const double pi = 3.14159265358979323846;

enum { NODES = DUAL_BOUNCE_NODES, ENERGIES = DUAL_BOUNCE_ENERGIES };

const int dual_bounce_channels[3][2] = {
    {DUAL_R, DUAL_TT}, {DUAL_TT, DUAL_TRT}, {DUAL_TRT, DUAL_CHANNELS}};

// Eq 32, 33 unseparated: Int M_t(theta_o) cos cos / cos^2 theta_d E dtheta_o.
// x is theta_o's distance from the end where the specular cone goes; at grazing
// light the cosines make a peak as wide as the light's distance e from pi/2,
// which x = e (exp(u) - 1) spreads out.
void dual_bounce_weigh(struct dual_bounce *b,
                       const struct dual_bounce_rule *rule, double theta,
                       const struct dual_bounce_lobe *lobe)
{
    double side = theta < 0 ? -1 : 1, e = pi / 2 - fabs(theta);
    double width = 2 * lobe->beta, mu = e + 2 * side * lobe->alpha;
    double lo = fmax(mu - 4.7 * width, 0), hi = fmin(mu + 4.7 * width, pi);
    b->count = lo < hi ? NODES : 0;
    if (b->count == 0)
        return;
    double u0 = log1p(lo / e), span = log1p(hi / e) - u0;
    for (int i = 0; i < NODES; i++) {
        double x = e * expm1(u0 + span * rule->x[i]), z = (x - mu) / width;
        double c = sin((x + e) / 2);
        double weight = rule->w[i] * span * (x + e) * exp(-z * z / 2) /
                        (width * sqrt(2 * pi)) * sin(x) * sin(e);
        // Channels but R's hold E / cos^2.
        b->cosine[i] = c;
        b->weight[i] = lobe->mode == 0 ? weight / (c * c) : weight;
    }
}

void dual_bounce_energy(const struct dual_azimuth *z, int i,
                        struct dual_energy *out)
{
    dual_azimuth_energy(z, fmax((double)i / ENERGIES, 1e-6), out);
}

// Adds weight * energy(cos_d) of these channels; parabolas through three.
static void add_energy(const struct dual_energy *energy, double cos_d,
                       double weight, const int channels[2],
                       struct dual_energy *s)
{
    double at = fmin(fmax(cos_d, 0), 1) * ENERGIES;
    int i = (int)(at + 0.5);
    i = i < 1 ? 1 : i > ENERGIES - 1 ? ENERGIES - 1 : i;
    double x = at - i, a = weight * x * (x - 1) / 2, b = weight * (1 - x * x),
           c = weight * x * (x + 1) / 2;
    const struct dual_energy *e = energy + i;
    for (int k = channels[0]; k < channels[1]; k++) {
        s->ahead[k] +=
            a * e[-1].ahead[k] + b * e[0].ahead[k] + c * e[1].ahead[k];
        s->all[k] += a * e[-1].all[k] + b * e[0].all[k] + c * e[1].all[k];
    }
}

void dual_bounce_add(const struct dual_bounce *b, int mode,
                     const struct dual_energy energy[DUAL_BOUNCE_ENERGIES + 1],
                     struct dual_energy *s)
{
    const int *channels = dual_bounce_channels[mode];
    for (int k = channels[0]; k < channels[1]; k++)
        s->ahead[k] = s->all[k] = 0;
    for (int i = 0; i < b->count; i++)
        add_energy(energy, b->cosine[i], b->weight[i], channels, s);
}
