// sky_shading.c - see the header.  R is in closed form; TT and TRT come from
// tables that are made by following many offsets h through the fibre
// (Marschner 2003, sections 4 and 5), smoothed by w_c.  The lights are summed
// over the same texels as the sky; narrow ones over points of their own.
#include "tests/numeric/sky_shading.h"

#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "renderer/sky_clean.h"
#include "renderer/sky_fit_target.h"

enum { THETAS = 48, PHIS = 180, OFFSETS = 20000, LOBES = 3 };

static const double pi = 3.14159265358979323846;
static const double eta = 1.55, sigma[3] = {0.15, 0.25, 0.45};
static const double alpha[LOBES] = {-7.5, 3.75, 11.25}; // degrees
static const double beta[LOBES] = {7.5, 3.75, 15};      // degrees, of theta_h

static double table[LOBES][THETAS][PHIS + 1][3];

static double fresnel(double c)
{
    double q = sqrt(eta * eta - 1 + c * c);
    double s = (c - q) / (c + q), p = (eta * eta * c - q) / (eta * eta * c + q);
    return 0.5 * (s * s + p * p);
}

// One offset: azimuth and attenuation of each lobe into the histograms.
static void deposit(int row, double theta, double h)
{
    double c = cos(theta), sn = sin(theta);
    double ep = sqrt(eta * eta - sn * sn) / c;
    double gi = asin(h), gt = asin(h / ep);
    double f = fresnel(c * sqrt(1 - h * h));
    double length = 2 * cos(gt) / sqrt(1 - sn * sn / (eta * eta));
    for (int p = 0; p < LOBES; p++) {
        double phi = 2 * p * gt - 2 * gi + p * pi;
        phi = fabs(remainder(phi, 2 * pi));
        double at = phi / pi * PHIS;
        int i = (int)at;
        double part = at - i;
        for (int k = 0; k < 3; k++) {
            double t = exp(-sigma[k] * length);
            double a =
                p == 0 ? f : (1 - f) * (1 - f) * (p == 1 ? t : t * t * f);
            double w = 0.5 * a / OFFSETS; // h in [0, 1]: both signs fold
            table[p][row][i][k] += w * (1 - part);
            if (i < PHIS)
                table[p][row][i + 1][k] += w * part;
        }
    }
}

// Histogram -> density, blurred: TT by 2 degrees, TRT by w_c = 10.
static void smooth(int p, int row)
{
    double width = (p == 2 ? 10 : 2) * pi / 180, old[PHIS + 1][3];
    double step = pi / PHIS;
    memcpy(old, table[p][row], sizeof old);
    memset(table[p][row], 0, sizeof old);
    for (int i = 0; i <= PHIS; i++)
        for (int k = 0; k < 3; k++) {
            double sum = 0;
            for (int j = -PHIS; j < PHIS; j++) {
                double d = remainder((i - j) * step, 2 * pi) / width;
                double mass = old[abs(j)][k];
                // The ends hold what fell on both sides of them.
                mass *= j == 0 || j == -PHIS ? 2 : 1;
                sum += mass * exp(-d * d);
            }
            table[p][row][i][k] = sum / (sqrt(pi) * width);
        }
}

static void make_tables(void)
{
    static bool made;
    if (made)
        return;
    made = true;
    for (int row = 0; row < THETAS; row++) {
        double theta = 0.5 * pi * row / THETAS;
        for (int i = 0; i < OFFSETS; i++)
            deposit(row, theta, (i + 0.5) / OFFSETS);
        smooth(1, row);
        smooth(2, row);
    }
}

struct frame {
    double u[3], v[3], w[3]; // tangent, and two across
    double theta, phi;       // of the eye
};

// S times the cosine of the light (Marschner 2003, eqs 1 and 8, in the form
// whose integral over theta_i is 1).
static void scatter(const struct frame *f, const double d[3], double out[3])
{
    double s = d[0] * f->u[0] + d[1] * f->u[1] + d[2] * f->u[2];
    double x = d[0] * f->v[0] + d[1] * f->v[1] + d[2] * f->v[2];
    double y = d[0] * f->w[0] + d[1] * f->w[1] + d[2] * f->w[2];
    double theta = asin(fmax(-1, fmin(1, s))), half = 0.5 * (f->theta - theta);
    double phi = fabs(remainder(f->phi - atan2(y, x), 2 * pi));
    double a = fabs(half) / (0.5 * pi) * THETAS, b = phi / pi * PHIS;
    int i = a < THETAS - 1 ? (int)a : THETAS - 2;
    int j = b < PHIS ? (int)b : PHIS - 1;
    double ca = cos(half), front = cos(theta) / (ca * ca);
    a -= i;
    b -= j;
    out[0] = out[1] = out[2] = 0;
    for (int p = 0; p < LOBES; p++) {
        double dev = 2 * beta[p] * pi / 180;
        double off = (theta - 2 * alpha[p] * pi / 180 + f->theta) / dev;
        double m = front * exp(-0.5 * off * off) / (sqrt(2 * pi) * dev);
        if (p == 0) {
            double c = cos(0.5 * phi), n = 0.25 * c * fresnel(ca * c);
            for (int k = 0; k < 3; k++)
                out[k] += m * n;
            continue;
        }
        for (int k = 0; k < 3; k++)
            out[k] += m * ((1 - a) * ((1 - b) * table[p][i][j][k] +
                                      b * table[p][i][j + 1][k]) +
                           a * ((1 - b) * table[p][i + 1][j][k] +
                                b * table[p][i + 1][j + 1][k]));
    }
}

struct source { // of light: direction, radiance times solid angle
    double d[3], e[3];
};

static void texel_direction(const struct sky_fit_target *t, size_t i,
                            double d[3])
{
    double own[3] = {t->direction[0][i], t->direction[1][i],
                     t->direction[2][i]};
    sky_fit_target_to_map(t, own, d);
}

// The map's energy, as the fit's own splat has it.
static size_t map_sources(const struct sky_map *map, struct sky_fit_target *t,
                          struct source **out)
{
    sky_fit_target_init(t, map, 1, SKY_FIT_PLAIN);
    *out = bytes_zalloc(t->count, sizeof **out);
    for (size_t i = 0; i < t->count; i++) {
        texel_direction(t, i, (*out)[i].d);
        for (int k = 0; k < 3; k++)
            (*out)[i].e[k] = t->black ? 0 : t->value[k][i] * t->root[i];
    }
    return t->count;
}

// Exact for polynomials of degree 3 in (r / lambda)^2 over the plane.
static size_t narrow_sources(const struct sky_light *l, struct source *out)
{
    static const double node[2] = {0.58578643762690485, 3.4142135623730949};
    static const double weight[2] = {0.85355339059327373, 0.14644660940672624};
    double a[3] = {0}, b[3], n = 0;
    const double *c = l->direction;
    a[fabs(c[0]) < 0.6 ? 0 : 1] = 1;
    double along = a[0] * c[0] + a[1] * c[1];
    for (int k = 0; k < 3; k++) {
        a[k] -= along * c[k];
        n += a[k] * a[k];
    }
    for (int k = 0; k < 3; k++)
        a[k] /= sqrt(n);
    for (int k = 0; k < 3; k++)
        b[k] =
            c[(k + 1) % 3] * a[(k + 2) % 3] - c[(k + 2) % 3] * a[(k + 1) % 3];
    size_t count = 0;
    for (int r = 0; r < 2; r++)
        for (int s = 0; s < 8; s++, count++) {
            double angle = l->lambda * sqrt(node[r]), turn = pi / 4 * s;
            for (int k = 0; k < 3; k++) {
                out[count].d[k] =
                    cos(angle) * c[k] +
                    sin(angle) * (cos(turn) * a[k] + sin(turn) * b[k]);
                out[count].e[k] =
                    l->radiance[k] * sky_lobe_omega(l->lambda) * weight[r] / 8;
            }
        }
    return count;
}

static size_t fit_sources(const struct sky_fit *fit,
                          const struct sky_fit_target *t, struct source **out)
{
    size_t count = t->count;
    *out = bytes_zalloc(count + 16 * SKY_LIGHTS_MAX, sizeof **out);
    struct sky_fit wide = *fit;
    wide.count = 0;
    for (int j = 0; j < fit->count; j++)
        if (fit->light[j].lambda < 0.15) // three texels
            count += narrow_sources(&fit->light[j], *out + count);
        else
            wide.light[wide.count++] = fit->light[j];
    for (size_t i = 0; i < t->count; i++) {
        struct source *s = *out + i;
        texel_direction(t, i, s->d);
        sky_fit_eval(&wide, s->d, s->e);
        for (int k = 0; k < 3; k++)
            s->e[k] *=
                sky_clean_solid_angle((int)i / t->width, t->width, t->height);
    }
    return count;
}

static double random01(uint64_t *state)
{
    *state = *state * 6364136223846793005u + 1442695040888963407u;
    return (double)(*state >> 11) * 0x1p-53;
}

static void random_unit(uint64_t *state, double out[3])
{
    double z = 2 * random01(state) - 1, phi = 2 * pi * random01(state);
    out[0] = sqrt(1 - z * z) * cos(phi);
    out[1] = sqrt(1 - z * z) * sin(phi);
    out[2] = z;
}

static struct frame random_frame(uint64_t *state)
{
    struct frame f;
    double other[3], dot = 0, n = 0;
    random_unit(state, f.u);
    random_unit(state, other);
    for (int k = 0; k < 3; k++)
        dot += f.u[k] * other[k];
    for (int k = 0; k < 3; k++) {
        f.v[k] = other[k] - dot * f.u[k];
        n += f.v[k] * f.v[k];
    }
    for (int k = 0; k < 3; k++)
        f.v[k] /= sqrt(n);
    for (int k = 0; k < 3; k++)
        f.w[k] = f.u[(k + 1) % 3] * f.v[(k + 2) % 3] -
                 f.u[(k + 2) % 3] * f.v[(k + 1) % 3];
    f.theta = asin(2 * random01(state) - 1);
    f.phi = 0; // v is random already
    return f;
}

static void shade(const struct frame *f, const struct source *s, size_t count,
                  double out[3])
{
    out[0] = out[1] = out[2] = 0;
    for (size_t i = 0; i < count; i++) {
        double t[3];
        scatter(f, s[i].d, t);
        for (int k = 0; k < 3; k++)
            out[k] += t[k] * s[i].e[k];
    }
}

static int rising(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return x < y ? -1 : x > y;
}

void sky_shading_errors(const struct sky_map *map, const struct sky_fit *fit,
                        int frames, double *sorted)
{
    make_tables();
    struct sky_fit_target t;
    struct source *a, *b;
    size_t na = map_sources(map, &t, &a), nb = fit_sources(fit, &t, &b);
    double(*ref)[3] = bytes_alloc((size_t)frames * sizeof *ref);
    double(*got)[3] = bytes_alloc((size_t)frames * sizeof *got);
    double mean[3] = {0};
    uint64_t state = 7;
    for (int i = 0; i < frames; i++) {
        struct frame f = random_frame(&state);
        shade(&f, a, na, ref[i]);
        shade(&f, b, nb, got[i]);
        for (int k = 0; k < 3; k++)
            mean[k] += ref[i][k] / frames;
    }
    for (int i = 0; i < frames; i++)
        for (int k = 0; k < 3; k++)
            sorted[3 * i + k] =
                fabs(got[i][k] - ref[i][k]) / fmax(ref[i][k], 0.05 * mean[k]);
    qsort(sorted, (size_t)(3 * frames), sizeof *sorted, rising);
    free(ref);
    free(got);
    free(a);
    free(b);
    sky_fit_target_finish(&t);
}
