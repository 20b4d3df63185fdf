// picture.c - targets, cells and accumulation.  What light a cell sends is the
// shading's affair (shading.h); what it looks like, display.h's.
#include "renderer/picture.h"

#include <math.h>
#include <string.h>

#include "protocol/bytes.h"
#include "renderer/gl.h"
#include "renderer/program.h"

enum {
    DISPATCH_OFFSET = 16,
    LIST_END = 32,
    NUMBERS_BINDING = 11,
    // key and number; of half of them, for more are never listed: radiance, key
    SLOT_BYTES = 4 + 4 + (16 + 4) / 2
};

struct scene_std140 { // scene.glsl
    float view_proj[16], eye[4], size[4], jitter[4], right[4], up[4],
        forward[4], head_centre[4], head_radius[4], hair_colour[4],
        sky_to_map[16];
    uint32_t sample_index[4];
    float mask[4], share[4];
};

bool picture_init(struct picture *p, struct error *err)
{
    memset(p, 0, sizeof *p);
    p->scene = gl_buffer(sizeof(struct scene_std140), NULL, "scene");
    return raster_init(&p->raster, err) &&
           (p->cells = program_compute("cells.comp", NULL, err)) &&
           (p->number = program_compute("cells_number.comp", NULL, err)) &&
           (p->count = program_compute("count.comp", NULL, err)) &&
           (p->add = program_compute("accumulate.comp", NULL, err));
}

static void drop_targets(struct picture *p)
{
    const unsigned buffers[] = {p->keys, p->radiance, p->list, p->counts,
                                p->map,  p->sum,      p->saw,  p->numbers};
    gl.DeleteBuffers(8, buffers);
    picture_gl_drop(&p->target);
    p->keys = p->radiance = p->list = p->counts = p->map = p->sum = p->saw = 0;
    p->numbers = 0;
    p->width = p->height = 0;
}

void picture_finish(struct picture *p)
{
    drop_targets(p);
    raster_finish(&p->raster);
    picture_gl_finish(&p->drawn);
    const unsigned programs[] = {p->cells, p->cells_drawn, p->number, p->count,
                                 p->add};
    for (int i = 0; i < 5; i++)
        program_drop(programs[i]);
    gl.DeleteBuffers(1, &p->scene);
    memset(p, 0, sizeof *p);
}

static unsigned buffer(size_t bytes, const char *name, uint64_t *total)
{
    *total += bytes;
    return gl_buffer(bytes, NULL, name);
}

static void clear(unsigned buffer)
{
    const uint32_t zero = 0;
    gl.ClearNamedBufferData(buffer, GL_R32UI, GL_RED_INTEGER, GL_UNSIGNED_INT,
                            &zero);
}

static uint64_t power_of_two(uint64_t n)
{
    uint64_t p = 1024;
    while (p < n)
        p *= 2;
    return p;
}

// The table is at most half full when a sample begins to fill it, so that a
// whole picture of new cells always finds place.
static bool cell_store(struct picture *p, const struct params *params,
                       struct error *err)
{
    GLint64 limit = 0;
    gl.GetInteger64v(GL_MAX_SHADER_STORAGE_BLOCK_SIZE, &limit);
    const uint64_t pixels = (uint64_t)p->width * (uint64_t)p->height;
    const uint64_t budget = (uint64_t)params->quality.cache_mb << 20;
    const uint64_t least = power_of_two(2 * pixels);
    uint64_t slots = power_of_two(12 * pixels);
    while (slots > least &&
           (SLOT_BYTES * slots > budget / 2 || 8 * slots > (uint64_t)limit))
        slots /= 2;
    if (8 * slots > (uint64_t)limit)
        return error_set(
            err, "limit", "image",
            "image: %d x %d pixels need a buffer of %llu bytes, this device "
            "allows %lld: at most %lld pixels",
            p->width, p->height, (unsigned long long)(8 * slots),
            (long long)limit, (long long)(limit / 16));
    uint64_t maps =
        (budget - (SLOT_BYTES * slots < budget ? SLOT_BYTES * slots : budget)) /
        (4 * pixels);
    const uint64_t most = (uint64_t)limit / (4 * pixels) - 1; // see below
    if (maps > most)
        maps = most;
    if (maps > (uint64_t)params->quality.samples)
        maps = (uint64_t)params->quality.samples;
    p->maps = maps < 1 ? 1 : (int)maps;
    p->slots = (uint32_t)slots;
    p->cache_mb = params->quality.cache_mb;
    p->cache_bytes = 0;
    p->keys = buffer(4 * slots, "cell keys", &p->cache_bytes);
    p->radiance = buffer(8 * slots, "cell radiance", &p->cache_bytes);
    p->list = buffer(2 * slots, "cell list", &p->cache_bytes);
    p->numbers = buffer(4 * slots, "cell numbers", &p->cache_bytes);
    p->counts = buffer(LIST_END + 4 * PICTURE_SAMPLES_MAX, "cell counts",
                       &p->cache_bytes);
    // one more than kept: where a sample beyond them puts its map
    p->map = buffer(4 * pixels * (uint64_t)(p->maps + 1), "cell maps",
                    &p->cache_bytes);
    p->sum = buffer(16 * pixels, "sample sum", &p->target_bytes);
    p->saw = buffer(4 * pixels, "hair and head seen", &p->target_bytes);
    clear(p->saw);
    clear(p->sum); // as seen.glsl has it
    return true;
}

bool picture_resize(struct picture *p, const struct params *params,
                    struct error *err)
{
    drop_targets(p);
    p->width = params->image.width;
    p->height = params->image.height;
    p->target_bytes = 0;
    if (!cell_store(p, params, err) || !gl_check("picture buffers", err)) {
        drop_targets(p);
        return false;
    }
    picture_forget(p);
    return true;
}

void picture_forget(struct picture *p)
{
    clear(p->keys);
    clear(p->counts);
    p->seen = 0;
    p->listed = 0;
    p->flushed = false;
}

void picture_list(struct picture *p, int k)
{
    clear(p->counts);
    p->seen = k;
}

void picture_restart(struct picture *p)
{
    if (p->flushed)
        picture_forget(p);
}

bool picture_must_see(const struct picture *p, int k)
{
    return k >= p->seen || k >= p->maps;
}

// The R2 sequence (M. Roberts 2018): even cover of the pixel at every count;
// sample 0 sits in the pixel's middle.
static void jitter_of(const struct picture *p, int k, float out[4])
{
    const double g = 1.32471795724474602596;
    double x = fmod(0.5 + k / g, 1), y = fmod(0.5 + k / (g * g), 1);
    out[0] = (float)((2 * x - 1) / p->width);
    out[1] = (float)((2 * y - 1) / p->height);
}

// Where sample k has its map.
static int map_of(const struct picture *p, int k)
{
    return k < p->maps ? k : p->maps;
}

static void put3(float out[4], const float in[3], float scale)
{
    for (int i = 0; i < 3; i++)
        out[i] = scale * in[i];
}

void picture_scene(struct picture *p, const struct picture_scene *s, int k)
{
    const struct camera *c = s->camera;
    struct scene_std140 b = {0};
    const float aspect = (float)p->width / (float)p->height;
    memcpy(b.view_proj, c->view_proj, sizeof b.view_proj);
    put3(b.eye, c->eye, 1);
    b.size[0] = (float)p->width;
    b.size[1] = (float)p->height;
    b.size[2] = 0.5f * (float)p->height / c->tan_half;
    b.size[3] = c->near;
    jitter_of(p, k, b.jitter);
    b.jitter[2] = s->strands->thin_most;
    put3(b.right, c->right, c->tan_half * aspect);
    put3(b.up, c->up, c->tan_half);
    put3(b.forward, c->forward, 1);
    put3(b.head_centre, s->strands->head_centre, 1);
    b.head_centre[3] = s->strands->has_head;
    put3(b.head_radius, s->strands->head_radius, 1);
    memcpy(b.hair_colour, s->strands->plain_colour, sizeof b.hair_colour);
    for (int col = 0; col < 3; col++)
        for (int row = 0; row < 3; row++)
            b.sky_to_map[4 * col + row] = s->to_map[3 * row + col];
    b.sample_index[0] = (uint32_t)k;
    b.sample_index[1] = s->strands->points;
    b.sample_index[2] = p->slots - 1;
    b.sample_index[3] =
        (uint32_t)map_of(p, k) * (uint32_t)(p->width * p->height);
    put3(b.mask, s->mask, 1);
    memcpy(b.share, s->share, 2 * sizeof *b.share);
    gl.NamedBufferSubData(p->scene, 0, sizeof b, &b);
    gl.BindBufferBase(GL_UNIFORM_BUFFER, PICTURE_SCENE_BINDING, p->scene);
}

void picture_bind(const struct picture *p)
{
    const unsigned buffers[] = {p->keys, p->radiance, p->list, p->counts,
                                p->map,  p->sum,      p->saw};
    for (unsigned i = 0; i < 7; i++)
        gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, 4 + i, buffers[i]);
}

bool picture_draws(const struct picture *p, const struct strands *s)
{
    return p->always_drawn || !s->points_texture;
}

// By the driver's raster, and cells from its ids.
static bool draw(struct picture *p, const struct strands *s, struct error *err)
{
    const bool sized = p->target.framebuffer != 0;
    if (!picture_gl_target(&p->target, p->width, p->height, err) ||
        !picture_gl_raster(&p->drawn, s, &p->target, err))
        return false;
    if (!sized)
        p->target_bytes += (uint64_t)PICTURE_GL_PIXEL * (uint64_t)p->width *
                           (uint64_t)p->height;
    if (!p->cells_drawn)
        p->cells_drawn = program_compute("cells.comp", "DRAWN", err);
    if (!p->cells_drawn)
        return false;
    gl.BindTextureUnit(0, p->target.id);
    gl.UseProgram(p->cells_drawn);
    gl.DispatchCompute((GLuint)(p->width + 7) / 8, (GLuint)(p->height + 7) / 8,
                       1);
    return true;
}

static bool walk(struct picture *p, const struct raster_view *v, int k,
                 struct error *err)
{
    const GLuint nothing = 0;
    const GLsizeiptr size = 4 * (GLsizeiptr)p->width * (GLsizeiptr)p->height;
    gl.ClearNamedBufferSubData(p->map, GL_R32UI, map_of(p, k) * size, size,
                               GL_RED_INTEGER, GL_UNSIGNED_INT, &nothing);
    if (!raster_see(&p->raster, v, err))
        return false;
    raster_pixels(&p->raster, p->cells);
    return true;
}

static void dispatch_pixels(const struct picture *p)
{
    const uint64_t pixels = (uint64_t)p->width * (uint64_t)p->height;
    gl_dispatch_spread((pixels + PICTURE_GROUP_PIXELS - 1) /
                       PICTURE_GROUP_PIXELS);
}

bool picture_see(struct picture *p, const struct strands *s,
                 const struct camera *c, int k, struct error *err)
{
    const uint64_t pixels = (uint64_t)p->width * (uint64_t)p->height;
    if (k >= p->seen && p->listed + pixels > p->slots / 2) {
        picture_forget(p); // full: begin anew; what is summed is summed
        p->flushed = true;
        p->seen = k;
    }
    const struct raster_view view = {s, c, p->width, p->height, p->watch};
    picture_bind(p);
    gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, NUMBERS_BINDING, p->numbers);
    if (!(picture_draws(p, s) ? draw(p, s, err) : walk(p, &view, k, err)))
        return false;
    gl.MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
    gl.UseProgram(p->number);
    dispatch_pixels(p);
    gl.MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
    return true;
}

void picture_prepare(struct picture *p, int k)
{
    picture_bind(p);
    gl.UseProgram(p->count);
    gl.ProgramUniform1ui(p->count, 0, (GLuint)k);
    gl.ProgramUniform1ui(p->count, 1, k >= p->seen);
    gl.DispatchCompute(1, 1, 1);
    gl.MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_COMMAND_BARRIER_BIT |
                     GL_BUFFER_UPDATE_BARRIER_BIT); // picture_counters
    if (k >= p->seen)
        p->seen = k + 1;
}

void picture_dispatch(const struct picture *p)
{
    gl.BindBuffer(GL_DISPATCH_INDIRECT_BUFFER, p->counts);
    gl.DispatchComputeIndirect(DISPATCH_OFFSET);
    gl.MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
}

void picture_dispatch_some(const struct picture *p, uint32_t cells)
{
    (void)p;
    gl_dispatch(cells);
    gl.MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
}

void picture_dispatch_lights(const struct picture *p, uint32_t cells,
                             int lights)
{
    (void)p;
    const GLuint groups = (cells + 63) / 64;
    const GLuint x = groups < GL_ROW_GROUPS ? groups : GL_ROW_GROUPS;
    const GLuint rows = (groups + GL_ROW_GROUPS - 1) / GL_ROW_GROUPS;
    gl.DispatchCompute(x, (GLuint)lights, rows);
    gl.MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
}

void picture_dispatch_add(const struct picture *p)
{
    dispatch_pixels(p);
    gl.MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT |
                     GL_BUFFER_UPDATE_BARRIER_BIT);
}

void picture_add(struct picture *p)
{
    gl.UseProgram(p->add);
    picture_dispatch_add(p);
}

uint32_t picture_counters(struct picture *p)
{
    uint32_t c[8] = {0};
    gl.GetNamedBufferSubData(p->counts, 0, sizeof c, c);
    p->listed = c[0];
    p->lost = c[1];
    return c[3];
}

void picture_read_sum(const struct picture *p, float *rgba, int samples)
{
    const size_t n = 4 * (size_t)p->width * (size_t)p->height;
    gl.GetNamedBufferSubData(p->sum, 0, (GLsizeiptr)(n * sizeof *rgba), rgba);
    const float share = samples > 0 ? 1 / (float)samples : 0;
    for (size_t i = 0; i < n; i++)
        rgba[i] *= share;
}
