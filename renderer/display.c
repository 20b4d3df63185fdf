// display.c - the last pass, and its read-back through a mapped buffer.
#include "renderer/display.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "protocol/bytes.h"
#include "renderer/gl.h"
#include "renderer/program.h"

// display.comp
enum { COLUMNS = 64, ROWS = 16, HEAD_BINDING = 12, BEHIND_BINDING = 13 };

static _Atomic unsigned numbers; // of skies

void display_init(struct display *d)
{
    memset(d, 0, sizeof *d);
}

static void drop_kept(struct display_kept *k)
{
    gl.DeleteBuffers(1, &k->buffer);
    k->buffer = 0;
    k->bytes = 0;
}

static void drop_pixels(struct display *d)
{
    if (d->mapped)
        gl.UnmapNamedBuffer(d->pixels);
    gl.DeleteBuffers(1, &d->pixels);
    d->pixels = 0;
    d->mapped = NULL;
    d->size = 0;
    drop_kept(&d->head);
    drop_kept(&d->behind);
}

void display_forget_sky(struct display *d)
{
    gl.DeleteTextures(1, &d->sky);
    d->sky = 0;
    d->sky_of = NULL;
}

void display_finish(struct display *d)
{
    for (int i = 0; i < 3; i++)
        program_drop(d->program[i]);
    drop_pixels(d);
    display_forget_sky(d);
}

static bool pixels(struct display *d, const struct params *p, struct error *err)
{
    size_t size = 4 * (size_t)p->image.width * (size_t)p->image.height;
    if (size == d->size)
        return true;
    drop_pixels(d);
    const GLbitfield how =
        GL_MAP_READ_BIT | GL_MAP_PERSISTENT_BIT | GL_MAP_COHERENT_BIT;
    gl.CreateBuffers(1, &d->pixels);
    gl.NamedBufferStorage(d->pixels, (GLsizeiptr)size, NULL,
                          how | GL_CLIENT_STORAGE_BIT);
    gl.ObjectLabel(GL_BUFFER, d->pixels, -1, "display");
    d->mapped = gl.MapNamedBufferRange(d->pixels, 0, (GLsizeiptr)size, how);
    if (!d->mapped)
        return gl_check("display buffer", err) &&
               error_set(err, "gpu", "display", "cannot map %zu bytes", size);
    d->size = size;
    return true;
}

static bool program(struct display *d, int background, struct error *err)
{
    static const char *const defines[3] = {"BACKGROUND_NONE", NULL,
                                           "BACKGROUND_SKY"};
    if (!d->program[background])
        d->program[background] =
            program_compute("display.comp", defines[background], err);
    return d->program[background] != 0;
}

// Row by row: what is above the largest half would become infinite, and between
// texels no number.
static void upload_rows(unsigned sky, const struct sky_map *map)
{
    const size_t values = 3 * (size_t)map->width;
    float *row = bytes_alloc(values * sizeof *row);
    gl.PixelStorei(GL_UNPACK_ALIGNMENT, 4);
    for (int y = 0; y < map->height; y++) {
        const float *from = map->rgb + values * (size_t)y;
        for (size_t i = 0; i < values; i++)
            row[i] = fminf(from[i], 65504);
        gl.TextureSubImage2D(sky, 0, 0, y, map->width, 1, GL_RGB, GL_FLOAT,
                             row);
    }
    free(row);
}

static void upload_sky(struct display *d, const struct sky_map *map)
{
    if (d->sky_of == map)
        return;
    display_forget_sky(d);
    gl.CreateTextures(GL_TEXTURE_2D, 1, &d->sky);
    gl.TextureStorage2D(d->sky, 1, GL_RGB16F, map->width, map->height);
    upload_rows(d->sky, map);
    gl.TextureParameteri(d->sky, GL_TEXTURE_WRAP_S, GL_REPEAT);
    gl.TextureParameteri(d->sky, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
    gl.TextureParameteri(d->sky, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    gl.TextureParameteri(d->sky, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    d->sky_of = map;
    d->sky_number = ++numbers;
}

static void copy3(float to[3], const float from[3])
{
    memcpy(to, from, 3 * sizeof *to);
}

static struct display_view view_of(const struct params *p,
                                   const struct display_input *in)
{
    const struct camera *c = in->camera;
    struct display_view v = {.width = p->image.width,
                             .height = p->image.height,
                             .tan_half = c->tan_half};
    copy3(v.right, c->right);
    copy3(v.up, c->up);
    copy3(v.forward, c->forward);
    return v;
}

// What the lights make of the head and what the sky is behind are kept while
// nothing of that changes: they would cost more than all the rest.  A pixel has
// a stamp, for with every sample more of them are seen.
static void keep(struct display_kept *k, const struct display_view *v,
                 uint64_t bytes, unsigned binding)
{
    const uint32_t zero = 0;
    if (k->bytes < bytes) {
        gl.DeleteBuffers(1, &k->buffer);
        k->buffer = gl_buffer(bytes, NULL, "behind the hair");
        k->bytes = bytes;
        gl.ClearNamedBufferData(k->buffer, GL_R32UI, GL_RED_INTEGER,
                                GL_UNSIGNED_INT, &zero);
    }
    if (k->stamp == 0 || memcmp(v, &k->view, sizeof *v) != 0)
        k->stamp++;
    k->view = *v;
    gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, binding, k->buffer);
}

static void keep_head(struct display *d, const struct params *p,
                      const struct display_input *in)
{
    const bool shown = p->view.head && in->strands->has_head;
    struct display_view v = view_of(p, in);
    v.source = in->lights->made;
    copy3(v.eye, in->camera->eye);
    copy3(v.centre, in->strands->head_centre);
    copy3(v.radius, in->strands->head_radius);
    keep(&d->head, &v, shown ? 4 * (uint64_t)d->size : 16, HEAD_BINDING);
}

static void keep_sky(struct display *d, const struct params *p,
                     const struct display_input *in)
{
    struct display_view v = view_of(p, in);
    v.source = d->sky_number;
    memcpy(v.to_map, in->lights->to_map, sizeof v.to_map);
    keep(&d->behind, &v, 4 * (uint64_t)d->size, BEHIND_BINDING);
}

static GLuint groups(int n, int of)
{
    return ((GLuint)n + (GLuint)of - 1) / (GLuint)of;
}

bool display_draw(struct display *d, const struct params *p,
                  const struct display_input *in, struct error *err)
{
    const int background = p->view.background;
    if (!pixels(d, p, err) || !program(d, background, err))
        return false;
    if (background == 2) {
        upload_sky(d, in->map);
        gl.BindTextureUnit(0, d->sky);
        keep_sky(d, p, in);
    }
    gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, 11, d->pixels);
    keep_head(d, p, in);
    const unsigned program = d->program[background];
    gl.UseProgram(program);
    const float share = in->samples > 0 ? 1 / (float)in->samples : 0;
    const float *t = in->lights->tint;
    gl.ProgramUniform4f(program, 0, share * t[0], share * t[1], share * t[2],
                        share);
    gl.ProgramUniform4f(program, 1, t[0], t[1], t[2], exp2f(p->view.exposure));
    gl.ProgramUniform2ui(program, 2, d->head.stamp, d->behind.stamp);
    gl.DispatchCompute(groups(p->image.width, COLUMNS),
                       GL_SPREAD * groups(p->image.height, GL_SPREAD * ROWS),
                       1);
    gl.MemoryBarrier(GL_CLIENT_MAPPED_BUFFER_BARRIER_BIT |
                     GL_SHADER_STORAGE_BARRIER_BIT);
    return true;
}

uint64_t display_bytes(const struct display *d)
{
    return d->size + d->head.bytes + d->behind.bytes;
}

void display_read(const struct display *d, struct buf *out)
{
    buf_append(out, d->mapped, d->size);
}
