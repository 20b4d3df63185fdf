// shoot_brute.c - see the header.
#include "tests/numeric/shoot_brute.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "tests/numeric/cases.h"

struct groom *shoot_brute_groom(uint32_t strands, uint32_t points,
                                float diameter)
{
    struct groom *g = bytes_zalloc(1, sizeof *g);
    snprintf(g->name, sizeof g->name, "test");
    g->strands = strands;
    g->points = strands * points;
    g->first = bytes_zalloc((size_t)strands + 1, sizeof *g->first);
    g->position = bytes_zalloc((size_t)g->points * 3, sizeof *g->position);
    for (uint32_t k = 0; k <= strands; k++)
        g->first[k] = k * points;
    g->default_diameter = diameter;
    g->default_opacity = 1;
    g->up = 2;
    return g;
}

struct shoot *shoot_brute_scene(const struct groom *g)
{
    struct error err = {0};
    struct params p;
    params_defaults(&p);
    p.hair.use_opacity = g->opacity != NULL;
    struct shoot *s = shoot_create(g, &p, &err);
    if (!s) {
        printf("not ok scene: %s\n", err.text);
        exit(1);
    }
    return s;
}

double shoot_brute_uniform(uint64_t *state, double lo, double hi)
{
    return cases_uniform(state, lo, hi);
}

void shoot_brute_aim(uint64_t *state, double d[3])
{
    double z = cases_uniform(state, -1, 1);
    double phi = cases_uniform(state, -M_PI, M_PI), s = sqrt(1 - z * z);
    d[0] = s * cos(phi);
    d[1] = s * sin(phi);
    d[2] = z;
}

struct vec {
    long double x, y, z;
};

static struct vec cross(struct vec a, struct vec b)
{
    return (struct vec){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z,
                        a.x * b.y - a.y * b.x};
}

static long double dot(struct vec a, struct vec b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

static struct vec vec_of(const double v[3])
{
    return (struct vec){v[0], v[1], v[2]};
}

static struct vec point_of(const struct groom *g, uint32_t i)
{
    const float *p = g->position + 3 * (size_t)i;
    return (struct vec){p[0], p[1], p[2]};
}

static struct vec minus(struct vec a, struct vec b)
{
    return (struct vec){a.x - b.x, a.y - b.y, a.z - b.z};
}

// Value at `u` of something given a point, or of a constant.
static long double mix(const float *values, float constant, uint32_t i,
                       long double u)
{
    if (!values)
        return (long double)constant;
    return (long double)values[i] +
           u * ((long double)values[i + 1] - (long double)values[i]);
}

// The common perpendicular of two lines in space: along e x d.
static bool meets(const struct groom *g, const struct shoot_ray *ray,
                  uint32_t i, long double *distance, long double *u)
{
    struct vec d = vec_of(ray->direction), p = point_of(g, i);
    struct vec e = minus(point_of(g, i + 1), p);
    struct vec w = minus(p, vec_of(ray->origin)), n = cross(e, d);
    long double nn = dot(n, n);
    if (!(nn > 1e-20L * dot(e, e)))
        return false;
    *u = -dot(cross(w, d), n) / nn;
    if (!(*u >= 0 && *u < 1))
        return false;
    long double apart = dot(w, n) * dot(w, n) / nn;
    long double r = mix(g->diameter, g->default_diameter, i, *u) / 2;
    if (!(apart <= r * r))
        return false;
    *distance = dot(w, d) + *u * dot(e, d);
    return *distance > 0 && *distance < (long double)ray->reach;
}

static bool is_own(const struct groom *g, uint32_t k, uint32_t segment)
{
    return segment >= g->first[k] && segment < g->first[k + 1];
}

struct shoot_brute shoot_brute(const struct groom *g,
                               const struct shoot_ray *ray)
{
    struct shoot_brute b = {0, 1, INFINITY, 0, UINT32_MAX};
    for (uint32_t k = 0; k < g->strands; k++)
        for (uint32_t i = g->first[k]; i + 1 < g->first[k + 1]; i++) {
            long double t, u;
            if (!meets(g, ray, i, &t, &u))
                continue;
            if (is_own(g, k, ray->segment) &&
                t < 8 * mix(g->diameter, g->default_diameter, i, u))
                continue;
            long double o = mix(g->opacity, 1, i, u);
            b.crossings += (double)o;
            b.transmittance *= (double)(1 - o);
            if ((double)t < b.distance) {
                b.distance = (double)t;
                b.along = (double)u;
                b.segment = i;
            }
        }
    return b;
}
