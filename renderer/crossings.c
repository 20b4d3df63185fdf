// crossings.c - the grid's box and memory, the field's, how many directions a
// light has.  What is in a voxel is crossings_grid.c's business, which
// directions stand for a light crossings_ways.c's, what is in the field
// crossings_sweep.c's, how they are looked up shaders/shadow.glsl's.
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

static const int usual_ways = 120;
// The samples of depth maps are as sparse as this: voxels of the field in one.
enum { SPARSE = 3, SPARSE_MIN = 16 };

enum { X = 0, Y = 1, Z = 2 };

// --- life --------------------------------------------------------------------

static bool begin(struct crossings *c, const struct crossings *of,
                  struct error *err)
{
    memset(c, 0, sizeof *c);
    c->block = bytes_zalloc(1, sizeof *c->block);
    GLint most = 0;
    gl.GetIntegerv(GL_MAX_UNIFORM_BLOCK_SIZE, &most);
    if ((size_t)most < sizeof *c->block) {
        error_set(err, "gpu", "shadow",
                  "shadows: a uniform block of %zu bytes is needed, this "
                  "device allows %d",
                  sizeof *c->block, most);
        goto fail;
    }
    if (!crossings_sweep_init(c, of, err))
        goto fail;
    c->uniform = gl_buffer(sizeof *c->block, NULL, "crossings");
    gl.CreateQueries(GL_TIMESTAMP, 2, c->query);
    if (gl_check("making the crossings' buffers", err))
        return true;
fail:
    crossings_finish(c);
    return false;
}

bool crossings_init(struct crossings *c, struct error *err)
{
    return begin(c, NULL, err);
}

bool crossings_init_beside(struct crossings *c, const struct crossings *of,
                           struct error *err)
{
    return begin(c, of, err);
}

static void forget_ways(struct crossings *c)
{
    gl.DeleteTextures(1, &c->field_texture);
    gl.DeleteBuffers(1, &c->field);
    c->field = c->field_texture = 0;
    c->field_size = 0;
    c->stats.ways_bytes = 0;
    c->stats.ways = c->stats.lights = 0;
}

static void forget_grid(struct crossings *c)
{
    forget_ways(c);
    crossings_sweep_forget(c);
    crossings_lists_forget(c);
    crossings_map_forget(c);
    gl.DeleteTextures(2, c->tensor);
    c->tensor[0] = c->tensor[1] = 0;
    c->stats.grid_bytes = 0;
}

void crossings_finish(struct crossings *c)
{
    if (!c->block)
        return;
    forget_grid(c);
    crossings_sweep_finish(c);
    crossings_map_finish(c);
    gl.DeleteBuffers(1, &c->uniform);
    if (c->query[0])
        gl.DeleteQueries(2, c->query);
    free(c->block);
    memset(c, 0, sizeof *c);
}

// --- the grid's box ----------------------------------------------------------

uint64_t crossings_voxels(const struct crossings *c)
{
    return (uint64_t)c->size[X] * (uint64_t)c->size[Y] * (uint64_t)c->size[Z];
}

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

// Of the field for so many ways, in texels of a bank of slots each.
static uint64_t field_texels(const struct crossings *c, int ways)
{
    const int slots = crossings_ways_slots(ways);
    return (uint64_t)((slots + CROSSINGS_BANK - 1) / CROSSINGS_BANK) *
           crossings_voxels(c);
}

// How many banks the device holds at most.
static int most_banks(const struct crossings *c)
{
    GLint texels = 0;
    gl.GetIntegerv(GL_MAX_TEXTURE_BUFFER_SIZE, &texels);
    const uint64_t n = (uint64_t)texels / crossings_voxels(c);
    const int most = CROSSINGS_WAYS_MAX / CROSSINGS_BANK;
    return n > (uint64_t)most ? most : (int)n;
}

static bool fits(const struct crossings *c)
{
    GLint64 block = 0;
    gl.GetInteger64v(GL_MAX_SHADER_STORAGE_BLOCK_SIZE, &block);
    const uint64_t voxels = crossings_voxels(c);
    const int ways = c->options.ways > 0 ? c->options.ways : usual_ways;
    return CROSSINGS_BANK * voxels <= (uint64_t)block && most_banks(c) > 0 &&
           (c->options.budget == 0 ||
            (32 + (uint64_t)ways) * voxels <=
                c->options.budget / (c->options.map ? 2 : 1));
}

static bool choose_resolution(struct crossings *c, const float low[3],
                              const float high[3], struct error *err)
{
    const bool map = c->options.map != NULL;
    const int least = map ? SPARSE_MIN : CROSSINGS_RESOLUTION_MIN;
    int r = c->options.resolution;
    r = r < CROSSINGS_RESOLUTION_MIN   ? CROSSINGS_RESOLUTION_MIN
        : r > CROSSINGS_RESOLUTION_MAX ? CROSSINGS_RESOLUTION_MAX
                                       : r;
    c->options.resolution = r;
    r = map ? r / SPARSE : r;
    r = r < least ? least : r / 4 * 4;
    for (; r >= least; r -= 4) {
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
                         (unsigned long long)crossings_voxels(c));
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
        gl.TextureStorage3D(
            c->tensor[i], 1, GL_RGBA32F, gl_texture_side(c->size[X]),
            gl_texture_side(c->size[Y]), gl_texture_side(c->size[Z]));
        gl.TextureSubImage3D(c->tensor[i], 0, 0, 0, 0, c->size[X], c->size[Y],
                             c->size[Z], GL_RGBA, GL_FLOAT, tensor[i]);
        gl.TextureParameteri(c->tensor[i], GL_TEXTURE_MIN_FILTER, GL_NEAREST);
        gl.TextureParameteri(c->tensor[i], GL_TEXTURE_MAG_FILTER, GL_NEAREST);
        gl.ObjectLabel(GL_TEXTURE, c->tensor[i], -1, "crossings grid");
    }
    c->stats.grid_bytes = 32 * crossings_voxels(c);
}

static bool make_tensor(struct crossings *c, const struct groom *g,
                        const struct params *p)
{
    struct crossings_hair hair = {.watch = c->watch};
    float *tensor[2];
    for (int i = 0; i < 2; i++)
        tensor[i] =
            bytes_zalloc(4 * (size_t)crossings_voxels(c), sizeof(float));
    crossings_grid_hair(&hair, c->box_min, c->voxel, g, p);
    crossings_grid_splat(&hair, c->size, tensor);
    crossings_grid_hair_finish(&hair);
    const bool whole = !watch_cut(c->watch);
    if (whole)
        upload_tensor(c, tensor);
    free(tensor[0]);
    free(tensor[1]);
    return whole;
}

bool crossings_build_grid(struct crossings *c, const struct groom *g,
                          const struct params *p,
                          const struct crossings_options *o, struct error *err)
{
    const double began = timer_now();
    forget_grid(c);
    c->options = *o;
    hair_box(g, p, c->hair_min, c->hair_max);
    if (!choose_resolution(c, c->hair_min, c->hair_max, err))
        return false;
    if (!o->map && !make_tensor(c, g, p))
        return false;
    for (int k = 0; k < 3; k++) {
        c->block->box[k] = c->box_min[k];
        c->block->size[k] = (float)c->size[k];
    }
    c->block->box[3] = 1 / c->voxel;
    c->block->texel[3] = p->hair.use_opacity ? g->default_opacity : 1;
    take_head(c, g, p);
    c->stats.grid_ms = 1e3 * (timer_now() - began);
    return gl_check("the shadows' grid", err);
}

// --- directions --------------------------------------------------------------

static bool has_room(const struct crossings *c, int ways)
{
    const uint64_t texels = field_texels(c, ways);
    return texels <= (uint64_t)most_banks(c) * crossings_voxels(c) &&
           (c->options.budget == 0 ||
            c->stats.grid_bytes + CROSSINGS_BANK * texels <= c->options.budget);
}

// Ways of each light, fewer by `shift` halvings; returns their sum.
static int count_ways(struct crossings *c, const struct crossings_light *l,
                      int count, enum crossings_quality quality, int shift)
{
    int total = 0;
    for (int j = 0; j < count; j++) {
        int k = c->options.map ? 1 : crossings_ways_count(&l[j], quality);
        k = c->options.most > 0 && k > c->options.most ? c->options.most : k;
        k >>= shift;
        k = k < 1 ? 1 : k;
        c->block->light[j][0] = (uint32_t)total;
        c->block->light[j][1] = (uint32_t)k;
        total += k;
    }
    return total;
}

static bool choose_counts(struct crossings *c, const struct crossings_light *l,
                          int count, enum crossings_quality quality,
                          struct error *err)
{
    if (!has_room(c, count))
        return error_set(
            err, "limit", "shadow",
            "shadows: %d lights need %llu bytes for %d x %d x %d "
            "voxels; %llu and %d directions are possible",
            count,
            (unsigned long long)(c->stats.grid_bytes +
                                 CROSSINGS_BANK * field_texels(c, count)),
            c->size[X], c->size[Y], c->size[Z],
            (unsigned long long)c->options.budget,
            CROSSINGS_BANK * most_banks(c));
    int total = count_ways(c, l, count, quality, 0);
    const int wanted = total;
    for (int shift = 1; !has_room(c, total); shift++)
        total = count_ways(c, l, count, quality, shift);
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

// Side of a square as large as a way's share of the lobe.
static float share_of(const struct crossings_light *l, int ways)
{
    return fmaxf(l->lambda, 1e-4f) * sqrtf((float)M_PI / (float)ways);
}

static void fill_slot(struct crossings *c, const struct crossings_light *l,
                      int j, const float way[4])
{
    float *slot = c->block->slot[(int)way[3]], across = 0;
    for (int k = 0; k < 3; k++) {
        slot[k] = way[k] * c->block->inverse[k];
        across += slot[k] * slot[k];
    }
    for (int k = 0; k < 3; k++)
        slot[k] /= sqrtf(across);
    slot[3] = 1 / share_of(l, (int)c->block->light[j][1]);
}

static void fill_block(struct crossings *c, const struct crossings_light *l)
{
    struct crossings_block *b = c->block;
    b->all[1] = (uint32_t)c->size[X];
    b->all[2] = (uint32_t)(c->size[X] * c->size[Y]);
    b->all[3] = (uint32_t)crossings_voxels(c);
    for (int j = 0; j < c->stats.lights; j++) {
        const int first = (int)b->light[j][0], n = (int)b->light[j][1];
        b->light[j][2] = float_bits(l[j].lambda);
        b->light[j][3] = float_bits(share_of(&l[j], n));
        memcpy(b->centre[j], l[j].direction, sizeof l[j].direction);
        for (int i = first; i < first + n; i++)
            fill_slot(c, &l[j], j, b->way[i]);
    }
    gl.NamedBufferSubData(c->uniform, 0, sizeof *b, b);
}

// A bank lies where it lies however many there are: the buffer may be larger.
static bool make_field(struct crossings *c, struct error *err)
{
    const uint64_t wanted =
        CROSSINGS_BANK * c->block->all[0] * crossings_voxels(c);
    if (c->field && c->field_size >= wanted && c->field_size / 2 <= wanted)
        return true;
    const int lights = c->stats.lights, ways = c->stats.ways;
    forget_ways(c);
    c->field_size = gl_texture_buffer_size(wanted);
    gl.CreateBuffers(1, &c->field);
    gl.NamedBufferStorage(c->field, (GLsizeiptr)c->field_size, NULL, 0);
    gl.ObjectLabel(GL_BUFFER, c->field, -1, "crossings");
    gl.CreateTextures(GL_TEXTURE_BUFFER, 1, &c->field_texture);
    gl.TextureBuffer(c->field_texture, GL_RGBA32UI, c->field);
    gl.ObjectLabel(GL_TEXTURE, c->field_texture, -1, "crossings");
    if (!gl_check("the shadows' directions", err)) {
        forget_ways(c);
        return false;
    }
    c->stats.ways_bytes = c->field_size;
    c->stats.lights = lights;
    c->stats.ways = ways;
    return true;
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
    crossings_ways_lay(c, lights);
    if (!make_field(c, err))
        return false;
    fill_block(c, lights);
    gl.QueryCounter(c->query[0], GL_TIMESTAMP);
    bool ok = true;
    if (c->options.map)
        ok = crossings_map_run(c, lights, err);
    else
        ok = crossings_sweep_run(c);
    gl.QueryCounter(c->query[1], GL_TIMESTAMP);
    c->timed = true;
    return ok && gl_check("the shadows' sweeps", err);
}

// --- use ---------------------------------------------------------------------

bool crossings_has_lists(const struct crossings *c)
{
    return c->rays.list[0] != 0;
}

void crossings_bind(struct crossings *c, const struct strands *s)
{
    gl.BindBufferBase(GL_UNIFORM_BUFFER, CROSSINGS_UNIFORM_BINDING, c->uniform);
    gl.BindTextureUnit(CROSSINGS_TEXTURE_UNIT, c->field_texture);
    if (c->options.map)
        crossings_map_bind(c);
    else if (c->rays.list[0] && s)
        crossings_lists_bind(c, s);
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
