// crossings_ways.c - the few directions along which a lobe is looked up, and
// which slot has them.
#include "renderer/crossings_private.h"

#include <math.h>
#include <string.h>

// Rings of directions, and directions a ring.
enum { LEVELS = 4 };
static const int rings[LEVELS] = {1, 1, 2, 4}, in_ring[LEVELS] = {1, 3, 3, 3};

int crossings_ways_count(const struct crossings_light *l,
                         enum crossings_quality quality)
{
    int level = l->lambda <= 0.16f   ? 0
                : l->lambda <= 0.4f  ? 1
                : l->lambda <= 0.75f ? 2
                                     : 3;
    level -= l->dim + (quality == CROSSINGS_COARSE);
    level = level < 0 ? 0 : level;
    return rings[level] * in_ring[level];
}

// Two unit vectors across z.
static void frame(const float z[3], double x[3], double y[3])
{
    int k = 0;
    for (int i = 1; i < 3; i++)
        if (fabsf(z[i]) < fabsf(z[k]))
            k = i;
    const int i = (k + 1) % 3, j = (k + 2) % 3;
    const double zi = (double)z[i], zj = (double)z[j];
    const double n = sqrt(zi * zi + zj * zj);
    x[k] = 0;
    x[i] = -zj / n;
    x[j] = zi / n;
    for (int c = 0; c < 3; c++) {
        const int u = (c + 1) % 3, v = (c + 2) % 3;
        y[c] = (double)z[u] * x[v] - (double)z[v] * x[u];
    }
}

void crossings_ways_frame(const float z[3], float x[3], float y[3])
{
    double u[3], v[3];
    frame(z, u, v);
    for (int k = 0; k < 3; k++) {
        x[k] = (float)u[k];
        y[k] = (float)v[k];
    }
}

// Rings about the lobe's axis that have equal shares of its density
// exp(2 (cos - 1) / lambda^2) (Xu 2011, eq 2): the distribution function
// inverted at the middle of each.  Every second ring is turned by half a step.
// A count that is no product of a table's is one ring.
void crossings_ways_direction(const struct crossings_light *l, int i, int count,
                              float out[3])
{
    for (int c = 0; c < 3; c++)
        out[c] = l->direction[c];
    if (count <= 1)
        return;
    const int each = count % 3 == 0 ? 3 : count, ring = i / each;
    const double l2 = (double)l->lambda * (double)l->lambda;
    const double u = (ring + 0.5) * each / count;
    const double phi = 2 * M_PI * (i % each + 0.5 * (ring % 2)) / each;
    const double lack = -l2 / 2 * log1p((1 - u) * expm1(-4 / l2)); // 1 - cos
    const double sine = sqrt(fmax(0, lack * (2 - lack)));
    double x[3], y[3], n = 0, d[3];
    frame(l->direction, x, y);
    for (int c = 0; c < 3; c++) {
        d[c] = (1 - lack) * (double)l->direction[c] +
               sine * (cos(phi) * x[c] + sin(phi) * y[c]);
        n += d[c] * d[c];
    }
    for (int c = 0; c < 3; c++)
        out[c] = (float)(d[c] / sqrt(n));
}

// --- slots -------------------------------------------------------------------

enum { GROUPS = 6, MOST = 12 }; // directions a light, at most

// Which are swept together: the axis that a direction follows most, and which
// way.
static int group_of(const float d[3])
{
    int a = fabsf(d[0]) > fabsf(d[1]) ? 0 : 1;
    a = fabsf(d[2]) >= fabsf(d[a]) ? 2 : a;
    return 2 * a + (d[a] > 0);
}

int crossings_ways_slots(int ways)
{
    const int most = (ways + 3 * GROUPS) / 4; // words
    return 4 * (ways < most ? ways : most);
}

// The directions of light j in the order of their groups.
static void sort_ways(struct crossings *c, const struct crossings_light *l,
                      int j)
{
    float(*way)[4] = &c->block->way[c->block->light[j][0]], d[MOST][3];
    const int n = (int)c->block->light[j][1];
    int k = 0;
    for (int i = 0; i < n; i++)
        crossings_ways_direction(l, i, n, d[i]);
    for (int g = 0; g < GROUPS; g++)
        for (int i = 0; i < n; i++)
            if (group_of(d[i]) == g)
                memcpy(way[k++], d[i], sizeof d[i]);
}

// Those of light j that are in group g, from slot `at` on: a run.  Returns the
// slot after it.
static int put_run(struct crossings *c, int j, int g, int at)
{
    struct crossings_block *b = c->block;
    const int first = (int)b->light[j][0], n = (int)b->light[j][1];
    int put = 0, before = 0;
    for (int i = first; i < first + n; i++) {
        const int of = group_of(b->way[i]);
        before += of < g;
        if (of != g)
            continue;
        b->way[i][3] = (float)at;
        c->slots_way[at++] = i;
        put++;
    }
    if (put > 0)
        b->run[at - 1] = (uint32_t)(j + 1) | CROSSINGS_RUN_END |
                         (before > 0 ? CROSSINGS_RUN_AGAIN : 0) |
                         (put < n ? CROSSINGS_RUN_SHARED : 0) |
                         (uint32_t)n << CROSSINGS_RUN_WAYS;
    return at;
}

void crossings_ways_lay(struct crossings *c, const struct crossings_light *l)
{
    int at = 0;
    for (int i = 0; i < CROSSINGS_WAYS_MAX; i++) // of none, until one comes
        c->block->run[i] = CROSSINGS_RUN_END;
    for (int j = 0; j < c->stats.lights; j++)
        sort_ways(c, &l[j], j);
    for (int g = 0; g < GROUPS; g++) {
        c->swept[g].first = at;
        for (int j = 0; j < c->stats.lights; j++) {
            const int from = at;
            at = put_run(c, j, g, at);
            for (int i = from; i < at - 1; i++)
                c->block->run[i] = 0;
        }
        c->swept[g].count = at - c->swept[g].first;
        at = (at + 3) / 4 * 4;
    }
    c->block->all[0] = ((uint32_t)at + CROSSINGS_BANK - 1) / CROSSINGS_BANK;
}
