// crossings_grid.c - puts strands into voxels: area density rho = sum(length x
// diameter) / volume, weighted by opacity, and rho times the mean of t t^T.
// The box and the GPU's copy are crossings.c's business.
#include "renderer/crossings_private.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "protocol/bytes.h"
#include "renderer/place.h"
#include "renderer/shoot_threads.h"

enum {
    SLABS = 2,
    LOOK_EVERY = 256,
    LOOK_POINTS = 1 << 14
}; // one thread each; strands

void crossings_grid_hair(struct crossings_hair *h, const float corner[3],
                         float unit, const struct groom *g,
                         const struct params *p)
{
    const bool varies = place_diameter_varies(g, p);
    const float inverse = 1 / unit;
    float d = varies ? 0 : place_diameter(g, p, 0);
    h->first = g->first;
    h->strands = g->strands;
    h->points = g->points;
    h->at = bytes_alloc((size_t)g->points * 4 * sizeof *h->at);
    h->opacity = NULL;
    for (uint32_t i = 0; i < g->points; i++) {
        if (i % LOOK_POINTS == 0 && watch_cut(h->watch))
            return;
        float *out = h->at + 4 * (size_t)i;
        place_point(g, p, i, out);
        for (int k = 0; k < 3; k++)
            out[k] = (out[k] - corner[k]) * inverse;
        if (varies)
            d = place_diameter(g, p, i);
        out[3] = place_width(p, d) * inverse;
    }
    if (!p->hair.use_opacity)
        return;
    h->opacity = bytes_alloc((size_t)g->points * sizeof *h->opacity);
    for (uint32_t i = 0; i < g->points; i++)
        h->opacity[i] = g->opacity ? g->opacity[i] : g->default_opacity;
}

void crossings_grid_hair_finish(struct crossings_hair *h)
{
    free(h->at);
    free(h->opacity);
    memset(h, 0, sizeof *h);
}

struct splat {
    const struct crossings_hair *hair;
    const int *size;
    float *const *tensor;
};

static int voxel_of(float x, int size)
{
    int i = (int)x;
    return i < 0 ? 0 : i < size ? i : size - 1;
}

static void deposit(const struct splat *s, const float at[3], const int slab[2],
                    const float what[7])
{
    const int z = voxel_of(at[2], s->size[2]);
    if (z < slab[0] || z >= slab[1])
        return;
    const int x = voxel_of(at[0], s->size[0]), y = voxel_of(at[1], s->size[1]);
    const size_t i =
        4 * (((size_t)z * (size_t)s->size[1] + (size_t)y) * (size_t)s->size[0] +
             (size_t)x);
    for (size_t k = 0; k < 4; k++)
        s->tensor[0][i + k] += what[k];
    for (size_t k = 0; k < 3; k++)
        s->tensor[1][i + k] += what[4 + k];
}

// Pieces of at most half a voxel, each put where its middle is.
static void splat_segment(const struct splat *s, uint32_t i, const int slab[2])
{
    const float *a = s->hair->at + 4 * (size_t)i, *b = a + 4;
    const float low = fminf(a[2], b[2]), high = fmaxf(a[2], b[2]);
    const bool first = slab[0] == 0, last = slab[1] == s->size[2];
    if ((high < (float)slab[0] && !first) || (low >= (float)slab[1] && !last))
        return;
    float e[3], length = 0;
    for (int k = 0; k < 3; k++) {
        e[k] = b[k] - a[k];
        length += e[k] * e[k];
    }
    length = sqrtf(length);
    if (!(length > 0))
        return;
    const int pieces = 1 + (int)(2 * length);
    const float *o = s->hair->opacity ? s->hair->opacity + i : NULL;
    const float xx = e[0] / length, yy = e[1] / length, zz = e[2] / length;
    for (int n = 0; n < pieces; n++) {
        const float t = ((float)n + 0.5f) / (float)pieces;
        float at[3], area = length / (float)pieces;
        for (int k = 0; k < 3; k++)
            at[k] = a[k] + t * e[k];
        area *= a[3] + t * (b[3] - a[3]);
        if (o)
            area *= o[0] + t * (o[1] - o[0]);
        const float what[7] = {area,           area * xx * xx, area * yy * yy,
                               area * zz * zz, area * yy * zz, area * zz * xx,
                               area * xx * yy};
        deposit(s, at, slab, what);
    }
}

// Each thread has its own slices of the grid and takes the strands in order,
// so that the sums do not depend on how the threads run.
static void splat_slab(void *context, size_t n)
{
    const struct splat *s = context;
    const int depth = s->size[2];
    const int slab[2] = {depth * (int)n / SLABS, depth * ((int)n + 1) / SLABS};
    for (uint32_t k = 0; k < s->hair->strands; k++) {
        if (k % LOOK_EVERY == 0 && watch_cut(s->hair->watch))
            return;
        for (uint32_t i = s->hair->first[k]; i + 1 < s->hair->first[k + 1]; i++)
            splat_segment(s, i, slab);
    }
}

void crossings_grid_splat(const struct crossings_hair *h, const int size[3],
                          float *const tensor[2])
{
    struct splat s = {h, size, tensor};
    shoot_threads(SLABS, splat_slab, &s);
}
