// grown.c - the same bytes on every call.
#include "tests/bench/grown.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// In [-1, 1].
static float noise(uint32_t strand, uint32_t axis)
{
    uint32_t h = strand * 2654435769u + axis * 0x9e3779b9u;
    h ^= h >> 16;
    h *= 0x7feb352du;
    h ^= h >> 15;
    return (float)(h >> 8) / 8388608.0f - 1;
}

static void strand(const struct groom *from, uint32_t source, uint32_t points,
                   const float shift[3], float *out)
{
    const float *p = from->position + 3 * (size_t)from->first[source];
    const uint32_t n = from->first[source + 1] - from->first[source];
    for (uint32_t i = 0; i < points; i++) {
        const float at = (float)i / (float)(points - 1) * (float)(n - 1);
        uint32_t k = (uint32_t)at;
        k = k + 2 > n ? n - 2 : k;
        for (uint32_t c = 0; c < 3; c++)
            out[3 * i + c] =
                p[3 * k + c] +
                (at - (float)k) * (p[3 * (k + 1) + c] - p[3 * k + c]) +
                shift[c];
    }
}

static void measure(struct groom *g)
{
    for (int c = 0; c < 3; c++)
        g->box_min[c] = g->box_max[c] = g->position[c];
    for (size_t i = 0; i < 3 * (size_t)g->points; i++) {
        const float v = g->position[i];
        if (v < g->box_min[i % 3])
            g->box_min[i % 3] = v;
        if (v > g->box_max[i % 3])
            g->box_max[i % 3] = v;
    }
}

struct groom *grown_groom(uint32_t strands, uint32_t points, struct error *err)
{
    struct groom *from = groom_builtin("straight", err);
    if (!from)
        return NULL;
    struct groom *g = bytes_alloc(sizeof *g);
    *g = *from; // but for the arrays: head, axis, nothing by point
    snprintf(g->name, sizeof g->name, "grown:%u x %u", strands, points);
    g->strands = strands;
    g->points = strands * points;
    g->first = bytes_alloc(((size_t)strands + 1) * sizeof *g->first);
    g->position = bytes_alloc(3 * (size_t)g->points * sizeof *g->position);
    for (uint32_t i = 0; i < strands; i++) {
        const uint32_t copy = i / from->strands;
        const uint32_t source =
            strands < from->strands
                ? (uint32_t)((uint64_t)i * from->strands / strands)
                : i % from->strands;
        float shift[3];
        for (uint32_t c = 0; c < 3; c++)
            shift[c] = copy > 0 ? 0.25f * noise(i, c) : 0;
        g->first[i] = i * points;
        strand(from, source, points, shift,
               g->position + 3 * (size_t)i * points);
    }
    g->first[strands] = g->points;
    measure(g);
    groom_destroy(from);
    return g;
}
