// reference.c - a groom, a fibre and a sky as the references see them, and the
// frame of a place on the hair.
#include "renderer/reference.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "protocol/bytes.h"
#include "renderer/place.h"
#include "renderer/reference_private.h"
#include "renderer/strands.h"

// --- the scene --------------------------------------------------------------

// Central differences within the strand, as scene.glsl has them.
static void take_tangents(struct reference *s, const struct groom *g)
{
    s->tangent = bytes_alloc(3 * (size_t)g->points * sizeof *s->tangent);
    for (uint32_t k = 0; k < g->strands; k++)
        for (uint32_t i = g->first[k]; i < g->first[k + 1]; i++) {
            const uint32_t a = i > g->first[k] ? i - 1 : i;
            const uint32_t b = i + 1 < g->first[k + 1] ? i + 1 : i;
            float p[3], q[3], n = 0, *out = s->tangent + 3 * (size_t)i;
            place_point(g, &s->params, a, p);
            place_point(g, &s->params, b, q);
            for (int c = 0; c < 3; c++) {
                out[c] = q[c] - p[c];
                n += out[c] * out[c];
            }
            n = sqrtf(n);
            for (int c = 0; c < 3; c++)
                out[c] = n > 0 ? out[c] / n : c == 2 ? -1 : 0;
        }
}

static void grow(struct reference *s, const float p[3])
{
    for (int c = 0; c < 3; c++) {
        s->box_min[c] = fminf(s->box_min[c], p[c]);
        s->box_max[c] = fmaxf(s->box_max[c], p[c]);
    }
}

// The box that the camera's `auto` looks at: strands.c's.
static void take_box(struct reference *s, const struct groom *g)
{
    float p[3], centre[3], radius[3];
    for (int c = 0; c < 3; c++) {
        s->box_min[c] = INFINITY;
        s->box_max[c] = -INFINITY;
    }
    for (uint32_t i = 0; i < g->points; i++) {
        place_point(g, &s->params, i, p);
        grow(s, p);
    }
    if (!place_head(g, &s->params, centre, radius))
        return;
    for (int sign = -1; sign <= 1; sign += 2) {
        for (int c = 0; c < 3; c++)
            p[c] = centre[c] + (float)sign * radius[c];
        grow(s, p);
    }
}

static void take_colour(struct reference *s, const struct groom *g)
{
    const bool use = s->params.hair.use_colour;
    for (int c = 0; c < 3; c++)
        s->plain[c] = use ? (double)g->default_colour[c] : 1;
    if (!use || !g->colour)
        return;
    const size_t bytes = 3 * (size_t)g->points * sizeof *s->colour;
    s->colour = memcpy(bytes_alloc(bytes), g->colour, bytes);
}

// The fit's lights as lights.c turns and colours them; none is dropped.
static void take_lights(struct reference *s, const struct sky_fit *fit)
{
    double m[9];
    const double gain = exp2((double)s->params.tint.exposure);
    lights_rotation(&s->params, m);
    free(s->light);
    s->light = bytes_zalloc(SKY_LIGHTS_MAX, sizeof *s->light);
    s->lights = fit->count;
    for (int j = 0; j < fit->count; j++) {
        const struct sky_light *from = &fit->light[j];
        struct sky_light *to = &s->light[j];
        to->lambda = from->lambda;
        for (int k = 0; k < 3; k++) {
            for (int c = 0; c < 3; c++)
                to->direction[k] += m[3 * k + c] * from->direction[c];
            to->radiance[k] =
                from->radiance[k] * gain * (double)s->params.tint.colour[k];
        }
    }
}

static uint64_t hashed(uint64_t h, const void *data, size_t size)
{
    const unsigned char *p = data;
    for (; size >= 8; size -= 8, p += 8) {
        uint64_t x;
        memcpy(&x, p, sizeof x);
        h = (h ^ x) * 0x9e3779b97f4a7c15u;
        h ^= h >> 29;
    }
    for (; size > 0; size--)
        h = (h ^ *p++) * 0x100000001b3u;
    return h;
}

// Tells grooms apart; an address may be another groom's by now.
static uint64_t key_of(const struct groom *g)
{
    const size_t n = g->points * sizeof(float);
    uint64_t h = hashed(1, g->first, ((size_t)g->strands + 1) * 4);
    h = hashed(h, g->position, 3 * n);
    if (g->diameter)
        h = hashed(h, g->diameter, n);
    if (g->opacity)
        h = hashed(h + 1, g->opacity, n);
    if (g->colour)
        h = hashed(h + 2, g->colour, 3 * n);
    h = hashed(h, &g->default_diameter, sizeof g->default_diameter);
    h = hashed(h, &g->default_opacity, sizeof g->default_opacity);
    h = hashed(h, g->default_colour, sizeof g->default_colour);
    h = hashed(h, g->head.centre, sizeof g->head.centre);
    h = hashed(h, g->head.radius, sizeof g->head.radius);
    return hashed(h, &g->up, sizeof g->up) + g->head.present;
}

static void drop_hair(struct reference *s)
{
    shoot_destroy(s->shoot);
    free(s->tangent);
    free(s->axis);
    free(s->colour);
    s->shoot = NULL;
    s->tangent = s->colour = NULL;
    s->axis = NULL;
}

static bool take_hair(struct reference *s, const struct reference_scene *scene,
                      struct error *err)
{
    const struct groom *g = scene->groom;
    const struct params *p = scene->params;
    const uint64_t key = key_of(g);
    const bool moved = params_changed(&s->params, p) & 1u << GROUP_hair;
    if (s->shoot && key == s->hair_key && !moved) {
        s->params = *p;
        return true;
    }
    struct shoot *shoot = shoot_create_watched(g, p, scene->watch, err);
    if (!shoot)
        return false;
    drop_hair(s);
    s->params = *p;
    s->shoot = shoot;
    s->hair_key = key;
    take_tangents(s, g);
    take_box(s, g);
    take_colour(s, g);
    s->hair_bytes = shoot_bytes(s->shoot) +
                    (s->colour ? 6 : 3) * (size_t)g->points * sizeof(float);
    return true;
}

bool reference_update(struct reference *s, const struct reference_scene *scene,
                      struct error *err)
{
    const uint32_t sky_groups = 1u << GROUP_light | 1u << GROUP_tint |
                                1u << GROUP_sun1 | 1u << GROUP_sun2 |
                                1u << GROUP_sun3;
    const uint32_t changed = params_changed(&s->params, scene->params);
    if (!take_hair(s, scene, err))
        return false;
    struct fibre_spec spec;
    fibre_spec_of(scene->params, scene->model, &spec);
    if (!s->fibre || changed & 1u << GROUP_fibre ||
        fibre_spec(s->fibre)->model != scene->model) {
        fibre_destroy(s->fibre);
        s->fibre = fibre_create(&spec);
    }
    if (changed & sky_groups || !s->sky_made ||
        memcmp(s->sky_key, scene->map->sha256, sizeof s->sky_key) != 0) {
        reference_sky_make(&s->sky, scene->map, scene->params);
        memcpy(s->sky_key, scene->map->sha256, sizeof s->sky_key);
        s->sky_made = true;
    }
    s->lights = 0;
    if (scene->fit)
        take_lights(s, scene->fit);
    if (spec.a != 1 && !s->axis) {
        s->axis = bytes_zalloc(scene->groom->points, sizeof *s->axis);
        strands_axes(scene->groom, place_up(scene->groom, scene->params),
                     s->axis);
    }
    s->elliptic = spec.a != 1;
    return true;
}

struct reference *reference_create(const struct reference_scene *scene,
                                   struct error *err)
{
    struct reference *s = bytes_zalloc(1, sizeof *s);
    params_defaults(&s->params);
    if (!reference_update(s, scene, err)) {
        reference_destroy(s);
        return NULL;
    }
    return s;
}

void reference_destroy(struct reference *s)
{
    if (!s)
        return;
    drop_hair(s);
    fibre_destroy(s->fibre);
    free(s->light);
    free(s);
}

size_t reference_bytes(const struct reference *s)
{
    return s->hair_bytes;
}

const struct fibre *reference_fibre(const struct reference *s)
{
    return s->fibre;
}

// --- frames -----------------------------------------------------------------

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static bool across(const double u[3], const double side[3], double v[3])
{
    const double along = dot(side, u);
    for (int k = 0; k < 3; k++)
        v[k] = side[k] - along * u[k];
    const double n = dot(v, v);
    if (!(n > 1e-10))
        return false;
    for (int k = 0; k < 3; k++)
        v[k] /= sqrt(n);
    return true;
}

static void axis_at(const uint32_t *axis, double along, double out[3])
{
    out[0] = out[1] = out[2] = 0;
    for (int e = 0; e < 2; e++) { // snorm16 octahedral, as strands.c packs it
        double x = (int16_t)(axis[e] & 0xffff) / 32767.0;
        double y = (int16_t)(axis[e] >> 16) / 32767.0;
        const double z = 1 - fabs(x) - fabs(y);
        if (z < 0) {
            const double fx = (1 - fabs(y)) * (x < 0 ? -1 : 1);
            y = (1 - fabs(x)) * (y < 0 ? -1 : 1);
            x = fx;
        }
        const double w = e ? along : 1 - along;
        out[0] += w * x;
        out[1] += w * y;
        out[2] += w * z;
    }
}

struct fibre_direction reference_vertex_in(const struct reference_vertex *v,
                                           const double d[3])
{
    const double x = dot(d, v->v), y = dot(d, v->w);
    return (struct fibre_direction){
        asin(fmin(fmax(dot(d, v->u), -1), 1)),
        x != 0 || y != 0 ? atan2(y, x) : 0,
    };
}

void reference_vertex_out(const struct reference_vertex *v,
                          const struct fibre_direction *i, double d[3])
{
    const double c = cos(i->theta), x = c * cos(i->phi), y = c * sin(i->phi);
    const double z = sin(i->theta);
    for (int k = 0; k < 3; k++)
        d[k] = z * v->u[k] + x * v->v[k] + y * v->w[k];
    const double n = sqrt(dot(d, d));
    for (int k = 0; k < 3; k++)
        d[k] /= n;
}

// side: v lies towards it.
static void across_or_any(const double u[3], const double side[3], double v[3])
{
    const double other[3] = {fabs(u[2]) >= 0.9, 0, fabs(u[2]) < 0.9};
    if (!across(u, side, v))
        across(u, other, v);
}

void reference_vertex_across(const uint32_t *axis, const struct places_item *p,
                             double v[3])
{
    double side[3] = {p->to_eye[0], p->to_eye[1], p->to_eye[2]};
    if (axis)
        axis_at(axis + p->segment, p->along, side);
    across_or_any(p->tangent, side, v);
}

static void frame(struct reference_vertex *p, const double side[3],
                  const double to_eye[3])
{
    across_or_any(p->u, side, p->v);
    for (int k = 0; k < 3; k++) {
        const int i = (k + 1) % 3, j = (k + 2) % 3;
        p->w[k] = p->u[i] * p->v[j] - p->u[j] * p->v[i];
    }
    p->eye = reference_vertex_in(p, to_eye);
}

void reference_vertex_of(const struct reference *s, uint32_t segment,
                         double along, const double to_eye[3],
                         struct reference_vertex *out)
{
    struct shoot_point at;
    const float *t = s->tangent + 3 * (size_t)segment;
    shoot_point(s->shoot, segment, along, &at);
    double n = 0, side[3] = {to_eye[0], to_eye[1], to_eye[2]};
    for (int k = 0; k < 3; k++) {
        out->position[k] = at.position[k];
        out->u[k] = (1 - along) * (double)t[k] + along * (double)t[k + 3];
        n += out->u[k] * out->u[k];
    }
    for (int k = 0; k < 3; k++)
        out->u[k] = n > 1e-12 ? out->u[k] / sqrt(n) : (double)t[k];
    out->segment = segment;
    out->along = along;
    if (s->elliptic)
        axis_at(s->axis + segment, along, side);
    frame(out, side, to_eye);
}

void reference_vertex_at(const struct reference *s,
                         const struct places_item *place,
                         struct reference_vertex *out)
{
    (void)s;
    memcpy(out->position, place->position, sizeof out->position);
    memcpy(out->u, place->tangent, sizeof out->u);
    out->segment = place->segment;
    out->along = place->along;
    frame(out, place->across, place->to_eye);
}

void reference_vertex_colour(const struct reference *s,
                             const struct reference_vertex *v, double rgb[3])
{
    const float *c = s->colour ? s->colour + 3 * (size_t)v->segment : NULL;
    for (int k = 0; k < 3; k++)
        rgb[k] = c ? (1 - v->along) * (double)c[k] + v->along * (double)c[k + 3]
                   : s->plain[k];
}

// Only the segment that was met last is left out, so two strands in one place
// would hand a ray that does not move to each other for ever.
void reference_ray_past(struct shoot_ray *ray, uint32_t segment, double t)
{
    double size = t;
    for (int k = 0; k < 3; k++)
        size = fmax(size, fabs(ray->origin[k]));
    t += 0x1p-36 * size; // of the thousands of roundings of 2^-53 at most
    for (int k = 0; k < 3; k++)
        ray->origin[k] += t * ray->direction[k];
    ray->segment = segment;
}
