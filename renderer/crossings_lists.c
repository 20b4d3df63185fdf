// crossings_lists.c - for rays: the segments that touch each of the cells into
// which voxels are cut, as wide as they are.  Two passes, counting and filling.
#include "renderer/crossings_private.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "protocol/bytes.h"
#include "renderer/gl.h"
#include "renderer/shoot_threads.h"
#include "renderer/timer.h"

enum { CELLS = 2 }; // a voxel, along an axis; 1 where memory ends
// How far rays count real fibres, in voxels.
static const float ray_voxels = 2;

enum { SLABS = 2, LOOK_EVERY = 256 }; // one thread each; strands

struct job {
    const struct crossings_hair *hair;
    const int *size;  // cells
    uint32_t *counts; // [cells]: how many, or where the next is to be put
    uint32_t *pieces; // NULL: count
    uint64_t most;    // entries; a slab that has more stops counting
};

struct reach {        // a segment, and how far it reaches across
    float a[3], d[3]; // from a to a + d
    float slow[3];    // 1 / d, huge where d is nothing
    float r;
};

static struct reach reach_of(const float *a, const float *b)
{
    struct reach g;
    for (int k = 0; k < 3; k++) {
        g.a[k] = a[k];
        g.d[k] = b[k] - a[k];
        g.slow[k] = 1 / (fabsf(g.d[k]) > 1e-12f ? g.d[k] : 1e-12f);
    }
    g.r = 0.5f * (a[3] > b[3] ? a[3] : b[3]) + 1e-4f; // and rounding
    return g;
}

static int cell_of(float x, int size)
{
    const int i = x > 0 ? (int)x : 0;
    return i < size ? i : size - 1;
}

// The part of the segment, 0 to 1, between low and high of axis k.
static void clip(const struct reach *g, int k, float low, float high,
                 float t[2])
{
    const float u = (low - g->a[k]) * g->slow[k];
    const float v = (high - g->a[k]) * g->slow[k];
    const float first = u < v ? u : v, last = u < v ? v : u;
    t[0] = first > t[0] ? first : t[0];
    t[1] = last < t[1] ? last : t[1];
}

// Cells along axis k that the part t of the segment can touch.
static void range_of(const struct reach *g, int k, const float t[2], int size,
                     int out[2])
{
    const float x = g->a[k] + t[0] * g->d[k], y = g->a[k] + t[1] * g->d[k];
    out[0] = cell_of((x < y ? x : y) - g->r, size);
    out[1] = cell_of((x < y ? y : x) + g->r, size);
}

static void put(const struct job *job, const int v[3], uint32_t i,
                uint64_t *total)
{
    const int *n = job->size;
    const size_t at =
        ((size_t)v[2] * (size_t)n[1] + (size_t)v[1]) * (size_t)n[0] +
        (size_t)v[0];
    if (job->pieces)
        job->pieces[job->counts[at]] = i;
    job->counts[at]++;
    ++*total;
}

// Cells of one layer across axis k: those that the segment touches.
static uint64_t place_layer(const struct job *job, const struct reach *g, int k,
                            int layer, const int slab[2], uint32_t i)
{
    const int p = (k + 1) % 3, q = (k + 2) % 3;
    float t[2] = {0, 1};
    int across[3][2], v[3];
    uint64_t total = 0;
    clip(g, k, (float)layer - g->r, (float)layer + 1 + g->r, t);
    if (t[0] > t[1])
        return 0;
    range_of(g, p, t, job->size[p], across[p]);
    range_of(g, q, t, job->size[q], across[q]);
    across[k][0] = across[k][1] = layer;
    across[2][0] = across[2][0] < slab[0] ? slab[0] : across[2][0];
    across[2][1] = across[2][1] < slab[1] ? across[2][1] : slab[1] - 1;
    for (v[2] = across[2][0]; v[2] <= across[2][1]; v[2]++)
        for (v[1] = across[1][0]; v[1] <= across[1][1]; v[1]++)
            for (v[0] = across[0][0]; v[0] <= across[0][1]; v[0]++) {
                float part[2] = {t[0], t[1]};
                clip(g, p, (float)v[p] - g->r, (float)v[p] + 1 + g->r, part);
                clip(g, q, (float)v[q] - g->r, (float)v[q] + 1 + g->r, part);
                if (part[0] <= part[1])
                    put(job, v, i, &total);
            }
    return total;
}

static uint64_t place_segment(const struct job *job, uint32_t i,
                              const int slab[2])
{
    const float *a = job->hair->at + 4 * (size_t)i;
    const struct reach g = reach_of(a, a + 4);
    const float whole[2] = {0, 1};
    int k = 0, layer[2], depth[2];
    range_of(&g, 2, whole, job->size[2], depth);
    if (depth[1] < slab[0] || depth[0] >= slab[1])
        return 0;
    for (int c = 1; c < 3; c++)
        if (fabsf(g.d[c]) > fabsf(g.d[k]))
            k = c;
    range_of(&g, k, whole, job->size[k], layer);
    uint64_t total = 0;
    for (int n = layer[0]; n <= layer[1]; n++)
        total += place_layer(job, &g, k, n, slab, i);
    return total;
}

// Each thread has its own layers of cells, so that what is in a cell comes in
// the strands' order.
static void place_slab(void *context, size_t n)
{
    const struct job *job = context;
    const struct crossings_hair *h = job->hair;
    const int depth = job->size[2];
    const int slab[2] = {depth * (int)n / SLABS, depth * ((int)n + 1) / SLABS};
    uint64_t total = 0;
    for (uint32_t k = 0; k < h->strands && total <= job->most; k++) {
        if (k % LOOK_EVERY == 0 && watch_cut(h->watch))
            return;
        for (uint32_t i = h->first[k]; i + 1 < h->first[k + 1]; i++)
            total += place_segment(job, i, slab);
    }
}

// starts: one more than cells; *pieces: malloced, starts[cells] of them, the
// point numbers at which segments begin.  False when they are more than `most`.
static bool make(const struct crossings_hair *h, const int size[3],
                 uint64_t most, uint32_t *starts, uint32_t **pieces)
{
    const size_t cells = (size_t)size[0] * (size_t)size[1] * (size_t)size[2];
    struct job job = {h, size, starts, NULL, most};
    shoot_threads(SLABS, place_slab, &job);
    uint64_t sum = 0;
    if (watch_cut(h->watch))
        return false;
    for (size_t i = 0; i <= cells; i++) {
        const uint32_t n = i < cells ? starts[i] : 0;
        if (sum > most)
            return false;
        starts[i] = (uint32_t)sum;
        sum += n;
    }
    *pieces = bytes_alloc(((size_t)sum + 1) * sizeof **pieces);
    (*pieces)[sum] = 0;
    job.pieces = *pieces;
    shoot_threads(SLABS, place_slab, &job);
    if (watch_cut(h->watch))
        return false; // the caller frees *pieces
    // each start now is where the next one was
    memmove(starts + 1, starts, cells * sizeof *starts);
    starts[0] = 0;
    return true;
}

void crossings_lists_forget(struct crossings *c)
{
    gl.DeleteBuffers(2, c->rays.list);
    gl.DeleteTextures(5, c->rays.texture);
    memset(&c->rays, 0, sizeof c->rays);
    c->stats.lists_bytes = 0;
}

static void look_into(unsigned *texture, GLenum format, unsigned buffer)
{
    gl.DeleteTextures(1, texture);
    *texture = 0;
    if (!buffer)
        return;
    gl.CreateTextures(GL_TEXTURE_BUFFER, 1, texture);
    gl.TextureBuffer(*texture, format, buffer);
}

// A buffer's name may come again after it was deleted, but then the lists were
// forgotten with the grid.
void crossings_lists_bind(struct crossings *c, const struct strands *s)
{
    const unsigned of[3] = {s->position, s->strand, s->opacity};
    static const GLenum format[3] = {GL_RGBA32F, GL_R32UI, GL_R32F};
    for (int i = 0; i < 3; i++)
        if (c->rays.of[i] != of[i])
            look_into(&c->rays.texture[2 + i], format[i], of[i]);
    memcpy(c->rays.of, of, sizeof of);
    for (GLuint i = 0; i < 5; i++)
        if (c->rays.texture[i])
            gl.BindTextureUnit(CROSSINGS_TEXTURE_UNIT + 1 + i,
                               c->rays.texture[i]);
}

// Some megabytes at a time: they are copied while somebody may wait.
static bool fill(unsigned buffer, const void *data, size_t bytes,
                 struct watch *watch)
{
    const size_t most = (size_t)4 << 20;
    gl.NamedBufferStorage(buffer, (GLsizeiptr)gl_texture_buffer_size(bytes),
                          NULL, GL_DYNAMIC_STORAGE_BIT);
    for (size_t at = 0; at < bytes && !watch_cut(watch); at += most)
        gl.NamedBufferSubData(
            buffer, (GLintptr)at,
            (GLsizeiptr)(bytes - at < most ? bytes - at : most),
            (const char *)data + at);
    return !watch_cut(watch);
}

static bool send(struct crossings *c, const int size[3], const uint32_t *starts,
                 const uint32_t *pieces)
{
    const size_t cells = (size_t)size[0] * (size_t)size[1] * (size_t)size[2];
    const size_t bytes[2] = {4 * (cells + 1), 4 * ((size_t)starts[cells] + 1)};
    const void *const data[2] = {starts, pieces};
    static const char *const name[2] = {"crossings cells", "crossings pieces"};
    gl.CreateBuffers(2, c->rays.list);
    for (int i = 0; i < 2; i++) {
        if (!fill(c->rays.list[i], data[i], bytes[i], c->watch)) {
            crossings_lists_forget(c);
            return false;
        }
        gl.ObjectLabel(GL_BUFFER, c->rays.list[i], -1, name[i]);
    }
    for (int i = 0; i < 2; i++)
        look_into(&c->rays.texture[i], GL_R32UI, c->rays.list[i]);
    c->stats.lists_bytes = bytes[0] + bytes[1];
    for (int k = 0; k < 3; k++)
        c->block->cells[k] = (float)size[k];
    c->block->cells[3] = (float)(size[0] / c->size[0]);
    c->block->inverse[3] = ray_voxels * c->block->cells[3];
    gl.NamedBufferSubData(c->uniform, 0, sizeof *c->block, c->block);
    return true;
}

// Lists of `cells` cells a voxel along an axis, of at most `most` bytes each.
static bool build(struct crossings *c, const struct groom *g,
                  const struct params *p, int cells, uint64_t most)
{
    const int size[3] = {cells * c->size[0], cells * c->size[1],
                         cells * c->size[2]};
    const uint64_t all =
        (uint64_t)(cells * cells * cells) * crossings_voxels(c);
    if (4 * (all + 1) > most || watch_cut(c->watch))
        return false;
    struct crossings_hair hair = {.watch = c->watch};
    uint32_t *pieces = NULL, *starts = bytes_zalloc((size_t)all + 1, 4);
    crossings_grid_hair(&hair, c->box_min, c->voxel / (float)cells, g, p);
    const bool ok = make(&hair, size, most / 4 - 1, starts, &pieces) &&
                    send(c, size, starts, pieces);
    crossings_grid_hair_finish(&hair);
    free(starts);
    free(pieces);
    return ok;
}

bool crossings_build_lists(struct crossings *c, const struct groom *g,
                           const struct params *p, struct error *err)
{
    const double began = timer_now();
    GLint texels = 0;
    gl.GetIntegerv(GL_MAX_TEXTURE_BUFFER_SIZE, &texels);
    uint64_t most = 4 * (uint64_t)texels;
    // Half of it for each of the two; the directions have their own share, or
    // else how many they are would depend on whether there are lists.
    if (c->options.budget > 0 && c->options.budget / 2 < most)
        most = c->options.budget / 2;
    crossings_lists_forget(c);
    bool ok = g->points <= (uint64_t)texels;
    ok = ok && (build(c, g, p, CELLS, most) || build(c, g, p, 1, most));
    c->stats.lists_ms = 1e3 * (timer_now() - began);
    if (watch_cut(c->watch))
        return false;
    return ok ? gl_check("the shadows' lists", err)
              : error_set(
                    err, "limit", "shadow",
                    "shadows: lists of the %u points near each of %d x %d "
                    "x %d voxels are longer than %llu bytes",
                    g->points, c->size[0], c->size[1], c->size[2],
                    (unsigned long long)most);
}
