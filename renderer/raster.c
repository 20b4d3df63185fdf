// raster.c - buffers and dispatches of the raster; what they do is in
// raster_head.comp, raster_keep.comp and raster_walk.comp.
#include "renderer/raster.h"

#include <math.h>
#include <string.h>

#include "renderer/gl.h"
#include "renderer/program.h"

enum {
    BOUNDS_BINDING = 2, // raster_keep.comp
    WORK_BINDING = 3,   // raster_work.glsl, as the rest
    OPACITY_BINDING = 12,
    DEPTH_BINDING = 13,
    SEEN_BINDING = 14,
    POINTS_UNIT = 18, // raster.glsl
    GROUPS = 0,
    WINDOWS = 2,
    NEAREST = 4, // lists, two of each
    PIXELS = 6,  // one of these
    LISTS = 7,
    ROW = 64 // RASTER_ROW of raster_work.glsl
};

static bool made(struct raster *r)
{
    return r->keep && r->walk[0] && r->walk[1] && r->settle[0] && r->settle[1];
}

static bool variants(struct raster *r, bool opacity, struct error *err)
{
    static const char *const words[2][4] = {
        {NULL, "WIDE", "SETTLE", "WIDE SETTLE"},
        {"WITH_OPACITY", "WIDE WITH_OPACITY", "SETTLE WITH_OPACITY",
         "WIDE SETTLE WITH_OPACITY"}};
    unsigned *const walk[4] = {&r->walk[0], &r->walk[1], &r->settle[0],
                               &r->settle[1]};
    if (made(r) && opacity == r->opacity_variant)
        return true;
    program_drop(r->keep);
    for (int i = 0; i < 4; i++) {
        program_drop(*walk[i]);
        *walk[i] = 0;
    }
    r->opacity_variant = opacity;
    r->keep = program_compute("raster_keep.comp", words[opacity][0], err);
    for (int i = 0; i < 4 && r->keep; i++)
        if (!(*walk[i] =
                  program_compute("raster_walk.comp", words[opacity][i], err)))
            break;
    return made(r); // 0 where one failed: tried again next time
}

bool raster_init(struct raster *r, struct error *err)
{
    return (r->head = program_compute("raster_head.comp", NULL, err)) &&
           variants(r, false, err);
}

void raster_drop(struct raster *r)
{
    const unsigned buffers[] = {r->depth, r->seen, r->work};
    gl.DeleteBuffers(3, buffers);
    r->depth = r->seen = r->work = 0;
    r->pixels = 0;
    r->bytes = 0;
}

void raster_finish(struct raster *r)
{
    const unsigned programs[] = {r->head,    r->keep,      r->walk[0],
                                 r->walk[1], r->settle[0], r->settle[1]};
    for (int i = 0; i < 6; i++)
        program_drop(programs[i]);
    raster_drop(r);
    memset(r, 0, sizeof *r);
}

static unsigned buffer(uint64_t bytes, const char *name, uint64_t *total)
{
    *total += bytes;
    return gl_buffer(bytes, NULL, name);
}

// A segment is listed as nearest once at most, and so is each of its windows.
static bool fit(struct raster *r, const struct strands *s, uint32_t pixels,
                struct error *err)
{
    const uint32_t windows = 4096 + pixels / 8;
    const uint32_t room[3] = {s->groups, windows, s->points + 2 * windows};
    bool fits = r->pixels >= pixels;
    for (int i = 0; i < 3; i++)
        fits &= r->room[i] >= room[i];
    if (fits)
        return true;
    raster_drop(r);
    memcpy(r->room, room, sizeof room);
    r->depth = buffer(4 * (uint64_t)pixels, "raster depth", &r->bytes);
    r->seen = buffer(4 * (uint64_t)pixels, "raster ids", &r->bytes);
    const uint64_t entries =
        2 * ((uint64_t)room[0] + room[1]) + room[2] + pixels;
    r->work = buffer(16 * LISTS + 4 * entries, "raster lists", &r->bytes);
    if (!gl_check("raster buffers", err)) {
        raster_drop(r);
        return false;
    }
    r->pixels = pixels;
    return true;
}

static void bind(const struct raster *r, const struct strands *s)
{
    const struct {
        GLuint binding, buffer;
    } b[] = {{0, s->position},
             {1, s->strand},
             {BOUNDS_BINDING, s->bounds},
             {WORK_BINDING, r->work},
             {OPACITY_BINDING, s->opacity},
             {DEPTH_BINDING, r->depth},
             {SEEN_BINDING, r->seen}};
    for (size_t i = 0; i < sizeof b / sizeof b[0]; i++)
        gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, b[i].binding, b[i].buffer);
    gl.BindTextureUnit(POINTS_UNIT, s->points_texture);
}

static void use(const struct raster *r, unsigned program)
{
    program_use(program);
    gl.ProgramUniform3ui(program, 0, r->room[0], r->room[1], r->room[2]);
}

// Nothing is seen, no list has an entry.
static void clear(const struct raster *r)
{
    GLuint head[LISTS][4];
    const GLuint nothing = 0, none = 0xffffffff; // RASTER_NONE
    for (int i = 0; i < LISTS; i++)
        memcpy(head[i], (GLuint[4]){ROW, 0, 1, 0}, sizeof head[i]);
    gl.ClearNamedBufferData(r->depth, GL_R32UI, GL_RED_INTEGER, GL_UNSIGNED_INT,
                            &nothing);
    gl.ClearNamedBufferData(r->seen, GL_R32UI, GL_RED_INTEGER, GL_UNSIGNED_INT,
                            &none);
    gl.NamedBufferSubData(r->work, 0, sizeof head, head);
}

static float dot(const float a[3], const float b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

// Columns and rows that the head may be seen in: those of its box's corners, or
// all where one of them is not before the eye.
static void head_window(const struct raster_view *v, GLuint out[4])
{
    const struct strands *s = v->strands;
    const struct camera *c = v->camera;
    const float extent[2] = {(float)v->width, (float)v->height};
    const float scale = 0.5f * extent[1] / c->tan_half;
    float low[2] = {INFINITY, INFINITY}, high[2] = {-INFINITY, -INFINITY};
    for (int k = 0; k < 8; k++) {
        float d[3];
        for (int i = 0; i < 3; i++)
            d[i] = s->head_centre[i] +
                   (k >> i & 1 ? s->head_radius[i] : -s->head_radius[i]) -
                   c->eye[i];
        const float depth = dot(c->forward, d);
        const bool before = depth > c->near;
        const float at[2] = {dot(c->right, d), dot(c->up, d)};
        for (int i = 0; i < 2; i++) { // the jitter is less than a pixel
            const float p = 0.5f * extent[i] + at[i] * scale / depth;
            low[i] = before ? fminf(low[i], p - 2) : -INFINITY;
            high[i] = before ? fmaxf(high[i], p + 2) : INFINITY;
        }
    }
    for (int i = 0; i < 2; i++) {
        const float from = floorf(fminf(fmaxf(low[i], 0), extent[i]));
        const float to = ceilf(fminf(fmaxf(high[i], 0), extent[i]));
        out[i] = (GLuint)from;
        out[i + 2] = (GLuint)(to - from);
    }
}

static void head(const struct raster *r, const struct raster_view *v)
{
    GLuint window[4];
    head_window(v, window);
    if (window[2] == 0 || window[3] == 0)
        return;
    use(r, r->head);
    gl.ProgramUniform4ui(r->head, 1, window[0], window[1], window[2],
                         window[3]);
    gl.DispatchCompute((window[2] + 7) / 8, (window[3] + 7) / 8, 1);
}

static void keep(const struct raster *r, const struct strands *s)
{
    use(r, r->keep);
    gl.ProgramUniform1ui(r->keep, 1, s->groups);
    gl.ProgramUniform2f(r->keep, 2, s->diameter_min, s->diameter_max);
    gl_dispatch(s->groups);
    gl.MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_COMMAND_BARRIER_BIT);
}

// Walks the entries of two lists, lines and ribbons.
static void walk(const struct raster *r, const struct strands *s,
                 const unsigned *program, int list)
{
    const bool drawn[2] = {s->draw_thin, s->draw_wide};
    for (int wide = 0; wide < 2; wide++) {
        if (!drawn[wide])
            continue;
        use(r, program[wide]);
        gl.ProgramUniform1ui(program[wide], 1, (GLuint)(list + wide));
        gl.DispatchComputeIndirect(16 * (list + wide));
    }
    gl.MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_COMMAND_BARRIER_BIT);
}

bool raster_see(struct raster *r, const struct raster_view *v,
                struct error *err)
{
    const struct strands *s = v->strands;
    const uint32_t pixels = (uint32_t)v->width * (uint32_t)v->height;
    if (!fit(r, s, pixels, err) || !variants(r, s->opacity != 0, err))
        return false;
    bind(r, s);
    clear(r);
    if (s->has_head)
        head(r, v);
    keep(r, s);
    gl.BindBuffer(GL_DISPATCH_INDIRECT_BUFFER, r->work);
    const struct {
        const unsigned *program;
        int list;
    } pass[] = {{r->walk, GROUPS}, {r->walk, WINDOWS}, {r->settle, NEAREST}};
    for (int i = 0; i < 3; i++) {
        if (watch_cut(v->watch))
            return false;
        walk(r, s, pass[i].program, pass[i].list);
    }
    return true;
}

void raster_pixels(const struct raster *r, unsigned program)
{
    use(r, program);
    gl.BindBuffer(GL_DISPATCH_INDIRECT_BUFFER, r->work);
    gl.DispatchComputeIndirect(16 * PIXELS);
}
