// program.h - GLSL sources embedded in the binary become GL programs.
//
// A source may say `#include "name.glsl"` (each file at most once per program).
// "params.glsl" is made from the parameter table (glsl.h).
// Definitions are put after the #version line, so one source makes variants.
// Thread: render.
#ifndef RENDERER_PROGRAM_H
#define RENDERER_PROGRAM_H

#include <stdbool.h>

#include "protocol/bytes.h"
#include "protocol/error.h"

// The embedded text of shaders/NAME, or an empty span.
struct span program_source(const char *name);

// The text of shaders/NAME with its includes put in and `defines` ("A=1 B" or
// NULL, blanks between) set, as the GL compiler will get it.
bool program_expand(struct buf *out, const char *name, const char *defines,
                    struct error *err);

// Compiles and links, unless the context has an idle one (program_pool.h).  0
// and *err (with the compiler's first message) on fault.  Not deleted but
// dropped.
unsigned program_compute(const char *name, const char *defines,
                         struct error *err);
unsigned program_raster(const char *vert, const char *frag, const char *defines,
                        struct error *err);
void program_drop(unsigned program); // 0 is allowed

// Makes a compute program that reads buffer textures the current one.  Mesa's
// llvmpipe makes machine code once more for every sampler that a program meets,
// and Mesa leaves that of a buffer texture, which has none, as an earlier
// program had it: so that it is the same whatever ran before, a dispatch of a
// single thread puts all samplers back first.  Elsewhere this is glUseProgram.
void program_use(unsigned program);

// Compiles ahead what a line of program_pool_list names, unless it is there.
bool program_prepare(struct span line, struct error *err);

#endif
