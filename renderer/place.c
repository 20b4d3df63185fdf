// place.c - see the header.  What is done with the numbers is strands.c's and
// shoot.c's business.
#include "renderer/place.h"

#include <math.h>
#include <string.h>

int place_up(const struct groom *g, const struct params *p)
{
    return p->hair.up > 0 ? p->hair.up - 1 : g->up;
}

void place_axes(int up, const float in[3], float out[3])
{
    switch (up) {
    case 0: // x up
        memcpy(out, (float[3]){in[1], in[2], in[0]}, 12);
        break;
    case 1: // y up
        memcpy(out, (float[3]){in[0], -in[2], in[1]}, 12);
        break;
    default:
        memcpy(out, in, 12);
    }
}

void place_point(const struct groom *g, const struct params *p, uint32_t i,
                 float out[3])
{
    float at[3];
    place_axes(place_up(g, p), g->position + 3 * (size_t)i, at);
    for (int c = 0; c < 3; c++)
        out[c] = p->hair.scale * at[c];
}

bool place_diameter_varies(const struct groom *g, const struct params *p)
{
    return p->hair.diameter <= 0 && g->diameter;
}

float place_diameter(const struct groom *g, const struct params *p, uint32_t i)
{
    if (p->hair.diameter > 0)
        return p->hair.diameter;
    if (g->diameter)
        return g->diameter[i];
    return g->default_diameter > 0 ? g->default_diameter
                                   : groom_auto_diameter(g);
}

float place_width(const struct params *p, float diameter)
{
    return fmaxf(p->hair.scale * diameter, 1e-12f);
}

bool place_head(const struct groom *g, const struct params *p, float centre[3],
                float radius[3])
{
    if (!g->head.present)
        return false;
    float c[3], r[3];
    const int up = place_up(g, p);
    place_axes(up, g->head.centre, c);
    place_axes(up, g->head.radius, r);
    for (int k = 0; k < 3; k++) {
        centre[k] = p->hair.scale * c[k];
        radius[k] = p->hair.scale * fabsf(r[k]);
    }
    return true;
}
