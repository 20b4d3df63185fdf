// crossings_sweep.c - fills the field: all directions that follow the same axis
// together, slice after slice from each one's light's side
// (shaders/crossings_sweep.comp).  Not all axes at once: their slices lie
// across each other, and a texel that is written a few bytes at a time leaves
// the cache in between.
#include "renderer/crossings_private.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "renderer/gl.h"
#include "renderer/program.h"

// Uniform locations in crossings_sweep.comp, and directions an invocation.
enum { AT_SIZE = 0, AT_TURN = 1, AT_STRIDE = 2, AT_AXIS = 3 };
enum { GROUP = 64, TOGETHER = 16, CHUNKS = 256 };
enum { X = 0, Y = 1, Z = 2 };
// For each axis a that is swept along: the axes b, c across it, then a.
static const int order[3][3] = {{Y, Z, X}, {X, Z, Y}, {X, Y, Z}};

struct ways_std140 {
    // directions of the same group: slots from a first one up to an end, 1
    // where the axis is followed upwards
    uint32_t chunk[CHUNKS][4];
    float way[CROSSINGS_WAYS_MAX][4];
};

bool crossings_sweep_init(struct crossings *c, const struct crossings *of,
                          struct error *err)
{
    char defines[32];
    snprintf(defines, sizeof defines, "TOGETHER=%du", TOGETHER);
    c->borrowed = of != NULL;
    c->sweep =
        of ? of->sweep : program_compute("crossings_sweep.comp", defines, err);
    if (!c->sweep)
        return false;
    c->ways = gl_buffer(sizeof(struct ways_std140), NULL, "crossings ways");
    return true;
}

void crossings_sweep_forget(struct crossings *c)
{
    gl.DeleteBuffers(1, &c->state);
    gl.DeleteTextures(1, &c->before);
    c->state = c->before = 0;
    c->state_size = 0;
    c->stats.scratch_bytes = 0;
}

void crossings_sweep_finish(struct crossings *c)
{
    crossings_sweep_forget(c);
    gl.DeleteBuffers(1, &c->ways);
    if (!c->borrowed && c->sweep)
        program_drop(c->sweep);
}

struct batch { // slots whose banks can be written at once; of an axis
    int first, end;
    int axis, chunks;
};

// Two slices of entries of four voxels, with a frame, along whatever axis.
static uint64_t state_entries(const struct crossings *c)
{
    uint64_t most = 0;
    for (int a = 0; a < 3; a++) {
        const uint64_t n = (uint64_t)(c->size[order[a][0]] / 4 + 2) *
                           (uint64_t)(c->size[order[a][1]] + 2) * 2;
        most = n > most ? n : most;
    }
    return most;
}

// The part of group g that is in the batch, in chunks of TOGETHER.
static void put_chunks(const struct crossings *c, int g, struct batch *b,
                       struct ways_std140 *out)
{
    const int first = c->swept[g].first, last = first + c->swept[g].count;
    const int from = first > b->first ? first : b->first;
    const int end = last < b->end ? last : b->end, *o = order[b->axis];
    for (int i = from; i < end; i++) {
        const float *d = c->block->way[c->slots_way[i]];
        for (int k = 0; k < 3; k++)
            out->way[i - b->first][k] = d[o[k]];
        if ((i - from) % TOGETHER != 0)
            continue;
        uint32_t *chunk = out->chunk[b->chunks++];
        chunk[0] = (uint32_t)(i - b->first);
        chunk[1] =
            (uint32_t)((end - i > TOGETHER ? i + TOGETHER : end) - b->first);
        chunk[2] = (uint32_t)g % 2;
    }
}

static void send_ways(struct crossings *c, struct batch *b)
{
    struct ways_std140 ways = {0};
    b->chunks = 0;
    for (int up = 0; up < 2; up++)
        put_chunks(c, 2 * b->axis + up, b, &ways);
    gl.NamedBufferSubData(c->ways, 0, sizeof ways, &ways);
}

static void begin_state(struct crossings *c, int slots)
{
    const uint32_t air[2] = {UINT32_MAX, UINT32_MAX};
    const uint64_t wanted = 8 * state_entries(c) * (uint64_t)slots;
    if (c->state_size < wanted) {
        gl.DeleteBuffers(1, &c->state);
        gl.DeleteTextures(1, &c->before);
        c->state_size = gl_texture_buffer_size(wanted);
        c->state = gl_buffer(c->state_size, NULL, "crossings slices");
        gl.CreateTextures(GL_TEXTURE_BUFFER, 1, &c->before);
        gl.TextureBuffer(c->before, GL_RG32UI, c->state);
    }
    gl.MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT); // shaders wrote it
    gl.ClearNamedBufferSubData(c->state, GL_RG32UI, 0, (GLsizeiptr)wanted,
                               GL_RG_INTEGER, GL_UNSIGNED_INT, air);
}

static void bind(const struct crossings *c, const struct batch *b)
{
    const uint64_t entries = state_entries(c), bank = crossings_voxels(c);
    const GLuint texture[] = {c->tensor[0], c->tensor[1], c->before};
    for (GLuint i = 0; i < 3; i++)
        gl.BindTextureUnit(i, texture[i]);
    gl.BindBufferBase(GL_UNIFORM_BUFFER, 1, c->ways);
    gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, c->state);
    gl.BindBufferRange(GL_SHADER_STORAGE_BUFFER, 1, c->field,
                       (GLintptr)((uint64_t)b->first * bank),
                       (GLsizeiptr)((uint64_t)(b->end - b->first) * bank));
    gl.ProgramUniform3ui(c->sweep, AT_SIZE, (GLuint)c->size[X],
                         (GLuint)c->size[Y], (GLuint)c->size[Z]);
    gl.ProgramUniform1ui(c->sweep, AT_STRIDE, (GLuint)entries);
    gl.ProgramUniform1ui(c->sweep, AT_AXIS, (GLuint)b->axis);
}

// False where it was cut.
static bool run_slices(const struct crossings *c, const struct batch *b)
{
    const int *o = order[b->axis], n = c->size[o[0]] / 4 * c->size[o[1]];
    bind(c, b);
    program_use(c->sweep);
    for (int turn = 0; b->chunks > 0 && turn < c->size[b->axis]; turn++) {
        if (watch_cut(c->watch))
            return false;
        gl.ProgramUniform1ui(c->sweep, AT_TURN, (GLuint)turn);
        gl.MemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT);
        gl.DispatchCompute((GLuint)(n + GROUP - 1) / GROUP, (GLuint)b->chunks,
                           1);
    }
    gl.MemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT);
    return true;
}

// How many slots at once: as many banks as can be written, and read as slices.
static int most_of(const struct crossings *c)
{
    GLint64 block = 0;
    GLint texels = 0;
    gl.GetInteger64v(GL_MAX_SHADER_STORAGE_BLOCK_SIZE, &block);
    gl.GetIntegerv(GL_MAX_TEXTURE_BUFFER_SIZE, &texels);
    const uint64_t entries = state_entries(c) * CROSSINGS_BANK;
    uint64_t banks = (uint64_t)block / (CROSSINGS_BANK * crossings_voxels(c));
    banks =
        banks > (uint64_t)texels / entries ? (uint64_t)texels / entries : banks;
    banks = banks > (uint64_t)block / (8 * entries)
                ? (uint64_t)block / (8 * entries)
                : banks;
    const uint64_t most = CROSSINGS_WAYS_MAX / CROSSINGS_BANK;
    return CROSSINGS_BANK * (int)(banks < 1 ? 1 : banks > most ? most : banks);
}

bool crossings_sweep_run(struct crossings *c)
{
    const int most = most_of(c), all = (int)c->block->all[0] * CROSSINGS_BANK;
    bool whole = true;
    for (int first = 0; first < all && whole; first += most) {
        struct batch b = {.first = first};
        b.end = all - first < most ? all : first + most;
        begin_state(c, b.end - first);
        for (b.axis = 0; b.axis < 3 && whole; b.axis++) {
            send_ways(c, &b);
            whole = run_slices(c, &b);
        }
    }
    c->stats.scratch_bytes = c->state_size;
    return whole;
}
