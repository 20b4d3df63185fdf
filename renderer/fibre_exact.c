// fibre_exact.c - N_t at one azimuth: R in closed form, TT by its one root, TRT
// as an integral over h, because it is smoothed by w_c.
#include <math.h>
#include <stdbool.h>
#include <string.h>

#include "renderer/exact.h"
#include "renderer/fibre_private.h"
#include "renderer/quadrature.h"

static const double pi = 3.14159265358979323846;
#define REACH 4.8 // Xu widths at which the smoothing lobe is below 1e-10

// h = -sin(phi/2): one root for every phi.
void fibre_exact_r(const struct fibre_section *s, double phi, double n[3])
{
    const double c = fabs(cos(phi / 2));
    n[0] = n[1] = n[2] = exact_fresnel(s->eta, s->cos_d * c) * c / 4;
}

// 2 gamma - 2 asin(sin gamma / eta') = |phi - pi| rises from 0 to the last
// azimuth that refracted light reaches.
void fibre_exact_tt(const struct fibre_section *s, double phi, double n[3])
{
    const double away = fabs(remainder(phi - pi, 2 * pi));
    const double most = pi - 2 * asin(1 / s->path);
    n[0] = n[1] = n[2] = 0;
    if (away >= most)
        return;
    double lo = 0, hi = pi / 2, g = hi * (1 - sqrt(1 - away / most));
    for (int i = 0; i < 60; i++) {
        const double x = sin(g) / s->path;
        const double off = 2 * g - 2 * asin(x) - away;
        *(off > 0 ? &hi : &lo) = g;
        const double slope = 2 - 2 * cos(g) / (s->path * sqrt(1 - x * x));
        double next = g - off / slope;
        if (!(next > lo && next < hi))
            next = (lo + hi) / 2;
        const bool there = fabs(next - g) < 1e-14 * (1 + g);
        g = next;
        if (there)
            break;
    }
    const double x = sin(g) / s->path, c = cos(g);
    const double spread = c / (1 - c / (s->path * sqrt(1 - x * x))) / 4;
    fibre_section_carry(s, 1, g, n);
    for (int k = 0; k < 3; k++)
        n[k] *= spread;
}

// --- TRT: 1/2 Int A(h) g(phi - phi(h)) dh, h = sin gamma --------------------

static double kernel(double kappa, double x)
{
    const double sn = sin(x / 2);
    return exp(-2 * kappa * sn * sn);
}

static double kernel_norm(double kappa)
{
    return 1 / (2 * pi * exact_i0e(kappa));
}

struct smoothed { // what the panels of one azimuth share
    const struct fibre_section *s;
    double phi, width, kappa;
    double *n;
};

// from..to: within it phi(h) is monotone; a, b: phi(h) at its ends.
static void panel(const struct smoothed *m, const double gamma[2],
                  const double turn[2], int depth)
{
    const double mid = (gamma[0] + gamma[1]) / 2, half = mid - gamma[0];
    const double centre = (turn[0] + turn[1]) / 2;
    const double span = fabs(turn[1] - turn[0]), w = m->width;
    double off[2];
    bool near = false;
    for (int side = 0; side < 2; side++) { // h and -h
        off[side] = remainder(m->phi + (side ? centre : -centre), 2 * pi);
        near |= fabs(off[side]) - span / 2 < REACH * w;
    }
    if (!near)
        return;
    if (depth > 0 && (span > 1.5 * w || half > 0.2)) {
        const double at = fibre_section_turn(m->s, 2, mid);
        panel(m, (double[2]){gamma[0], mid}, (double[2]){turn[0], at},
              depth - 1);
        panel(m, (double[2]){mid, gamma[1]}, (double[2]){at, turn[1]},
              depth - 1);
        return;
    }
    for (int i = 0; i < 8; i++) {
        const double g = mid + (i < 4 ? half : -half) * quadrature_x[i % 4];
        const double t = fibre_section_turn(m->s, 2, g);
        const double lobe =
            kernel(m->kappa, m->phi - t) + kernel(m->kappa, m->phi + t);
        double a[3];
        fibre_section_carry(m->s, 2, g, a);
        for (int c = 0; c < 3; c++)
            m->n[c] += quadrature_w[i % 4] * half * cos(g) * lobe * a[c];
    }
}

void fibre_exact_trt(const struct fibre_section *s, double phi, double n[3])
{
    const double w = s->spec->w_c;
    const struct smoothed m = {s, phi, w, 2 / (w * w), n};
    const double scale = kernel_norm(m.kappa) / 2;
    double fold = pi / 2;
    if (s->path < 2)
        fold = asin(sqrt((4 - s->path * s->path) / 3));
    const double turn[3] = {fibre_section_turn(s, 2, 0),
                            fibre_section_turn(s, 2, fold),
                            fibre_section_turn(s, 2, pi / 2)};
    n[0] = n[1] = n[2] = 0;
    panel(&m, (double[2]){0, fold}, turn, 20);
    if (fold < pi / 2)
        panel(&m, (double[2]){fold, pi / 2}, turn + 1, 20);
    for (int c = 0; c < 3; c++)
        n[c] *= scale;
}

// Deposits one offset's light, and its mirror image's, on the grid.
static void deposit(double *row, int columns, double kappa, double reach,
                    double turn, const double a[3])
{
    const double step = pi / columns;
    for (int side = -1; side <= 1; side += 2) {
        const double at = remainder(side * turn, 2 * pi);
        int first = (int)ceil((at - reach) / step);
        int last = (int)floor((at + reach) / step);
        if (last - first >= 2 * columns) { // a wide lobe goes round once
            first = -columns;
            last = columns - 1;
        }
        for (int k = first; k <= last; k++) {
            int j = k % (2 * columns);
            j = j < 0 ? j + 2 * columns : j;
            if (j > columns)
                continue; // the function is even: the other side has it
            const double lobe = kernel(kappa, k * step - at);
            for (int c = 0; c < 3; c++)
                row[3 * j + c] += lobe * a[c];
        }
    }
}

void fibre_exact_row(const struct fibre_section *s, int columns, double *row)
{
    const double w = s->spec->w_c, kappa = 2 / (w * w);
    memset(row, 0, 3 * ((size_t)columns + 1) * sizeof *row);
    // |dphi/dgamma| <= 2: a panel covers at most two widths of the lobe
    const int panels = 16 + (int)(pi / (2 * w));
    const double half = pi / 4 / panels, norm = kernel_norm(kappa) / 2;
    for (int i = 0; i < 8 * panels; i++) {
        const int k = i % 8;
        const double x = k < 4 ? quadrature_x[k] : -quadrature_x[k - 4];
        const double g = half * (2 * (i / 8) + 1 + x);
        double a[3];
        fibre_section_carry(s, 2, g, a);
        for (int c = 0; c < 3; c++)
            a[c] *= quadrature_w[k % 4] * half * cos(g) * norm;
        deposit(row, columns, kappa, fmin(REACH * w, pi),
                fibre_section_turn(s, 2, g), a);
    }
}
