// lit_source.c - which lights are one, and how the shaders' loops read them.
#include "renderer/lit_source.h"

#include <math.h>
#include <string.h>

// Width of lobes from which on `spread` is had whole: beta of 3.4 degrees.
// Places then err no more with narrow lobes than with wide ones
// (docs/METHODS.md).
static const double wide = 0.168;

double lit_source_spread(const struct lit_fibre *f, double spread)
{
    return spread * fmin(exp2(floor(log2(lit_plan_narrowest(f) / wide))), 1);
}

void lit_source_group(struct light_groups *g, const struct lights *l,
                      double spread)
{
    struct light_groups_light light[LIT_PLAN_LIGHTS];
    const int sky = l->used - l->suns;
    for (int j = 0; j < l->used; j++) {
        const struct lights_place *from = &l->place[j];
        for (int c = 0; c < 3; c++)
            light[j].direction[c] = (double)from->direction[c];
        light[j].lambda = (double)from->lambda;
        light[j].power = (double)from->share;
    }
    light_groups_make(g, light, sky, spread);
    for (int j = sky; j < l->used; j++) {
        struct light_groups_group *sun = &g->group[g->count++];
        *sun = (struct light_groups_group){
            .lambda = light[j].lambda, .power = 1, .first = j, .end = j + 1};
        memcpy(sun->direction, light[j].direction, sizeof sun->direction);
        g->member[j] = j;
    }
    g->lights = l->used;
}

// Tables begin at multiples of four columns' cells (lit_plan.c: phis_for).
static uint32_t in_short(const uint32_t light[4])
{
    const uint32_t rows = light[1] >> 16, phis = light[1] & 0xffff;
    return light[2] / (4 * LIT_PLAN_D) << 14 | rows << 4 | phis / 4;
}

void lit_source_put(struct lit_sources *s, const struct lights *l,
                    const struct light_groups *g, const struct lit_plan *plan)
{
    memset(s, 0, sizeof *s);
    for (int j = 0; j < l->used; j++) {
        s->light[j].table = in_short(plan->block.light[j]);
        memcpy(s->light[j].radiance, l->radiance[j],
               sizeof s->light[j].radiance);
    }
    for (int i = 0; i < g->count; i++) {
        struct lit_source_group *out = &s->group[i];
        out->lambda = (float)g->group[i].lambda;
        for (int k = g->group[i].first; k < g->group[i].end; k++) {
            const float *r = l->radiance[g->member[k]];
            for (int c = 0; c < 3; c++)
                out->flux[c] += r[c] * r[3]; // w: solid angle
        }
    }
}

void lit_source_members(struct lit_members *m, const struct light_groups *g,
                        const struct lights *l)
{
    memset(m, 0, sizeof *m);
    m->count[0] = (uint32_t)g->count;
    for (int i = 0; i < g->count; i++) {
        const struct light_groups_group *from = &g->group[i];
        for (int c = 0; c < 3; c++)
            m->axis[i][c] = (float)from->direction[c];
        m->axis[i][3] = (float)from->lambda;
        for (int k = from->first; k < from->end; k++) {
            const double share = (double)l->place[g->member[k]].share;
            const float weight = (float)(share / from->power);
            m->member[k][0] = (uint32_t)g->member[k];
            memcpy(&m->member[k][1], &weight, sizeof weight);
        }
        m->member[from->end - 1][2] = (uint32_t)i + 1;
    }
}
