// nodes.c - buffers and dispatches of the shadow stage.  What a transmittance
// is, is shadow.glsl's affair.
#include "renderer/nodes.h"

#include <string.h>

#include "renderer/gl.h"
#include "renderer/program.h"

enum { PART_LOCATION = 0, RAYS_LOCATION = 3, FROM_LOCATION = 5, PROGRAMS = 32 };

static void drop(struct nodes_store *s)
{
    gl.DeleteTextures(1, &s->texture);
    gl.DeleteBuffers(1, &s->buffer);
    memset(s, 0, sizeof *s);
}

void nodes_finish(struct nodes *n)
{
    drop(&n->first);
    drop(&n->rest);
    for (int i = 0; i < PROGRAMS; i++)
        program_drop(n->program[i]);
    memset(n, 0, sizeof *n);
}

bool nodes_kept(const struct nodes *n, int part, int rays)
{
    return part == 0 && rays == 0 && n->first_valid;
}

uint32_t nodes_room(const struct nodes_request *q)
{
    GLint64 limit = 0, texels = 0;
    gl.GetInteger64v(GL_MAX_SHADER_STORAGE_BLOCK_SIZE, &limit);
    gl.GetInteger64v(GL_MAX_TEXTURE_BUFFER_SIZE, &texels);
    if (limit > 8 * texels)
        limit = 8 * texels;
    const uint64_t bytes =
        q->budget < (uint64_t)limit ? q->budget : (uint64_t)limit;
    const uint64_t groups = bytes / (64 * 8 * (uint64_t)q->lights);
    return groups < 1          ? 64
           : groups > 1u << 24 ? 1u << 30
                               : (uint32_t)groups * 64;
}

static bool grow(struct nodes_store *s, const struct nodes_request *q,
                 struct error *err)
{
    const uint64_t bytes = 8 * (uint64_t)q->places * (uint64_t)q->lights;
    if (bytes > s->bytes) {
        drop(s);
        gl.CreateBuffers(1, &s->buffer);
        gl.NamedBufferStorage(
            s->buffer, (GLsizeiptr)gl_texture_buffer_size(bytes), NULL, 0);
        gl.ObjectLabel(GL_BUFFER, s->buffer, -1, "transmittances");
        gl.CreateTextures(GL_TEXTURE_BUFFER, 1, &s->texture);
        gl.TextureBuffer(s->texture, GL_RG32UI, s->buffer);
        gl.ObjectLabel(GL_TEXTURE, s->texture, -1, "transmittances");
        if (!gl_check("transmittances", err)) {
            drop(s); // else the next sample would believe that it is there
            return false;
        }
        s->bytes = bytes;
    }
    s->stride = q->places;
    s->begin = q->begin;
    return true;
}

static unsigned program_of(struct nodes *n, const struct nodes_request *q,
                           bool opacity, struct error *err)
{
    const bool asked[5] = {q->rays > 0, opacity, q->by_pixel, q->centres,
                           q->map};
    static const char *const words[5] = {"SHADOW_RAYS ", "WITH_OPACITY ",
                                         "BY_PIXEL ", "CENTRES ",
                                         "SHADOW_MAP "};
    char defines[80] = "";
    int number = 0;
    for (int i = 0; i < 5; i++)
        if (asked[i]) {
            strcat(defines, words[i]);
            number += 1 << i;
        }
    if (!n->program[number])
        n->program[number] = program_compute("shadow.comp", defines, err);
    return n->program[number];
}

bool nodes_make(struct nodes *n, const struct nodes_request *q,
                const struct strands *s, const struct nodes_store **out,
                struct error *err)
{
    const bool first = q->part == 0 && q->rays == 0;
    struct nodes_store *store = first ? &n->first : &n->rest;
    *out = store;
    if (nodes_kept(n, q->part, q->rays))
        return true;
    if (!grow(store, q, err))
        return false;
    unsigned program = program_of(n, q, s->opacity != 0, err);
    if (!program)
        return false;
    program_use(program);
    gl.ProgramUniform1ui(program, PART_LOCATION, (GLuint)q->part);
    gl.ProgramUniform1ui(program, NODES_STRIDE_LOCATION, store->stride);
    gl.ProgramUniform1ui(program, NODES_BEGIN_LOCATION, store->begin);
    if (q->rays > 0)
        gl.ProgramUniform1ui(program, RAYS_LOCATION, (GLuint)q->rays);
    gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, s->position);
    gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, 1, s->strand);
    gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, NODES_BINDING, store->buffer);
    n->now = program;
    return true;
}

void nodes_run(const struct nodes *n, const struct nodes_request *q,
               const struct picture *p, uint32_t from, uint32_t count)
{
    gl.ProgramUniform1ui(n->now, FROM_LOCATION, from);
    // all lights an invocation, but of rays and maps (shadow.comp)
    picture_dispatch_lights(p, count, q->rays > 0 || q->map ? q->lights : 1);
}

void nodes_made(struct nodes *n, const struct nodes_request *q)
{
    gl.MemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT);
    const bool first = q->part == 0 && q->rays == 0;
    n->first_valid |= first;
    n->made += first;
}
