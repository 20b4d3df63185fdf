// strands.c - turns a groom's arrays into GPU buffers.  Rotation and scale are
// applied here once, so that every shader works in world space.
#include "renderer/strands.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "protocol/bytes.h"
#include "renderer/gl.h"
#include "renderer/place.h"

// A cell's key (scene.glsl) has 32 bits, CELL_BITS of them for the cell.
enum { POINTS_MAX = 1 << 23, LOOK_EVERY = 1024 };

static bool upload(unsigned *buffer, const void *data, size_t size,
                   const char *name, struct error *err)
{
    GLint64 limit = 0;
    gl.GetInteger64v(GL_MAX_SHADER_STORAGE_BLOCK_SIZE, &limit);
    if ((GLint64)size > limit)
        return error_set(err, "limit", name,
                         "%s: %zu bytes are more than this device's limit of "
                         "%lld bytes a buffer",
                         name, size, (long long)limit);
    *buffer = gl_buffer(gl_texture_buffer_size(size), NULL, name);
    gl.NamedBufferSubData(*buffer, 0, (GLsizeiptr)size, data);
    return gl_check(name, err);
}

static void grow_box(struct strands *s, const float p[3])
{
    for (int k = 0; k < 3; k++) {
        s->box_min[k] = fminf(s->box_min[k], p[k]);
        s->box_max[k] = fmaxf(s->box_max[k], p[k]);
    }
}

static void grow_by_head(struct strands *s, const struct groom *g,
                         const struct params *p)
{
    s->has_head = place_head(g, p, s->head_centre, s->head_radius);
    if (!s->has_head)
        return;
    for (int sign = -1; sign <= 1; sign += 2) {
        float corner[3];
        for (int k = 0; k < 3; k++)
            corner[k] = s->head_centre[k] + (float)sign * s->head_radius[k];
        grow_box(s, corner);
    }
}

static void fill(struct strands *s, const struct groom *g,
                 const struct params *p, float *position, uint32_t *strand)
{
    const bool varies = place_diameter_varies(g, p);
    float d = varies ? 0 : place_diameter(g, p, 0);
    for (uint32_t k = 0; k < g->strands; k++) {
        if (k % LOOK_EVERY == 0 && watch_cut(s->watch))
            return;
        for (uint32_t i = g->first[k]; i < g->first[k + 1]; i++) {
            float *out = position + 4 * (size_t)i;
            place_point(g, p, i, out);
            if (varies)
                d = place_diameter(g, p, i);
            s->diameter = fmaxf(s->diameter, d);
            float world = place_width(p, d);
            s->diameter_min = fminf(s->diameter_min, world);
            s->diameter_max = fmaxf(s->diameter_max, world);
            out[3] = i + 1 == g->first[k + 1] ? -world : world;
            strand[i] = k;
            grow_box(s, out);
        }
    }
}

// The box of a group's segments: its middle and half its sides; no segment:
// negative sides.
static void bound(const float *position, uint32_t from, uint32_t points,
                  float out[6])
{
    float low[3] = {INFINITY, INFINITY, INFINITY}, high[3];
    for (int c = 0; c < 3; c++)
        high[c] = -INFINITY;
    for (uint32_t i = from; i < from + STRANDS_GROUP && i + 1 < points; i++) {
        const float *p = position + 4 * (size_t)i;
        for (int c = 0; c < 3 && p[3] >= 0; c++) {
            low[c] = fminf(low[c], fminf(p[c], p[c + 4]));
            high[c] = fmaxf(high[c], fmaxf(p[c], p[c + 4]));
        }
    }
    for (int c = 0; c < 3; c++) {
        const bool none = high[0] < low[0];
        const float half = none ? -1 : 0.5f * (high[c] - low[c]);
        out[c] = none ? 0 : low[c] + half;
        // rounding must not leave a point outside
        out[c + 3] = none ? -1 : half + 1e-6f * (half + fabsf(out[c]));
    }
}

static bool upload_bounds(struct strands *s, const float *position,
                          struct error *err)
{
    s->groups = (s->points + STRANDS_GROUP - 1) / STRANDS_GROUP;
    float *box = bytes_zalloc(6 * (size_t)s->groups, sizeof *box);
    for (uint32_t g = 0; g < s->groups; g++)
        bound(position, g * STRANDS_GROUP, s->points, box + 6 * (size_t)g);
    const bool ok =
        upload(&s->bounds, box, 24 * (size_t)s->groups, "strand bounds", err);
    free(box);
    if (!ok)
        return false;
    s->bytes += 24 * (uint64_t)s->groups;
    GLint most = 0;
    gl.GetIntegerv(GL_MAX_TEXTURE_BUFFER_SIZE, &most);
    if ((GLint64)most < (GLint64)s->points)
        return true; // drawn by other means (picture_draws)
    gl.CreateTextures(GL_TEXTURE_BUFFER, 1, &s->points_texture);
    gl.TextureBuffer(s->points_texture, GL_RGBA32F, s->position);
    return gl_check("strand points", err);
}

static bool upload_optional(struct strands *s, const struct groom *g,
                            const struct params *p, struct error *err)
{
    const size_t n = g->points;
    if (p->hair.use_opacity && g->opacity) {
        if (!upload(&s->opacity, g->opacity, n * 4, "opacity", err))
            return false;
        s->bytes += n * 4;
    }
    if (p->hair.use_colour && g->colour) {
        float *rgba = bytes_zalloc(n * 4, sizeof *rgba);
        for (size_t i = 0; i < n; i++)
            memcpy(rgba + 4 * i, g->colour + 3 * i, 12);
        bool ok = upload(&s->colour, rgba, n * 16, "colour", err);
        free(rgba);
        if (!ok)
            return false;
        s->bytes += n * 16;
    }
    return true;
}

bool strands_build(struct strands *s, const struct groom *g,
                   const struct params *p, struct error *err)
{
    struct watch *const watch = s->watch;
    strands_finish(s);
    s->watch = watch;
    const size_t n = g->points;
    if (n > POINTS_MAX)
        return error_set(err, "limit", "hair",
                         "hair: %zu points are more than the %d that can be "
                         "told apart",
                         n, POINTS_MAX);
    float *position = bytes_zalloc(n * 4, sizeof *position);
    uint32_t *strand = bytes_zalloc(n, sizeof *strand);
    s->up = place_up(g, p);
    s->points = g->points;
    s->strands = g->strands;
    s->diameter_min = INFINITY;
    for (int k = 0; k < 3; k++) {
        s->box_min[k] = INFINITY;
        s->box_max[k] = -INFINITY;
    }
    fill(s, g, p, position, strand);
    grow_by_head(s, g, p);
    s->bytes = n * 20;
    for (int c = 0; c < 3; c++)
        s->plain_colour[c] = p->hair.use_colour ? g->default_colour[c] : 1;
    s->plain_colour[3] = p->hair.use_opacity ? g->default_opacity : 1;
    bool ok = !watch_cut(watch) &&
              upload(&s->position, position, n * 16, "strand points", err) &&
              upload(&s->strand, strand, n * 4, "strand index", err) &&
              upload_bounds(s, position, err) && upload_optional(s, g, p, err);
    free(position);
    free(strand);
    if (!ok)
        strands_finish(s);
    return ok;
}

// --- the cross section's axis ------------------------------------------------

static float dot(const float a[3], const float b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static bool normalise(float v[3])
{
    float n = sqrtf(dot(v, v));
    if (!(n > 0))
        return false;
    for (int i = 0; i < 3; i++)
        v[i] /= n;
    return true;
}

static void reflect(float v[3], const float n[3], float nn)
{
    float s = 2 * dot(v, n) / nn;
    for (int i = 0; i < 3; i++)
        v[i] -= s * n[i];
}

// Tangent at point i of a strand [a, b): central difference, as scene.glsl.
static void tangent_at(int up, const struct groom *g, uint32_t i, uint32_t a,
                       uint32_t b, float out[3])
{
    float from[3], to[3];
    place_axes(up, g->position + 3 * (size_t)(i > a ? i - 1 : i), from);
    place_axes(up, g->position + 3 * (size_t)(i + 1 < b ? i + 1 : i), to);
    for (int c = 0; c < 3; c++)
        out[c] = to[c] - from[c];
    if (!normalise(out))
        memcpy(out, (float[3]){0, 0, -1}, 12);
}

static float seeded_angle(uint32_t strand)
{
    uint32_t h = strand * 2654435769u + 0x9e37u;
    h ^= h >> 16;
    h *= 0x7feb352du;
    h ^= h >> 15;
    return (float)h * (float)(2 * M_PI / 4294967296.0);
}

static void root_axis(const float t[3], float angle, float v[3])
{
    float side[3] = {0, 0, 0}, w[3];
    side[fabsf(t[2]) < 0.9f ? 2 : 0] = 1;
    float s = dot(side, t);
    for (int c = 0; c < 3; c++)
        side[c] -= s * t[c];
    normalise(side);
    w[0] = t[1] * side[2] - t[2] * side[1];
    w[1] = t[2] * side[0] - t[0] * side[2];
    w[2] = t[0] * side[1] - t[1] * side[0];
    for (int c = 0; c < 3; c++)
        v[c] = cosf(angle) * side[c] + sinf(angle) * w[c];
}

static uint32_t octahedral(const float v[3])
{
    float l = fabsf(v[0]) + fabsf(v[1]) + fabsf(v[2]);
    float x = v[0] / l, y = v[1] / l;
    if (v[2] < 0) {
        float fx = (1 - fabsf(y)) * (x < 0 ? -1.f : 1.f);
        y = (1 - fabsf(x)) * (y < 0 ? -1.f : 1.f);
        x = fx;
    }
    int16_t ix = (int16_t)lrintf(x * 32767), iy = (int16_t)lrintf(y * 32767);
    return (uint32_t)(uint16_t)ix | (uint32_t)(uint16_t)iy << 16;
}

// Rotation-minimising frame by double reflection (Wang, Juttler, Zheng and Liu
// 2008): v is reflected in the chord's bisecting plane, then in the tangents'.
static void strand_axes(int up, const struct groom *g, uint32_t k,
                        uint32_t *out)
{
    uint32_t a = g->first[k], b = g->first[k + 1];
    float t0[3], v[3];
    tangent_at(up, g, a, a, b, t0);
    root_axis(t0, seeded_angle(k), v);
    out[a] = octahedral(v);
    for (uint32_t i = a + 1; i < b; i++) {
        float p0[3], p1[3], chord[3], t1[3], tl[3], n2[3];
        place_axes(up, g->position + 3 * (size_t)(i - 1), p0);
        place_axes(up, g->position + 3 * (size_t)i, p1);
        tangent_at(up, g, i, a, b, t1);
        memcpy(tl, t0, sizeof tl);
        for (int c = 0; c < 3; c++)
            chord[c] = p1[c] - p0[c];
        float cc = dot(chord, chord);
        if (cc > 0) {
            reflect(v, chord, cc);
            reflect(tl, chord, cc);
        }
        for (int c = 0; c < 3; c++)
            n2[c] = t1[c] - tl[c];
        float nn = dot(n2, n2);
        if (nn > 1e-12f)
            reflect(v, n2, nn);
        normalise(v);
        memcpy(t0, t1, sizeof t0);
        out[i] = octahedral(v);
    }
}

void strands_axes(const struct groom *g, int up, uint32_t *axis)
{
    for (uint32_t k = 0; k < g->strands; k++)
        strand_axes(up, g, k, axis);
}

bool strands_build_axis(struct strands *s, const struct groom *g,
                        struct error *err)
{
    if (s->axis)
        return true;
    uint32_t *axis = bytes_zalloc(g->points, sizeof *axis);
    for (uint32_t k = 0; k < g->strands; k++) {
        if (k % LOOK_EVERY == 0 && watch_cut(s->watch))
            break;
        strand_axes(s->up, g, k, axis);
    }
    bool ok = !watch_cut(s->watch) &&
              upload(&s->axis, axis, (size_t)g->points * 4, "strand axis", err);
    free(axis);
    if (!ok) {
        gl.DeleteBuffers(1, &s->axis);
        s->axis = 0; // not there: tried again
        return false;
    }
    s->bytes += (uint64_t)g->points * 4;
    return true;
}

void strands_widths(struct strands *s, const struct camera *c, float scale)
{
    const float threshold = 0.7f; // THIN_BELOW of visible.vert
    float nearest = INFINITY, farthest = -INFINITY;
    for (int corner = 0; corner < 8; corner++) {
        float depth = 0;
        for (int k = 0; k < 3; k++)
            depth +=
                c->forward[k] *
                ((corner >> k & 1 ? s->box_max[k] : s->box_min[k]) - c->eye[k]);
        nearest = fminf(nearest, depth);
        farthest = fmaxf(farthest, depth);
    }
    // a margin of 1 %: float rounding must not lose a segment between the two
    nearest = fmaxf(nearest, c->near);
    s->draw_wide = s->diameter_max * scale / nearest >= 0.99f * threshold;
    // a line's slope makes at most sqrt 2 of it (visible.vert)
    s->thin_most = 1.01f * sqrtf(2) * s->diameter_max * scale / nearest;
    s->draw_thin =
        s->diameter_min * scale / fmaxf(farthest, c->near) < 1.01f * threshold;
}

void strands_finish(struct strands *s)
{
    const unsigned all[] = {s->position, s->strand, s->opacity,
                            s->colour,   s->axis,   s->bounds};
    gl.DeleteTextures(1, &s->points_texture);
    gl.DeleteBuffers(6, all);
    memset(s, 0, sizeof *s);
}
