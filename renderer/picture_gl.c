// picture_gl.c - draw calls and targets of the driver's raster.
#include "renderer/picture_gl.h"

#include <stdlib.h>
#include <string.h>

#include "protocol/bytes.h"
#include "renderer/gl.h"
#include "renderer/program.h"

enum {
    HEAD_VERTICES = 96 * 48 * 6,
    OPACITY_BINDING = 12, // visible.vert
    QUADS = 16384         // a draw: as many as 16-bit indices reach
};

// Quads share their corners, so a corner is transformed once.
static void quad_indices(struct picture_gl *g)
{
    static const uint16_t corner[6] = {0, 1, 2, 1, 3, 2};
    uint16_t *index = bytes_alloc(6 * QUADS * sizeof *index);
    for (size_t q = 0; q < QUADS; q++)
        for (size_t c = 0; c < 6; c++)
            index[6 * q + c] = (uint16_t)(4 * q + corner[c]);
    gl.CreateBuffers(1, &g->quads);
    gl.NamedBufferStorage(g->quads, 6 * QUADS * sizeof *index, index, 0);
    gl.VertexArrayElementBuffer(g->vertices, g->quads);
    free(index);
}

static bool programs(struct picture_gl *g, bool opacity, struct error *err)
{
    if (!g->vertices) {
        gl.CreateVertexArrays(1, &g->vertices);
        quad_indices(g);
    }
    if (!g->solid)
        g->solid = program_raster("head.vert", "head.frag", NULL, err);
    if (g->solid && g->thin && g->wide && opacity == g->opacity_variant)
        return true;
    program_drop(g->thin);
    program_drop(g->wide);
    g->thin = program_raster("visible.vert", "visible.frag",
                             opacity ? "WITH_OPACITY" : NULL, err);
    g->wide = program_raster("visible.vert", "visible.frag",
                             opacity ? "WIDE WITH_OPACITY" : "WIDE", err);
    g->opacity_variant = opacity;
    // 0 where one failed: tried again next time
    return g->solid && g->thin && g->wide;
}

void picture_gl_finish(struct picture_gl *g)
{
    program_drop(g->thin);
    program_drop(g->wide);
    program_drop(g->solid);
    gl.DeleteBuffers(1, &g->quads);
    gl.DeleteVertexArrays(1, &g->vertices);
    memset(g, 0, sizeof *g);
}

static unsigned texture(GLenum format, int width, int height)
{
    unsigned t = 0;
    gl.CreateTextures(GL_TEXTURE_2D, 1, &t);
    gl.TextureStorage2D(t, 1, format, width, height);
    gl.TextureParameteri(t, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    gl.TextureParameteri(t, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    return t;
}

bool picture_gl_target(struct picture_gl_target *t, int width, int height,
                       struct error *err)
{
    if (t->framebuffer && t->width == width && t->height == height)
        return true;
    picture_gl_drop(t);
    t->width = width;
    t->height = height;
    t->id = texture(GL_RG32UI, width, height);
    t->depth = texture(GL_DEPTH_COMPONENT32F, width, height);
    gl.CreateFramebuffers(1, &t->framebuffer);
    gl.NamedFramebufferTexture(t->framebuffer, GL_COLOR_ATTACHMENT0, t->id, 0);
    gl.NamedFramebufferTexture(t->framebuffer, GL_DEPTH_ATTACHMENT, t->depth,
                               0);
    if (gl.CheckNamedFramebufferStatus(t->framebuffer, GL_FRAMEBUFFER) ==
            GL_FRAMEBUFFER_COMPLETE &&
        gl_check("raster targets", err))
        return true;
    picture_gl_drop(t);
    return error_set(err, "gpu", "image",
                     "the driver cannot draw into a %d x %d picture", width,
                     height);
}

void picture_gl_drop(struct picture_gl_target *t)
{
    const unsigned textures[] = {t->id, t->depth};
    gl.DeleteTextures(2, textures);
    gl.DeleteFramebuffers(1, &t->framebuffer);
    memset(t, 0, sizeof *t);
}

void picture_gl_draw(const struct picture_gl *g, const struct strands *s,
                     unsigned thin, unsigned wide)
{
    gl.BindVertexArray(g->vertices);
    gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, s->position);
    gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, 1, s->strand);
    gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, OPACITY_BINDING, s->opacity);
    const GLsizei segments = (GLsizei)s->points - 1;
    if (s->draw_thin) {
        gl.UseProgram(thin);
        gl.DrawArrays(GL_LINES, 0, 2 * segments);
    }
    if (s->draw_wide) {
        gl.UseProgram(wide);
        for (GLsizei at = 0; at < segments; at += QUADS) {
            GLsizei n = segments - at < QUADS ? segments - at : QUADS;
            gl.DrawElementsBaseVertex(GL_TRIANGLES, 6 * n, GL_UNSIGNED_SHORT,
                                      NULL, 4 * at);
        }
    }
}

bool picture_gl_raster(struct picture_gl *g, const struct strands *s,
                       const struct picture_gl_target *to, struct error *err)
{
    const GLuint none[4] = {0, 0, 0, 0};
    const GLfloat far = 0;
    if (!programs(g, s->opacity != 0, err))
        return false;
    gl.ClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
    gl.BindFramebuffer(GL_FRAMEBUFFER, to->framebuffer);
    gl.Viewport(0, 0, to->width, to->height);
    gl.ClearNamedFramebufferuiv(to->framebuffer, GL_COLOR, 0, none);
    gl.ClearNamedFramebufferfv(to->framebuffer, GL_DEPTH, 0, &far);
    gl.Enable(GL_DEPTH_TEST);
    gl.DepthFunc(GL_GREATER);
    if (s->has_head) {
        gl.BindVertexArray(g->vertices);
        gl.UseProgram(g->solid);
        gl.DrawArrays(GL_TRIANGLES, 0, HEAD_VERTICES);
    }
    picture_gl_draw(g, s, g->thin, g->wide);
    gl.BindFramebuffer(GL_FRAMEBUFFER, 0);
    // Read next.  GL orders that by itself, but Mesa's llvmpipe can let a
    // dispatch begin to read what is still being drawn.
    gl.TextureBarrier();
    return true;
}
