// picture_gl.h - ids and depths of head and strands by the driver's own raster
// of lines and triangles: what forward shading draws, and what a picture falls
// back on where a device cannot do it by raster.h.  Nothing of it exists until
// it is asked for.
// Thread: render.
#ifndef RENDERER_PICTURE_GL_H
#define RENDERER_PICTURE_GL_H

#include <stdbool.h>
#include <stdint.h>

#include "protocol/error.h"
#include "renderer/strands.h"

struct picture_gl {             // zero-initialised is empty
    unsigned thin, wide, solid; // programs
    bool opacity_variant;
    unsigned vertices; // a vertex array with nothing but quads' indices
    unsigned quads;
};

struct picture_gl_target {
    unsigned id, depth; // textures: RG32UI (visible.frag), 32-bit float
    unsigned framebuffer;
    int width, height;
};

enum { PICTURE_GL_PIXEL = 12 }; // bytes of a target

void picture_gl_finish(struct picture_gl *g);
bool picture_gl_target(struct picture_gl_target *t, int width, int height,
                       struct error *err);
void picture_gl_drop(struct picture_gl_target *t);
// Fills the target.  The scene block is bound.
bool picture_gl_raster(struct picture_gl *g, const struct strands *s,
                       const struct picture_gl_target *to, struct error *err);
// Draws the strands once more, with programs that begin with visible.vert
// (wide: with WIDE), into the framebuffer that is bound.
void picture_gl_draw(const struct picture_gl *g, const struct strands *s,
                     unsigned thin, unsigned wide);

#endif
