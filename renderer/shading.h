// shading.h - the program that shades cells: which variant a scene needs, its
// uniforms and tables, and what was left out of it and why.
// Thread: render.
#ifndef RENDERER_SHADING_H
#define RENDERER_SHADING_H

#include <stdbool.h>

#include "protocol/error.h"
#include "protocol/params.h"
#include "renderer/strands.h"
#include "renderer/xu_tables.h"

enum { SHADING_VARIANTS = 8, SHADING_DEFINES = 96 };

struct shading_variant {
    char defines[SHADING_DEFINES];
    unsigned program;
    unsigned age; // the oldest gives way
};

struct shading {
    struct shading_variant variant[SHADING_VARIANTS];
    unsigned program; // in use; owned by the variants
    unsigned clock;
    unsigned params; // uniform block
    struct xu_tables *tables;
    bool circular, opaque;
    double opaque_bound; // what leaving TT and TRT out can change, of R
    float mask[3];       // R, TT, TRT shown
};

void shading_init(struct shading *s);
void shading_finish(struct shading *s);

// Picks (compiles, if it is new) the variant for these parameters and uploads
// the parameter block.  with_axis: an eccentric fibre needs strands' axis.
bool shading_update(struct shading *s, const struct params *p,
                    const struct strands *strands, struct error *err);
bool shading_wants_axis(const struct params *p);

// Binds program, block, tables and strands for picture_dispatch; k as there.
void shading_bind(const struct shading *s, const struct strands *strands,
                  int k);

#endif
