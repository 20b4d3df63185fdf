// shoot.c - a groom as a scene for rays, and single rays.  The tree is made in
// shoot_build.c, walked in shoot_walk.c; lobes are averaged in shoot_lobe.c.
#include "renderer/shoot.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "protocol/bytes.h"
#include "renderer/place.h"
#include "renderer/shoot_walk.h"

// About 57 bytes a segment at rest and 120 while it is built: a gigabyte.
enum { POINTS_MAX = 8 << 20 };

// --- the scene ---------------------------------------------------------------

static bool place_points(struct shoot *s, const struct groom *g,
                         const struct params *p, struct error *err)
{
    const bool varies = place_diameter_varies(g, p);
    float d = varies ? 0 : place_diameter(g, p, 0);
    double largest = 0;
    for (uint32_t i = 0; i < g->points; i++) {
        float *out = s->point + 4 * (size_t)i;
        place_point(g, p, i, out);
        if (varies)
            d = place_diameter(g, p, i);
        out[3] = place_width(p, d);
        for (int k = 0; k < 4; k++)
            if (!isfinite(out[k]))
                return error_set(err, "range", "hair.scale",
                                 "hair.scale: %g takes point %u of %s out of "
                                 "the range of single precision",
                                 (double)p->hair.scale, i, g->name);
        for (int k = 0; k < 3; k++)
            largest = fmax(largest, fabs((double)out[k]) + (double)out[3]);
    }
    int exponent;
    frexp(largest, &exponent);
    s->unit = ldexp(1, -exponent);
    for (size_t i = 0; i < 4 * (size_t)g->points; i++)
        s->point[i] = (float)(s->unit * (double)s->point[i]);
    return true;
}

static void measure_diameter(struct shoot *s)
{
    double sum = 0, length = 0;
    for (uint32_t k = 0; k < s->strands; k++)
        for (uint32_t i = s->first[k]; i + 1 < s->first[k + 1]; i++) {
            const float *a = s->point + 4 * (size_t)i, *b = a + 4;
            double dl2 = 0;
            for (int c = 0; c < 3; c++) {
                double e = (double)b[c] - (double)a[c];
                dl2 += e * e;
            }
            s->tapered |= a[3] != b[3];
            sum += sqrt(dl2) * ((double)a[3] + (double)b[3]) / 2;
            length += sqrt(dl2);
        }
    s->diameter = (length > 0 ? sum / length : (double)s->point[3]) / s->unit;
}

static void take_opacity(struct shoot *s, const struct groom *g,
                         const struct params *p)
{
    if (!p->hair.use_opacity || (!g->opacity && g->default_opacity >= 1))
        return;
    s->opacity = bytes_alloc(g->points * sizeof *s->opacity);
    for (uint32_t i = 0; i < g->points; i++)
        s->opacity[i] = g->opacity ? g->opacity[i] : g->default_opacity;
}

static void take_head(struct shoot *s, const struct groom *g,
                      const struct params *p)
{
    float centre[3], radius[3];
    s->head = place_head(g, p, centre, radius);
    for (int k = 0; s->head && k < 3; k++) {
        s->head_centre[k] = (double)centre[k];
        s->head_radius[k] = (double)radius[k];
    }
    for (int k = 0; k < 3; k++)
        if (!(s->head_radius[k] > 0))
            s->head = false; // flat: it hides nothing
}

struct shoot *shoot_create(const struct groom *g, const struct params *p,
                           struct error *err)
{
    return shoot_create_watched(g, p, NULL, err);
}

struct shoot *shoot_create_watched(const struct groom *g,
                                   const struct params *p, struct watch *watch,
                                   struct error *err)
{
    if (g->points > POINTS_MAX) {
        error_set(err, "limit", g->name,
                  "%s: %u points are more than the %d that rays can be shot at",
                  g->name, g->points, POINTS_MAX);
        return NULL;
    }
    struct shoot *s = bytes_zalloc(1, sizeof *s);
    s->points = g->points;
    s->strands = g->strands;
    s->point = bytes_alloc(4 * (size_t)g->points * sizeof *s->point);
    s->first = bytes_alloc(((size_t)g->strands + 1) * sizeof *s->first);
    memcpy(s->first, g->first, ((size_t)g->strands + 1) * sizeof *s->first);
    if (!place_points(s, g, p, err)) {
        shoot_destroy(s);
        return NULL;
    }
    measure_diameter(s);
    take_opacity(s, g, p);
    take_head(s, g, p);
    const struct shoot_segments in = {s->point, s->first, s->strands, watch};
    if (shoot_build(&s->tree, &in))
        return s;
    shoot_destroy(s);
    return NULL;
}

void shoot_destroy(struct shoot *s)
{
    if (!s)
        return;
    shoot_build_finish(&s->tree);
    free(s->point);
    free(s->first);
    free(s->opacity);
    free(s);
}

double shoot_diameter(const struct shoot *s)
{
    return s->diameter;
}

size_t shoot_bytes(const struct shoot *s)
{
    return sizeof *s + s->tree.nodes * sizeof *s->tree.node +
           s->tree.leaves * sizeof *s->tree.leaf +
           s->points * (s->opacity ? 5u : 4u) * sizeof(float) +
           ((size_t)s->strands + 1) * sizeof *s->first;
}

// --- places ------------------------------------------------------------------

static uint32_t strand_of(const struct shoot *s, uint32_t point)
{
    uint32_t low = 0, high = s->strands;
    while (high - low > 1) {
        uint32_t middle = low + (high - low) / 2;
        if (s->first[middle] <= point)
            low = middle;
        else
            high = middle;
    }
    return low;
}

struct shoot_own shoot_own(const struct shoot *s, uint32_t segment)
{
    if (segment >= s->points)
        return (struct shoot_own){0, 0};
    uint32_t k = strand_of(s, segment);
    return (struct shoot_own){s->first[k], s->first[k + 1]};
}

void shoot_point(const struct shoot *s, uint32_t segment, double along,
                 struct shoot_point *out)
{
    const float *a = s->point + 4 * (size_t)segment, *b = a + 4;
    double e[3], n = 0;
    for (int k = 0; k < 3; k++) {
        e[k] = (double)b[k] - (double)a[k];
        n += e[k] * e[k];
        out->position[k] = ((double)a[k] + along * e[k]) / s->unit;
    }
    n = sqrt(n);
    for (int k = 0; k < 3; k++)
        out->tangent[k] = n > 0 ? e[k] / n : k == 2 ? -1 : 0;
    out->diameter =
        ((double)a[3] + along * ((double)b[3] - (double)a[3])) / s->unit;
    out->opacity = 1;
    if (s->opacity) {
        double o = (double)s->opacity[segment];
        out->opacity = o + along * ((double)s->opacity[segment + 1] - o);
    }
    out->strand = strand_of(s, segment);
}

// --- the head ----------------------------------------------------------------

double shoot_head(const struct shoot *s, const struct shoot_ray *ray)
{
    if (!s->head)
        return INFINITY;
    // where the head is the unit sphere
    double oo = 0, od = 0, dd = 0;
    for (int k = 0; k < 3; k++) {
        double o = (ray->origin[k] - s->head_centre[k]) / s->head_radius[k];
        double d = ray->direction[k] / s->head_radius[k];
        oo += o * o;
        od += o * d;
        dd += d * d;
    }
    if (!(od < 0))
        return INFINITY; // it leads away
    if (oo <= 1)
        return ray->reach > 0 ? 0 : INFINITY;
    double under = od * od - dd * (oo - 1);
    if (!(under >= 0))
        return INFINITY;
    // (oo - 1) / ... and not -od - sqrt: nothing cancels near the surface
    double t = (oo - 1) / (-od + sqrt(under));
    return t < ray->reach ? t : INFINITY;
}

// --- single rays -------------------------------------------------------------

void shoot_ray(const struct shoot *s, const struct shoot_ray *ray,
               struct shoot_hit *hit)
{
    const double head = shoot_head(s, ray);
    struct shoot_ray before = *ray;
    before.reach = head < ray->reach ? head : ray->reach;
    struct shoot_walk w = {.want = SHOOT_ALL};
    shoot_walk(s, &before, shoot_own(s, ray->segment), &w);
    hit->crossings = w.crossings;
    hit->head = head < INFINITY;
    hit->transmittance = hit->head ? 0 : w.transmittance;
}

double shoot_transmittance(const struct shoot *s, const struct shoot_ray *ray)
{
    if (shoot_head(s, ray) < INFINITY)
        return 0;
    struct shoot_walk w = {.want = SHOOT_CLEAR};
    shoot_walk(s, ray, shoot_own(s, ray->segment), &w);
    return w.transmittance;
}

double shoot_first(const struct shoot *s, const struct shoot_ray *ray,
                   uint32_t *segment, double *along)
{
    const double head = shoot_head(s, ray);
    struct shoot_ray before = *ray;
    before.reach = head < ray->reach ? head : ray->reach;
    struct shoot_walk w = {.want = SHOOT_FIRST};
    shoot_walk(s, &before, shoot_own(s, ray->segment), &w);
    *segment = w.segment;
    *along = w.along;
    return fmin(w.distance, head);
}
