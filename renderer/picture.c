// picture.c - targets, cells and accumulation.  What light a cell sends is the
// shading's affair (shading.h); what it looks like, display.h's.
#include "renderer/picture.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "protocol/bytes.h"
#include "renderer/gl.h"
#include "renderer/program.h"

enum {
    HEAD_VERTICES = 96 * 48 * 6,
    DISPATCH_OFFSET = 16,
    LIST_END = 32,
    OPACITY_BINDING = 12, // visible.vert
    QUADS = 16384         // a draw: as many as 16-bit indices reach
};

struct scene_std140 { // scene.glsl
    float view_proj[16], eye[4], size[4], jitter[4], right[4], up[4],
        forward[4], head_centre[4], head_radius[4], hair_colour[4],
        sky_to_map[16];
    uint32_t sample_index[4];
    float mask[4], share[4];
};

static bool rasters(struct picture *p, bool opacity, struct error *err)
{
    gl.DeleteProgram(p->thin);
    gl.DeleteProgram(p->wide);
    p->thin = program_raster("visible.vert", "visible.frag",
                             opacity ? "WITH_OPACITY" : NULL, err);
    p->wide = program_raster("visible.vert", "visible.frag",
                             opacity ? "WIDE WITH_OPACITY" : "WIDE", err);
    p->opacity_variant = opacity;
    return p->thin && p->wide; // 0 where one failed: tried again next time
}

// Quads share their corners, so a corner is transformed once.
static void quad_indices(struct picture *p)
{
    static const uint16_t corner[6] = {0, 1, 2, 1, 3, 2};
    uint16_t *index = bytes_alloc(6 * QUADS * sizeof *index);
    for (size_t q = 0; q < QUADS; q++)
        for (size_t c = 0; c < 6; c++)
            index[6 * q + c] = (uint16_t)(4 * q + corner[c]);
    gl.CreateBuffers(1, &p->quads);
    gl.NamedBufferStorage(p->quads, 6 * QUADS * sizeof *index, index, 0);
    gl.VertexArrayElementBuffer(p->vertices, p->quads);
    free(index);
}

bool picture_init(struct picture *p, struct error *err)
{
    memset(p, 0, sizeof *p);
    gl.CreateVertexArrays(1, &p->vertices);
    quad_indices(p);
    gl.CreateBuffers(1, &p->scene);
    gl.NamedBufferStorage(p->scene, sizeof(struct scene_std140), NULL,
                          GL_DYNAMIC_STORAGE_BIT);
    return rasters(p, false, err) &&
           (p->solid = program_raster("head.vert", "head.frag", NULL, err)) &&
           (p->cells = program_compute("cells.comp", NULL, err)) &&
           (p->count = program_compute("count.comp", NULL, err)) &&
           (p->add = program_compute("accumulate.comp", NULL, err));
}

static void drop_targets(struct picture *p)
{
    const unsigned buffers[] = {p->keys, p->radiance, p->list, p->counts,
                                p->map,  p->sum,      p->head};
    gl.DeleteBuffers(7, buffers);
    const unsigned textures[] = {p->id, p->depth};
    gl.DeleteTextures(2, textures);
    gl.DeleteFramebuffers(1, &p->target);
    p->keys = p->radiance = p->list = p->counts = p->map = p->sum = p->head = 0;
    p->id = p->depth = p->target = 0;
    p->width = p->height = 0;
}

void picture_finish(struct picture *p)
{
    drop_targets(p);
    const unsigned programs[] = {p->thin,  p->wide,  p->solid,
                                 p->cells, p->count, p->add};
    for (int i = 0; i < 6; i++)
        gl.DeleteProgram(programs[i]);
    gl.DeleteBuffers(1, &p->scene);
    gl.DeleteBuffers(1, &p->quads);
    gl.DeleteVertexArrays(1, &p->vertices);
    memset(p, 0, sizeof *p);
}

static unsigned buffer(size_t bytes, const char *name, uint64_t *total)
{
    unsigned b = 0;
    gl.CreateBuffers(1, &b);
    gl.NamedBufferStorage(b, (GLsizeiptr)bytes, NULL, GL_DYNAMIC_STORAGE_BIT);
    gl.ObjectLabel(GL_BUFFER, b, -1, name);
    *total += bytes;
    return b;
}

static bool targets(struct picture *p, struct error *err)
{
    gl.CreateTextures(GL_TEXTURE_2D, 1, &p->id);
    gl.TextureStorage2D(p->id, 1, GL_RG32UI, p->width, p->height);
    gl.TextureParameteri(p->id, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    gl.TextureParameteri(p->id, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    gl.CreateTextures(GL_TEXTURE_2D, 1, &p->depth);
    gl.TextureStorage2D(p->depth, 1, GL_DEPTH_COMPONENT32F, p->width,
                        p->height);
    gl.CreateFramebuffers(1, &p->target);
    gl.NamedFramebufferTexture(p->target, GL_COLOR_ATTACHMENT0, p->id, 0);
    gl.NamedFramebufferTexture(p->target, GL_DEPTH_ATTACHMENT, p->depth, 0);
    if (gl.CheckNamedFramebufferStatus(p->target, GL_FRAMEBUFFER) !=
        GL_FRAMEBUFFER_COMPLETE)
        return error_set(err, "gpu", "image",
                         "the driver cannot draw into a %d x %d picture",
                         p->width, p->height);
    p->target_bytes = (uint64_t)12 * (uint64_t)p->width * (uint64_t)p->height;
    return true;
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
           (22 * slots > budget / 2 || 16 * slots > (uint64_t)limit))
        slots /= 2;
    if (16 * slots > (uint64_t)limit)
        return error_set(
            err, "limit", "image",
            "image: %d x %d pixels need a buffer of %llu bytes, this device "
            "allows %lld: at most %lld pixels",
            p->width, p->height, (unsigned long long)(16 * slots),
            (long long)limit, (long long)(limit / 32));
    uint64_t maps =
        (budget - (22 * slots < budget ? 22 * slots : budget)) / (4 * pixels);
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
    p->radiance = buffer(16 * slots, "cell radiance", &p->cache_bytes);
    p->list = buffer(2 * slots, "cell list", &p->cache_bytes);
    p->counts = buffer(LIST_END + 4 * PICTURE_SAMPLES_MAX, "cell counts",
                       &p->cache_bytes);
    // one more than kept: where a sample beyond them puts its map
    p->map = buffer(4 * pixels * (uint64_t)(p->maps + 1), "cell maps",
                    &p->cache_bytes);
    p->sum = buffer(16 * pixels, "sample sum", &p->target_bytes);
    p->head = buffer(4 * pixels, "head sum", &p->target_bytes);
    return true;
}

bool picture_resize(struct picture *p, const struct params *params,
                    struct error *err)
{
    drop_targets(p);
    p->width = params->image.width;
    p->height = params->image.height;
    if (!targets(p, err) || !cell_store(p, params, err) ||
        !gl_check("picture buffers", err)) {
        drop_targets(p);
        return false;
    }
    picture_forget(p);
    return true;
}

void picture_forget(struct picture *p)
{
    const uint32_t zero = 0;
    gl.ClearNamedBufferData(p->keys, GL_R32UI, GL_RED_INTEGER, GL_UNSIGNED_INT,
                            &zero);
    gl.ClearNamedBufferData(p->counts, GL_R32UI, GL_RED_INTEGER,
                            GL_UNSIGNED_INT, &zero);
    p->seen = 0;
    p->listed = 0;
    p->flushed = false;
}

void picture_list(struct picture *p, int k)
{
    const uint32_t zero = 0;
    gl.ClearNamedBufferData(p->counts, GL_R32UI, GL_RED_INTEGER,
                            GL_UNSIGNED_INT, &zero);
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
    b.sample_index[3] = (uint32_t)(k < p->maps ? k : p->maps) *
                        (uint32_t)(p->width * p->height);
    put3(b.mask, s->mask, 1);
    memcpy(b.share, s->share, 2 * sizeof *b.share);
    gl.NamedBufferSubData(p->scene, 0, sizeof b, &b);
    gl.BindBufferBase(GL_UNIFORM_BUFFER, PICTURE_SCENE_BINDING, p->scene);
}

void picture_bind(const struct picture *p)
{
    const unsigned buffers[] = {p->keys, p->radiance, p->list, p->counts,
                                p->map,  p->sum,      p->head};
    for (unsigned i = 0; i < 7; i++)
        gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, 4 + i, buffers[i]);
}

void picture_draw(const struct picture *p, const struct strands *s,
                  unsigned thin, unsigned wide)
{
    gl.BindVertexArray(p->vertices);
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

bool picture_raster(struct picture *p, const struct strands *s, unsigned target,
                    struct error *err)
{
    const GLuint none[4] = {0, 0, 0, 0};
    const GLfloat far = 0;
    const bool opacity = s->opacity != 0;
    const bool made = p->thin && p->wide && opacity == p->opacity_variant;
    if (!made && !rasters(p, opacity, err))
        return false;
    gl.ClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
    gl.BindFramebuffer(GL_FRAMEBUFFER, target);
    gl.Viewport(0, 0, p->width, p->height);
    gl.ClearNamedFramebufferuiv(target, GL_COLOR, 0, none);
    gl.ClearNamedFramebufferfv(target, GL_DEPTH, 0, &far);
    gl.Enable(GL_DEPTH_TEST);
    gl.DepthFunc(GL_GREATER);
    if (s->has_head) {
        gl.BindVertexArray(p->vertices);
        gl.UseProgram(p->solid);
        gl.DrawArrays(GL_TRIANGLES, 0, HEAD_VERTICES);
    }
    picture_draw(p, s, p->thin, p->wide);
    gl.BindFramebuffer(GL_FRAMEBUFFER, 0);
    // Read next.  GL orders that by itself, but Mesa's llvmpipe can let a
    // dispatch begin to read what is still being drawn.
    gl.TextureBarrier();
    return true;
}

bool picture_see(struct picture *p, const struct strands *s, int k,
                 struct error *err)
{
    const uint64_t pixels = (uint64_t)p->width * (uint64_t)p->height;
    if (k >= p->seen && p->listed + pixels > p->slots / 2) {
        picture_forget(p); // full: begin anew; what is summed is summed
        p->flushed = true;
        p->seen = k;
    }
    if (!picture_raster(p, s, p->target, err))
        return false;
    picture_bind(p);
    gl.BindTextureUnit(0, p->id);
    gl.UseProgram(p->cells);
    gl.DispatchCompute((GLuint)(p->width + 7) / 8, (GLuint)(p->height + 7) / 8,
                       1);
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
    gl.MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_COMMAND_BARRIER_BIT);
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

void picture_add(struct picture *p)
{
    gl.UseProgram(p->add);
    gl_dispatch((uint64_t)p->width * (uint64_t)p->height);
    gl.MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT |
                     GL_BUFFER_UPDATE_BARRIER_BIT);
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
