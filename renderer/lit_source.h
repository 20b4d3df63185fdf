// lit_source.h - what the loops over lights read of them
// (shaders/shade_lit.glsl, lit_record.glsl): of each light its table and what
// it shines with, and which lights are a group (light_groups.h). Thread: any.
#ifndef RENDERER_LIT_SOURCE_H
#define RENDERER_LIT_SOURCE_H

#include "renderer/light_groups.h"
#include "renderer/lights.h"
#include "renderer/lit_plan.h"

// As shaders/lit.glsl has them: a texel each ...
struct lit_source_light {
    uint32_t table; // in one number: lit_table; 0: none
    float radiance[3];
};
struct lit_source_group {
    float lambda, flux[3];
};
struct lit_sources {
    struct lit_source_light light[LIT_PLAN_LIGHTS];
    struct lit_source_group group[LIT_PLAN_LIGHTS];
};

// ... and the uniform block, from lit_groups on.
struct lit_members {
    uint32_t count[4];
    uint32_t member[LIT_PLAN_LIGHTS][4];
    float axis[LIT_PLAN_LIGHTS][4];
};

// What grouping may move the sky's light by (rad), of `spread`, which holds
// where fibres scatter it as far as light hair does: narrower lobes, which
// leave more to see of where it began, have a half of it, a quarter ...
double lit_source_spread(const struct lit_fibre *f, double spread);
// Which lights are one for what other fibres scatter forward.  A sun stays
// alone.
void lit_source_group(struct light_groups *g, const struct lights *l,
                      double spread);

// Every byte is written.
void lit_source_put(struct lit_sources *s, const struct lights *l,
                    const struct light_groups *g, const struct lit_plan *plan);
void lit_source_members(struct lit_members *m, const struct light_groups *g,
                        const struct lights *l);

#endif
