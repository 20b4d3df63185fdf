// lit_plan.h - what shape the tables of lights have (lit_tables.h): which
// lights share one, how many cells a turn of s and over |Phi|, where they
// begin.
//
// What a table holds depends on the fibre and on a light's width alone, neither
// on its place nor on its colour.  So lights of one width have one table, and
// those of nearly one width, too, where that changes little of what they do.
// The plan depends on what it is told and on nothing that was before.
// Thread: any.
#ifndef RENDERER_LIT_PLAN_H
#define RENDERER_LIT_PLAN_H

#include <stdbool.h>
#include <stdint.h>

#include "renderer/dual_azimuth.h"

enum {
    LIT_PLAN_LIGHTS = 200,
    LIT_PLAN_COARSER = 6,
    LIT_PLAN_D = 26, // shape: shaders/lit_size.glsl has it too
    LIT_PLAN_FAR_D = 12,
    LIT_PLAN_FAR_P = 8,
    LIT_PLAN_NEAR_BYTES = 32, // of a cell
    LIT_PLAN_FAR_BYTES = 32,
    LIT_PLAN_VALUE_BYTES = 16, // what cells are made from: one a cell of a
    LIT_PLAN_FAR_VALUES = 3,   // light's, 3 a cell of the far table
    LIT_PLAN_MARK_BYTES = 4    // of a cell of a light's
};

struct lit_fibre {
    struct dual_fibre fibre;
    bool opaque;   // TT and TRT are left out
    bool multiple; // with light that several fibres scatter
    float d_b;     // how much of it turns back: fibre.d_b
};

struct lit_lights {
    int count; // to LIT_PLAN_LIGHTS
    // of each: its width; what it holds of all light, 1 on average
    float lambda[LIT_PLAN_LIGHTS], share[LIT_PLAN_LIGHTS];
    float least;    // the narrowest that light scattered forward starts from
    float spread;   // that grouping may move it by, rad (light_groups.h)
    uint64_t bytes; // that the tables may take on the device
    bool apart;     // each has a table of its own width
};

struct lit_block { // uniform block Lit (shaders/lit.glsl)
    float far[4];
    uint32_t from[4], light[LIT_PLAN_LIGHTS][4], rest[LIT_PLAN_LIGHTS / 4][4];
    uint32_t table[LIT_PLAN_LIGHTS][4];
};

struct lit_plan {
    struct lit_block block;
    uint32_t cells, far_cells; // of all lights; of the far table
    uint32_t columns;          // most of any table
    uint32_t tables, rest;     // how many; lights that have none
    uint32_t narrow;           // of these because lobes are too narrow
    // Steps of 2^(1/8) by which cells are larger for want of memory, to
    // LIT_PLAN_COARSER.
    uint32_t coarser;
};

// Of equal share, each with a table of its own, however much memory that takes.
struct lit_lights lit_plan_apart(const float *lambda, int count);

// Every byte is written: plans compare as bytes.
void lit_plan_make(struct lit_plan *plan, const struct lit_fibre *f,
                   const struct lit_lights *lights);

// 2 sqrt2 beta of the narrowest lobe that is not left out.
double lit_plan_narrowest(const struct lit_fibre *f);

// On the device: cells, values and marks.
uint64_t lit_plan_bytes(const struct lit_plan *plan);

#endif
