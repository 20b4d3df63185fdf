// dual_tables.c - which pieces an update makes, S_back as views see it, upload.
// What happens in a cross section is dual_azimuth.c's, or in the paper's way
// dual_paper.c's; integrals over the inclination are dual_bounce.c's, sums over
// paths dual_mean.c's.
#include "renderer/dual_tables.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "protocol/bytes.h"
#include "renderer/crew.h"
#include "renderer/dual_bounce.h"
#include "renderer/dual_paper.h"
#include "renderer/gl.h"
#include "renderer/quadrature.h"

static const double pi = 3.14159265358979323846;

enum {
    COLUMNS = DUAL_TABLES_COLUMNS,
    ENERGIES = DUAL_BOUNCE_ENERGIES,
    NODES = DUAL_BOUNCE_NODES, // of an integral over an inclination, here too
    BLOCK_ENERGIES = 4,        // of an update's pieces
    BLOCK_COLUMNS = 8,
    COLUMN_BLOCKS = COLUMNS / BLOCK_COLUMNS,
    ENERGY_BLOCKS = (ENERGIES + BLOCK_ENERGIES) / BLOCK_ENERGIES,
    HEAD = 1,  // vec4 before the waves in the block
    WAVES = 4, // vec4 of a harmonic
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
    struct dual_tables_work work;
    struct dual_bounce_rule rule;
    // Of a cross section, and what it was.
    struct dual_section section;
    struct dual_azimuth azimuth;
    struct dual_energy energy[ENERGIES + 1]; // of cos theta_d
    struct dual_sample sample[DUAL_SAMPLES];
    struct dual_series series;
    // Of a mode's shift and width, and what they were.
    struct dual_bounce_lobe lobe[3];
    struct dual_bounce bounce[3][COLUMNS];
    bool section_stale, lobe_stale[3]; // for the update that runs
    // Of all of these.
    struct dual_mean mean[COLUMNS][3];
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

static void make_rule(struct dual_bounce_rule *r)
{
    quadrature_legendre(NODES, r->x, r->w);
    for (int i = 0; i < NODES; i++) {
        r->x[i] = (1 + r->x[i]) / 2;
        r->w[i] /= 2;
    }
}

struct dual_tables *dual_tables_create(void)
{
    struct dual_tables *t = bytes_zalloc(1, sizeof *t);
    make_rule(&t->rule);
    return t;
}

struct dual_tables_work dual_tables_work(const struct dual_tables *t)
{
    return t->work;
}

void dual_tables_bytes(const struct dual_tables *t, struct buf *out)
{
    buf_append(out, t->layer, sizeof t->layer);
    buf_append(out, t->block, sizeof t->block);
}

double dual_tables_ms(const struct dual_tables *t)
{
    return t->ms;
}

const struct dual_series *dual_tables_series(const struct dual_tables *t)
{
    return &t->series;
}

// --- between entries ---------------------------------------------------------
struct between { // two entries and their shares
    const struct dual_mean *p, *q;
    double a, b;
};

static struct between between(const struct dual_tables *t, double theta,
                              int channel)
{
    double at = (theta / pi + 0.5) * (COLUMNS - 1);
    at = fmin(fmax(at, 0), COLUMNS - 1);
    int i = (int)fmin(at, COLUMNS - 2);
    double b = at - i;
    return (struct between){&t->mean[i][channel], &t->mean[i + 1][channel],
                            1 - b, b};
}

void dual_tables_ahead(const struct dual_tables *t, double theta, int channel,
                       double out[2])
{
    const struct between n = between(t, theta, channel);
    out[0] = n.a * n.p->a_f + n.b * n.q->a_f;
    out[1] = n.a * n.p->beta2_f + n.b * n.q->beta2_f;
}

void dual_tables_mean(const struct dual_tables *t, double theta, int channel,
                      struct dual_mean *out)
{
    struct between n = between(t, theta, channel);
    const struct dual_mean *p = n.p, *q = n.q;
    double a = n.a, b = n.b;
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

struct back {
    double A_b, delta_b, sigma_b;
};

static struct back back_at(const struct dual_tables *t, double theta,
                           int channel)
{
    const struct between n = between(t, theta, channel);
    return (struct back){n.a * n.p->A_b + n.b * n.q->A_b,
                         n.a * n.p->delta_b + n.b * n.q->delta_b,
                         n.a * n.p->sigma_b + n.b * n.q->sigma_b};
}

static void look(const struct dual_tables *t, double theta_o, int channel,
                 struct view *v)
{
    struct back m = back_at(t, -theta_o, channel), n = m;
    double mu = m.delta_b - theta_o, at = mu;
    // The centre moves with the inclination that it makes: for lobes of less
    // than a degree by many widths.  Wider ones keep the first centre: the
    // fifth may hop between two where the light grazes.
    for (int i = 0; i < 4; i++) {
        n = back_at(t, (at - theta_o) / 2, channel);
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
        double ti = lo + (hi - lo) * t->rule.x[i], d = (ti - theta_o) / 2;
        double c = cos(d);
        m = back_at(t, d, channel);
        double z = (ti + theta_o - m.delta_b) / m.sigma_b;
        v->theta[i] = ti;
        v->k[i] = t->rule.w[i] * (hi - lo) * m.A_b * cos(ti) /
                  fmax(c * c, 1e-8) * exp(-z * z / 2) /
                  (m.sigma_b * sqrt(2 * pi));
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

static void fill_views(void *context, size_t block)
{
    struct dual_tables *t = context;
    struct view v;
    const int from = BLOCK_COLUMNS * (int)block;
    for (int i = from; i < from + BLOCK_COLUMNS; i++)
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

// First pieces: of the cross section, then of each lobe.
static void prepare(void *context, size_t i)
{
    struct dual_tables *t = context;
    if (t->section_stale) {
        if (i < DUAL_SAMPLES) {
            dual_azimuth_sample(&t->azimuth, (int)i, &t->sample[i]);
            return;
        }
        i -= DUAL_SAMPLES;
        if (i < ENERGY_BLOCKS) {
            const int from = BLOCK_ENERGIES * (int)i;
            for (int k = from; k < from + BLOCK_ENERGIES && k <= ENERGIES; k++)
                dual_bounce_energy(&t->azimuth, k, &t->energy[k]);
            return;
        }
        i -= ENERGY_BLOCKS;
    }
    int mode = 0;
    for (; !t->lobe_stale[mode] || i >= COLUMN_BLOCKS; mode++)
        i -= t->lobe_stale[mode] ? COLUMN_BLOCKS : 0;
    const int from = BLOCK_COLUMNS * (int)i;
    for (int k = from; k < from + BLOCK_COLUMNS; k++)
        dual_bounce_weigh(&t->bounce[mode][k], &t->rule, theta_at(k),
                          &t->lobe[mode]);
}

// Second: the series' modes, the longest first, where there are new samples of
// it; then means.
static void put_together(void *context, size_t i)
{
    struct dual_tables *t = context;
    if (t->section_stale) {
        if (i < 3) {
            dual_azimuth_fit(t->sample, 2 - (int)i, &t->series);
            return;
        }
        i -= 3;
    }
    const int from = BLOCK_COLUMNS * (int)i;
    for (int k = from; k < from + BLOCK_COLUMNS; k++) {
        struct dual_energy s;
        for (int mode = 0; mode < 3; mode++)
            dual_bounce_add(&t->bounce[mode][k], mode, t->energy, &s);
        dual_mean_take(&t->fibre, t->scheme, &s, t->mean[k]);
    }
}

// What of what is kept is of another fibre: the key of each piece is all that
// it is made of.
static void find_stale(struct dual_tables *t, const struct dual_fibre *f)
{
    const struct dual_section section = dual_azimuth_section(f);
    t->section_stale =
        t->work.sections == 0 || !dual_azimuth_same(&section, &t->section);
    t->section = section;
    for (int mode = 0; mode < 3; mode++) {
        struct dual_bounce_lobe *l = &t->lobe[mode];
        t->lobe_stale[mode] = t->work.lobes == 0 ||
                              l->alpha != f->alpha[mode] ||
                              l->beta != f->beta[mode];
        *l = (struct dual_bounce_lobe){mode, f->alpha[mode], f->beta[mode]};
    }
}

static bool fill_best(struct dual_tables *t, bool other)
{
    size_t first = 0, second = COLUMN_BLOCKS;
    find_stale(t, &t->fibre);
    if (t->section_stale) {
        dual_azimuth_init(&t->azimuth, &t->section);
        first += DUAL_SAMPLES + ENERGY_BLOCKS;
        second += 3;
        t->work.sections++;
    }
    for (int mode = 0; mode < 3; mode++)
        if (t->lobe_stale[mode]) {
            first += COLUMN_BLOCKS;
            t->work.lobes++;
        }
    if (first == 0 && !other)
        return false;
    crew_run(first, prepare, t);
    crew_run(second, put_together, t);
    if (t->section_stale)
        fill_block(t);
    crew_run(COLUMN_BLOCKS, fill_views, t);
    return true;
}

static void fill_paper(struct dual_tables *t)
{
    for (int i = 0; i < COLUMNS; i++) {
        struct dual_energy e, s;
        double theta = theta_at(i);
        dual_paper_energy(&t->fibre, cos(theta), &e);
        for (int mode = 0; mode < 3; mode++) {
            const int *channels = dual_bounce_channels[mode];
            double along = dual_paper_along(&t->fibre, mode, theta);
            for (int k = channels[0]; k < channels[1]; k++) {
                s.ahead[k] = along * e.ahead[k];
                s.all[k] = along * e.all[k];
            }
        }
        dual_mean_take(&t->fibre, t->scheme, &s, t->mean[i]);
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
    const double began = now_ms();
    const bool other = t->work.means == 0 || t->scheme != scheme;
    bool made = true;
    t->fibre = *f;
    t->scheme = scheme;
    if (scheme == DUAL_SCHEME_BEST)
        made = fill_best(t, other);
    else
        fill_paper(t);
    for (int i = 0; made && i < COLUMNS; i++)
        for (int k = 0; k < 3; k++) {
            t->layer[LAYER_A][i][k] = (float)t->mean[i][k].a_f;
            t->layer[LAYER_BETA2][i][k] = (float)t->mean[i][k].beta2_f;
        }
    t->work.means += made;
    t->stale |= made;
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
