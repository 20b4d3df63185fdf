// fibre_section.c - rays through the cross section of a fibre: where they go,
// and what is left of them.
#include <math.h>

#include "renderer/exact.h"
#include "renderer/fibre_private.h"

static const double pi = 3.14159265358979323846;
static const double least_index = 1 + 1e-6; // a < .71 only: eta* below 1

static double bravais(double eta, double sin2, double cos_d)
{
    return sqrt(eta * eta - sin2) / cos_d;
}

void fibre_section_at(const struct fibre_spec *s, double theta_d, double eta,
                      double path, struct fibre_section *out)
{
    const double sn = sin(theta_d), sin2 = sn * sn;
    out->spec = s;
    out->eta = fmax(eta, least_index);
    out->cos_d = fmax(cos(theta_d), 1e-9);
    out->path = bravais(fmax(path, least_index), sin2, out->cos_d);
    out->real = bravais(out->eta, sin2, out->cos_d);
    for (int c = 0; c < 3; c++)
        out->sigma[c] = s->sigma_a[c] / sqrt(1 - sin2 / (out->eta * out->eta));
}

double fibre_section_turn(const struct fibre_section *s, int p, double gamma)
{
    const double inside = p ? asin(sin(gamma) / s->path) : 0;
    return 2 * p * inside - 2 * gamma + pi * p;
}

void fibre_section_carry(const struct fibre_section *s, int p, double gamma,
                         double a[3])
{
    const double f = exact_fresnel(s->eta, s->cos_d * cos(gamma));
    if (p == 0) {
        a[0] = a[1] = a[2] = f;
        return;
    }
    const double x = sin(gamma) / s->real, length = 2 * p * sqrt(1 - x * x);
    const double in = (1 - f) * (1 - f) * (p == 2 ? f : 1);
    for (int c = 0; c < 3; c++)
        a[c] = in * exp(-s->sigma[c] * length);
}

double fibre_section_index(const struct fibre_spec *s, double twice)
{
    if (s->a == 1)
        return s->eta;
    const double aa = s->a * s->a, swing = 2 * (s->eta - 1);
    const double e1 = swing * aa - s->eta + 2, e2 = swing / aa - s->eta + 2;
    return (e1 + e2 + cos(twice) * (e1 - e2)) / 2;
}
