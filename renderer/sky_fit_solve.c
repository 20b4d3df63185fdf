// sky_fit_solve.c - see the header.
#include "renderer/sky_fit_solve.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "protocol/bytes.h"
#include "renderer/sky_fit_vector.h"

bool sky_fit_solve_cholesky(double *a, size_t n, size_t stride)
{
    for (size_t i = 0; i < n; i++) {
        double *ri = a + i * stride;
        for (size_t j = 0; j < i; j++) {
            const double *rj = a + j * stride;
            ri[j] = (ri[j] - sky_fit_vector_dot_dd(ri, rj, j)) / rj[j];
        }
        double d = ri[i] - sky_fit_vector_dot_dd(ri, ri, i);
        if (!(d > 0) || !isfinite(d))
            return false;
        ri[i] = sqrt(d);
    }
    return true;
}

void sky_fit_solve_forward(const double *l, size_t n, size_t stride, double *x)
{
    for (size_t i = 0; i < n; i++) {
        const double *r = l + i * stride;
        x[i] = (x[i] - sky_fit_vector_dot_dd(r, x, i)) / r[i];
    }
}

void sky_fit_solve_backward(const double *l, size_t n, size_t stride, double *x)
{
    for (size_t i = n; i-- > 0;) {
        const double *r = l + i * stride;
        x[i] /= r[i];
        for (size_t j = 0; j < i; j++)
            x[j] -= r[j] * x[i];
    }
}

struct nnls {
    const double *a, *b;
    size_t n, stride;
    double *x;
    size_t *set, count; // indices that are free to be positive
    double *l, *s;      // factor and solution on the set
};

static void drop(struct nnls *w, size_t at)
{
    w->x[w->set[at]] = 0;
    memmove(w->set + at, w->set + at + 1, (w->count - at - 1) * sizeof *w->set);
    w->count--;
}

static bool solve_on_set(struct nnls *w)
{
    size_t m = w->count;
    for (size_t i = 0; i < m; i++) {
        for (size_t j = 0; j <= i; j++)
            w->l[i * m + j] = w->a[w->set[i] * w->stride + w->set[j]];
        w->s[i] = w->b[w->set[i]];
    }
    if (!sky_fit_solve_cholesky(w->l, m, m))
        return false;
    sky_fit_solve_forward(w->l, m, m, w->s);
    sky_fit_solve_backward(w->l, m, m, w->s);
    return true;
}

// Goes towards the free solution and stops where a component reaches zero,
// until none does.
static void settle(struct nnls *w)
{
    while (w->count > 0) {
        if (!solve_on_set(w)) { // numerically dependent: the last one goes
            drop(w, w->count - 1);
            continue;
        }
        double step = 1;
        size_t first = w->count;
        for (size_t i = 0; i < w->count; i++) {
            double x = w->x[w->set[i]];
            if (w->s[i] <= 0 && x / (x - w->s[i]) < step) {
                step = x / (x - w->s[i]);
                first = i;
            }
        }
        for (size_t i = 0; i < w->count; i++) {
            double *x = &w->x[w->set[i]];
            *x += step * (w->s[i] - *x);
        }
        if (first == w->count)
            return;
        for (size_t i = w->count; i-- > 0;)
            if (i == first || !(w->x[w->set[i]] > 0))
                drop(w, i);
    }
}

// The index outside the set along which the objective falls most steeply.
static size_t steepest(const struct nnls *w, const bool *barred)
{
    double best = 0;
    size_t at = w->n;
    for (size_t i = 0; i < w->n; i++) {
        if (w->x[i] > 0 || barred[i])
            continue;
        double g = w->b[i];
        for (size_t k = 0; k < w->count; k++)
            g -= w->a[i * w->stride + w->set[k]] * w->x[w->set[k]];
        // In units in which rounding of g is about 1e-15.
        g /= fabs(w->b[i]) + 1e-300;
        if (w->b[i] > 0 && g > best) {
            best = g;
            at = i;
        }
    }
    return best > 1e-10 ? at : w->n;
}

void sky_fit_solve_nnls(const double *a, size_t n, size_t stride,
                        const double *b, double *x)
{
    struct nnls w = {a, b, n, stride, x, NULL, 0, NULL, NULL};
    w.set = bytes_alloc((n + 1) * sizeof *w.set);
    w.l = bytes_alloc((n * n + 1) * sizeof *w.l);
    w.s = bytes_alloc((n + 1) * sizeof *w.s);
    bool *barred = bytes_zalloc(n + 1, sizeof *barred);
    for (size_t i = 0; i < n; i++)
        if (x[i] > 0)
            w.set[w.count++] = i;
        else
            x[i] = 0;
    settle(&w);
    for (size_t turn = 0; turn < 3 * n; turn++) {
        size_t i = steepest(&w, barred);
        if (i == n)
            break;
        w.set[w.count++] = i;
        x[i] = 0;
        settle(&w);
        // Rounding alone made it look useful: do not come back to it.
        if (!(x[i] > 0))
            barred[i] = true;
    }
    free(w.set);
    free(w.l);
    free(w.s);
    free(barred);
}
