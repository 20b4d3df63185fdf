// lit_plan.h - what shape the tables of lights have (lit_tables.h): of each
// light's how many cells a turn of s, over |Phi|, and where they begin.
// Thread: any.
#ifndef RENDERER_LIT_PLAN_H
#define RENDERER_LIT_PLAN_H

#include <stdbool.h>
#include <stdint.h>

#include "renderer/dual_azimuth.h"

enum {
    LIT_PLAN_LIGHTS = 200,
    LIT_PLAN_D = 26, // shape: shaders/lit_size.glsl has it too
    LIT_PLAN_FAR_D = 12,
    LIT_PLAN_FAR_P = 8,
    LIT_PLAN_NEAR_BYTES = 32, // of a cell
    LIT_PLAN_FAR_BYTES = 32
};

struct lit_fibre {
    struct dual_fibre fibre;
    bool opaque;   // TT and TRT are left out
    bool multiple; // with light that several fibres scatter
    float d_b;     // how much of it turns back: fibre.d_b
};

struct lit_block { // uniform block Lit (shaders/lit.glsl)
    float far[4];
    uint32_t from[4], light[LIT_PLAN_LIGHTS][4], rest[LIT_PLAN_LIGHTS / 4][4];
};

struct lit_plan {
    struct lit_block block;
    uint32_t cells, far_cells; // of all lights; of the far table
    uint32_t columns;          // most of any light
};

// Every byte is written: plans compare as bytes.  lambda: of each light.
void lit_plan_make(struct lit_plan *plan, const struct lit_fibre *f,
                   const float *lambda, int count);

#endif
