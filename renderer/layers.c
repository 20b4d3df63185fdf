// layers.c - buffers and sums.  Which part a layer is and which of them a scene
// has, renderer_sample.c knows.
#include "renderer/layers.h"

#include <string.h>

#include "renderer/gl.h"
#include "renderer/program.h"

enum { RADIANCE_BINDING = 5, SUM_BINDING = 9 }; // cells.glsl, accumulate.comp

void layers_drop(struct layers *l)
{
    gl.DeleteBuffers(LAYERS, l->radiance);
    gl.DeleteBuffers(LAYERS, l->sum);
    program_drop(l->add);
    memset(l, 0, sizeof *l);
}

bool layers_fit(struct layers *l, int i, const struct picture *p,
                struct error *err)
{
    if (l->slots != p->slots || l->width != p->width ||
        l->height != p->height) {
        layers_drop(l);
        l->on = true;
        l->slots = p->slots;
        l->width = p->width;
        l->height = p->height;
    }
    if (!l->add)
        l->add = program_compute("accumulate.comp", "LAYER", err);
    if (l->radiance[i] || !l->add)
        return l->add != 0;
    const uint64_t pixels = (uint64_t)p->width * (uint64_t)p->height;
    l->radiance[i] = gl_buffer(8 * (uint64_t)p->slots, NULL, "layer radiance");
    l->sum[i] = gl_buffer(16 * pixels, NULL, "layer sum");
    return gl_check("layers", err);
}

void layers_bind(const struct layers *l, int i)
{
    gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, RADIANCE_BINDING,
                      l->radiance[i]);
    gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, SUM_BINDING, l->sum[i]);
}

void layers_add(const struct layers *l, const struct picture *p)
{
    gl.UseProgram(l->add);
    picture_dispatch_add(p);
}

void layers_read(const struct layers *l, int i, const struct picture *p,
                 float *rgba, int samples)
{
    struct picture as = *p;
    as.sum = l->sum[i];
    if (l->sum[i])
        picture_read_sum(&as, rgba, samples);
    else
        memset(rgba, 0, 16 * (size_t)p->width * (size_t)p->height);
}
