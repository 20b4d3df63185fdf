// sky_fit_start.c - orthogonal matching pursuit with non-negative amplitudes
// (Pati, Rezaiifar and Krishnaprasad 1993, in colour).
//
// Atoms are lobes of up to five widths at 32 x 16 centres.  Centres of one row
// and width differ by a turn, so a table per row and width, as long as two
// turns, holds them all; an atom's inner product with the residual is a
// rectangle of the table against the residual.
#include "renderer/sky_fit_start.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "renderer/sky_fit_vector.h"
#include "renderer/watch.h"

static const double pi = 3.14159265358979323846;

enum { ROWS = 16, COLUMNS = 32, WIDTHS = 5, FIRST_REFITS = 10 };

struct atoms {
    const struct sky_fit_target *t;
    int widths;
    double lambda[WIDTHS];
    float *table;           // [widths][ROWS][t->height][2 * t->width]
    int from[WIDTHS][ROWS]; // rows of the target that an atom reaches
    int to[WIDTHS][ROWS];   // one beyond the last
    double *norm2;          // [widths][ROWS][COLUMNS], weighted
    bool *taken;            // the same
    float *z[3];            // root * residual
};

static size_t index_of(int width, int row, int column)
{
    return ((size_t)width * ROWS + (size_t)row) * COLUMNS + (size_t)column;
}

static float *table_at(const struct atoms *a, int width, int row, int target)
{
    return a->table +
           (((size_t)width * ROWS + (size_t)row) * (size_t)a->t->height +
            (size_t)target) *
               2 * (size_t)a->t->width;
}

// Widths in units of the narrowest; clipped to the bounds, each once.
static void choose_widths(struct atoms *a)
{
    static const double hair[WIDTHS] = {1.02, 1.7, 3, 5.5, 10};
    static const double plain[WIDTHS] = {1.02, 2, 4, 10, 30};
    const double *of = a->t->blur > 0 ? hair : plain;
    for (int i = 0; i < WIDTHS; i++) {
        double lambda = fmin(of[i] * a->t->lambda_min, a->t->lambda_max);
        if (a->widths == 0 || lambda > 1.001 * a->lambda[a->widths - 1])
            a->lambda[a->widths++] = lambda;
    }
}

static void fill_row(struct atoms *a, int width, int row, int target)
{
    const struct sky_fit_target *t = a->t;
    double k = 2 / (a->lambda[width] * a->lambda[width]);
    double p = pi * (row + 0.5) / ROWS, q = pi * (target + 0.5) / t->height;
    float *to = table_at(a, width, row, target), largest = 0;
    double shift = t->width - 0.5 + 0.5 * t->width / COLUMNS;
    for (int d = 0; d < 2 * t->width; d++) {
        double phi = 2 * pi * (d - shift) / t->width;
        to[d] =
            (float)exp(k * (cos(p) * cos(q) + sin(p) * sin(q) * cos(phi) - 1));
        largest = fmaxf(largest, to[d]);
    }
    if (largest > 1e-6f) {
        if (a->to[width][row] == 0)
            a->from[width][row] = target;
        a->to[width][row] = target + 1;
    }
}

// The rectangle of atom (width, row, column), against z.
static struct sky_fit_vector_patch patch(const struct atoms *a, int width,
                                         int row, int column)
{
    const struct sky_fit_target *t = a->t;
    int from = a->from[width][row];
    size_t w = (size_t)t->width, at = (size_t)from * w;
    int step = t->width / COLUMNS;
    return (struct sky_fit_vector_patch){
        table_at(a, width, row, from) + (t->width - step * column),
        2 * w,
        {a->z[0] + at, a->z[1] + at, a->z[2] + at},
        w,
        (size_t)(a->to[width][row] - from)};
}

static double weighted_norm2(const struct atoms *a, int width, int row,
                             int column)
{
    struct sky_fit_vector_patch p = patch(a, width, row, column);
    const double *root = a->t->root + (size_t)a->from[width][row] * p.width;
    double sum = 0;
    for (size_t r = 0; r < p.rows; r++)
        for (size_t i = 0; i < p.width; i++) {
            double g = (double)p.a[r * p.stride + i] * root[r * p.width + i];
            sum += g * g;
        }
    return sum;
}

static void atoms_init(struct atoms *a, const struct sky_fit_target *t,
                       struct watch *watch)
{
    *a = (struct atoms){.t = t};
    choose_widths(a);
    size_t count = index_of(a->widths, 0, 0);
    a->table = bytes_alloc((size_t)a->widths * ROWS * (size_t)t->height * 2 *
                           (size_t)t->width * sizeof *a->table);
    a->norm2 = bytes_alloc(count * sizeof *a->norm2);
    a->taken = bytes_zalloc(count, sizeof *a->taken);
    for (int c = 0; c < 3; c++)
        a->z[c] = bytes_alloc(t->count * sizeof *a->z[c]);
    for (int w = 0; w < a->widths; w++)
        for (int r = 0; r < ROWS && !watch_cut(watch); r++) {
            for (int y = 0; y < t->height; y++)
                fill_row(a, w, r, y);
            for (int c = 0; c < COLUMNS; c++)
                a->norm2[index_of(w, r, c)] = weighted_norm2(a, w, r, c);
        }
}

static void atoms_finish(struct atoms *a)
{
    free(a->table);
    free(a->norm2);
    free(a->taken);
    for (int c = 0; c < 3; c++)
        free(a->z[c]);
}

struct pick {
    int width, row, column;
    double along[3]; // amplitude that removes most of the residual, >= 0
    double gain;     // 0: nothing to pick
};

static struct pick best_atom(struct atoms *a, const struct sky_fit_model *m)
{
    struct pick best = {0};
    for (int c = 0; c < 3; c++)
        for (size_t i = 0; i < a->t->count; i++)
            a->z[c][i] = (float)(a->t->root[i] * m->residual[c][i]);
    for (int w = 0; w < a->widths; w++)
        for (int r = 0; r < ROWS; r++)
            for (int col = 0; col < COLUMNS; col++) {
                size_t i = index_of(w, r, col);
                if (a->taken[i] || !(a->norm2[i] > 0))
                    continue;
                struct sky_fit_vector_patch p = patch(a, w, r, col);
                double s[3], gain = 0;
                sky_fit_vector_patch_dot(&p, s);
                for (int c = 0; c < 3; c++) {
                    s[c] = fmax(0, s[c]);
                    gain += s[c] * s[c] / a->norm2[i];
                }
                if (gain > best.gain)
                    best =
                        (struct pick){w,
                                      r,
                                      col,
                                      {s[0] / a->norm2[i], s[1] / a->norm2[i],
                                       s[2] / a->norm2[i]},
                                      gain};
            }
    return best;
}

static void take(struct atoms *a, struct sky_fit_model *m, const struct pick *p)
{
    double theta = pi * (p->row + 0.5) / ROWS;
    double phi = pi - 2 * pi * (p->column + 0.5) / COLUMNS;
    int j = m->count++;
    m->lobe[j] = (struct sky_fit_lobe){
        {sin(theta) * cos(phi), sin(theta) * sin(phi), cos(theta)},
        log(a->lambda[p->width])};
    for (int c = 0; c < 3; c++)
        m->amplitude[c][j] = p->along[c];
    a->taken[index_of(p->width, p->row, p->column)] = true;
    sky_fit_model_update(m, j);
}

void sky_fit_start_run(struct sky_fit_model *m, int lights, struct watch *watch)
{
    struct atoms a;
    atoms_init(&a, m->target, watch);
    int every = lights / 20 > 1 ? lights / 20 : 1;
    while (m->count < lights && !watch_cut(watch)) {
        struct pick p = best_atom(&a, m);
        if (!(p.gain > 0))
            break;
        take(&a, m, &p);
        if (m->count <= FIRST_REFITS || m->count % every == 0 ||
            m->count == lights)
            sky_fit_model_refit(m);
        else
            sky_fit_model_residual(m);
    }
    sky_fit_model_refit(m);
    atoms_finish(&a);
}
