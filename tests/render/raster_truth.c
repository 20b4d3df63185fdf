// raster_truth.c - the rule of raster_walk.comp, pixel by pixel.
#include "tests/render/raster_truth.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "protocol/bytes.h"
#include "renderer/gl.h"

static uint32_t mixed(uint32_t x)
{
    x ^= x >> 16;
    x *= 0x7feb352du;
    x ^= x >> 15;
    x *= 0x846ca68bu;
    return x ^ (x >> 16);
}

// keep.glsl, sample 0: the scramble of nothing but the seed.
static double draw_of(uint32_t strand)
{
    uint32_t x = mixed(strand + 0x9e3779b9u), out = 0;
    x ^= x * 0x6c50b47cu;
    x ^= x * 0xb82f1e52u;
    x ^= x * 0xc7afe638u;
    x = x ^ x * 0x8d22f6e6u;
    for (int i = 0; i < 32; i++)
        out |= (x >> i & 1) << (31 - i);
    return (out >> 8) / 16777216.0;
}

struct end { // of a segment, where it is seen
    double x, y, depth, at, corner[2][2];
    bool cut;
};

static double dot3(const float a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void project(const struct raster_truth *t, const double p[3],
                    struct end *e)
{
    const struct camera *c = &t->r->camera;
    double d[3];
    for (int i = 0; i < 3; i++)
        d[i] = p[i] - c->eye[i];
    const double w = dot3(c->forward, d);
    const double scale = 0.5 * TRUTH_HEIGHT / c->tan_half / w;
    e->x = 0.5 * TRUTH_WIDTH + dot3(c->right, d) * scale +
           0.5 * TRUTH_WIDTH * t->jitter[0];
    e->y = 0.5 * TRUTH_HEIGHT + dot3(c->up, d) * scale +
           0.5 * TRUTH_HEIGHT * t->jitter[1];
    e->depth = c->near / w;
}

static double w_of(const struct raster_truth *t, uint32_t i)
{
    double d[3];
    for (int c = 0; c < 3; c++)
        d[c] = t->point[4 * i + (unsigned)c] - (double)t->r->camera.eye[c];
    return dot3(t->r->camera.forward, d);
}

static double width_of(const struct raster_truth *t, uint32_t i, double at,
                       double depth)
{
    const struct camera *c = &t->r->camera;
    const double a = fabsf(t->point[4 * i + 3]);
    const double b = fabsf(t->point[4 * i + 7]);
    return (a + at * (b - a)) * depth / c->near * 0.5 * TRUTH_HEIGHT /
           c->tan_half;
}

// The tangent's direction in the picture, by going a little along it.
static void across_of(const struct raster_truth *t, uint32_t i, double out[2])
{
    const float *p = t->point;
    const uint32_t a = i > 0 && p[4 * (i - 1) + 3] > 0 ? i - 1 : i;
    const uint32_t b = p[4 * i + 3] > 0 ? i + 1 : i;
    double here[3], there[3], n = 0;
    struct end e0, e1;
    for (int c = 0; c < 3; c++) {
        const double go =
            (double)p[4 * b + (unsigned)c] - p[4 * a + (unsigned)c];
        here[c] = p[4 * i + (unsigned)c];
        there[c] = here[c] + 1e-5 * go;
    }
    project(t, here, &e0);
    project(t, there, &e1);
    n = hypot(e1.x - e0.x, e1.y - e0.y);
    out[0] = n > 0 ? -(e1.y - e0.y) / n : 1;
    out[1] = n > 0 ? (e1.x - e0.x) / n : 0;
}

// False where nothing of it is before the near plane.
static bool ends(const struct raster_truth *t, uint32_t i, struct end e[2])
{
    const double near = t->r->camera.near;
    const double w[2] = {w_of(t, i), w_of(t, i + 1)};
    if (t->point[4 * i + 3] < 0 || fmax(w[0], w[1]) <= near)
        return false;
    for (int k = 0; k < 2; k++) {
        double p[3];
        e[k].cut = w[k] < near;
        e[k].at = e[k].cut ? (near - w[0]) / (w[1] - w[0]) : k;
        for (unsigned c = 0; c < 3; c++) {
            const double a = t->point[4 * i + c], b = t->point[4 * i + 4 + c];
            p[c] = a + e[k].at * (b - a);
        }
        project(t, p, &e[k]);
    }
    const double dx = e[1].x - e[0].x, dy = e[1].y - e[0].y;
    for (int k = 0; k < 2; k++) {
        double n[2] = {-dy / hypot(dx, dy), dx / hypot(dx, dy)};
        if (!e[k].cut)
            across_of(t, i + (uint32_t)k, n);
        const double half = 0.5 * width_of(t, i, e[k].at, e[k].depth);
        for (int s = 0; s < 2; s++) {
            e[k].corner[s][0] = e[k].x + (s ? half : -half) * n[0];
            e[k].corner[s][1] = e[k].y + (s ? half : -half) * n[1];
        }
    }
    return true;
}

static double share_of(const struct raster_truth *t, uint32_t i,
                       const struct end e[2], double s, double slope)
{
    double share[2];
    for (int k = 0; k < 2; k++) {
        const double width = width_of(t, i, e[k].at, e[k].depth);
        const double o0 = t->opacity ? t->opacity[i] : 1;
        const double o1 = t->opacity ? t->opacity[i + 1] : 1;
        share[k] = (o0 + e[k].at * (o1 - o0)) *
                   (slope > 0 ? fmin(width * slope, 1) : 1);
    }
    return share[0] + s * (share[1] - share[0]);
}

static void cover(struct raster_truth *t, uint32_t i, const double item[3],
                  int at)
{ // item: draw minus share, depth, distance to a limit in pixels
    if (fabs(item[0]) < 1e-4 || fabs(item[2]) < 2e-3)
        t->close[at] = true;
    if (item[0] >= 0 || item[2] < 0)
        return;
    if (fabs(item[1] / t->depth[at] - 1) < 1e-5)
        t->close[at] = true;
    if (item[1] <= t->depth[at])
        return;
    t->depth[at] = item[1];
    t->seen[at] = i;
}

// How far inside of [a, b) is x?  Negative: outside.
static double inside(double x, double a, double b)
{
    return fmin(x - fmin(a, b), fmax(a, b) - x);
}

static void line(struct raster_truth *t, uint32_t i, const struct end e[2])
{
    const double dx = e[1].x - e[0].x, dy = e[1].y - e[0].y;
    const bool steep = fabs(dy) > fabs(dx);
    const double slope = hypot(dx, dy) / fmax(fabs(dx), fabs(dy));
    if (fabs(fabs(dy) - fabs(dx)) < 1e-3) // either way: tell nobody off
        for (int at = 0; at < TRUTH_PIXELS; at++)
            t->close[at] |=
                hypot(at % TRUTH_WIDTH - e[0].x, at / TRUTH_WIDTH - e[0].y) <
                hypot(dx, dy) + 2;
    for (int at = 0; at < TRUTH_PIXELS; at++) {
        const double x = at % TRUTH_WIDTH + 0.5, y = at / TRUTH_WIDTH + 0.5;
        const double s = steep ? (y - e[0].y) / dy : (x - e[0].x) / dx;
        const double along =
            steep ? inside(y, e[0].y, e[1].y) : inside(x, e[0].x, e[1].x);
        const double off = steep ? e[0].x + s * dx - x : e[0].y + s * dy - y;
        const double item[3] = {draw_of(t->strand[i]) -
                                    share_of(t, i, e, s, slope),
                                e[0].depth + s * (e[1].depth - e[0].depth),
                                fmin(along, 0.5 - fabs(off))};
        if (item[2] > -0.01)
            cover(t, i, item, at);
    }
}

static void ribbon(struct raster_truth *t, uint32_t i, const struct end e[2])
{
    const double dx = e[1].x - e[0].x, dy = e[1].y - e[0].y;
    const double *q[4] = {e[0].corner[0], e[0].corner[1], e[1].corner[1],
                          e[1].corner[0]};
    for (int at = 0; at < TRUTH_PIXELS; at++) {
        const double x = at % TRUTH_WIDTH + 0.5, y = at / TRUTH_WIDTH + 0.5;
        double low = INFINITY, high = -INFINITY, lowest = INFINITY;
        double highest = -INFINITY;
        for (int k = 0; k < 4; k++) {
            const double *a = q[k], *b = q[(k + 1) % 4];
            lowest = fmin(lowest, a[1]);
            highest = fmax(highest, a[1]);
            if ((a[1] <= y) == (b[1] <= y))
                continue;
            const double c = a[0] + (y - a[1]) / (b[1] - a[1]) * (b[0] - a[0]);
            low = fmin(low, c);
            high = fmax(high, c);
        }
        double s =
            ((x - e[0].x) * dx + (y - e[0].y) * dy) / (dx * dx + dy * dy);
        s = fmin(fmax(s, 0), 1);
        const double item[3] = {
            draw_of(t->strand[i]) - share_of(t, i, e, s, 0),
            e[0].depth + s * (e[1].depth - e[0].depth),
            fmin(inside(x, low, high), inside(y, lowest, highest))};
        if (item[2] > -0.01)
            cover(t, i, item, at);
    }
}

// The nearest point of the ellipsoid on the pixel's line of sight.
static double head_depth(const struct raster_truth *t, int at)
{
    const struct camera *c = &t->r->camera;
    const struct strands *s = &t->r->strands;
    const double x =
        2 * (at % TRUTH_WIDTH + 0.5) / TRUTH_WIDTH - 1 - t->jitter[0];
    const double y =
        2 * (at / TRUTH_WIDTH + 0.5) / TRUTH_HEIGHT - 1 - t->jitter[1];
    double a = 0, b = 0, m = -1;
    for (int k = 0; k < 3; k++) {
        const double d =
            (c->forward[k] +
             c->tan_half * (x * TRUTH_WIDTH / TRUTH_HEIGHT * c->right[k] +
                            y * c->up[k])) /
            s->head_radius[k];
        const double o =
            ((double)c->eye[k] - s->head_centre[k]) / s->head_radius[k];
        a += d * d;
        b += d * o;
        m += o * o;
    }
    const double root = b * b - a * m;
    if (!s->has_head || root < 0)
        return 0;
    double far = (-b - sqrt(root)) / a;
    if (far < c->near)
        far = (-b + sqrt(root)) / a;
    return far < c->near ? 0 : c->near / far;
}

static void fill(struct raster_truth *t)
{
    const struct strands *s = &t->r->strands;
    const double scale = 0.5 * TRUTH_HEIGHT / t->r->camera.tan_half;
    for (int at = 0; at < TRUTH_PIXELS; at++) {
        t->depth[at] = head_depth(t, at);
        t->seen[at] = TRUTH_NONE;
    }
    for (uint32_t i = 0; i + 1 < s->points; i++) {
        struct end e[2];
        if (!ends(t, i, e))
            continue;
        const double width =
            (fabsf(t->point[4 * i + 3]) + fabsf(t->point[4 * i + 7])) * scale /
            fmax(w_of(t, i) + w_of(t, i + 1), 2 * t->r->camera.near);
        if (width < 0.7f)
            line(t, i, e);
        else
            ribbon(t, i, e);
    }
}

struct raster_truth *raster_truth_make(const struct renderer *r)
{
    struct raster_truth *t = bytes_zalloc(1, sizeof *t);
    const size_t n = r->strands.points;
    t->r = r; // sample 0 sits in the pixel's middle
    t->point = bytes_alloc(16 * n);
    t->strand = bytes_alloc(4 * n);
    gl.GetNamedBufferSubData(r->strands.position, 0, (GLsizeiptr)(16 * n),
                             t->point);
    gl.GetNamedBufferSubData(r->strands.strand, 0, (GLsizeiptr)(4 * n),
                             t->strand);
    if (r->strands.opacity) {
        t->opacity = bytes_alloc(4 * n);
        gl.GetNamedBufferSubData(r->strands.opacity, 0, (GLsizeiptr)(4 * n),
                                 t->opacity);
    } else if (r->strands.plain_colour[3] < 1) {
        t->opacity = bytes_alloc(4 * n);
        for (size_t i = 0; i < n; i++)
            t->opacity[i] = r->strands.plain_colour[3];
    }
    fill(t);
    return t;
}

void raster_truth_free(struct raster_truth *t)
{
    free(t->point);
    free(t->strand);
    free(t->opacity);
    free(t);
}
