// crossings_truth.h - places on strands, lights around them, and what rays
// against the strands say of both; for test_crossings.c and bench_crossings.c.
#ifndef TESTS_NUMERIC_CROSSINGS_TRUTH_H
#define TESTS_NUMERIC_CROSSINGS_TRUTH_H

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "protocol/bytes.h"
#include "renderer/crossings_probe.h"
#include "renderer/shoot.h"

enum { TRUTH_AIMS = 12, TRUTH_WIDTHS = 4, TRUTH_LIGHTS = 48 };
static const float truth_width[TRUTH_WIDTHS] = {0.05f, 0.2f, 0.5f, 1};
static const double truth_attenuation[4] = {0.3, 0.6, 0.85, 0.95};

struct truth {
    int places, visible; // the first `visible` are seen from outside
    struct crossings_place *place;
    struct crossings_light light[TRUTH_LIGHTS]; // aim * TRUTH_WIDTHS + width
    struct shoot_lobe *lobe;                    // [places * TRUTH_LIGHTS]
};

static inline double truth_uniform(uint64_t *state)
{
    *state += 0x9e3779b97f4a7c15u; // splitmix64
    uint64_t x = *state;
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
    x ^= x >> 31;
    return (double)(x >> 11) * 0x1p-53;
}

static inline void truth_place(struct truth *t, int i, const struct shoot *s,
                               uint32_t segment, double along)
{
    struct shoot_point p;
    shoot_point(s, segment, along, &p);
    struct crossings_place *out = &t->place[i];
    for (int k = 0; k < 3; k++) {
        out->p[k] = (float)p.position[k];
        out->u[k] = (float)p.tangent[k];
    }
    out->segment = segment;
    out->key = (uint32_t)i * 2654435761u;
}

static inline uint32_t truth_segment(const struct groom *g, uint64_t *state)
{
    uint32_t k = (uint32_t)(truth_uniform(state) * g->strands);
    uint32_t n = g->first[k + 1] - g->first[k] - 1;
    return g->first[k] + (uint32_t)(truth_uniform(state) * n);
}

// First met on the way to a place on a strand, from far away in a random
// direction; the head does not count.
static inline bool truth_seen(struct truth *t, int i, const struct groom *g,
                              const struct shoot *s, uint64_t *state)
{
    struct shoot_point aim;
    shoot_point(s, truth_segment(g, state), truth_uniform(state), &aim);
    double z = 2 * truth_uniform(state) - 1;
    double phi = 2 * M_PI * truth_uniform(state), far = 0;
    for (int k = 0; k < 3; k++)
        far += fabs((double)g->box_max[k] - (double)g->box_min[k]);
    struct shoot_ray r = {.reach = INFINITY, .segment = UINT32_MAX};
    r.direction[0] = sqrt(1 - z * z) * cos(phi);
    r.direction[1] = sqrt(1 - z * z) * sin(phi);
    r.direction[2] = z;
    for (int k = 0; k < 3; k++)
        r.origin[k] = aim.position[k] - 2 * far * r.direction[k];
    uint32_t segment;
    double along;
    shoot_first(s, &r, &segment, &along);
    if (segment == UINT32_MAX)
        return false;
    truth_place(t, i, s, segment, along);
    return true;
}

static inline void truth_lights(struct truth *t)
{
    for (int a = 0; a < TRUTH_AIMS; a++) {
        float z = 1 - 2 * ((float)a + 0.5f) / TRUTH_AIMS;
        float phi = 2.39996323f * (float)a + 0.3f, r = sqrtf(1 - z * z);
        for (int w = 0; w < TRUTH_WIDTHS; w++)
            t->light[a * TRUTH_WIDTHS + w] = (struct crossings_light){
                {r * cosf(phi), r * sinf(phi), z}, truth_width[w], 0};
    }
}

static inline void truth_make(struct truth *t, const struct groom *g,
                              const struct shoot *s, int each, int rays)
{
    uint64_t state = 5;
    t->visible = each;
    t->places = 2 * each;
    t->place = bytes_zalloc((size_t)t->places, sizeof *t->place);
    const size_t count = (size_t)t->places * TRUTH_LIGHTS;
    t->lobe = bytes_zalloc(count, sizeof *t->lobe);
    for (int i = 0; i < each;)
        i += truth_seen(t, i, g, s, &state);
    for (int i = each; i < t->places; i++)
        truth_place(t, i, s, truth_segment(g, &state), truth_uniform(&state));
    truth_lights(t);
    struct shoot_ray *from = bytes_zalloc(count, sizeof *from);
    for (size_t i = 0; i < count; i++) {
        const struct crossings_place *p = &t->place[i / TRUTH_LIGHTS];
        const struct crossings_light *l = &t->light[i % TRUTH_LIGHTS];
        for (int k = 0; k < 3; k++) {
            from[i].origin[k] = (double)p->p[k];
            t->lobe[i].direction[k] = (double)l->direction[k];
        }
        from[i].reach = INFINITY;
        from[i].segment = p->segment;
        t->lobe[i].lambda = (double)l->lambda;
    }
    shoot_lobes(s, from, truth_attenuation, rays, 17, t->lobe, count);
    free(from);
}

static inline void truth_free(struct truth *t)
{
    free(t->place);
    free(t->lobe);
    memset(t, 0, sizeof *t);
}

struct truth_errors { // means of |got - want| and of got - want
    double clear, bias, forward[4], forward_bias[4], sky, noise;
    double by_width[TRUTH_WIDTHS], visible, interior;
    // of |got - want| of T~: 95 of a hundred are below; narrow (.05), medium
    // (.2, .5) and wide (1) lobes
    double p95, class_mean[3], class_p95[3];
};

static inline int truth_ascending(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

// Of the widths from `first` to `last`.
static inline void truth_spread(const struct truth *t,
                                const struct crossings_result *r, int first,
                                int last, double *mean, double *p95)
{
    const size_t all = (size_t)t->places * TRUTH_LIGHTS;
    double *off = bytes_alloc(all * sizeof *off);
    size_t n = 0;
    *mean = 0;
    for (size_t i = 0; i < all; i++) {
        const int width = (int)(i % TRUTH_WIDTHS); // lights are aim-major
        if (width < first || width > last)
            continue;
        off[n] = fabs((double)r[i].clear - t->lobe[i].transmittance);
        *mean += off[n++];
    }
    qsort(off, n, sizeof *off, truth_ascending);
    *p95 = off[n * 95 / 100];
    *mean /= (double)n;
    free(off);
}

// sky: the mean over the twelve aims, each with another of the four widths.
static inline struct truth_errors
truth_compare(const struct truth *t, const struct crossings_result *r)
{
    struct truth_errors e = {0};
    const double all = (double)t->places * TRUTH_LIGHTS;
    for (int i = 0; i < t->places; i++) {
        double sky = 0;
        for (int j = 0; j < TRUTH_LIGHTS; j++) {
            const struct crossings_result *got = &r[i * TRUTH_LIGHTS + j];
            const struct shoot_lobe *want = &t->lobe[i * TRUTH_LIGHTS + j];
            const double d = (double)got->clear - want->transmittance;
            e.clear += fabs(d) / all;
            e.bias += d / all;
            e.noise += want->deviation * sqrt(2 / M_PI) / all;
            e.by_width[j % TRUTH_WIDTHS] += fabs(d) / (all / TRUTH_WIDTHS);
            *(i < t->visible ? &e.visible : &e.interior) += fabs(d) / (all / 2);
            for (int m = 0; m < 4; m++) {
                double f = (double)got->forward[m] - want->forward[m];
                e.forward[m] += fabs(f) / all;
                e.forward_bias[m] += f / all;
            }
            if (j % TRUTH_WIDTHS == j / TRUTH_WIDTHS % TRUTH_WIDTHS)
                sky += d / TRUTH_AIMS;
        }
        e.sky += fabs(sky) / t->places;
    }
    static const int from[3] = {0, 1, 3}, to[3] = {0, 2, 3};
    double mean;
    for (int k = 0; k < 3; k++)
        truth_spread(t, r, from[k], to[k], &e.class_mean[k], &e.class_p95[k]);
    truth_spread(t, r, 0, TRUTH_WIDTHS - 1, &mean, &e.p95);
    return e;
}

#endif
