// best_lobes.c - moments of TRT's panels by Gauss-Legendre quadrature, and
// their polynomials by weighted least squares, in double precision.  What is
// done with them is the shader's business.
#include "renderer/best_lobes.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "protocol/bytes.h"
#include "renderer/gl.h"

static const double pi = 3.14159265358979323846;

enum {
    PANELS = BEST_LOBES_PANELS,
    TERMS = BEST_LOBES_TERMS,
    NODES = 12,   // of a panel: 1e-6 of its moments at eta' = 1.05
    SAMPLES = 24, // of a polynomial
    VALUES = 5,   // sin(phi/2), 1/kappa, three energies
    COLUMNS = BEST_LOBES_COLUMNS,
    ROWS = BEST_LOBES_ROWS
};

// Ends of the panels in h: measured to be the best three.
static const double cut[PANELS + 1] = {0, 0.6, 0.94, 1};

// 12-point Gauss-Legendre, positive half.
static const double gl_x[6] = {0.1252334085114689155, 0.3678314989981801937,
                               0.5873179542866174473, 0.7699026741943046870,
                               0.9041172563704748567, 0.9815606342467192507};
static const double gl_w[6] = {0.2491470458134027850, 0.2334925365383548088,
                               0.2031674267230659217, 0.1600783285433462263,
                               0.1069393259953184310, 0.0471753363865118272};

struct best_lobes {
    struct best_fibre fibre;
    bool made, stale, turned;
    double ms;
    double c[PANELS][VALUES][TERMS]; // by powers of x
    // [power]: sin(phi/2) of the panels; [TERMS + power]: 1/kappa; then
    // energies of the first, second, third panel in red, green, blue; and at
    // last eta^2 - 1, 2 eta, eta, smallest 1/kappa; smallest eta* - 1, 1/range
    // of it
    float block[VALUES * TERMS + 2][4];
    float layer[BEST_LOBES_LAYERS][ROWS][COLUMNS][4];
    unsigned texture, buffer;
};

// --- circular Gaussians -----------------------------------------------------
// I_1/I_0: Gauss's continued fraction, its tail by Amos's bound.
static double bessel_ratio(double k)
{
    double r = k / (20.5 + sqrt(21.5 * 21.5 + k * k));
    for (int n = 20; n >= 1; n--)
        r = k / (2 * n + k * r);
    return r;
}

// 1/kappa of the circular Gaussian whose first moment is 1 - e.
static double inverse_kappa(double e)
{
    if (e < 1e-4)
        return 2 * e - e * e - e * e * e;
    double r = 1 - fmin(e, 1 - 1e-9);
    double k = e < 0.05 ? 1 / (2 * e - e * e - e * e * e)
                        : r * (2 - r * r) / (1 - r * r);
    for (int i = 0; i < 3; i++) {
        double a = bessel_ratio(k);
        k -= (a - r) / (1 - a * a - a / k);
    }
    return 1 / k;
}

// --- a panel ----------------------------------------------------------------
struct panel { // at one theta_d, without what an index of its own changes
    double h[NODES], gamma[NODES], weight[NODES];
    double energy[3];
};

// cos theta_d that belongs to x; never zero.
static double cos_of(double eta, double x)
{
    double s = fmax(x + 1, 1e-6) / (2 * eta);
    return fmin(s * sqrt((eta * eta - 1) / (1 - s * s)), 1);
}

static double fresnel(double eta, double c)
{
    double q = sqrt(eta * eta - 1 + c * c), n = eta * eta * c;
    double s = (c - q) / (c + q), p = (n - q) / (n + q);
    return (s * s + p * p) / 2;
}

static struct panel panel_at(const struct best_fibre *f, int i, double cos_d)
{
    struct panel p = {.energy = {0}};
    double root2 = f->eta * f->eta - 1 + cos_d * cos_d, eta1 = sqrt(root2);
    double a = asin(cut[i]), b = asin(cut[i + 1]);
    for (int k = 0; k < NODES; k++) {
        double x = k % 2 ? gl_x[k / 2] : -gl_x[k / 2];
        double g = (a + b) / 2 + (b - a) / 2 * x, u = cos(g), h = sin(g);
        double t = cos_d * h / eta1, path = 4 * sqrt(1 - t * t);
        double r = fresnel(f->eta, cos_d * u), in = (1 - r) / cos_d, mean = 0;
        double w = gl_w[k / 2] * (b - a) / 4 * u * in * in * r;
        for (int c = 0; c < 3; c++) {
            double pass = exp(-path * f->sigma_a[c] * f->eta / eta1);
            p.energy[c] += w * pass;
            mean += pass;
        }
        p.h[k] = h;
        p.gamma[k] = g;
        p.weight[k] = w * mean;
    }
    return p;
}

// sin(phi/2) and 1/kappa with an index eta1 = eta'.
static void moment(const struct panel *p, double eta1, double e_c,
                   double out[2])
{
    double w = 0, x = 0, y = 0;
    for (int k = 0; k < NODES; k++) {
        double phi = 4 * asin(p->h[k] / eta1) - 2 * p->gamma[k];
        w += p->weight[k];
        x += p->weight[k] * cos(phi);
        y += p->weight[k] * sin(phi);
    }
    double mean = atan2(y, x), e = w > 0 ? fmax(1 - hypot(x, y) / w, 0) : 0;
    out[0] = sin(mean / 2);
    out[1] = inverse_kappa(e + e_c - e * e_c);
}

// e^-k I_0(k): the series, or the asymptotic one.
static double i0e(double k)
{
    double sum = 1, term = 1;
    if (k > 40) {
        for (int n = 1; n < 20; n++) {
            term *= (2 * n - 1) * (2 * n - 1) / (8 * n * k);
            sum += term;
        }
        return sum / sqrt(2 * pi * k);
    }
    for (int n = 1; n < 100; n++) {
        term *= k * k / (4.0 * n * n);
        sum += term;
    }
    return sum * exp(-k);
}

static double widening(double w_c) // 1 - first moment of w_c's Gaussian
{
    double k = 2 / (w_c * w_c);
    return k > 1e4 ? 0.5 / k + 0.125 / (k * k) : 1 - bessel_ratio(k);
}

void best_lobes_exact(const struct best_fibre *f, int panel, double cos_d,
                      double out[5])
{
    struct panel p = panel_at(f, panel, cos_d);
    moment(&p, sqrt(f->eta * f->eta - 1 + cos_d * cos_d) / cos_d,
           widening(f->w_c), out);
    memcpy(out + 2, p.energy, sizeof p.energy);
}

// --- polynomials ------------------------------------------------------------
struct fit {
    double x[SAMPLES], t[SAMPLES][TERMS]; // Chebyshev polynomials
    double power[TERMS][TERMS];           // and what powers they are made of
};

static void fit_start(struct fit *f)
{
    memset(f, 0, sizeof *f);
    for (int i = 0; i < SAMPLES; i++) {
        double angle = pi * (i + 0.5) / SAMPLES;
        f->x[i] = cos(angle);
        for (int k = 0; k < TERMS; k++)
            f->t[i][k] = cos(k * angle);
    }
    f->power[0][0] = f->power[1][1] = 1;
    for (int k = 2; k < TERMS; k++)
        for (int n = 0; n < TERMS; n++)
            f->power[k][n] =
                (n > 0 ? 2 * f->power[k - 1][n - 1] : 0) - f->power[k - 2][n];
}

// Least squares of (sum - y) * weight; normal equations by Cholesky.
static void fit_run(const struct fit *f, const double *y, const double *weight,
                    double c[TERMS])
{
    double m[TERMS][TERMS] = {{0}}, v[TERMS] = {0};
    for (int i = 0; i < SAMPLES; i++)
        for (int a = 0; a < TERMS; a++) {
            double w = weight[i] * weight[i] * f->t[i][a];
            v[a] += w * y[i];
            for (int b = 0; b <= a; b++)
                m[a][b] += w * f->t[i][b];
        }
    for (int a = 0; a < TERMS; a++)
        for (int b = 0; b <= a; b++) {
            for (int k = 0; k < b; k++)
                m[a][b] -= m[a][k] * m[b][k];
            m[a][b] = a == b ? sqrt(fmax(m[a][a], 1e-30)) : m[a][b] / m[b][b];
        }
    for (int a = 0; a < TERMS; a++) {
        for (int k = 0; k < a; k++)
            v[a] -= m[a][k] * v[k];
        v[a] /= m[a][a];
    }
    for (int a = TERMS - 1; a >= 0; a--) {
        for (int k = a + 1; k < TERMS; k++)
            v[a] -= m[k][a] * v[k];
        v[a] /= m[a][a];
    }
    for (int n = 0; n < TERMS; n++) {
        c[n] = 0;
        for (int k = 0; k < TERMS; k++)
            c[n] += v[k] * f->power[k][n];
    }
}

// Errors count relative to the value, down to `floor` of the largest.
static void fit_value(const struct fit *f, const double *y, double floor,
                      double c[TERMS])
{
    double weight[SAMPLES], top = 0;
    for (int i = 0; i < SAMPLES; i++)
        top = fmax(top, fabs(y[i]));
    if (!(top > 1e-30)) {
        memset(c, 0, TERMS * sizeof *c);
        return;
    }
    for (int i = 0; i < SAMPLES; i++)
        weight[i] = 1 / (fabs(y[i]) / top + floor);
    fit_run(f, y, weight, c);
}

// What an energy is divided by, so that the lights need no I_0 of the panel's
// own: with the root, which they have, it hardly varies.
static double share(const struct best_lobes *t, double per_kappa)
{
    return t->turned ? 1 : i0e(1 / per_kappa) / sqrt(per_kappa);
}

static void fill_polynomials(struct best_lobes *t)
{
    struct fit fit;
    fit_start(&fit);
    for (int q = 0; q < PANELS; q++) {
        double y[VALUES][SAMPLES], out[VALUES];
        for (int i = 0; i < SAMPLES; i++) {
            best_lobes_exact(&t->fibre, q, cos_of(t->fibre.eta, fit.x[i]), out);
            for (int k = 0; k < VALUES; k++)
                y[k][i] = out[k] / (k < 2 ? 1 : share(t, out[1]));
        }
        fit_value(&fit, y[0], 1, t->c[q][0]);
        for (int k = 1; k < VALUES; k++)
            fit_value(&fit, y[k], 1e-3, t->c[q][k]);
    }
}

// --- eccentric fibres -------------------------------------------------------
static void fill_turned(struct best_lobes *t)
{
    const struct best_fibre *f = &t->fibre;
    double aa = f->a * f->a, swing = fabs(aa - 1 / aa) * (f->eta - 1);
    double low = (aa + 1 / aa - 1) * (f->eta - 1) - swing;
    double e_c = widening(f->w_c);
    low = fmax(low, 1e-3);
    t->block[VALUES * TERMS + 1][0] = (float)low;
    t->block[VALUES * TERMS + 1][1] = (float)(1 / fmax(2 * swing, 1e-6));
    for (int row = 0; row < ROWS; row++) {
        double cos_d = cos_of(f->eta, 2.0 * row / (ROWS - 1) - 1);
        for (int q = 0; q < PANELS; q++) {
            struct panel p = panel_at(f, q, cos_d);
            for (int col = 0; col < COLUMNS; col++) {
                double star = 1 + low + 2 * swing * col / (COLUMNS - 1), out[2];
                double eta1 = sqrt(star * star - 1 + cos_d * cos_d) / cos_d;
                moment(&p, eta1, e_c, out);
                t->layer[0][row][col][q] = (float)out[0];
                t->layer[1][row][col][q] = (float)out[1];
            }
        }
    }
}

// --- the whole --------------------------------------------------------------
static double now_ms(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return 1e3 * (double)now.tv_sec + 1e-6 * (double)now.tv_nsec;
}

static void pack(struct best_lobes *t)
{
    for (int n = 0; n < TERMS; n++)
        for (int q = 0; q < PANELS; q++) {
            t->block[n][q] = (float)t->c[q][0][n];
            t->block[TERMS + n][q] = (float)t->c[q][1][n];
            for (int c = 0; c < 3; c++)
                t->block[(2 + q) * TERMS + n][c] = (float)t->c[q][2 + c][n];
        }
    float *last = t->block[VALUES * TERMS];
    double eta = t->fibre.eta;
    last[0] = (float)((eta - 1) * (eta + 1));
    last[1] = (float)(2 * eta);
    last[2] = (float)eta;
    last[3] = (float)inverse_kappa(widening(t->fibre.w_c));
}

struct best_lobes *best_lobes_create(void)
{
    return bytes_zalloc(1, sizeof(struct best_lobes));
}

static bool same(const struct best_fibre *a, const struct best_fibre *b)
{
    return a->eta == b->eta && a->a == b->a && a->w_c == b->w_c &&
           memcmp(a->sigma_a, b->sigma_a, sizeof a->sigma_a) == 0;
}

void best_lobes_update(struct best_lobes *t, const struct best_fibre *f)
{
    if (t->made && same(&t->fibre, f))
        return;
    double began = now_ms();
    t->fibre = *f;
    t->turned = f->a != 1;
    fill_polynomials(t);
    if (t->turned)
        fill_turned(t);
    pack(t);
    t->made = t->stale = true;
    t->ms = now_ms() - began;
}

double best_lobes_ms(const struct best_lobes *t)
{
    return t->ms;
}

void best_lobes_panel(const struct best_lobes *t, int panel, double cos_d,
                      double out[5])
{
    double eta = t->fibre.eta;
    double x = 2 * eta * cos_d / sqrt(eta * eta - 1 + cos_d * cos_d) - 1;
    for (int k = 0; k < VALUES; k++) {
        out[k] = 0;
        for (int n = TERMS - 1; n >= 0; n--)
            out[k] = out[k] * x + t->c[panel][k][n];
    }
    for (int k = 2; k < VALUES; k++)
        out[k] *= share(t, out[1]);
}

static void create_objects(struct best_lobes *t)
{
    t->buffer = gl_buffer(sizeof t->block, NULL, "best lobes");
}

static void create_texture(struct best_lobes *t)
{
    gl.CreateTextures(GL_TEXTURE_2D_ARRAY, 1, &t->texture);
    gl.TextureStorage3D(t->texture, 1, GL_RGBA32F, COLUMNS, ROWS,
                        BEST_LOBES_LAYERS);
    gl.TextureParameteri(t->texture, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    gl.TextureParameteri(t->texture, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    gl.TextureParameteri(t->texture, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    gl.TextureParameteri(t->texture, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
    gl.ObjectLabel(GL_TEXTURE, t->texture, -1, "best lobes, turned");
}

void best_lobes_bind(struct best_lobes *t)
{
    if (!t->buffer)
        create_objects(t);
    if (t->turned && !t->texture)
        create_texture(t);
    if (t->stale) {
        gl.NamedBufferSubData(t->buffer, 0, sizeof t->block, t->block);
        if (t->turned)
            gl.TextureSubImage3D(t->texture, 0, 0, 0, 0, COLUMNS, ROWS,
                                 BEST_LOBES_LAYERS, GL_RGBA, GL_FLOAT,
                                 t->layer);
        t->stale = false;
    }
    if (t->turned)
        gl.BindTextureUnit(BEST_LOBES_UNIT, t->texture);
    gl.BindBufferBase(GL_UNIFORM_BUFFER, BEST_LOBES_BINDING, t->buffer);
}

void best_lobes_destroy(struct best_lobes *t)
{
    if (!t)
        return;
    if (t->texture)
        gl.DeleteTextures(1, &t->texture);
    if (t->buffer)
        gl.DeleteBuffers(1, &t->buffer);
    free(t);
}
