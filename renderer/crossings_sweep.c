// crossings_sweep.c - fills the atlas: directions that follow the same axis the
// same way are swept together, slice after slice from the light's side
// (shaders/crossings_sweep.comp), into bytes that are then copied to their
// tiles.
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
    float d[3];
    uint32_t tile;
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
    c->turn = program_compute("crossings_turn.comp", NULL, err);
    return c->turn != 0;
}

bool crossings_sweep_init(struct crossings *c, const struct crossings *of,
                          struct error *err)
{
    if (of) {
        memcpy(c->sweep, of->sweep, sizeof c->sweep);
        c->turn = of->turn;
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
    const unsigned scratch[] = {c->state, c->bytes[0], c->bytes[1]};
    gl.DeleteBuffers(3, scratch);
    gl.DeleteTextures(1, &c->before);
    c->state = c->bytes[0] = c->bytes[1] = c->before = 0;
    c->state_size = c->bytes_size[0] = c->bytes_size[1] = 0;
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
    if (c->turn)
        program_drop(c->turn);
}

struct group { // directions that are swept along the same axis, the same way
    int axis, count;
    int way[CROSSINGS_WAYS_MAX];
};

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

static void send_ways(struct crossings *c, const struct group *g, int begin,
                      int count)
{
    struct way_std140 way[CROSSINGS_WAYS_MAX];
    const uint32_t words = (uint32_t)(crossings_voxels(c) / 4);
    for (int i = 0; i < count; i++) {
        const float *d = c->block->way[g->way[begin + i]][0];
        for (int k = 0; k < 3; k++)
            way[i].d[k] = d[order[g->axis][k]];
        way[i].tile = (uint32_t)i * words;
    }
    gl.NamedBufferSubData(c->ways, 0, (GLsizeiptr)((size_t)count * sizeof *way),
                          way);
}

static void set_sizes(const struct crossings *c, int axis)
{
    const int *o = order[axis];
    const GLuint program = c->sweep[axis];
    const unsigned n[3] = {(unsigned)c->size[X], (unsigned)c->size[Y],
                           (unsigned)c->size[Z]};
    gl.ProgramUniform3ui(program, AT_SIZE, n[o[0]], n[o[1]], n[o[2]]);
    // x fastest; along x as y, z, x, which crossings_turn.comp puts right
    const unsigned w = n[X] / 4, v = n[Y] / 4;
    if (axis == X)
        gl.ProgramUniform3ui(program, AT_TO, 1, v, v * n[Z]);
    else if (axis == Y)
        gl.ProgramUniform3ui(program, AT_TO, 1, w * n[Y], w);
    else
        gl.ProgramUniform3ui(program, AT_TO, 1, w, w * n[Y]);
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

static bool run_slices(struct crossings *c, int axis, int count)
{
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
    gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, 1, c->bytes[0]);
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

static void put_right(struct crossings *c, int count)
{
    gl.ProgramUniform3ui(c->turn, 0, (GLuint)c->size[X], (GLuint)c->size[Y],
                         (GLuint)c->size[Z]);
    gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, c->bytes[0]);
    gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, 1, c->bytes[1]);
    program_use(c->turn);
    gl.MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
    gl.DispatchCompute((GLuint)(c->size[X] / 4 + 7) / 8,
                       (GLuint)(c->size[Y] / 4 + 7) / 8,
                       (GLuint)(c->size[Z] * count));
}

// False where it was cut.
static bool into_atlas(struct crossings *c, const struct group *g, int begin,
                       int count)
{
    gl.MemoryBarrier(GL_PIXEL_BUFFER_BARRIER_BIT);
    gl.BindBuffer(GL_PIXEL_UNPACK_BUFFER, c->bytes[g->axis == X]);
    for (int i = 0; i < count && !watch_cut(c->watch); i++) {
        const float *at = c->block->way[g->way[begin + i]][1];
        const uintptr_t from = (uintptr_t)(crossings_voxels(c) * (uint64_t)i);
        gl.TextureSubImage3D(c->atlas, 0, (GLint)at[X], (GLint)at[Y],
                             (GLint)at[Z], c->size[X], c->size[Y], c->size[Z],
                             GL_RED, GL_UNSIGNED_BYTE, (const void *)from);
    }
    gl.BindBuffer(GL_PIXEL_UNPACK_BUFFER, 0);
    return !watch_cut(c->watch);
}

static bool sweep_group(struct crossings *c, const struct group *g)
{
    GLint texels = 0;
    gl.GetIntegerv(GL_MAX_TEXTURE_BUFFER_SIZE, &texels);
    uint64_t most = scratch_most / crossings_voxels(c);
    const uint64_t held = 8 * (uint64_t)texels / state_bytes(c, g->axis);
    most = most > held ? held : most;
    most = most < 1 ? 1 : most;
    set_sizes(c, g->axis);
    for (int begin = 0; begin < g->count;) {
        int count = g->count - begin;
        count = (uint64_t)count > most ? (int)most : count;
        grow_state(c, state_bytes(c, g->axis) * (uint64_t)count);
        for (int i = 0; i <= (g->axis == X); i++)
            grow(&c->bytes[i], &c->bytes_size[i],
                 crossings_voxels(c) * (uint64_t)count, "crossings tiles");
        send_ways(c, g, begin, count);
        if (!run_slices(c, g->axis, count))
            return false;
        if (g->axis == X)
            put_right(c, count);
        if (!into_atlas(c, g, begin, count))
            return false;
        begin += count;
    }
    return true;
}

bool crossings_sweep_run(struct crossings *c)
{
    struct group group[6] = {{.axis = X}, {.axis = X}, {.axis = Y},
                             {.axis = Y}, {.axis = Z}, {.axis = Z}};
    for (int i = 0; i < c->stats.ways; i++) {
        const float *d = c->block->way[i][0];
        int a = fabsf(d[X]) > fabsf(d[Y]) ? X : Y;
        a = fabsf(d[Z]) >= fabsf(d[a]) ? Z : a;
        struct group *g = &group[2 * a + (d[a] > 0)];
        g->way[g->count++] = i;
    }
    bool whole = true;
    for (int i = 0; i < 6 && whole; i++)
        whole = sweep_group(c, &group[i]);
    c->stats.scratch_bytes =
        c->state_size + c->bytes_size[0] + c->bytes_size[1];
    return whole;
}
