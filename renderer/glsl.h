// glsl.h - the parameter table as the shaders see it: a uniform block P of one
// vec4 a row, and a name for each (`fibre_eta`, `fibre_sigma_a`, ...).
// One vec4 a row wastes a few hundred bytes and needs no layout rules.
// Thread: any.
#ifndef RENDERER_GLSL_H
#define RENDERER_GLSL_H

#include "protocol/bytes.h"
#include "protocol/params.h"

enum { GLSL_PARAMS_BINDING = 0 }; // of the uniform block

// The text of the virtual shader file "params.glsl".
void glsl_params_text(struct buf *out);

// The block's contents: 4 floats a row, degrees turned into radians, linked
// fibre values resolved, other `auto` values 0.  out: 4 * params_row_count.
void glsl_params_values(const struct params *p, float *out);

#endif
