// fibre_draw.c - directions drawn from a fibre's lobes.  A mode by its share of
// the light, theta_i from its Gaussian cut at +-pi/2, phi from a histogram of
// N at theta_d.  What is drawn from is not quite S, but its density is known
// exactly, so that weights make up for it.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "protocol/bytes.h"
#include "renderer/fibre_private.h"
#include "renderer/shoot_threads.h"

static const double pi = 3.14159265358979323846;
// Share of phi that is drawn evenly: no azimuth may have a density of nothing.
#define EVEN 0.02
// A Gaussian of which less than this lies within +-pi/2 is left out.
#define NOTHING 1e-14

// --- tables -----------------------------------------------------------------

static double *row_of(const struct fibre *f, double *table, int mode, int row)
{
    return table + ((size_t)mode * (size_t)f->draw_rows + (size_t)row) *
                       (size_t)f->bins;
}

static void take_bin(const struct fibre *f, double theta_d, int bin,
                     double sum[FIBRE_MODES])
{
    const int turns = f->spec.a == 1 ? 1 : 4;
    for (int k = 0; k < 2; k++)
        for (int j = 0; j < turns; j++) {
            double n[FIBRE_MODES][3];
            fibre_azimuth(f, theta_d, pi * (bin + 0.25 + 0.5 * k) / f->bins,
                          2 * pi * (j + 0.5) / turns, n);
            for (int t = 0; t < FIBRE_MODES; t++)
                for (int c = 0; c < 3; c++)
                    sum[t] += n[t][c];
        }
}

static void draw_row(void *context, size_t r)
{
    struct fibre *f = context;
    const int row = (int)r, bins = f->bins;
    const double td = fmin(pi / 2 * row / (f->draw_rows - 1), pi / 2 - 1e-4);
    for (int b = 0; b < bins; b++) {
        double sum[FIBRE_MODES] = {0};
        take_bin(f, td, b, sum);
        for (int t = 0; t < FIBRE_MODES; t++)
            row_of(f, f->density, t, row)[b] = sum[t];
    }
    for (int t = 0; t < FIBRE_MODES; t++) {
        double *density = row_of(f, f->density, t, row), all = 0, before = 0;
        for (int b = 0; b < bins; b++)
            all += density[b];
        for (int b = 0; b < bins; b++) {
            const double p = all > 0 ? density[b] / all * bins : 1;
            density[b] = ((1 - EVEN) * p + EVEN) / pi;
            row_of(f, f->below, t, row)[b] = before;
            before += density[b] * pi / bins;
        }
    }
}

static void albedo_row(void *context, size_t i)
{
    struct fibre *f = context;
    fibre_albedo(f, pi * ((double)i / FIBRE_ALBEDOS - 0.5), f->albedo[i]);
}

void fibre_draw_make(struct fibre *f)
{
    const double w = f->spec.w_c;
    // an elliptic fibre's TRT is a mean over its turns, which are broad
    const bool round = f->spec.a == 1;
    f->bins = (int)fmin(fmax(ceil(4 * pi / w), 256), round ? 1024 : 256);
    f->draw_rows = 1 + (int)fmin(fmax(ceil(2 * pi / w), 32), round ? 128 : 32);
    const size_t size =
        (size_t)FIBRE_MODES * (size_t)f->draw_rows * (size_t)f->bins;
    f->density = bytes_alloc(size * sizeof *f->density);
    f->below = bytes_alloc(size * sizeof *f->below);
    f->albedo = bytes_alloc((FIBRE_ALBEDOS + 1) * sizeof *f->albedo);
    shoot_threads((size_t)f->draw_rows, draw_row, f);
    shoot_threads(FIBRE_ALBEDOS + 1, albedo_row, f);
}

// --- the Gaussian of theta_i ------------------------------------------------

static double beyond(double z) // of the normal distribution
{
    return erfc(z / sqrt(2)) / 2;
}

static double between(double a, double b)
{
    return a > 0 ? beyond(a) - beyond(b) : beyond(-b) - beyond(-a);
}

// z in [a, b] below which the share u of the normal distribution's part in
// [a, b] lies: Newton's steps from where they cannot overshoot, bounded.
static double within(double a, double b, double u)
{
    if (b < 0)
        return -within(-b, -a, 1 - u);
    const double want = beyond(a) - u * (beyond(a) - beyond(b));
    double lo = a, hi = b, z = fmax(a, 0);
    for (int i = 0; i < 100 && hi - lo > 1e-13; i++) {
        const double off = beyond(z) - want;
        *(off > 0 ? &lo : &hi) = z;
        double next = z + off * sqrt(2 * pi) * exp(z * z / 2);
        if (!(next > lo && next < hi))
            next = (lo + hi) / 2;
        const bool there = fabs(next - z) < 1e-13;
        z = next;
        if (there)
            break;
    }
    return z;
}

// --- drawing ----------------------------------------------------------------

void fibre_look(const struct fibre *f, const struct fibre_direction *o,
                const double weight[3], struct fibre_view *v)
{
    const double x = fmin(fmax(o->theta / pi + 0.5, 0), 1) * FIBRE_ALBEDOS;
    const int i = (int)fmin(x, FIBRE_ALBEDOS - 1);
    double all = 0;
    v->o = *o;
    for (int t = 0; t < FIBRE_MODES; t++) {
        const double dev = 2 * f->spec.beta[t];
        v->centre[t] = 2 * f->spec.alpha[t] - o->theta;
        v->low[t] = (-pi / 2 - v->centre[t]) / dev;
        v->high[t] = (pi / 2 - v->centre[t]) / dev;
        v->mass[t] = between(v->low[t], v->high[t]);
        v->share[t] = 0;
        if (v->mass[t] < NOTHING)
            continue;
        for (int c = 0; c < 3; c++)
            v->share[t] +=
                weight[c] *
                (f->albedo[i][t][c] +
                 (x - i) * (f->albedo[i + 1][t][c] - f->albedo[i][t][c]));
        all += v->share[t];
    }
    for (int t = 0; t < FIBRE_MODES; t++)
        v->share[t] = all > 0 ? v->share[t] / all : 0;
}

// The two rows about theta_d; returns how much of the second.
static double rows_at(const struct fibre *f, double theta_d, int *row)
{
    const double y = fmin(fabs(theta_d) / (pi / 2), 1) * (f->draw_rows - 1);
    *row = (int)fmin(y, f->draw_rows - 2);
    return y - *row;
}

// |phi| of mode t from a row's histogram.
static double draw_phi(const struct fibre *f, int t, int row, double u)
{
    const double *below = row_of(f, f->below, t, row);
    int lo = 0, hi = f->bins;
    while (hi - lo > 1) {
        const int mid = (lo + hi) / 2;
        *(below[mid] <= u ? &lo : &hi) = mid;
    }
    const double density = row_of(f, f->density, t, row)[lo];
    const double inside = fmin((u - below[lo]) / density, pi / f->bins);
    return pi * lo / f->bins + inside;
}

bool fibre_sample(const struct fibre *f, const struct fibre_view *v,
                  const double u[3], struct fibre_direction *i)
{
    double pick = u[0];
    int t = 0, row;
    while (t < FIBRE_MODES && !(pick < v->share[t]))
        pick -= v->share[t++];
    if (t == FIBRE_MODES) { // rounding, or nothing at all
        for (t = FIBRE_MODES - 1; t >= 0 && !(v->share[t] > 0);)
            t--;
        if (t < 0)
            return false;
        pick = 0.5 * v->share[t];
    }
    const double z = within(v->low[t], v->high[t], pick / v->share[t]);
    i->theta = v->centre[t] + 2 * f->spec.beta[t] * z;
    i->theta = fmin(fmax(i->theta, -pi / 2), pi / 2);
    const double part = rows_at(f, (v->o.theta - i->theta) / 2, &row);
    double at = u[1];
    if (at < part) {
        row++;
        at /= part;
    } else {
        at = (at - part) / (1 - part);
    }
    const double phi = draw_phi(f, t, row, at);
    i->phi = v->o.phi + (u[2] < 0.5 ? phi : -phi);
    return true;
}

double fibre_pdf(const struct fibre *f, const struct fibre_view *v,
                 const struct fibre_direction *i)
{
    const double ci = cos(i->theta);
    const double phi = fabs(remainder(v->o.phi - i->phi, 2 * pi));
    const int bin = (int)fmin(phi / pi * f->bins, f->bins - 1);
    double sum = 0;
    int row;
    const double part = rows_at(f, (v->o.theta - i->theta) / 2, &row);
    if (!(ci > 0))
        return 0;
    for (int t = 0; t < FIBRE_MODES; t++) {
        if (!(v->share[t] > 0))
            continue;
        const double dev = 2 * f->spec.beta[t];
        const double z = (i->theta - v->centre[t]) / dev;
        const double p = exp(-z * z / 2) / (sqrt(2 * pi) * dev * v->mass[t]);
        const double q = (1 - part) * row_of(f, f->density, t, row)[bin] +
                         part * row_of(f, f->density, t, row + 1)[bin];
        sum += v->share[t] * p * q / 2;
    }
    return sum / ci;
}
