// renderer_places.c - visible places of the present picture, and its scene as
// the references take it.
#include "renderer/places.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "protocol/bytes.h"
#include "renderer/egl.h"
#include "renderer/gl.h"
#include "renderer/glsl.h"
#include "renderer/place.h"
#include "renderer/program.h"
#include "renderer/reference.h"
#include "renderer/reference_private.h"
#include "renderer/renderer_private.h"

enum { COUNT_LOCATION = 0, NUMBERS_BINDING = 2, ITEMS_BINDING = 3, GROUP = 64 };

struct gpu_item { // places.comp
    float position[4], tangent[4], radiance[4];
};

struct chosen { // pixels, and what they see
    uint32_t *pixel, *number;
    size_t count;
};

static int rising(const void *a, const void *b)
{
    const uint32_t x = *(const uint32_t *)a, y = *(const uint32_t *)b;
    return x < y ? -1 : x > y;
}

static bool has(const uint32_t *sorted, size_t n, uint32_t x)
{
    return n > 0 && bsearch(&x, sorted, n, sizeof x, rising);
}

// Pixels in a seeded random order (Fisher and Yates), as far as needed; of two
// that see one place the first.
static void draw(const uint32_t *map, size_t pixels, size_t want, uint64_t seed,
                 struct chosen *c)
{
    enum { MAP_FIRST = 2 }; // cells.glsl
    uint32_t *order = bytes_alloc((pixels + 1) * sizeof *order);
    size_t n = 0;
    for (size_t i = 0; i < pixels; i++)
        if (map[i] >= MAP_FIRST)
            order[n++] = (uint32_t)i;
    want = want < n ? want : n;
    c->pixel = bytes_alloc((want + 1) * sizeof *c->pixel);
    c->number = bytes_alloc((want + 1) * sizeof *c->number);
    uint32_t *sorted = bytes_alloc((want + 1) * sizeof *sorted);
    struct reference_random random;
    reference_random_begin(&random, seed, 0, 0);
    for (size_t i = 0; i < n && c->count < want; i++) {
        const size_t j =
            i + (size_t)(reference_random_next(&random) * (double)(n - i));
        const uint32_t pixel = order[j], number = map[pixel] - MAP_FIRST;
        order[j] = order[i];
        if (has(sorted, c->count, number))
            continue;
        size_t at = c->count;
        for (; at > 0 && sorted[at - 1] > number; at--)
            sorted[at] = sorted[at - 1];
        sorted[at] = number;
        c->pixel[c->count] = pixel;
        c->number[c->count++] = number;
    }
    free(sorted);
    free(order);
}

static void bind(const struct renderer *r, unsigned numbers, unsigned items)
{
    picture_bind(&r->picture);
    gl.BindBufferBase(GL_UNIFORM_BUFFER, PICTURE_SCENE_BINDING,
                      r->picture.scene);
    gl.BindBufferBase(GL_UNIFORM_BUFFER, GLSL_PARAMS_BINDING,
                      r->shading.params);
    gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, r->strands.position);
    gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, 1, r->strands.strand);
    gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, NUMBERS_BINDING, numbers);
    gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, ITEMS_BINDING, items);
}

// The shader says where a cell is: the same numbers as in the picture.
static bool fetch(struct renderer *r, const struct chosen *c,
                  struct gpu_item *items, struct error *err)
{
    if (!r->places) // kept: while it is compiled an edit would wait
        r->places = program_compute("places.comp", NULL, err);
    const unsigned program = r->places;
    if (!program)
        return false;
    const GLsizeiptr size = (GLsizeiptr)(c->count * sizeof *items);
    unsigned buffer[2];
    gl.CreateBuffers(2, buffer);
    gl.NamedBufferStorage(buffer[0], (GLsizeiptr)(c->count * sizeof *c->number),
                          c->number, 0);
    gl.NamedBufferStorage(buffer[1], size, NULL, 0);
    bind(r, buffer[0], buffer[1]);
    gl.UseProgram(program);
    gl.ProgramUniform1ui(program, COUNT_LOCATION, (GLuint)c->count);
    gl.DispatchCompute((GLuint)(c->count + GROUP - 1) / GROUP, 1, 1);
    gl.MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    gl.GetNamedBufferSubData(buffer[1], 0, size, items);
    gl.DeleteBuffers(2, buffer);
    return gl_check("places", err);
}

static void fill(const struct renderer *r, const uint32_t *axis,
                 const struct gpu_item *g, uint32_t pixel,
                 struct places_item *out)
{
    double n = 0;
    memset(out, 0, sizeof *out); // padding too: places are compared as bytes
    memcpy(&out->segment, &g->tangent[3], sizeof out->segment);
    out->along = (double)g->position[3];
    for (int k = 0; k < 3; k++) {
        out->position[k] = (double)g->position[k];
        out->tangent[k] = (double)g->tangent[k];
        out->to_eye[k] = (double)r->camera.eye[k] - out->position[k];
        out->radiance[k] = g->radiance[k] * r->lights.tint[k];
        n += out->to_eye[k] * out->to_eye[k];
    }
    for (int k = 0; k < 3; k++)
        out->to_eye[k] /= sqrt(n);
    reference_vertex_across(axis, out, out->across);
    out->x = (int)(pixel % (uint32_t)r->picture.width);
    out->y = (int)(pixel / (uint32_t)r->picture.width);
}

static bool ready(const struct renderer *r, struct error *err)
{
    if (r->samples == 0)
        return error_set(err, "state", "image", "nothing is rendered yet");
    if (r->path == RENDERER_FORWARD)
        return error_set(err, "state", "render.path",
                         "render.path: forward shades fragments and keeps no "
                         "light of places");
    if (r->picture.flushed)
        return error_set(err, "state", "quality.cache_mb",
                         "quality.cache_mb: %d is too little to keep what "
                         "sample 0 saw until now; ask earlier",
                         r->params.quality.cache_mb);
    return true;
}

bool renderer_places(struct renderer *r, size_t want, uint64_t seed,
                     struct places_item *item, size_t *got, struct error *err)
{
    struct chosen c = {0};
    struct gpu_item *items = NULL;
    uint32_t *axis = NULL;
    bool ok = true;
    *got = 0;
    egl_use(r->egl);
    if (!ready(r, err))
        return false;
    renderer_freshen_tint(r);
    const size_t pixels = (size_t)r->picture.width * (size_t)r->picture.height;
    uint32_t *map = bytes_alloc(pixels * sizeof *map);
    gl.GetNamedBufferSubData(r->picture.map, 0,
                             (GLsizeiptr)(pixels * sizeof *map), map);
    draw(map, pixels, want, seed, &c);
    if (r->params.fibre.a != 1.0f) {
        axis = bytes_zalloc(r->groom->points, sizeof *axis);
        strands_axes(r->groom, place_up(r->groom, &r->params), axis);
    }
    if (c.count > 0) {
        items = bytes_alloc(c.count * sizeof *items);
        ok = fetch(r, &c, items, err);
    }
    for (size_t i = 0; ok && i < c.count; i++)
        fill(r, axis, &items[i], c.pixel[i], &item[i]);
    *got = ok ? c.count : 0;
    free(axis);
    free(items);
    free(c.pixel);
    free(c.number);
    free(map);
    return ok;
}

void renderer_scene(const struct renderer *r, struct reference_scene *out)
{
    *out = (struct reference_scene){r->groom,   r->map,      &r->fit,
                                    &r->params, FIBRE_EXACT, NULL};
}

static bool scene_of(const struct renderer *r, enum fibre_model model,
                     struct reference_scene *scene, struct error *err)
{
    if (!r->groom || !r->map)
        return error_set(err, "state", r->groom ? "env" : "hair",
                         "no %s is loaded", r->groom ? "sky" : "groom");
    renderer_scene(r, scene);
    scene->model = model;
    return true;
}

struct reference *renderer_reference(const struct renderer *r,
                                     enum fibre_model model, struct error *err)
{
    struct reference_scene scene;
    return scene_of(r, model, &scene, err) ? reference_create(&scene, err)
                                           : NULL;
}

bool renderer_reference_update(const struct renderer *r, enum fibre_model model,
                               struct reference *s, struct error *err)
{
    struct reference_scene scene;
    return scene_of(r, model, &scene, err) && reference_update(s, &scene, err);
}
