// crossings_sweep.c - fills the atlas: directions that follow the same axis the
// same way are swept together, slice after slice from the light's side
// (shaders/crossings_sweep.comp), into bytes that are then copied to their
// tiles, four directions each.
#include "renderer/crossings_private.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "renderer/gl.h"
#include "renderer/program.h"

// Bytes of tiles that are finished before they go into the atlas together.
static const uint64_t scratch_most = 32u << 20;

// Uniform locations in crossings_sweep.comp, and directions an invocation.
enum { AT_SIZE = 0, AT_TO = 1, AT_TURN = 2, AT_COUNT = 3 };
enum { GROUP = 64, TOGETHER = 8 };
enum { X = 0, Y = 1, Z = 2 };
// For each axis a that is swept along: the axes b, c across it, then a.
static const int order[3][3] = {{Y, Z, X}, {X, Z, Y}, {X, Y, Z}};

struct way_std140 {
    float d[3], pad;
};

static bool programs(struct crossings *c, struct error *err)
{
    for (int a = 0; a < 3; a++) {
        char defines[32];
        snprintf(defines, sizeof defines, "AXIS=%d TOGETHER=%du", a, TOGETHER);
        c->sweep[a] = program_compute("crossings_sweep.comp", defines, err);
        if (!c->sweep[a])
            return false;
    }
    return true;
}

bool crossings_sweep_init(struct crossings *c, const struct crossings *of,
                          struct error *err)
{
    if (of) {
        memcpy(c->sweep, of->sweep, sizeof c->sweep);
        c->borrowed = true;
    } else if (!programs(c, err)) {
        return false;
    }
    c->ways = gl_buffer(CROSSINGS_WAYS_MAX * sizeof(struct way_std140), NULL,
                        "crossings ways");
    return true;
}

void crossings_sweep_forget(struct crossings *c)
{
    const unsigned scratch[] = {c->state, c->bytes};
    gl.DeleteBuffers(2, scratch);
    gl.DeleteTextures(1, &c->before);
    c->state = c->bytes = c->before = 0;
    c->state_size = c->bytes_size = 0;
    c->stats.scratch_bytes = 0;
}

void crossings_sweep_finish(struct crossings *c)
{
    crossings_sweep_forget(c);
    gl.DeleteBuffers(1, &c->ways);
    if (c->borrowed)
        return;
    for (int a = 0; a < 3; a++)
        if (c->sweep[a])
            program_drop(c->sweep[a]);
}

struct batch { // directions that are swept at once: slots
    int axis, first, count;
};

static int tiles_of(const struct batch *b)
{
    return (b->count + 3) / 4;
}

static void grow(unsigned *buffer, uint64_t *size, uint64_t wanted,
                 const char *name)
{
    if (*size >= wanted)
        return;
    gl.DeleteBuffers(1, buffer);
    *buffer = gl_buffer(wanted, NULL, name);
    *size = wanted;
}

// Two slices of entries of four voxels, with a frame.
static uint64_t state_bytes(const struct crossings *c, int axis)
{
    const int *o = order[axis];
    return (uint64_t)(c->size[o[0]] / 4 + 2) * (uint64_t)(c->size[o[1]] + 2) *
           2 * 8;
}

static void send_ways(struct crossings *c, const struct batch *b)
{
    struct way_std140 way[CROSSINGS_WAYS_MAX];
    const int *o = order[b->axis];
    for (int i = 0; i < b->count; i++) {
        const float *d = c->block->way[c->slots_way[b->first + i]];
        for (int k = 0; k < 3; k++)
            way[i].d[k] = d[o[k]];
    }
    gl.NamedBufferSubData(c->ways, 0,
                          (GLsizeiptr)((size_t)b->count * sizeof *way), way);
}

static void set_sizes(const struct crossings *c, int axis)
{
    const int *o = order[axis];
    const GLuint program = c->sweep[axis];
    const unsigned n[3] = {(unsigned)c->size[X], (unsigned)c->size[Y],
                           (unsigned)c->size[Z]};
    gl.ProgramUniform3ui(program, AT_SIZE, n[o[0]], n[o[1]], n[o[2]]);
    // x fastest
    const unsigned step[3] = {1, n[X], n[X] * n[Y]};
    gl.ProgramUniform4ui(program, AT_TO, step[o[0]], step[o[1]], step[o[2]],
                         n[X] * n[Y] * n[Z]);
}

static void grow_state(struct crossings *c, uint64_t size)
{
    if (c->state_size >= size)
        return;
    grow(&c->state, &c->state_size, gl_texture_buffer_size(size),
         "crossings slice");
    gl.DeleteTextures(1, &c->before);
    gl.CreateTextures(GL_TEXTURE_BUFFER, 1, &c->before);
    gl.TextureBuffer(c->before, GL_RG32UI, c->state);
}

static bool run_slices(struct crossings *c, const struct batch *b)
{
    const int axis = b->axis, count = b->count;
    const uint32_t air[2] = {UINT32_MAX, UINT32_MAX};
    const int *o = order[axis];
    const GLuint groups =
        (GLuint)(c->size[o[0]] / 4 * c->size[o[1]] + GROUP - 1) / GROUP;
    gl.MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    gl.ClearNamedBufferSubData(
        c->state, GL_RG32UI, 0,
        (GLsizeiptr)(state_bytes(c, axis) * (uint64_t)count), GL_RG_INTEGER,
        GL_UNSIGNED_INT, air);
    const GLuint texture[] = {c->tensor[0], c->tensor[1], c->before};
    for (GLuint i = 0; i < 3; i++)
        gl.BindTextureUnit(i, texture[i]);
    gl.BindBufferBase(GL_UNIFORM_BUFFER, 1, c->ways);
    gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, c->state);
    gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, 1, c->bytes);
    gl.ProgramUniform1ui(c->sweep[axis], AT_COUNT, (GLuint)count);
    program_use(c->sweep[axis]);
    for (int turn = 0; turn < c->size[axis]; turn++) {
        if (watch_cut(c->watch))
            return false;
        gl.ProgramUniform1ui(c->sweep[axis], AT_TURN, (GLuint)turn);
        gl.MemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT);
        gl.DispatchCompute(groups, (GLuint)(count + TOGETHER - 1) / TOGETHER,
                           1);
    }
    return true;
}

// False where it was cut.
static bool into_atlas(struct crossings *c, const struct batch *b)
{
    const uint64_t tile = 4 * crossings_voxels(c);
    gl.MemoryBarrier(GL_PIXEL_BUFFER_BARRIER_BIT);
    gl.BindBuffer(GL_PIXEL_UNPACK_BUFFER, c->bytes);
    for (int i = 0; i < tiles_of(b) && !watch_cut(c->watch); i++) {
        const float *at = c->block->tile[b->first / 4 + i];
        const uintptr_t from = (uintptr_t)(tile * (uint64_t)i);
        gl.TextureSubImage3D(c->atlas, 0, (GLint)at[X], (GLint)at[Y],
                             (GLint)at[Z], c->size[X], c->size[Y], c->size[Z],
                             GL_RGBA, GL_UNSIGNED_BYTE, (const void *)from);
    }
    gl.BindBuffer(GL_PIXEL_UNPACK_BUFFER, 0);
    return !watch_cut(c->watch);
}

// How many directions at once, whole tiles of them.
static int most_of(const struct crossings *c, int axis)
{
    GLint texels = 0;
    gl.GetIntegerv(GL_MAX_TEXTURE_BUFFER_SIZE, &texels);
    uint64_t most = scratch_most / crossings_voxels(c);
    const uint64_t held = 8 * (uint64_t)texels / state_bytes(c, axis);
    most = most > held ? held : most;
    return most < 4                    ? 4
           : most > CROSSINGS_WAYS_MAX ? CROSSINGS_WAYS_MAX
                                       : (int)most / 4 * 4;
}

static bool sweep_group(struct crossings *c, int group)
{
    struct batch b = {.axis = group / 2, .first = c->swept[group].first};
    const int most = most_of(c, b.axis), end = b.first + c->swept[group].count;
    set_sizes(c, b.axis);
    for (; b.first < end; b.first += b.count) {
        b.count = end - b.first < most ? end - b.first : most;
        grow_state(c, state_bytes(c, b.axis) * (uint64_t)b.count);
        grow(&c->bytes, &c->bytes_size,
             4 * crossings_voxels(c) * (uint64_t)tiles_of(&b),
             "crossings tiles");
        send_ways(c, &b);
        if (!run_slices(c, &b) || !into_atlas(c, &b))
            return false;
    }
    return true;
}

bool crossings_sweep_run(struct crossings *c)
{
    bool whole = true;
    for (int i = 0; i < 6 && whole; i++)
        whole = sweep_group(c, i);
    c->stats.scratch_bytes = c->state_size + c->bytes_size;
    return whole;
}
