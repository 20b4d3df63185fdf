// reference_walk.c - one path: at every scattering the sky and the suns are
// asked for light, then the path goes on in a direction drawn from the fibre.
// A direction may be found both ways, so both are weighted by their densities
// (Veach and Guibas 1995, the balance heuristic).
#include <math.h>
#include <string.h>

#include "renderer/reference_private.h"

// Scatterings before Russian roulette begins, and at which a path ends in any
// case (of a fibre that sends out as much as it gets nothing is left to draw).
enum { ROULETTE = 3, LONGEST = 1 << 20 };

struct now { // where a path is
    struct reference_vertex v;
    struct fibre_view view;
    double through[3];
    int scatterings; // before this one
};

static struct shoot_ray ray_from(const struct reference_vertex *v,
                                 const double d[3])
{
    return (struct shoot_ray){{v->position[0], v->position[1], v->position[2]},
                              {d[0], d[1], d[2]},
                              INFINITY,
                              v->segment};
}

static double next(struct reference_walk *w)
{
    return reference_random_next(&w->random);
}

static bool shadowed(const struct reference_walk *w)
{
    return !(w->flags & REFERENCE_UNSHADOWED);
}

static void put(struct reference_walk *w, const struct now *p,
                const double s[3], const double light[3], double weight)
{
    const int last = REFERENCE_BOUNCES - 1;
    double *to = w->bounce[p->scatterings < last ? p->scatterings : last];
    for (int c = 0; c < 3; c++)
        to[c] += p->through[c] * s[c] * light[c] * weight;
}

// S cos theta_i of all modes.
static void scatter(const struct reference_walk *w, const struct now *p,
                    const struct fibre_direction *i, double s[3])
{
    double mode[FIBRE_MODES][3];
    fibre_scatter(w->scene->fibre, &p->v.eye, i, mode);
    for (int c = 0; c < 3; c++)
        s[c] = mode[0][c] + mode[1][c] + mode[2][c];
}

// What light from d adds, if anything.
static void ask(struct reference_walk *w, const struct now *p,
                const double d[3], const double light[3], double weight)
{
    const struct fibre_direction i = reference_vertex_in(&p->v, d);
    double s[3];
    scatter(w, p, &i, s);
    if (!(s[0] * light[0] + s[1] * light[1] + s[2] * light[2] > 0))
        return;
    if (shadowed(w)) {
        const struct shoot_ray ray = ray_from(&p->v, d);
        weight *= shoot_transmittance(w->scene->shoot, &ray);
    }
    put(w, p, s, light, weight);
}

static double sky_density(const struct reference_sky *s, int texel)
{
    return s->chance[texel] / s->omega[texel / REFERENCE_WIDTH];
}

static void ask_sky(struct reference_walk *w, const struct now *p)
{
    const struct reference_sky *sky = &w->scene->sky;
    if (sky->black)
        return;
    double d[3];
    const int texel = reference_sky_draw(sky, next(w));
    const double u = next(w), v = next(w);
    reference_sky_direction(sky, texel, u, v, d);
    const struct fibre_direction i = reference_vertex_in(&p->v, d);
    const double other = fibre_pdf(w->scene->fibre, &p->view, &i);
    const double weight = 1 / (sky_density(sky, texel) + other);
    ask(w, p, d, sky->radiance[texel], weight);
}

static void ask_suns(struct reference_walk *w, const struct now *p)
{
    const struct reference_sky *sky = &w->scene->sky;
    for (int k = 0; k < sky->suns; k++)
        ask(w, p, sky->sun[k].direction, sky->sun[k].irradiance, 1);
}

enum met { MET_SKY, MET_HEAD, MET_HAIR };

// The first thing that stops the ray; hair of opacity o does so with chance o.
static enum met meet(struct reference_walk *w, struct shoot_ray ray,
                     uint32_t *segment, double *along)
{
    struct shoot_point at;
    if (!shadowed(w))
        return MET_SKY;
    for (;;) {
        const double t = shoot_first(w->scene->shoot, &ray, segment, along);
        if (*segment == UINT32_MAX)
            return t < INFINITY ? MET_HEAD : MET_SKY;
        shoot_point(w->scene->shoot, *segment, *along, &at);
        if (at.opacity >= 1 || next(w) < at.opacity)
            return MET_HAIR;
        reference_ray_past(&ray, *segment, t);
    }
}

static void find_sky(struct reference_walk *w, const struct now *p,
                     const double d[3], const double s[3], double density)
{
    const struct reference_sky *sky = &w->scene->sky;
    const int texel = reference_sky_texel(sky, d);
    const double other = sky->black ? 0 : sky_density(sky, texel);
    put(w, p, s, sky->radiance[texel], 1 / (density + other));
}

// Light from where the path goes next.  False: it ends here.
static bool go_on(struct reference_walk *w, struct now *p)
{
    const double u[3] = {next(w), next(w), next(w)};
    struct fibre_direction i;
    double d[3], s[3], along;
    uint32_t segment;
    if (!fibre_sample(w->scene->fibre, &p->view, u, &i))
        return false;
    const double density = fibre_pdf(w->scene->fibre, &p->view, &i);
    scatter(w, p, &i, s);
    if (!(density > 0) || !(s[0] + s[1] + s[2] > 0))
        return false;
    reference_vertex_out(&p->v, &i, d);
    const enum met met = meet(w, ray_from(&p->v, d), &segment, &along);
    if (met == MET_SKY)
        find_sky(w, p, d, s, density);
    if (met != MET_HAIR || p->scatterings + 1 == w->events)
        return false;
    double most = 0;
    for (int c = 0; c < 3; c++) {
        p->through[c] *= s[c] / density;
        most = fmax(most, p->through[c]);
    }
    if (p->scatterings >= ROULETTE && most < 1) {
        if (next(w) >= most)
            return false;
        for (int c = 0; c < 3; c++)
            p->through[c] /= most;
    }
    const double back[3] = {-d[0], -d[1], -d[2]};
    reference_vertex_of(w->scene, segment, along, back, &p->v);
    return true;
}

void reference_walk_run(struct reference_walk *w,
                        const struct reference_vertex *from)
{
    struct now p = {.v = *from, .through = {1, 1, 1}};
    double colour[3];
    memset(w->bounce, 0, sizeof w->bounce);
    for (;; p.scatterings++) {
        w->length = p.scatterings + 1;
        fibre_look(w->scene->fibre, &p.v.eye, p.through, &p.view);
        ask_sky(w, &p);
        ask_suns(w, &p);
        if (p.scatterings == LONGEST || !go_on(w, &p))
            break;
    }
    reference_vertex_colour(w->scene, from, colour);
    for (int n = 0; n < REFERENCE_BOUNCES; n++)
        for (int c = 0; c < 3; c++)
            w->bounce[n][c] *= colour[c];
}
