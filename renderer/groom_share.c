// groom_share.c - a groom of fewer, wider strands that cover as much.
#include "renderer/groom.h"

#include <stdlib.h>
#include <string.h>

// Values of the strands that stay, `width` a point, or NULL where there are
// none.
static float *values(const struct groom *from, const struct groom *to,
                     const float *all, size_t width, uint32_t stride)
{
    if (!all)
        return NULL;
    float *out = bytes_alloc(to->points * width * sizeof *out);
    for (uint32_t k = 0; k < to->strands; k++)
        memcpy(out + width * to->first[k],
               all + width * from->first[k * stride],
               (to->first[k + 1] - to->first[k]) * width * sizeof *out);
    return out;
}

struct groom *groom_share(const struct groom *g, uint32_t stride)
{
    struct groom *s = bytes_alloc(sizeof *s);
    *s = *g;
    s->strands = (g->strands + stride - 1) / stride;
    s->first = bytes_zalloc((size_t)s->strands + 1, sizeof *s->first);
    for (uint32_t k = 0; k < s->strands; k++)
        s->first[k + 1] =
            s->first[k] + g->first[k * stride + 1] - g->first[k * stride];
    s->points = s->first[s->strands];
    s->position = values(g, s, g->position, 3, stride);
    s->diameter = values(g, s, g->diameter, 1, stride);
    s->opacity = values(g, s, g->opacity, 1, stride);
    s->colour = values(g, s, g->colour, 3, stride);
    for (uint32_t i = 0; s->diameter && i < s->points; i++)
        s->diameter[i] *= (float)stride;
    s->default_diameter *= (float)stride;
    return s;
}
