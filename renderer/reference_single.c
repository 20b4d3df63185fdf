// reference_single.c - light scattered once at given places: the sky texel by
// texel, or light by light.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "protocol/bytes.h"
#include "renderer/exact.h"
#include "renderer/reference_private.h"
#include "renderer/shoot_threads.h"

static const double pi = 3.14159265358979323846;
// Shadows are looked for until what is left adds at most this share.
#define NEGLIGIBLE 1e-4

enum { LOBE_RAYS = 256 };

struct job {
    const struct reference *s;
    const struct places_item *place;
    unsigned flags;
    uint64_t seed;
    int cut; // directions a texel: cut x cut, at least
    struct reference_single *out;
};

static double clear_way(const struct job *j, const struct reference_vertex *v,
                        const double d[3])
{
    if (j->flags & REFERENCE_UNSHADOWED)
        return 1;
    const struct shoot_ray ray = {
        {v->position[0], v->position[1], v->position[2]},
        {d[0], d[1], d[2]},
        INFINITY,
        v->segment};
    return shoot_transmittance(j->s->shoot, &ray);
}

struct sum { // of one place
    struct reference_vertex v;
    double mode[FIBRE_MODES][3];
    double light, seen; // offered, and of it unblocked
};

static void add(struct sum *sum, double s[FIBRE_MODES][3],
                const double light[3], double through)
{
    for (int t = 0; t < FIBRE_MODES; t++)
        for (int c = 0; c < 3; c++)
            sum->mode[t][c] += through * s[t][c] * light[c];
}

static double offered(const double e[3])
{
    return (e[0] + e[1] + e[2]) / 3;
}

// --- texels -----------------------------------------------------------------

struct ray { // one direction into one texel
    double d[3];
    double s[FIBRE_MODES][3], light[3];
    double adds; // S times light, summed
};

static double all_of(double s[FIBRE_MODES][3], const double light[3])
{
    double sum = 0;
    for (int t = 0; t < FIBRE_MODES; t++)
        for (int c = 0; c < 3; c++)
            sum += s[t][c] * light[c];
    return sum;
}

static void texel_light(const struct reference_sky *sky, int texel, int rays,
                        double light[3])
{
    const double q = sky->omega[texel / REFERENCE_WIDTH] / rays;
    for (int c = 0; c < 3; c++)
        light[c] = sky->radiance[texel][c] * q;
}

// Bright texels are cut finer: what one of them sends should not hang on one
// ray.
static int cut_of(const struct job *j, int texel)
{
    const double share = j->s->sky.chance[texel];
    const int cut = share > 1.0 / 300 ? 4 : share > 1.0 / 1000 ? 2 : 1;
    return cut > j->cut ? cut : j->cut;
}

// A jittered direction in each of the texel's pieces; returns how many.
static int look(const struct job *j, const struct sum *sum, int texel,
                struct reference_random *random, struct ray *ray)
{
    const int cut = cut_of(j, texel);
    texel_light(&j->s->sky, texel, cut * cut, ray->light);
    for (int k = 0; k < cut * cut; k++) {
        const double row = k / cut, u = reference_random_next(random);
        const double v = reference_random_next(random);
        struct ray *r = &ray[k];
        memcpy(r->light, ray->light, sizeof r->light);
        reference_sky_direction(&j->s->sky, texel, (k % cut + u) / cut,
                                (row + v) / cut, r->d);
        const struct fibre_direction i = reference_vertex_in(&sum->v, r->d);
        fibre_scatter(j->s->fibre, &sum->v.eye, &i, r->s);
        r->adds = all_of(r->s, r->light);
    }
    return cut * cut;
}

static void by_texels(const struct job *j, struct sum *sum, uint64_t number)
{
    size_t rays = 0;
    for (int i = 0; i < REFERENCE_TEXELS; i++)
        rays += (size_t)cut_of(j, i) * (size_t)cut_of(j, i);
    struct ray *ray = bytes_alloc(rays * sizeof *ray), *at = ray;
    struct reference_random random;
    double all = 0;
    reference_random_begin(&random, j->seed, number, 1);
    for (int i = 0; i < REFERENCE_TEXELS; i++) {
        const int n = look(j, sum, i, &random, at);
        for (int k = 0; k < n; k++)
            all += (at++)->adds;
    }
    const double least = NEGLIGIBLE * all / (double)rays;
    for (size_t i = 0; i < rays; i++) {
        struct ray *r = &ray[i];
        if (!(r->adds > least))
            continue;
        const double through = clear_way(j, &sum->v, r->d);
        sum->light += offered(r->light);
        sum->seen += through * offered(r->light);
        add(sum, r->s, r->light, through);
    }
    free(ray);
}

static void by_suns(const struct job *j, struct sum *sum)
{
    for (int k = 0; k < j->s->sky.suns; k++) {
        const struct lights_sun *sun = &j->s->sky.sun[k];
        const struct fibre_direction i =
            reference_vertex_in(&sum->v, sun->direction);
        double s[FIBRE_MODES][3];
        fibre_scatter(j->s->fibre, &sum->v.eye, &i, s);
        const double through = clear_way(j, &sum->v, sun->direction);
        sum->light += offered(sun->irradiance);
        sum->seen += through * offered(sun->irradiance);
        add(sum, s, sun->irradiance, through);
    }
}

// --- SRBF lights ------------------------------------------------------------

static void exact_channels(const struct job *j, const struct sum *sum,
                           const struct sky_light *light,
                           double s[FIBRE_MODES][3])
{
    const struct fibre_spec *f = fibre_spec(j->s->fibre);
    const struct fibre_direction i =
        reference_vertex_in(&sum->v, light->direction);
    struct exact_case c = {
        .eta = f->eta,
        .alpha = {f->alpha[0], f->alpha[1], f->alpha[2]},
        .beta = {f->beta[0], f->beta[1], f->beta[2]},
        .w_c = f->w_c,
        .a = f->a,
        .lambda_j = light->lambda,
        .theta_j = i.theta,
        .phi_j = i.phi,
        .theta_o = sum->v.eye.theta,
        .phi_o = sum->v.eye.phi,
        .delta_eta = f->delta_eta,
    };
    for (int k = 0; k < 3; k++) {
        double mode[EXACT_MODES];
        c.sigma_a = f->sigma_a[k];
        exact_modes(&c, mode);
        for (int t = 0; t < FIBRE_MODES; t++)
            s[t][k] = mode[t];
    }
}

static void by_lights(const struct job *j, struct sum *sum, uint64_t number)
{
    const struct reference_vertex *v = &sum->v;
    for (int k = 0; k < j->s->lights; k++) {
        const struct sky_light *light = &j->s->light[k];
        const double omega = sky_lobe_omega(light->lambda);
        double s[FIBRE_MODES][3], e[3];
        struct shoot_lobe lobe = {.lambda = light->lambda, .transmittance = 1};
        struct shoot_ray from = {.reach = INFINITY, .segment = v->segment};
        memcpy(lobe.direction, light->direction, sizeof lobe.direction);
        memcpy(from.origin, v->position, sizeof from.origin);
        exact_channels(j, sum, light, s);
        if (!(j->flags & REFERENCE_UNSHADOWED))
            shoot_lobe(j->s->shoot, &from, NULL, LOBE_RAYS,
                       j->seed + (uint64_t)j->s->lights * number + (uint64_t)k,
                       &lobe);
        for (int c = 0; c < 3; c++)
            e[c] = light->radiance[c] * omega;
        sum->light += offered(e);
        sum->seen += lobe.transmittance * offered(e);
        add(sum, s, light->radiance, lobe.transmittance);
    }
}

// --- places -----------------------------------------------------------------

static void work(void *context, size_t i)
{
    const struct job *j = context;
    struct reference_single *out = &j->out[i];
    struct sum sum = {0};
    double colour[3];
    reference_vertex_at(j->s, &j->place[i], &sum.v);
    if (j->flags & REFERENCE_SRBF)
        by_lights(j, &sum, i);
    else
        by_texels(j, &sum, i);
    by_suns(j, &sum);
    reference_vertex_colour(j->s, &sum.v, colour);
    memset(out, 0, sizeof *out);
    for (int t = 0; t < FIBRE_MODES; t++)
        for (int c = 0; c < 3; c++) {
            out->mode[t][c] = sum.mode[t][c] * colour[c];
            out->sum[c] += out->mode[t][c];
        }
    out->seen = sum.light > 0 ? sum.seen / sum.light : 1;
}

void reference_single(const struct reference *s,
                      const struct places_item *place, size_t count,
                      unsigned flags, uint64_t seed,
                      struct reference_single *out)
{
    struct job j = {s, place, flags, seed, 1, out};
    // a piece of a texel is to be smaller than the narrowest lobe's deviation
    const double *beta = fibre_spec(s->fibre)->beta;
    const double least = 2 * fmin(beta[0], fmin(beta[1], beta[2]));
    while (j.cut < 4 && 2 * pi / REFERENCE_WIDTH / j.cut > least)
        j.cut++;
    shoot_threads(count, work, &j);
}
