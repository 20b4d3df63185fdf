// fibre_marschner.c - N as the practical model of Marschner 2003, section 5,
// has it: paths by a cubic in place of Snell's law, caustics taken out and
// replaced by lobes.  What is corrected is listed in docs/METHODS.md.
#include <math.h>
#include <string.h>

#include "renderer/fibre_private.h"

static const double pi = 3.14159265358979323846;

struct cubic { // phi(gamma) - p pi = linear gamma - third gamma^3 (eq 10)
    double linear, third;
};

static struct cubic cubic_of(int p, double index)
{
    const double c = asin(1 / index);
    return (struct cubic){6 * p * c / pi - 2, 8 * p * c / (pi * pi * pi)};
}

// Real roots of linear x - third x^3 = y, third > 0.
static int roots_of(const struct cubic *q, double y, double x[3])
{
    const double b = -q->linear / q->third, d = y / q->third; // x^3 + b x + d
    const double disc = d * d / 4 + b * b * b / 27;
    if (disc >= 0) {
        const double r = sqrt(disc), s = d > 0 ? -d / 2 - r : -d / 2 + r;
        const double u = cbrt(s); // the sum that does not cancel
        x[0] = u != 0 ? u - b / (3 * u) : 0;
        return 1;
    }
    const double m = 2 * sqrt(-b / 3);
    const double t = acos(fmin(fmax(3 * d / (b * m), -1), 1)) / 3;
    for (int i = 0; i < 3; i++)
        x[i] = m * cos(t - 2 * pi * i / 3);
    return 3;
}

// N_p of eq 8 at the roots of eq 10, the slope that of eq 10 as well: with eq
// 3's the poles would lie elsewhere than where roots appear.
static void path_sum(const struct fibre_section *s, int p, double phi,
                     double n[3])
{
    const struct cubic q = cubic_of(p, s->path);
    n[0] = n[1] = n[2] = 0;
    for (int turn = -2; turn <= 2; turn++) {
        const double y = remainder(phi - p * pi, 2 * pi) + 2 * pi * turn;
        double x[3] = {-y / 2, 0, 0}, a[3];
        const int count = p ? roots_of(&q, y, x) : 1;
        for (int i = 0; i < count; i++) {
            if (!(fabs(x[i]) <= pi / 2))
                continue;
            const double slope = fabs(q.linear - 3 * q.third * x[i] * x[i]);
            const double spread = cos(x[i]) / (2 * fmax(slope, 1e-12));
            fibre_section_carry(s, p, x[i], a);
            for (int c = 0; c < 3; c++)
                n[c] += a[c] * spread;
        }
    }
}

struct glints { // of one cross section (section 5.2.2)
    double phi_c, dh, t, a[3];
};

static struct glints glints_of(const struct fibre_section *s, double width)
{
    const struct fibre_spec *f = s->spec;
    struct glints g = {0, f->delta_h_m, 1, {0, 0, 0}};
    double h = 0;
    if (s->path < 2) {
        const double z = (4 - s->path * s->path) / 3; // h_c^2, eq 4
        const struct cubic q = cubic_of(2, s->path);
        const double fold = sqrt(q.linear / (3 * q.third));
        h = sqrt(z);
        g.phi_c = fold * (q.linear - q.third * fold * fold);
        const double bend =
            h * (4 * pow(s->path * s->path - z, -1.5) - 2 * pow(1 - z, -1.5));
        g.dh = fmin(f->delta_h_m, 2 * sqrt(2 * width / fabs(bend)));
    } else { // smoothstep, 1 before the range and 0 behind it
        const double x = fmin((s->path - 2) / f->delta_eta, 1);
        g.t = 1 - x * x * (3 - 2 * x);
    }
    fibre_section_carry(s, 2, asin(h), g.a);
    return g;
}

static void trt(const struct fibre_section *s, double phi, double n[3])
{
    const double width = s->spec->w_c / sqrt(2); // a standard deviation there
    const struct glints g = glints_of(s, width);
    double keep = 1, add = 0;
    path_sum(s, 2, phi, n);
    for (int side = -1; side <= 1; side += 2) {
        const double x = remainder(phi + side * g.phi_c, 2 * pi) / width;
        const double lobe = exp(-x * x / 2);
        keep *= 1 - g.t * lobe;
        add += lobe / (sqrt(2 * pi) * width);
    }
    for (int c = 0; c < 3; c++)
        n[c] = n[c] * keep + g.t * s->spec->k_g * g.a[c] * g.dh * add;
}

void fibre_marschner(const struct fibre_spec *f, double theta_d, double phi,
                     double twice, double n[FIBRE_MODES][3])
{
    struct fibre_section s;
    fibre_section_at(f, theta_d, f->eta, f->eta, &s);
    path_sum(&s, 0, phi, n[FIBRE_R]);
    path_sum(&s, 1, phi, n[FIBRE_TT]);
    const double star = fibre_section_index(f, twice);
    if (f->a != 1)
        fibre_section_at(f, theta_d, star, star, &s);
    trt(&s, phi, n[FIBRE_TRT]);
}
