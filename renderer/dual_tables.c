// dual_tables.c - integrals over the inclination, sums over paths, upload. What
// happens in a cross section is dual_azimuth.c's, or in the paper's way
// dual_paper.c's.
#include "renderer/dual_tables.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "protocol/bytes.h"
#include "renderer/dual_paper.h"
#include "renderer/gl.h"
#include "renderer/quadrature.h"

static const double pi = 3.14159265358979323846;

enum {
    COLUMNS = DUAL_TABLES_COLUMNS,
    ENERGIES = 96, // intervals of cos theta_d
    NODES = 20,    // of an integral over an inclination
    HEAD = 1,      // vec4 before the waves in the block
    WAVES = 4,     // vec4 of a harmonic
    BLOCK = HEAD + WAVES * DUAL_HARMONICS_TRT + DUAL_WAVES_TT * DUAL_POWERS +
            DUAL_WAVES_TRT * DUAL_POWERS_TRT
};

// Layers of the texture; the last five differ with the scheme.
enum {
    LAYER_A,
    LAYER_BETA2,
    LAYER_MASS, // BEST: S_back seen from theta_o, a function of theta_i
    LAYER_CENTRE,
    LAYER_WIDTH2,
    LAYER_SKEW,
    LAYER_PEAK,
    LAYER_BACK, // over the illumination: A_b, Delta_b, sigma_b^2
    LAYER_BACK_DELTA,
    LAYER_BACK_SIGMA2,
    LAYER_A_B = LAYER_MASS, // PAPER: over the illumination
    LAYER_DELTA,            // integrals from -pi/2 (eq 31)
    LAYER_SIGMA
};

struct dual_tables {
    struct dual_fibre fibre;
    enum dual_scheme scheme;
    double x[NODES], w[NODES];               // Gauss-Legendre on [0, 1]
    struct dual_energy energy[ENERGIES + 1]; // of cos theta_d
    struct dual_mean mean[COLUMNS][3];
    struct dual_series series;
    float layer[DUAL_TABLES_LAYERS][COLUMNS][4];
    float block[BLOCK][4];
    double ms;
    bool stale;
    unsigned texture, buffer; // 0 until bound for the first time
};

static double theta_at(int i)
{
    // Grazing light leaves nothing to take the mean of.
    double edge = pi / 2 - 1e-4, t = pi * i / (COLUMNS - 1) - pi / 2;
    return fmin(fmax(t, -edge), edge);
}

static void make_rule(struct dual_tables *t)
{
    quadrature_legendre(NODES, t->x, t->w);
    for (int i = 0; i < NODES; i++) {
        t->x[i] = (1 + t->x[i]) / 2;
        t->w[i] /= 2;
    }
}

struct dual_tables *dual_tables_create(void)
{
    struct dual_tables *t = bytes_zalloc(1, sizeof *t);
    make_rule(t);
    return t;
}

double dual_tables_ms(const struct dual_tables *t)
{
    return t->ms;
}

const struct dual_series *dual_tables_series(const struct dual_tables *t)
{
    return &t->series;
}

// --- means over half a space ------------------------------------------------
struct sums { // of one theta: by mode, channels side by side
    double ahead[DUAL_CHANNELS], all[DUAL_CHANNELS];
};

// Adds weight * energy(cos_d) of a mode's channels; parabolas through three.
static void add_energy(const struct dual_tables *t, double cos_d, double weight,
                       const int channels[2], struct sums *s)
{
    double at = fmin(fmax(cos_d, 0), 1) * ENERGIES;
    int i = (int)(at + 0.5);
    i = i < 1 ? 1 : i > ENERGIES - 1 ? ENERGIES - 1 : i;
    double x = at - i, a = weight * x * (x - 1) / 2, b = weight * (1 - x * x),
           c = weight * x * (x + 1) / 2;
    const struct dual_energy *e = t->energy + i;
    for (int k = channels[0]; k < channels[1]; k++) {
        s->ahead[k] +=
            a * e[-1].ahead[k] + b * e[0].ahead[k] + c * e[1].ahead[k];
        s->all[k] += a * e[-1].all[k] + b * e[0].all[k] + c * e[1].all[k];
    }
}

static const int channels_of[3][2] = {
    {DUAL_R, DUAL_TT}, {DUAL_TT, DUAL_TRT}, {DUAL_TRT, DUAL_CHANNELS}};

// Eq 32, 33 unseparated: Int M_t(theta_o) cos cos / cos^2 theta_d E dtheta_o.
// x is theta_o's distance from the end where the specular cone goes; at grazing
// light the cosines make a peak as wide as the light's distance e from pi/2,
// which x = e (exp(u) - 1) spreads out.
static void bounce(const struct dual_tables *t, int mode, double theta,
                   struct sums *s)
{
    const struct dual_fibre *f = &t->fibre;
    double side = theta < 0 ? -1 : 1, e = pi / 2 - fabs(theta);
    double width = 2 * f->beta[mode], mu = e + 2 * side * f->alpha[mode];
    double lo = fmax(mu - 4.7 * width, 0), hi = fmin(mu + 4.7 * width, pi);
    if (lo >= hi)
        return;
    double u0 = log1p(lo / e), span = log1p(hi / e) - u0;
    for (int i = 0; i < NODES; i++) {
        double x = e * expm1(u0 + span * t->x[i]), z = (x - mu) / width;
        double c = sin((x + e) / 2);
        double weight = t->w[i] * span * (x + e) * exp(-z * z / 2) /
                        (width * sqrt(2 * pi)) * sin(x) * sin(e);
        // Channels but R's hold E / cos^2.
        add_energy(t, c, mode == 0 ? weight / (c * c) : weight,
                   channels_of[mode], s);
    }
}

// Zinke 2008, section 3.2: paths that turn back an odd number of times.
static void turn_back(struct dual_mean *m, enum dual_scheme scheme)
{
    double x = m->a_f * m->a_f, y = 1 - x, b2 = m->a_b * m->a_b;
    double r = b2 / (y * y), q = 1 + b2 - x;
    double pile = 2 * m->a_b / (q + sqrt(fmax(0, q * q - 4 * b2)));
    double nb = (1 + 3 * r) / (1 + r);
    double nf = 2 / y * (1 + r * (1 + 2 * x)) / (1 + r);
    if (scheme == DUAL_SCHEME_BEST) {
        // Layers without end: reflectance R = a_b + a_f^2 R / (1 - a_b R), of
        // which the first bounce is single scattering's.
        m->A_b = x * pile / (1 - m->a_b * pile);
        m->delta_b = 2 * (nb * m->alpha_b + nf * m->alpha_f);
        m->sigma_b = 2 * sqrt(nb * m->beta2_b + nf * m->beta2_f);
        return;
    }
    m->A_b = m->a_b * x / y * (1 + b2 / (y * y)); // eq 11, 13
    // Eq 16 with a plus; eq 17 without betas among the weights of its quotient.
    m->delta_b = 2 * (m->alpha_b * (1 + 2 * r) +
                      m->alpha_f * (2 * y * y + 4 * x * b2) / (y * y * y));
    m->sigma_b = 2 * (1 + 0.7 * x) *
                 (sqrt(2 * m->beta2_f + m->beta2_b) +
                  b2 * sqrt(2 * m->beta2_f + 3 * m->beta2_b)) /
                 (1 + b2);
}

static void take_means(struct dual_tables *t, const struct sums *s,
                       struct dual_mean out[3])
{
    const double tiny = 1e-30; // of a mode that nothing comes through
    for (int k = 0; k < 3; k++) {
        struct dual_mean m = {0};
        const int channel[3] = {DUAL_R, DUAL_TT + k, DUAL_TRT + k};
        for (int mode = 0; mode < 3; mode++) {
            double f = s->ahead[channel[mode]], alpha = t->fibre.alpha[mode];
            double b = fmax(s->all[channel[mode]] - f, 0) + tiny;
            double beta2 = t->fibre.beta[mode] * t->fibre.beta[mode];
            f += tiny;
            m.a_f += f;
            m.a_b += b;
            m.alpha_f += f * alpha;
            m.alpha_b += b * alpha;
            m.beta2_f += f * beta2;
            m.beta2_b += b * beta2;
        }
        m.alpha_f /= m.a_f;
        m.beta2_f /= m.a_f;
        m.alpha_b /= m.a_b;
        m.beta2_b /= m.a_b;
        // Tilted modes may weigh inclinations differently, and the paper's
        // lobes hold too much: never more light out than in.
        double more = (m.a_f + m.a_b) / (1 - 1e-4);
        if (more > 1) {
            m.a_f /= more;
            m.a_b /= more;
        }
        turn_back(&m, t->scheme);
        out[k] = m;
    }
}

void dual_tables_mean(const struct dual_tables *t, double theta, int channel,
                      struct dual_mean *out)
{
    double at = (theta / pi + 0.5) * (COLUMNS - 1);
    at = fmin(fmax(at, 0), COLUMNS - 1);
    int i = (int)fmin(at, COLUMNS - 2);
    double b = at - i, a = 1 - b;
    const struct dual_mean *p = &t->mean[i][channel];
    const struct dual_mean *q = &t->mean[i + 1][channel];
    *out = (struct dual_mean){
        a * p->a_f + b * q->a_f,         a * p->a_b + b * q->a_b,
        a * p->alpha_f + b * q->alpha_f, a * p->alpha_b + b * q->alpha_b,
        a * p->beta2_f + b * q->beta2_f, a * p->beta2_b + b * q->beta2_b,
        a * p->A_b + b * q->A_b,         a * p->delta_b + b * q->delta_b,
        a * p->sigma_b + b * q->sigma_b};
}

// --- S_back as one view sees it ---------------------------------------------
// For a given theta_o,
//   K(theta_i) = A_b g^u(theta_i + theta_o; Delta_b, sqrt2 sigma_b)
//                cos theta_i / cos^2 theta_d,
// with A_b, Delta_b, sigma_b at -theta_d, is close to a Gaussian: mass, centre,
// width and the next two Hermite coefficients make a light's integral a closed
// form.
struct view {
    double theta[NODES], k[NODES]; // weights included
};

static void look(const struct dual_tables *t, double theta_o, int channel,
                 struct view *v)
{
    struct dual_mean m, n;
    dual_tables_mean(t, -theta_o, channel, &m);
    double mu = m.delta_b - theta_o, at = mu;
    // The centre moves with the inclination that it makes: for lobes of less
    // than a degree by many widths.  Wider ones keep the first centre: the
    // fifth may hop between two where the light grazes.
    for (int i = 0; i < 4; i++) {
        dual_tables_mean(t, (at - theta_o) / 2, channel, &n);
        at = n.delta_b - theta_o;
    }
    if (m.sigma_b < 0.1 && fabs(at - mu) > 3 * m.sigma_b) {
        mu = at;
        m = n;
    }
    double reach = 4.5 * m.sigma_b;
    double lo = fmax(mu - reach, -pi / 2), hi = fmin(mu + reach, pi / 2);
    if (lo > hi) // the cone points beyond the fibre's end: what is left of it
        lo = hi = mu > 0 ? pi / 2 - 1e-3 : 1e-3 - pi / 2;
    for (int i = 0; i < NODES; i++) {
        double ti = lo + (hi - lo) * t->x[i], d = (ti - theta_o) / 2;
        double c = cos(d);
        dual_tables_mean(t, d, channel, &m);
        double z = (ti + theta_o - m.delta_b) / m.sigma_b;
        v->theta[i] = ti;
        v->k[i] = t->w[i] * (hi - lo) * m.A_b * cos(ti) / fmax(c * c, 1e-8) *
                  exp(-z * z / 2) / (m.sigma_b * sqrt(2 * pi));
    }
}

static void describe(const struct view *v, float *layer[5])
{
    double mass = 1e-30, mu = 0, var = 0, skew = 0, peak = 0;
    for (int i = 0; i < NODES; i++)
        mass += v->k[i];
    for (int i = 0; i < NODES; i++)
        mu += v->k[i] / mass * v->theta[i];
    for (int i = 0; i < NODES; i++)
        var += v->k[i] / mass * (v->theta[i] - mu) * (v->theta[i] - mu);
    var = fmax(var, 1e-6);
    for (int i = 0; i < NODES; i++) {
        double z = (v->theta[i] - mu) / sqrt(var), z2 = z * z;
        skew += v->k[i] / mass * z * (z2 - 3) / 6;
        peak += v->k[i] / mass * ((z2 - 6) * z2 + 3) / 24;
    }
    *layer[0] = (float)mass;
    *layer[1] = (float)mu;
    *layer[2] = (float)(2 * var); // a Xu width squared
    *layer[3] = (float)skew;
    *layer[4] = (float)peak;
}

static void fill_views(struct dual_tables *t)
{
    struct view v;
    for (int i = 0; i < COLUMNS; i++)
        for (int k = 0; k < 3; k++) {
            float *to[5];
            for (int n = 0; n < 5; n++)
                to[n] = &t->layer[LAYER_MASS + n][i][k];
            look(t, theta_at(i), k, &v);
            describe(&v, to);
            const struct dual_mean *m = &t->mean[i][k];
            t->layer[LAYER_BACK][i][k] = (float)m->A_b;
            t->layer[LAYER_BACK_DELTA][i][k] = (float)m->delta_b;
            t->layer[LAYER_BACK_SIGMA2][i][k] =
                (float)(m->sigma_b * m->sigma_b);
        }
}

// Eq 31: integrals, of which the shader takes differences.
static void fill_integrals(struct dual_tables *t)
{
    double step = pi / (COLUMNS - 1);
    for (int k = 0; k < 3; k++) {
        double delta = 0, sigma = 0;
        for (int i = 0; i < COLUMNS; i++) {
            const struct dual_mean *m = &t->mean[i][k];
            const struct dual_mean *p = &t->mean[i ? i - 1 : 0][k];
            delta += i ? step * (m->delta_b + p->delta_b) / 2 : 0;
            sigma += i ? step * (m->sigma_b + p->sigma_b) / 2 : 0;
            t->layer[LAYER_A_B][i][k] = (float)m->A_b;
            t->layer[LAYER_DELTA][i][k] = (float)delta;
            t->layer[LAYER_SIGMA][i][k] = (float)sigma;
        }
    }
}

// --- an edit ----------------------------------------------------------------
static void fill_block(struct dual_tables *t)
{
    const struct dual_series *s = &t->series;
    double eta = t->fibre.eta, f0 = (eta - 1) / (eta + 1);
    float(*row)[4] = t->block;
    row[0][0] = (float)(eta * eta - 1);
    row[0][1] = (float)(2 * eta);
    row[0][2] = (float)(f0 * f0);
    row += HEAD;
    // A harmonic: TT's four waves; R's three; four of TRT's, the other two.
    for (int k = 0; k < DUAL_HARMONICS_TRT; k++, row += WAVES) {
        for (int m = 0; m < DUAL_WAVES_TT && k < DUAL_HARMONICS; m++)
            row[0][m] = (float)s->wave_tt[m][k];
        for (int m = 0; m < DUAL_WAVES_R && k < DUAL_HARMONICS; m++)
            row[1][m] = (float)s->wave_r[m][k];
        for (int m = 0; m < DUAL_WAVES_TRT; m++)
            row[2 + m / 4][m % 4] = (float)s->wave_trt[m][k];
    }
    for (int m = 0; m < DUAL_WAVES_TT; m++)
        for (int p = 0; p < DUAL_POWERS; p++, row++) {
            for (int c = 0; c < 3; c++)
                row[0][c] = (float)s->tt[c][m][p];
            row[0][3] = m < DUAL_WAVES_R ? (float)s->r[m][p] : 0;
        }
    for (int m = 0; m < DUAL_WAVES_TRT; m++)
        for (int p = 0; p < DUAL_POWERS_TRT; p++, row++)
            for (int c = 0; c < 3; c++)
                row[0][c] = (float)s->trt[c][m][p];
}

static void fill_best(struct dual_tables *t)
{
    struct dual_azimuth z;
    dual_azimuth_init(&z, &t->fibre);
    for (int i = 0; i <= ENERGIES; i++)
        dual_azimuth_energy(&z, fmax((double)i / ENERGIES, 1e-6),
                            &t->energy[i]);
    dual_azimuth_series(&z, &t->series);
    fill_block(t);
    for (int i = 0; i < COLUMNS; i++) {
        struct sums s = {{0}, {0}};
        for (int mode = 0; mode < 3; mode++)
            bounce(t, mode, theta_at(i), &s);
        take_means(t, &s, t->mean[i]);
    }
    fill_views(t);
}

static void fill_paper(struct dual_tables *t)
{
    for (int i = 0; i < COLUMNS; i++) {
        struct dual_energy e;
        struct sums s;
        double theta = theta_at(i);
        dual_paper_energy(&t->fibre, cos(theta), &e);
        for (int mode = 0; mode < 3; mode++) {
            double along = dual_paper_along(&t->fibre, mode, theta);
            for (int k = channels_of[mode][0]; k < channels_of[mode][1]; k++) {
                s.ahead[k] = along * e.ahead[k];
                s.all[k] = along * e.all[k];
            }
        }
        take_means(t, &s, t->mean[i]);
    }
    fill_integrals(t);
}

static double now_ms(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return 1e3 * (double)now.tv_sec + 1e-6 * (double)now.tv_nsec;
}

void dual_tables_update(struct dual_tables *t, const struct dual_fibre *f,
                        enum dual_scheme scheme)
{
    double began = now_ms();
    t->fibre = *f;
    t->scheme = scheme;
    if (scheme == DUAL_SCHEME_BEST)
        fill_best(t);
    else
        fill_paper(t);
    for (int i = 0; i < COLUMNS; i++)
        for (int k = 0; k < 3; k++) {
            t->layer[LAYER_A][i][k] = (float)t->mean[i][k].a_f;
            t->layer[LAYER_BETA2][i][k] = (float)t->mean[i][k].beta2_f;
        }
    t->stale = true;
    t->ms = now_ms() - began;
}

static void create_objects(struct dual_tables *t)
{
    gl.CreateTextures(GL_TEXTURE_1D_ARRAY, 1, &t->texture);
    gl.TextureStorage2D(t->texture, 1, GL_RGBA32F, COLUMNS, DUAL_TABLES_LAYERS);
    gl.TextureParameteri(t->texture, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    gl.TextureParameteri(t->texture, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    gl.TextureParameteri(t->texture, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    gl.ObjectLabel(GL_TEXTURE, t->texture, -1, "dual tables");
    t->buffer = gl_buffer(sizeof t->block, NULL, "dual series");
}

void dual_tables_bind(struct dual_tables *t)
{
    if (!t->texture)
        create_objects(t);
    if (t->stale) {
        gl.TextureSubImage2D(t->texture, 0, 0, 0, COLUMNS, DUAL_TABLES_LAYERS,
                             GL_RGBA, GL_FLOAT, t->layer);
        gl.NamedBufferSubData(t->buffer, 0, sizeof t->block, t->block);
        t->stale = false;
    }
    gl.BindTextureUnit(DUAL_TABLES_UNIT, t->texture);
    gl.BindBufferBase(GL_UNIFORM_BUFFER, DUAL_TABLES_BINDING, t->buffer);
}

void dual_tables_destroy(struct dual_tables *t)
{
    if (!t)
        return;
    if (t->texture)
        gl.DeleteTextures(1, &t->texture);
    if (t->buffer)
        gl.DeleteBuffers(1, &t->buffer);
    free(t);
}
