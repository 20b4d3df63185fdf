// lit_source.c - packs lights and groups as the shaders' loops read them.
#include "renderer/lit_source.h"

#include <string.h>

// Tables begin at multiples of four columns' cells (lit_plan.c: phis_for).
static uint32_t in_short(const uint32_t light[4])
{
    const uint32_t rows = light[1] >> 16, phis = light[1] & 0xffff;
    return light[2] / (4 * LIT_PLAN_D) << 14 | rows << 4 | phis / 4;
}

void lit_source_lights(struct lit_sources *s, const struct lights *l,
                       const struct lit_plan *plan)
{
    memset(s, 0, sizeof *s);
    for (int j = 0; j < l->used; j++) {
        s->light[j].table = in_short(plan->block.light[j]);
        memcpy(s->light[j].radiance, l->radiance[j],
               sizeof s->light[j].radiance);
    }
    for (int i = 0; i < l->groups; i++) {
        s->group[i].lambda = l->group[i].lambda;
        memcpy(s->group[i].flux, l->group[i].flux, sizeof s->group[i].flux);
    }
}

void lit_source_groups(struct lit_groups *g, const struct lights *l)
{
    memset(g, 0, sizeof *g);
    g->count[0] = (uint32_t)l->groups;
    for (int i = 0; i < l->groups; i++) {
        const struct lights_group *from = &l->group[i];
        memcpy(g->axis[i], from->direction, sizeof from->direction);
        g->axis[i][3] = from->lambda;
        for (int k = from->first; k < from->end; k++) {
            g->member[k][0] = (uint32_t)l->member[k];
            memcpy(&g->member[k][1], &l->weight[k], sizeof l->weight[k]);
        }
        g->member[from->end - 1][2] = (uint32_t)i + 1;
    }
}
