// fibre.c - S of two directions: the Gaussians of theta here, N from the exact
// roots, a table of TRT or the practical model.
#include "renderer/fibre.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "protocol/bytes.h"
#include "renderer/fibre_private.h"
#include "renderer/shoot_threads.h"

static const double pi = 3.14159265358979323846;
// A Gaussian of theta is nothing beyond so many standard deviations (e^-32).
#define FAR 8.0

void fibre_spec_of(const struct params *p, enum fibre_model model,
                   struct fibre_spec *out)
{
    struct params r = *p;
    params_fibre_resolve(&r);
    const double rad = pi / 180;
    *out = (struct fibre_spec){
        .model = model,
        .eta = (double)r.fibre.eta,
        .a = (double)r.fibre.a,
        .alpha = {(double)r.fibre.alpha_r * rad, (double)r.fibre.alpha_tt * rad,
                  (double)r.fibre.alpha_trt * rad},
        .beta = {(double)r.fibre.beta_r * rad, (double)r.fibre.beta_tt * rad,
                 (double)r.fibre.beta_trt * rad},
        .w_c = (double)r.fibre.w_c * rad,
        .delta_eta = (double)r.fibre.delta_eta,
        .k_g = (double)r.fibre.k_g,
        .delta_h_m = (double)r.fibre.delta_h_m,
    };
    for (int c = 0; c < 3; c++)
        out->sigma_a[c] = (double)r.fibre.sigma_a[c];
}

// --- the table of TRT -------------------------------------------------------

// Cubic Lagrange errs by .023 h^4 f'''', and f'''' of exp(-x^2/w^2) is 12/w^4:
// steps of w/8 leave 7e-5 of the top.  Over theta_d caustics move fastest where
// they merge, by 3/sqrt(eta^2 - 1): steps of w/6 for the usual 2.5.
static void table_size(struct fibre *f)
{
    const double w = f->spec.w_c;
    f->columns = (int)fmin(fmax(ceil(8 * pi / w), 256), 2880);
    const double eta = f->spec.eta;
    const double speed = fmax(1.2 / sqrt(eta * eta - 1), 1);
    f->rows = 1 + (int)fmin(fmax(ceil(3 * pi / w * speed), 128), 1024);
}

static void table_row(void *context, size_t i)
{
    struct fibre *f = context;
    const size_t size = 3 * ((size_t)f->columns + 1);
    // the last row stands for the limit: N / cos^2 is finite there
    const double theta =
        fmin(pi / 2 * (double)i / (f->rows - 1), pi / 2 - 1e-5);
    double *row = bytes_alloc(size * sizeof *row);
    struct fibre_section s;
    fibre_section_at(&f->spec, theta, f->spec.eta, f->spec.eta, &s);
    fibre_exact_row(&s, f->columns, row);
    for (size_t k = 0; k < size; k++)
        f->trt[i * size + k] = (float)(row[k] / (s.cos_d * s.cos_d));
    free(row);
}

static void table_make(struct fibre *f)
{
    if (f->spec.model != FIBRE_EXACT || f->spec.a != 1)
        return;
    table_size(f);
    f->trt = bytes_alloc((size_t)f->rows * 3 * ((size_t)f->columns + 1) *
                         sizeof *f->trt);
    shoot_threads((size_t)f->rows, table_row, f);
}

// Weights of the four nodes at -1, 0, 1, 2 for a place t in [0, 1].
static void lagrange(double t, double w[4])
{
    const double a = t + 1, b = t - 1, c = t - 2;
    w[0] = -t * b * c / 6;
    w[1] = a * b * c / 2;
    w[2] = -a * t * c / 2;
    w[3] = a * t * b / 6;
}

// phi: even about both ends.  theta_d: even about 0; towards pi/2 the last four
// rows serve.
static void table_look(const struct fibre *f, double theta_d, double phi,
                       double n[3])
{
    const int last = f->columns;
    const double x = fabs(remainder(phi, 2 * pi)) / pi * last;
    const double y = fmin(theta_d / (pi / 2), 1) * (f->rows - 1);
    const int ix = (int)fmin(x, last - 1), iy = (int)fmin(y, f->rows - 3);
    double wx[4], wy[4];
    lagrange(x - ix, wx);
    lagrange(y - iy, wy);
    n[0] = n[1] = n[2] = 0;
    for (int r = 0; r < 4; r++) {
        const float *row =
            f->trt + (size_t)abs(iy + r - 1) * 3 * ((size_t)last + 1);
        for (int k = 0; k < 4; k++) {
            int j = abs(ix + k - 1);
            j = j > last ? 2 * last - j : j;
            for (int c = 0; c < 3; c++)
                n[c] += wy[r] * wx[k] * (double)row[3 * j + c];
        }
    }
    for (int c = 0; c < 3; c++)
        n[c] = fmax(n[c], 0);
}

// --- S ----------------------------------------------------------------------

// which: bits of the modes that are wanted.
static void azimuth(const struct fibre *f, const double theta_d_phi_twice[3],
                    unsigned which, double n[FIBRE_MODES][3])
{
    const double td = fabs(theta_d_phi_twice[0]), phi = theta_d_phi_twice[1];
    const double cd = fmax(cos(td), 1e-9), share = 1 / (cd * cd);
    struct fibre_section s;
    memset(n, 0, FIBRE_MODES * sizeof *n);
    if (f->spec.model == FIBRE_MARSCHNER) {
        fibre_marschner(&f->spec, td, phi, theta_d_phi_twice[2], n);
    } else {
        fibre_section_at(&f->spec, td, f->spec.eta, f->spec.eta, &s);
        if (which & 1 << FIBRE_R)
            fibre_exact_r(&s, phi, n[FIBRE_R]);
        if (which & 1 << FIBRE_TT)
            fibre_exact_tt(&s, phi, n[FIBRE_TT]);
        if ((which & 1 << FIBRE_TRT) && !f->trt) {
            const double star =
                fibre_section_index(&f->spec, theta_d_phi_twice[2]);
            fibre_section_at(&f->spec, td, f->spec.eta, star, &s);
            fibre_exact_trt(&s, phi, n[FIBRE_TRT]);
        }
    }
    for (int t = 0; t < FIBRE_MODES; t++)
        for (int c = 0; c < 3; c++)
            n[t][c] *= share;
    if (f->trt && (which & 1 << FIBRE_TRT))
        table_look(f, td, phi, n[FIBRE_TRT]);
}

void fibre_azimuth(const struct fibre *f, double theta_d, double phi,
                   double twice, double n[FIBRE_MODES][3])
{
    azimuth(f, (double[3]){theta_d, phi, twice}, 7, n);
}

void fibre_scatter(const struct fibre *f, const struct fibre_direction *o,
                   const struct fibre_direction *i, double s[FIBRE_MODES][3])
{
    double m[FIBRE_MODES] = {0};
    unsigned which = 0;
    const double ci = cos(i->theta);
    for (int t = 0; t < FIBRE_MODES; t++) {
        const double dev = 2 * f->spec.beta[t];
        const double x = (i->theta + o->theta - 2 * f->spec.alpha[t]) / dev;
        if (!(fabs(x) < FAR) || !(ci > 0))
            continue;
        m[t] = exp(-x * x / 2) / (sqrt(2 * pi) * dev) * ci;
        which |= 1u << t;
    }
    memset(s, 0, FIBRE_MODES * sizeof *s);
    if (!which)
        return;
    const double at[3] = {(o->theta - i->theta) / 2, o->phi - i->phi,
                          o->phi + i->phi};
    azimuth(f, at, which, s);
    for (int t = 0; t < FIBRE_MODES; t++)
        for (int c = 0; c < 3; c++)
            s[t][c] *= m[t];
}

// --- energy -----------------------------------------------------------------

static const double gl_x[8] = {0.0950125098376374, 0.2816035507792589,
                               0.4580167776572274, 0.6178762444026438,
                               0.7554044083550030, 0.8656312023878318,
                               0.9445750230732326, 0.9894009349916499};
static const double gl_w[8] = {0.1894506104550685, 0.1826034150449236,
                               0.1691565193950025, 0.1495959888165767,
                               0.1246289712555339, 0.0951585116824928,
                               0.0622535239386479, 0.0271524594117541};

// Int N dphi = 1/2 Int A dh of the exact model: no root, no smoothing; where
// a != 1 of the mean over phi_o, for paths alone know of a.
static void energy_of_h(const struct fibre_section *s, double e[FIBRE_MODES][3])
{
    enum { PANELS = 6 };
    const double half = pi / 4 / PANELS;
    for (int i = 0; i < 16 * PANELS; i++) {
        const int k = i % 16;
        const double x = k < 8 ? gl_x[k] : -gl_x[k - 8];
        const double g = half * (2 * (i / 16) + 1 + x);
        for (int t = 0; t < FIBRE_MODES; t++) {
            double a[3];
            fibre_section_carry(s, t, g, a);
            for (int c = 0; c < 3; c++)
                e[t][c] += gl_w[k % 8] * half * cos(g) * a[c];
        }
    }
}

// The same by equal steps of phi, for what has no such form.
static void energy_of_phi(const struct fibre *f, double theta_d,
                          double e[FIBRE_MODES][3])
{
    const int phis = 720, turns = f->spec.a == 1 ? 1 : 4;
    for (int i = 0; i < phis; i++)
        for (int j = 0; j < turns; j++) {
            double n[FIBRE_MODES][3];
            fibre_azimuth(f, theta_d, pi * (i + 0.5) / phis,
                          2 * pi * (j + 0.5) / turns, n);
            for (int t = 0; t < FIBRE_MODES; t++)
                for (int c = 0; c < 3; c++)
                    e[t][c] += 2 * pi / phis / turns * n[t][c];
        }
}

static void energy_row(void *context, size_t i)
{
    struct fibre *f = context;
    double(*e)[3] = f->energy[i];
    const double td = fmin(pi / 2 * (double)i / FIBRE_ENERGIES, pi / 2 - 1e-5);
    if (f->spec.model != FIBRE_EXACT) {
        energy_of_phi(f, td, e);
        return;
    }
    struct fibre_section s;
    fibre_section_at(&f->spec, td, f->spec.eta, f->spec.eta, &s);
    energy_of_h(&s, e);
    for (int t = 0; t < FIBRE_MODES; t++)
        for (int c = 0; c < 3; c++)
            e[t][c] /= s.cos_d * s.cos_d;
}

static double energy_at(const struct fibre *f, double theta_d, int t, int c)
{
    const double y = fmin(fabs(theta_d) / (pi / 2), 1) * FIBRE_ENERGIES;
    const int i = (int)fmin(y, FIBRE_ENERGIES - 2);
    double w[4], sum = 0;
    lagrange(y - i, w);
    for (int k = 0; k < 4; k++)
        sum += w[k] * f->energy[abs(i + k - 1)][t][c];
    return fmax(sum, 0);
}

void fibre_albedo(const struct fibre *f, double theta, double a[FIBRE_MODES][3])
{
    enum { PANELS = 8 };
    memset(a, 0, FIBRE_MODES * sizeof *a);
    for (int t = 0; t < FIBRE_MODES; t++) {
        const double dev = 2 * f->spec.beta[t];
        const double centre = 2 * f->spec.alpha[t] - theta;
        const double lo = fmax(-pi / 2, centre - FAR * dev);
        const double hi = fmin(pi / 2, centre + FAR * dev);
        const double half = (hi - lo) / 2 / PANELS;
        for (int i = 0; half > 0 && i < 16 * PANELS; i++) {
            const int k = i % 16;
            const double u = k < 8 ? gl_x[k] : -gl_x[k - 8];
            const double other = lo + half * (2 * (i / 16) + 1 + u);
            const double x = (other - centre) / dev, ci = cos(other);
            const double w = gl_w[k % 8] * half * exp(-x * x / 2) * ci * ci /
                             (sqrt(2 * pi) * dev);
            for (int c = 0; c < 3; c++)
                a[t][c] += w * energy_at(f, (theta - other) / 2, t, c);
        }
    }
}

// --- life -------------------------------------------------------------------

struct fibre *fibre_create(const struct fibre_spec *s)
{
    struct fibre *f = bytes_zalloc(1, sizeof *f);
    f->spec = *s;
    table_make(f);
    f->energy = bytes_zalloc(FIBRE_ENERGIES + 1, sizeof *f->energy);
    shoot_threads(FIBRE_ENERGIES + 1, energy_row, f);
    fibre_draw_make(f);
    return f;
}

void fibre_destroy(struct fibre *f)
{
    if (!f)
        return;
    free(f->trt);
    free(f->energy);
    free(f->density);
    free(f->below);
    free(f->albedo);
    free(f);
}

const struct fibre_spec *fibre_spec(const struct fibre *f)
{
    return &f->spec;
}

size_t fibre_bytes(const struct fibre *f)
{
    size_t bytes = sizeof *f + (FIBRE_ENERGIES + 1) * sizeof *f->energy;
    bytes += 2 * (size_t)FIBRE_MODES * (size_t)f->draw_rows * (size_t)f->bins *
             sizeof *f->density;
    if (f->trt)
        bytes +=
            (size_t)f->rows * 3 * ((size_t)f->columns + 1) * sizeof *f->trt;
    return bytes;
}
