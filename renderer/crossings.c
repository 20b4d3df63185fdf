// crossings.c - the grid's box and memory, the atlas of tiles, and the sweeps
// that fill it.  What is in a voxel is crossings_grid.c's business, which
// directions stand for a light crossings_ways.c's, how they are looked up
// shaders/shadow.glsl's.
#include "renderer/crossings.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "protocol/bytes.h"
#include "renderer/crossings_private.h"
#include "renderer/gl.h"
#include "renderer/place.h"
#include "renderer/program.h"
#include "renderer/timer.h"

// Bytes of tiles that are finished before they go into the atlas together.
static const uint64_t scratch_most = 32u << 20;
// From where a lookup begins, in voxels along the way: nearer, the voxels hold
// the strand itself and what is beside it.
static const float start_voxels = 0.7f;
static const int usual_ways = 210;
#ifndef CELLS
enum { CELLS = 2 }; // of the lists, a voxel along an axis
#endif
// How far rays count real fibres, in voxels.
static const float ray_voxels = 2;

// Uniform locations in crossings_sweep.comp.
enum { AT_SIZE = 0, AT_TO = 1, AT_TURN = 2, AT_COUNT = 3 };
enum { TOGETHER = 8 }; // directions of an invocation
enum { X = 0, Y = 1, Z = 2 };
// For each axis a that is swept along: the axes b, c across it, then a.
static const int order[3][3] = {{Y, Z, X}, {X, Z, Y}, {X, Y, Z}};

struct way_std140 {
    float d[3];
    uint32_t tile;
};

// --- life --------------------------------------------------------------------

bool crossings_init(struct crossings *c, struct error *err)
{
    memset(c, 0, sizeof *c);
    c->block = bytes_zalloc(1, sizeof *c->block);
    for (int a = 0; a < 3; a++) {
        char defines[32];
        snprintf(defines, sizeof defines, "AXIS=%d TOGETHER=%du", a, TOGETHER);
        c->sweep[a] = program_compute("crossings_sweep.comp", defines, err);
        if (!c->sweep[a])
            goto fail;
    }
    c->turn = program_compute("crossings_turn.comp", NULL, err);
    if (!c->turn)
        goto fail;
    gl.CreateBuffers(1, &c->uniform);
    gl.NamedBufferStorage(c->uniform, sizeof *c->block, NULL,
                          GL_DYNAMIC_STORAGE_BIT);
    gl.ObjectLabel(GL_BUFFER, c->uniform, -1, "crossings");
    gl.CreateBuffers(1, &c->ways);
    gl.NamedBufferStorage(c->ways,
                          CROSSINGS_WAYS_MAX * sizeof(struct way_std140), NULL,
                          GL_DYNAMIC_STORAGE_BIT);
    gl.CreateQueries(GL_TIMESTAMP, 4, c->query);
    if (gl_check("making the crossings' buffers", err))
        return true;
fail:
    crossings_finish(c);
    return false;
}

static void forget_lists(struct crossings *c)
{
    const unsigned lists[] = {c->starts, c->pieces};
    gl.DeleteBuffers(2, lists);
    c->starts = c->pieces = 0;
    c->stats.lists_bytes = 0;
}

static void forget_ways(struct crossings *c)
{
    const unsigned scratch[] = {c->state, c->bytes[0], c->bytes[1]};
    const unsigned textures[] = {c->atlas, c->before};
    gl.DeleteBuffers(3, scratch);
    gl.DeleteTextures(2, textures);
    c->state = c->bytes[0] = c->bytes[1] = c->atlas = c->before = 0;
    c->state_size = c->bytes_size[0] = c->bytes_size[1] = 0;
    memset(c->tiles, 0, sizeof c->tiles);
    c->stats.ways_bytes = c->stats.scratch_bytes = 0;
    c->stats.ways = c->stats.lights = 0;
}

static void forget_grid(struct crossings *c)
{
    forget_ways(c);
    forget_lists(c);
    gl.DeleteTextures(2, c->tensor);
    c->tensor[0] = c->tensor[1] = 0;
    c->stats.grid_bytes = 0;
}

void crossings_finish(struct crossings *c)
{
    if (!c->block)
        return;
    forget_grid(c);
    const unsigned buffers[] = {c->uniform, c->ways};
    gl.DeleteBuffers(2, buffers);
    for (int a = 0; a < 3; a++)
        if (c->sweep[a])
            gl.DeleteProgram(c->sweep[a]);
    if (c->turn)
        gl.DeleteProgram(c->turn);
    if (c->query[0])
        gl.DeleteQueries(4, c->query);
    free(c->block);
    memset(c, 0, sizeof *c);
}

// --- the grid's box ----------------------------------------------------------

static void hair_box(const struct groom *g, const struct params *p,
                     float low[3], float high[3])
{
    float a[3], b[3];
    const int up = place_up(g, p);
    place_axes(up, g->box_min, a);
    place_axes(up, g->box_max, b);
    for (int k = 0; k < 3; k++) {
        low[k] = p->hair.scale * fminf(a[k], b[k]);
        high[k] = p->hair.scale * fmaxf(a[k], b[k]);
    }
}

static uint64_t voxels_of(const struct crossings *c)
{
    return (uint64_t)c->size[X] * (uint64_t)c->size[Y] * (uint64_t)c->size[Z];
}

// A voxel of air around the hair, and sides of whole words.
static void choose_box(struct crossings *c, const float low[3],
                       const float high[3], int resolution)
{
    float longest = 0;
    for (int k = 0; k < 3; k++)
        longest = fmaxf(longest, high[k] - low[k]);
    // all points in one place: any size will do
    longest = fmaxf(longest, 1e-6f * fmaxf(fabsf(low[0]), 1));
    c->voxel = longest / ((float)resolution - 2) * 1.00001f;
    for (int k = 0; k < 3; k++) {
        int n = (int)ceilf((high[k] - low[k]) / c->voxel) + 2;
        c->size[k] = (n + 3) / 4 * 4;
        c->box_min[k] =
            0.5f * (low[k] + high[k]) - 0.5f * c->voxel * (float)c->size[k];
    }
    c->stats.resolution = resolution;
    memcpy(c->stats.size, c->size, sizeof c->size);
}

// How many tiles the device's 3-D textures hold at most.
static int most_tiles(const struct crossings *c, int limit)
{
    int64_t n = 1;
    for (int k = 0; k < 3; k++)
        n *= limit / c->size[k];
    return n > CROSSINGS_WAYS_MAX ? CROSSINGS_WAYS_MAX : (int)n;
}

static int limit_3d(void)
{
    GLint limit = 0;
    gl.GetIntegerv(GL_MAX_3D_TEXTURE_SIZE, &limit);
    return limit;
}

static bool fits(const struct crossings *c)
{
    GLint64 block = 0;
    gl.GetInteger64v(GL_MAX_SHADER_STORAGE_BLOCK_SIZE, &block);
    const uint64_t voxels = voxels_of(c);
    const int ways = c->options.ways > 0 ? c->options.ways : usual_ways;
    return 16 * voxels <= (uint64_t)block && most_tiles(c, limit_3d()) > 0 &&
           (c->options.budget == 0 ||
            (32 + (uint64_t)ways) * voxels <= c->options.budget);
}

static bool choose_resolution(struct crossings *c, const float low[3],
                              const float high[3], struct error *err)
{
    int r = c->options.resolution / 4 * 4;
    r = r < CROSSINGS_RESOLUTION_MIN   ? CROSSINGS_RESOLUTION_MIN
        : r > CROSSINGS_RESOLUTION_MAX ? CROSSINGS_RESOLUTION_MAX
                                       : r;
    for (; r >= CROSSINGS_RESOLUTION_MIN; r -= 4) {
        choose_box(c, low, high, r);
        if (fits(c))
            return true;
    }
    return error_set(err, "limit", "shadow",
                     "shadows: %llu bytes hold no grid of %d x %d x %d voxels "
                     "and %d directions; at least %llu are needed",
                     (unsigned long long)c->options.budget, c->size[X],
                     c->size[Y], c->size[Z],
                     c->options.ways > 0 ? c->options.ways : usual_ways,
                     (unsigned long long)(32 + (uint64_t)(c->options.ways > 0
                                                              ? c->options.ways
                                                              : usual_ways)) *
                         (unsigned long long)voxels_of(c));
}

static void take_head(struct crossings *c, const struct groom *g,
                      const struct params *p)
{
    float centre[3] = {0, 0, 0}, radius[3] = {1, 1, 1};
    bool there = place_head(g, p, centre, radius);
    for (int k = 0; k < 3; k++)
        there = there && radius[k] > 0; // flat: it hides nothing
    for (int k = 0; k < 3; k++) {
        c->block->head[k] = centre[k];
        c->block->inverse[k] = there ? 1 / radius[k] : 1;
    }
    c->block->head[3] = there;
}

static void upload_tensor(struct crossings *c, float *const tensor[2])
{
    gl.CreateTextures(GL_TEXTURE_3D, 2, c->tensor);
    for (int i = 0; i < 2; i++) {
        gl.TextureStorage3D(c->tensor[i], 1, GL_RGBA32F, c->size[X], c->size[Y],
                            c->size[Z]);
        gl.TextureSubImage3D(c->tensor[i], 0, 0, 0, 0, c->size[X], c->size[Y],
                             c->size[Z], GL_RGBA, GL_FLOAT, tensor[i]);
        gl.TextureParameteri(c->tensor[i], GL_TEXTURE_MIN_FILTER, GL_NEAREST);
        gl.TextureParameteri(c->tensor[i], GL_TEXTURE_MAG_FILTER, GL_NEAREST);
        gl.ObjectLabel(GL_TEXTURE, c->tensor[i], -1, "crossings grid");
    }
    c->stats.grid_bytes = 32 * voxels_of(c);
}

bool crossings_build_grid(struct crossings *c, const struct groom *g,
                          const struct params *p,
                          const struct crossings_options *o, struct error *err)
{
    const double began = timer_now();
    float low[3], high[3], *tensor[2];
    struct crossings_hair hair;
    forget_grid(c);
    c->options = *o;
    hair_box(g, p, low, high);
    if (!choose_resolution(c, low, high, err))
        return false;
    for (int i = 0; i < 2; i++)
        tensor[i] = bytes_zalloc(4 * (size_t)voxels_of(c), sizeof(float));
    crossings_grid_hair(&hair, c->box_min, c->voxel, g, p);
    crossings_grid_splat(&hair, c->size, tensor);
    crossings_grid_hair_finish(&hair);
    upload_tensor(c, tensor);
    free(tensor[0]);
    free(tensor[1]);
    for (int k = 0; k < 3; k++) {
        c->block->box[k] = c->box_min[k];
        c->block->size[k] = (float)c->size[k];
    }
    c->block->box[3] = 1 / c->voxel;
    c->block->size[3] = start_voxels;
    c->block->texel[3] = p->hair.use_opacity ? g->default_opacity : 1;
    take_head(c, g, p);
    c->stats.grid_ms = 1e3 * (timer_now() - began);
    return gl_check("the shadows' grid", err);
}

bool crossings_build_lists(struct crossings *c, const struct groom *g,
                           const struct params *p, struct error *err)
{
    const double began = timer_now();
    const int fine = CELLS;
    const int size[3] = {fine * c->size[X], fine * c->size[Y],
                         fine * c->size[Z]};
    const uint64_t cells =
        (uint64_t)fine * (uint64_t)fine * (uint64_t)fine * voxels_of(c);
    GLint64 block = 0;
    gl.GetInteger64v(GL_MAX_SHADER_STORAGE_BLOCK_SIZE, &block);
    uint64_t most = (uint64_t)block / 4 - 1;
    if (most > UINT32_MAX)
        most = UINT32_MAX;
    struct crossings_hair hair;
    uint32_t *pieces = NULL, *starts = NULL;
    forget_lists(c);
    bool ok = cells <= most;
    if (ok) {
        starts = bytes_zalloc((size_t)cells + 1, sizeof *starts);
        crossings_grid_hair(&hair, c->box_min, c->voxel / (float)fine, g, p);
        ok = crossings_lists_make(&hair, size, most, starts, &pieces);
        crossings_grid_hair_finish(&hair);
    }
    if (ok) {
        const size_t count = starts[cells];
        gl.CreateBuffers(1, &c->starts);
        gl.CreateBuffers(1, &c->pieces);
        gl.NamedBufferStorage(c->starts, (GLsizeiptr)(4 * (cells + 1)), starts,
                              0);
        gl.NamedBufferStorage(c->pieces, (GLsizeiptr)(4 * (count + 1)), pieces,
                              0);
        gl.ObjectLabel(GL_BUFFER, c->starts, -1, "crossings cells");
        gl.ObjectLabel(GL_BUFFER, c->pieces, -1, "crossings pieces");
        c->stats.lists_bytes = 4 * (cells + 2 + count);
        for (int k = 0; k < 3; k++)
            c->block->cells[k] = (float)size[k];
        c->block->cells[3] = (float)fine;
        c->block->inverse[3] = ray_voxels * (float)fine;
        gl.NamedBufferSubData(c->uniform, 0, sizeof *c->block, c->block);
        c->stats.lists_ms = 1e3 * (timer_now() - began);
    }
    free(starts);
    free(pieces);
    return ok ? gl_check("the shadows' lists", err)
              : error_set(err, "limit", "shadow",
                          "shadows: lists of the segments near each of %d x %d "
                          "x %d cells are larger than the %lld bytes that this "
                          "device allows a buffer",
                          size[X], size[Y], size[Z], (long long)block);
}

// --- directions --------------------------------------------------------------

// Ways of each light, scaled down until they fit.
static bool choose_counts(struct crossings *c, const struct crossings_light *l,
                          int count, enum crossings_quality quality,
                          struct error *err)
{
    int most = most_tiles(c, limit_3d());
    const uint64_t kept = c->stats.grid_bytes + c->stats.lists_bytes;
    if (c->options.budget > 0) {
        uint64_t left = c->options.budget > kept ? c->options.budget - kept : 0;
        if (left / voxels_of(c) < (uint64_t)most)
            most = (int)(left / voxels_of(c));
    }
    if (count > most)
        return error_set(
            err, "limit", "shadow",
            "shadows: %d lights need %llu bytes for %d x %d x %d voxels, %llu "
            "are allowed",
            count, (unsigned long long)(kept + voxels_of(c) * (uint64_t)count),
            c->size[X], c->size[Y], c->size[Z],
            (unsigned long long)(kept + voxels_of(c) * (uint64_t)most));
    int wanted = 0, total = 0;
    for (int shift = 0; shift == 0 || total > most; shift++) {
        total = 0;
        for (int j = 0; j < count; j++) {
            int k = crossings_ways_count(l[j].lambda, quality) >> shift;
            k = k < 1 ? 1 : k;
            c->block->light[j][0] = (uint32_t)total;
            c->block->light[j][1] = (uint32_t)k;
            total += k;
        }
        if (shift == 0)
            wanted = total;
    }
    c->stats.lights = count;
    c->stats.ways = total;
    c->stats.ways_per_light = wanted ? (float)total / (float)wanted : 1;
    return true;
}

static uint32_t float_bits(float x)
{
    uint32_t bits;
    memcpy(&bits, &x, sizeof bits);
    return bits;
}

static void fill_block(struct crossings *c, const struct crossings_light *l)
{
    struct crossings_block *b = c->block;
    for (int k = 0; k < 3; k++)
        b->texel[k] = 1 / (float)(c->tiles[k] * c->size[k]);
    for (int j = 0, i = 0; j < c->stats.lights; j++) {
        const int n = (int)b->light[j][1];
        // side of a square as large as a way's share of the lobe
        const float share =
            fmaxf(l[j].lambda, 1e-4f) * sqrtf((float)M_PI / (float)n);
        b->light[j][2] = float_bits(l[j].lambda);
        b->light[j][3] = float_bits(share);
        memcpy(b->centre[j], l[j].direction, sizeof l[j].direction);
        for (int k = 0; k < n; k++, i++) {
            crossings_ways_direction(&l[j], k, n, b->way[i][0]);
            int tile = i;
            for (int a = Z; a >= X; a--) {
                b->way[i][1][a] = (float)(tile % c->tiles[a] * c->size[a]);
                tile /= c->tiles[a];
            }
        }
    }
    gl.NamedBufferSubData(c->uniform, 0, sizeof *b, b);
}

// Tiles are stacked along z first: close in memory to what is looked up with
// them.  How they lie depends on nothing but their number, or else a lookup's
// last bit would tell of what was in the atlas before.
static bool make_atlas(struct crossings *c, struct error *err)
{
    const int limit = limit_3d();
    int tiles[3], left = c->stats.ways;
    for (int a = Z; a >= X; a--) {
        int most = limit / c->size[a];
        tiles[a] = left < most ? left : most;
        left = (left + tiles[a] - 1) / tiles[a];
    }
    if (c->atlas && memcmp(tiles, c->tiles, sizeof tiles) == 0)
        return true;
    gl.DeleteTextures(1, &c->atlas);
    gl.CreateTextures(GL_TEXTURE_3D, 1, &c->atlas);
    gl.TextureStorage3D(c->atlas, 1, GL_R8, tiles[X] * c->size[X],
                        tiles[Y] * c->size[Y], tiles[Z] * c->size[Z]);
    gl.TextureParameteri(c->atlas, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    gl.TextureParameteri(c->atlas, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    gl.TextureParameteri(c->atlas, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    gl.TextureParameteri(c->atlas, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
    gl.TextureParameteri(c->atlas, GL_TEXTURE_WRAP_R, GL_CLAMP_TO_EDGE);
    gl.ObjectLabel(GL_TEXTURE, c->atlas, -1, "crossings");
    memcpy(c->tiles, tiles, sizeof tiles);
    c->stats.ways_bytes = (uint64_t)tiles[X] * (uint64_t)tiles[Y] *
                          (uint64_t)tiles[Z] * voxels_of(c);
    return gl_check("the shadows' directions", err);
}

// --- sweeps ------------------------------------------------------------------

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
    gl.CreateBuffers(1, buffer);
    gl.NamedBufferStorage(*buffer, (GLsizeiptr)wanted, NULL,
                          GL_DYNAMIC_STORAGE_BIT);
    gl.ObjectLabel(GL_BUFFER, *buffer, -1, name);
    *size = wanted;
}

static uint64_t state_bytes(const struct crossings *c, int axis)
{
    const int *o = order[axis];
    return (uint64_t)(c->size[o[0]] + 2) * (uint64_t)(c->size[o[1]] + 2) * 8;
}

static void send_ways(struct crossings *c, const struct group *g, int begin,
                      int count)
{
    struct way_std140 way[CROSSINGS_WAYS_MAX];
    const uint32_t words = (uint32_t)(voxels_of(c) / 4);
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
    grow(&c->state, &c->state_size, size, "crossings slice");
    gl.DeleteTextures(1, &c->before);
    gl.CreateTextures(GL_TEXTURE_BUFFER, 1, &c->before);
    gl.TextureBuffer(c->before, GL_R32F, c->state);
}

static void run_slices(struct crossings *c, int axis, int count)
{
    const float air = 1;
    const int *o = order[axis];
    const GLuint b = (GLuint)(c->size[o[0]] / 4 + 7) / 8;
    const GLuint across = (GLuint)(c->size[o[1]] + 7) / 8;
    gl.ClearNamedBufferSubData(
        c->state, GL_R32F, 0,
        (GLsizeiptr)(state_bytes(c, axis) * (uint64_t)count), GL_RED, GL_FLOAT,
        &air);
    const GLuint texture[] = {c->tensor[0], c->tensor[1], c->before};
    for (GLuint i = 0; i < 3; i++)
        gl.BindTextureUnit(i, texture[i]);
    gl.BindBufferBase(GL_UNIFORM_BUFFER, 1, c->ways);
    gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, c->state);
    gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, 1, c->bytes[0]);
    gl.ProgramUniform1ui(c->sweep[axis], AT_COUNT, (GLuint)count);
    gl.UseProgram(c->sweep[axis]);
    for (int turn = 0; turn < c->size[axis]; turn++) {
        gl.ProgramUniform1ui(c->sweep[axis], AT_TURN, (GLuint)turn);
        gl.MemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT);
        gl.DispatchCompute(b, across,
                           (GLuint)(count + TOGETHER - 1) / TOGETHER);
    }
}

static void put_right(struct crossings *c, int count)
{
    gl.ProgramUniform3ui(c->turn, 0, (GLuint)c->size[X], (GLuint)c->size[Y],
                         (GLuint)c->size[Z]);
    gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, c->bytes[0]);
    gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, 1, c->bytes[1]);
    gl.UseProgram(c->turn);
    gl.MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
    gl.DispatchCompute((GLuint)(c->size[X] / 4 + 7) / 8,
                       (GLuint)(c->size[Y] / 4 + 7) / 8,
                       (GLuint)(c->size[Z] * count));
}

static void into_atlas(struct crossings *c, const struct group *g, int begin,
                       int count)
{
    gl.MemoryBarrier(GL_PIXEL_BUFFER_BARRIER_BIT);
    gl.BindBuffer(GL_PIXEL_UNPACK_BUFFER, c->bytes[g->axis == X]);
    for (int i = 0; i < count; i++) {
        const float *at = c->block->way[g->way[begin + i]][1];
        const uintptr_t from = (uintptr_t)(voxels_of(c) * (uint64_t)i);
        gl.TextureSubImage3D(c->atlas, 0, (GLint)at[X], (GLint)at[Y],
                             (GLint)at[Z], c->size[X], c->size[Y], c->size[Z],
                             GL_RED, GL_UNSIGNED_BYTE, (const void *)from);
    }
    gl.BindBuffer(GL_PIXEL_UNPACK_BUFFER, 0);
}

static void sweep_group(struct crossings *c, const struct group *g)
{
    GLint texels = 0;
    gl.GetIntegerv(GL_MAX_TEXTURE_BUFFER_SIZE, &texels);
    uint64_t most = scratch_most / voxels_of(c);
    const uint64_t held = 4 * (uint64_t)texels / state_bytes(c, g->axis);
    most = most > held ? held : most;
    most = most < 1 ? 1 : most;
    set_sizes(c, g->axis);
    for (int begin = 0; begin < g->count;) {
        int count = g->count - begin;
        count = (uint64_t)count > most ? (int)most : count;
        grow_state(c, state_bytes(c, g->axis) * (uint64_t)count);
        for (int i = 0; i <= (g->axis == X); i++)
            grow(&c->bytes[i], &c->bytes_size[i],
                 voxels_of(c) * (uint64_t)count, "crossings tiles");
        send_ways(c, g, begin, count);
        run_slices(c, g->axis, count);
        if (g->axis == X)
            put_right(c, count);
        into_atlas(c, g, begin, count);
        begin += count;
    }
}

static void sweep_all(struct crossings *c)
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
    for (int i = 0; i < 6; i++)
        sweep_group(c, &group[i]);
    c->stats.scratch_bytes =
        c->state_size + c->bytes_size[0] + c->bytes_size[1];
}

bool crossings_update(struct crossings *c, const struct crossings_light *lights,
                      int count, enum crossings_quality quality,
                      struct error *err)
{
    if (count < 0 || count > CROSSINGS_LIGHTS_MAX)
        return error_set(err, "limit", "shadow",
                         "shadows: %d lights; 0 to %d are possible", count,
                         CROSSINGS_LIGHTS_MAX);
    if (!choose_counts(c, lights, count, quality, err))
        return false;
    if (c->stats.ways == 0) // nothing to look up
        return true;
    if (!make_atlas(c, err))
        return false;
    fill_block(c, lights);
    gl.QueryCounter(c->query[0], GL_TIMESTAMP);
    sweep_all(c);
    gl.QueryCounter(c->query[1], GL_TIMESTAMP);
    c->timed = true;
    return gl_check("the shadows' sweeps", err);
}

// --- use ---------------------------------------------------------------------

void crossings_bind(const struct crossings *c, const struct strands *s)
{
    gl.BindBufferBase(GL_UNIFORM_BUFFER, CROSSINGS_UNIFORM_BINDING, c->uniform);
    gl.BindTextureUnit(CROSSINGS_TEXTURE_UNIT, c->atlas);
    if (c->starts) {
        gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, CROSSINGS_STARTS_BINDING,
                          c->starts);
        gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, CROSSINGS_PIECES_BINDING,
                          c->pieces);
    }
    if (s && s->opacity)
        gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, CROSSINGS_OPACITY_BINDING,
                          s->opacity);
}

void crossings_read_stats(struct crossings *c, struct crossings_stats *out)
{
    if (c->timed) {
        GLuint64 from = 0, to = 0;
        gl.GetQueryObjectui64v(c->query[0], GL_QUERY_RESULT, &from);
        gl.GetQueryObjectui64v(c->query[1], GL_QUERY_RESULT, &to);
        c->stats.sweep_ms = to > from ? (double)(to - from) * 1e-6 : 0;
        c->timed = false;
    }
    *out = c->stats;
}
