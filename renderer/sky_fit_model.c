// sky_fit_model.c - the linear half of a fit.  Where lobes sit and how wide
// they are is the business of sky_fit_start.c and sky_fit_lm.c.
#include "renderer/sky_fit_model.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "renderer/sky_fit_solve.h"
#include "renderer/sky_fit_vector.h"

void sky_fit_model_init(struct sky_fit_model *m, const struct sky_fit_target *t,
                        int capacity)
{
    size_t n = (size_t)capacity;
    memset(m, 0, sizeof *m);
    m->target = t;
    m->capacity = capacity;
    m->basis = bytes_alloc(n * t->count * sizeof *m->basis);
    m->gram = bytes_zalloc(n * n, sizeof *m->gram);
    for (int c = 0; c < 3; c++) {
        m->rhs[c] = bytes_zalloc(n, sizeof(double));
        m->residual[c] = bytes_alloc(t->count * sizeof(double));
    }
    sky_fit_model_residual(m);
}

void sky_fit_model_finish(struct sky_fit_model *m)
{
    free(m->basis);
    free(m->gram);
    for (int c = 0; c < 3; c++) {
        free(m->rhs[c]);
        free(m->residual[c]);
    }
    memset(m, 0, sizeof *m);
}

// root * exp(k (w . c - 1)), k = 2 / lambda^2 (Xu 2011, eq 1).
static void fill(const struct sky_fit_target *t, const struct sky_fit_lobe *l,
                 float *column)
{
    double k = 2 * exp(-2 * l->l);
    const double *x = t->direction[0], *y = t->direction[1],
                 *z = t->direction[2], *c = l->centre;
    for (size_t i = 0; i < t->count; i++) {
        double e = k * (x[i] * c[0] + y[i] * c[1] + z[i] * c[2] - 1);
        column[i] = e < -60 ? 0 : (float)(t->root[i] * exp(e));
    }
}

void sky_fit_model_update(struct sky_fit_model *m, int first)
{
    size_t n = m->target->count, stride = (size_t)m->capacity;
    for (size_t j = (size_t)first; j < (size_t)m->count; j++) {
        float *column = m->basis + j * n;
        fill(m->target, &m->lobe[j], column);
        for (size_t i = 0; i <= j; i++)
            m->gram[j * stride + i] = m->gram[i * stride + j] =
                sky_fit_vector_dot(m->basis + i * n, column, n);
        for (int c = 0; c < 3; c++)
            m->rhs[c][j] =
                sky_fit_vector_dot_fd(column, m->target->value[c], n);
    }
}

void sky_fit_model_refit(struct sky_fit_model *m)
{
    size_t n = (size_t)m->count, stride = (size_t)m->capacity;
    double trace = 0;
    for (size_t i = 0; i < n; i++)
        trace += m->gram[i * stride + i];
    double ridge = n > 0 ? 1e-9 * trace / (double)n : 0;
    for (size_t i = 0; i < n; i++)
        m->gram[i * stride + i] += ridge;
    for (int c = 0; c < 3; c++)
        sky_fit_solve_nnls(m->gram, n, stride, m->rhs[c], m->amplitude[c]);
    for (size_t i = 0; i < n; i++)
        m->gram[i * stride + i] -= ridge;
    sky_fit_model_residual(m);
}

void sky_fit_model_residual(struct sky_fit_model *m)
{
    const struct sky_fit_target *t = m->target;
    double sum = 0;
    for (int c = 0; c < 3; c++) {
        memcpy(m->residual[c], t->value[c], t->count * sizeof(double));
        for (int j = 0; j < m->count; j++)
            if (m->amplitude[c][j] > 0)
                sky_fit_vector_add(m->residual[c], -m->amplitude[c][j],
                                   m->basis + (size_t)j * t->count, t->count);
        sum += sky_fit_vector_dot_dd(m->residual[c], m->residual[c], t->count);
    }
    m->f2 = t->norm2 > 0 ? sum / t->norm2 : 0;
}
