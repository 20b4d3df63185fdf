// sky_fit_lm.c - Levenberg-Marquardt on centres and widths, with amplitudes
// projected out (variable projection in Kaufman's form, 1975): amplitudes are
// the best ones at every point, and H lacks what they can make up for.
//
// Unknowns of lobe j, in this order: steps along two tangents at its centre in
// units of lambda, step of ln lambda.
#include "renderer/sky_fit_lm.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "renderer/sky_fit_solve.h"
#include "renderer/sky_fit_vector.h"
#include "renderer/watch.h"

enum { ITERATIONS = 40, TRIES = 8, RESEED_EVERY = 8, RESEED_LAST = 32 };

// A residual that is good enough: a shading error of a thousandth lies below
// what any scattering formula here gets right.
static const double enough = 1e-3;

struct lm {
    struct sky_fit_model *m;
    struct sky_fit_model trial;
    size_t n, samples;  // lobes, samples of the target
    float *columns;     // [3 n] derivatives, then [n] the basis
    double *gram;       // [4 n][4 n] of these, lower triangle
    double *h, *damped; // [3 n][3 n], lower triangle
    double *factor;     // [n][n]: Cholesky of the active lobes' Gram matrix
    double *projected;  // [3 n][n]: rows of (factor^-1 G^T D)^T
    double *step;       // gradient/2, then the step
    double *gradient;
    double (*tangent)[2][3];
    double mu;
    struct watch *watch;
};

static void lm_init(struct lm *s, struct sky_fit_model *m)
{
    size_t n = (size_t)m->count, g = 3 * n;
    *s = (struct lm){.m = m, .n = n, .samples = m->target->count, .mu = 1e-2};
    sky_fit_model_init(&s->trial, m->target, m->capacity);
    s->columns = bytes_alloc(4 * n * s->samples * sizeof *s->columns);
    s->gram = bytes_alloc(16 * n * n * sizeof *s->gram);
    s->h = bytes_alloc(g * g * sizeof *s->h);
    s->damped = bytes_alloc(g * g * sizeof *s->damped);
    s->factor = bytes_alloc(n * n * sizeof *s->factor);
    s->projected = bytes_alloc(g * n * sizeof *s->projected);
    s->step = bytes_alloc(g * sizeof *s->step);
    s->gradient = bytes_alloc(g * sizeof *s->gradient);
    s->tangent = bytes_alloc(n * sizeof *s->tangent);
}

static void lm_finish(struct lm *s)
{
    sky_fit_model_finish(&s->trial);
    free(s->columns);
    free(s->gram);
    free(s->h);
    free(s->damped);
    free(s->factor);
    free(s->projected);
    free(s->step);
    free(s->gradient);
    free(s->tangent);
}

// Two unit vectors that with c make an orthogonal frame.
static void tangents(const double c[3], double e[2][3])
{
    // Starts from an axis that turns with the map, so that a rolled map gives
    // the same steps; at a pole any axis does.
    double x = c[0], y = c[1], r = hypot(x, y);
    if (r < 1e-9) {
        x = r = 1;
        y = 0;
    }
    e[0][0] = -y / r;
    e[0][1] = x / r;
    e[0][2] = 0;
    e[1][0] = -c[2] * e[0][1];
    e[1][1] = c[2] * e[0][0];
    e[1][2] = c[0] * e[0][1] - c[1] * e[0][0];
}

// d/d(step) of root * exp(k (w . c - 1)): G k lambda (w . e) along a tangent,
// 2 k (1 - w . c) G in ln lambda.
static void derive(struct lm *s, size_t j)
{
    const struct sky_fit_target *t = s->m->target;
    const struct sky_fit_lobe *lobe = &s->m->lobe[j];
    const double *c = lobe->centre, *e0 = s->tangent[j][0],
                 *e1 = s->tangent[j][1];
    double k = 2 * exp(-2 * lobe->l), kl = k * exp(lobe->l);
    const float *g = s->m->basis + j * s->samples;
    float *d0 = s->columns + 3 * j * s->samples;
    float *d1 = d0 + s->samples, *d2 = d1 + s->samples;
    for (size_t i = 0; i < s->samples; i++) {
        double x = t->direction[0][i], y = t->direction[1][i];
        double z = t->direction[2][i], gi = (double)g[i];
        d0[i] = (float)(gi * kl * (x * e0[0] + y * e0[1]));
        d1[i] = (float)(gi * kl * (x * e1[0] + y * e1[1] + z * e1[2]));
        d2[i] = (float)(gi * 2 * k * (1 - x * c[0] - y * c[1] - z * c[2]));
    }
}

static void derivatives(struct lm *s)
{
    size_t g = 3 * s->n;
    for (size_t j = 0; j < s->n; j++) {
        tangents(s->m->lobe[j].centre, s->tangent[j]);
        derive(s, j);
    }
    memcpy(s->columns + g * s->samples, s->m->basis,
           s->n * s->samples * sizeof *s->columns);
    sky_fit_vector_gram(s->columns, s->samples, 4 * s->n, s->gram, 4 * s->n);
    for (size_t j = 0; j < g; j++) {
        s->gradient[j] = 0;
        for (int c = 0; c < 3; c++) {
            double a = s->m->amplitude[c][j / 3];
            if (a > 0)
                s->gradient[j] -=
                    a * sky_fit_vector_dot_fd(s->columns + j * s->samples,
                                              s->m->residual[c], s->samples);
        }
    }
}

static bool same_set(const double *a, const double *b, size_t n)
{
    for (size_t i = 0; i < n; i++)
        if ((a[i] > 0) != (b[i] > 0))
            return false;
    return true;
}

// Rows of (P^-1/2 G^T D)^T for the active lobes of channel c; returns how many
// these are.
static size_t project(struct lm *s, int c)
{
    const struct sky_fit_model *m = s->m;
    size_t set[SKY_LIGHTS_MAX], a = 0, g = 3 * s->n;
    size_t stride = (size_t)m->capacity;
    for (size_t i = 0; i < s->n; i++)
        if (m->amplitude[c][i] > 0)
            set[a++] = i;
    for (size_t i = 0; i < a; i++) {
        for (size_t j = 0; j <= i; j++)
            s->factor[i * a + j] = m->gram[set[i] * stride + set[j]];
        s->factor[i * a + i] *= 1 + 1e-7;
    }
    if (!sky_fit_solve_cholesky(s->factor, a, a))
        return 0; // coincident lobes: go on without the projection
    for (size_t j = 0; j < g; j++) {
        double *row = s->projected + j * s->n;
        for (size_t i = 0; i < a; i++)
            row[i] = s->gram[(g + set[i]) * 4 * s->n + j];
        sky_fit_solve_forward(s->factor, a, a, row);
    }
    return a;
}

// H = sum over channels of (a_c a_c^T) o [D^T D - X_c^T X_c].
static void hessian(struct lm *s)
{
    size_t g = 3 * s->n, active = 0;
    memset(s->h, 0, g * g * sizeof *s->h);
    for (int c = 0; c < 3; c++) {
        const double *a = s->m->amplitude[c];
        // Channels often have the same active lobes: one projection does.
        if (c == 0 || !same_set(a, s->m->amplitude[c - 1], s->n))
            active = project(s, c);
        for (size_t i = 0; i < g; i++) {
            if (!(a[i / 3] > 0))
                continue;
            for (size_t j = 0; j <= i; j++) {
                double w = a[i / 3] * a[j / 3];
                if (w > 0)
                    s->h[i * g + j] +=
                        w * (s->gram[i * 4 * s->n + j] -
                             sky_fit_vector_dot_dd(s->projected + i * s->n,
                                                   s->projected + j * s->n,
                                                   active));
            }
        }
    }
}

// A width at its bound that wants to go beyond stays where it is.
static void freeze(struct lm *s)
{
    const struct sky_fit_target *t = s->m->target;
    size_t g = 3 * s->n;
    double low = log(t->lambda_min), high = log(t->lambda_max);
    for (size_t j = 0; j < s->n; j++) {
        size_t i = 3 * j + 2;
        double l = s->m->lobe[j].l, down = s->gradient[i];
        if (!(l >= high && down < 0) && !(l <= low && down > 0))
            continue;
        s->gradient[i] = 0;
        for (size_t k = 0; k < i; k++)
            s->h[i * g + k] = 0;
        for (size_t k = i + 1; k < g; k++)
            s->h[k * g + i] = 0;
    }
}

static bool solve_step(struct lm *s)
{
    size_t g = 3 * s->n;
    double largest = 0;
    for (size_t i = 0; i < g; i++)
        largest = fmax(largest, s->h[i * g + i]);
    memcpy(s->damped, s->h, g * g * sizeof *s->h);
    for (size_t i = 0; i < g; i++) {
        double d = fmax(s->h[i * g + i], 1e-6 * largest);
        s->damped[i * g + i] = d + s->mu * d;
        s->step[i] = -s->gradient[i];
    }
    if (!sky_fit_solve_cholesky(s->damped, g, g))
        return false;
    sky_fit_solve_forward(s->damped, g, g, s->step);
    sky_fit_solve_backward(s->damped, g, g, s->step);
    return true;
}

// lobe + step -> out, kept within reach of the linearisation and the bounds.
static void move(const struct lm *s, size_t j, struct sky_fit_lobe *out)
{
    const struct sky_fit_target *t = s->m->target;
    const struct sky_fit_lobe *from = &s->m->lobe[j];
    double lambda = exp(from->l), s1 = s->step[3 * j], s2 = s->step[3 * j + 1];
    double size = hypot(s1, s2), most = fmin(0.7, 0.5 / lambda);
    if (size > most) {
        s1 *= most / size;
        s2 *= most / size;
    }
    double norm = 0;
    for (int k = 0; k < 3; k++) {
        out->centre[k] = from->centre[k] + lambda * (s1 * s->tangent[j][0][k] +
                                                     s2 * s->tangent[j][1][k]);
        norm += out->centre[k] * out->centre[k];
    }
    for (int k = 0; k < 3; k++)
        out->centre[k] /= sqrt(norm);
    double dl = fmin(0.4, fmax(-0.4, s->step[3 * j + 2]));
    out->l = fmin(log(t->lambda_max), fmax(log(t->lambda_min), from->l + dl));
}

static void swap(struct sky_fit_model *a, struct sky_fit_model *b)
{
    struct sky_fit_model t = *a;
    *a = *b;
    *b = t;
}

// The trial begins with the amplitudes of the model it comes from.
static void finish_trial(struct lm *s)
{
    s->trial.count = s->m->count;
    memcpy(s->trial.amplitude, s->m->amplitude, sizeof s->m->amplitude);
    sky_fit_model_update(&s->trial, 0);
    sky_fit_model_refit(&s->trial);
}

static bool iterate(struct lm *s)
{
    derivatives(s);
    hessian(s);
    freeze(s);
    for (int i = 0; i < TRIES && !watch_cut(s->watch); i++) {
        if (solve_step(s)) {
            for (size_t j = 0; j < s->n; j++)
                move(s, j, &s->trial.lobe[j]);
            finish_trial(s);
            if (s->trial.f2 < s->m->f2) {
                swap(s->m, &s->trial);
                s->mu = fmax(1e-6, s->mu / 3);
                return true;
            }
        }
        s->mu *= 4;
    }
    return false;
}

// --- reseeding -------------------------------------------------------------

static double lobe_energy(const struct sky_fit_model *m, int j)
{
    double k = 2 * exp(-2 * m->lobe[j].l);
    return (m->amplitude[0][j] + m->amplitude[1][j] + m->amplitude[2][j]) *
           sky_fit_target_omega(k);
}

// Where most radiance is missing, outside of `avoid`.
static size_t largest_residual(const struct sky_fit_model *m, const bool *avoid)
{
    size_t best = 0;
    double most = -1;
    for (size_t i = 0; i < m->target->count; i++) {
        double r = m->residual[0][i] + m->residual[1][i] + m->residual[2][i];
        if (!avoid[i] && r > most) {
            most = r;
            best = i;
        }
    }
    return best;
}

// Lobes that hold next to nothing start again where something is missing; kept
// if f2 does not rise.
static void reseed(struct lm *s)
{
    const struct sky_fit_target *t = s->m->target;
    double total = 0, lambda = 1.5 * t->lambda_min;
    int moved = 0;
    for (int j = 0; j < s->m->count; j++)
        total += lobe_energy(s->m, j);
    bool *avoid = bytes_zalloc(t->count, sizeof *avoid);
    for (int j = 0; j < s->m->count; j++) {
        s->trial.lobe[j] = s->m->lobe[j];
        if (!(lobe_energy(s->m, j) < 1e-5 * total))
            continue;
        size_t at = largest_residual(s->m, avoid);
        double c[3] = {t->direction[0][at], t->direction[1][at],
                       t->direction[2][at]};
        memcpy(s->trial.lobe[j].centre, c, sizeof c);
        s->trial.lobe[j].l = log(fmin(lambda, t->lambda_max));
        moved++;
        for (size_t i = 0; i < t->count; i++)
            if (t->direction[0][i] * c[0] + t->direction[1][i] * c[1] +
                    t->direction[2][i] * c[2] >
                cos(fmin(lambda, 1)))
                avoid[i] = true;
    }
    free(avoid);
    if (moved == 0)
        return;
    finish_trial(s);
    if (s->trial.f2 <= s->m->f2)
        swap(s->m, &s->trial);
}

int sky_fit_lm_run(struct sky_fit_model *m, struct watch *watch)
{
    if (m->count == 0)
        return 0;
    struct lm s;
    lm_init(&s, m);
    s.watch = watch;
    int done = 0, slow = 0;
    while (done < ITERATIONS && slow < 3 && m->f2 > enough * enough &&
           !watch_cut(watch)) {
        double before = m->f2;
        if (done > 0 && done % RESEED_EVERY == 0 && done <= RESEED_LAST)
            reseed(&s);
        if (!iterate(&s))
            break;
        done++;
        slow = before - m->f2 < 1e-4 * before ? slow + 1 : 0;
    }
    lm_finish(&s);
    return done;
}
