// frames.c - see the header.  Hair and skies are in frames_scene.c.
#include "tests/extremes/frames.h"

#include <math.h>
#include <stdlib.h>
#include <time.h>

#include "renderer/lights.h"
#include "renderer/renderer.h"
#include "tests/check.h"
#include "tests/extremes/frames_scene.h"
#include "tests/numeric/cases.h"
#include "tests/render/scene.h"

#define PI 3.14159265358979323846

static double seconds(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

// --- parameters -------------------------------------------------------------
static bool is(const struct params_row *row, const char *group,
               const char *name)
{
    return strcmp(row->group_name, group) == 0 &&
           (!name || strcmp(row->name, name) == 0);
}

// What only costs time or memory stays small; what a picture shows of itself
// (tangents, coverage) has no light in it.
static double most_of(const struct params_row *row)
{
    if (is(row, "shadow", "resolution"))
        return 48;
    if (is(row, "render", "tables") || is(row, "shadow", "memory_mb"))
        return row->min;
    if (is(row, "render", "components"))
        return 6;
    if (is(row, "render", "m"))
        return 64;
    if (is(row, "sky", "lights"))
        return 12; // of random frames; the skies' own say 1 and 200
    if (is(row, "shadow", "rays"))
        return 4;
    if (row->type == PARAMS_CHOICE) {
        int words = 1;
        for (const char *c = row->choices; *c; c++)
            words += *c == '|';
        return words - 1;
    }
    return row->type == PARAMS_BOOL ? 1 : row->max;
}

static bool kept(const struct params_row *row)
{
    return is(row, "camera", NULL) || is(row, "image", NULL) ||
           is(row, "hair", NULL) || is(row, "output", NULL) ||
           is(row, "quality", NULL);
}

static void extreme(struct params *p, const struct params_row *row, uint64_t *s)
{
    double lo = row->type == PARAMS_CHOICE || row->type == PARAMS_BOOL
                    ? 0
                    : row->min,
           hi = most_of(row);
    for (int i = 0; i < row->count; i++) {
        double turn = cases_uniform(s, 0, 4), v;
        if (turn < 1)
            v = lo;
        else if (turn < 2)
            v = hi;
        else if (lo > 0)
            v = exp(cases_uniform(s, log(lo), log(hi)));
        else
            v = cases_uniform(s, lo, hi);
        if (is(row, "render", "m")) // every m is a program of its own
            v = v < 20 ? lo : hi;
        if (row->type == PARAMS_INT || row->type == PARAMS_CHOICE ||
            row->type == PARAMS_BOOL)
            v = floor(v + 0.5);
        params_put(p, row, i, v);
    }
}

static void fill_params(struct params *p, uint64_t *s)
{
    scene_shadowed(p, 2, 0, 32);
    p->image.width = 48;
    p->image.height = 32;
    for (int r = 0; r < params_row_count; r++)
        if (!kept(&params_rows[r]) && cases_uniform(s, 0, 1) < 0.3)
            extreme(p, &params_rows[r], s);
    // Suns as bright as that leave nothing to be seen of the sky.
    if (cases_uniform(s, 0, 1) < 0.7)
        p->sun1.strength = p->sun2.strength = p->sun3.strength = 0;
}

// --- laws -------------------------------------------------------------------
static double largest(const float v[3])
{
    return fmax((double)v[0], fmax((double)v[1], (double)v[2]));
}

static double sun_of(double strength, const float colour[3])
{
    return strength * largest(colour) / sky_lobe_omega(LIGHTS_SUN_LAMBDA);
}

// Sum of L_j over lights and suns, brightest channel.
static double light_of(const struct renderer *r, const struct params *p)
{
    struct renderer_stats s;
    renderer_stats(r, &s);
    double sum = 0;
    for (int j = 0; j < s.fit.count; j++) {
        const double *l = s.fit.light[j].radiance;
        sum += fmax(l[0], fmax(l[1], l[2]));
    }
    sum *= exp2((double)p->tint.exposure) * largest(p->tint.colour);
    return sum + sun_of((double)p->sun1.strength, p->sun1.colour) +
           sun_of((double)p->sun2.strength, p->sun2.colour) +
           sun_of((double)p->sun3.strength, p->sun3.colour);
}

// A light's single scattering is at most 4 * 1.175 (1 + 1 + 4/27) L_j; what was
// scattered before, Omega_j (M^G + M^L), at most 4.5 L_j / cos theta_o, and the
// light's own glow 2 L_j / cos theta_o, cos theta_o kept above 1e-4.
#define BOUND (10.1 + 6.5e4)

static void judge(const struct buf *linear, double light,
                  struct frames_row *one)
{
    const float *v = (const float *)(const void *)linear->data;
    double top = 0;
    bool sane = true;
    for (size_t i = 0; i < linear->size / sizeof *v; i++) {
        sane = sane && isfinite(v[i]) && v[i] >= 0;
        if (i % 4 == 3)
            sane = sane && v[i] <= 1.00001f;
        else
            top = fmax(top, (double)v[i]);
    }
    double part = top / fmax(light, 1e-30);
    one->frames++;
    one->lit += top > 0;
    one->top = fmax(one->top, part);
    one->bad += !sane || part > BOUND;
}

static void add(struct frames_row *to, const struct frames_row *one)
{
    to->frames += one->frames;
    to->bad += one->bad;
    to->lit += one->lit;
    to->top = fmax(to->top, one->top);
    to->slowest = fmax(to->slowest, one->slowest);
}

static bool as_fresh(int hair, int sky, const struct params *p,
                     const struct buf *linear)
{
    struct renderer *r = scene_renderer(frames_hair(hair), frames_sky(sky), p);
    struct buf again = scene_linear(r);
    bool same = scene_same(linear, &again);
    buf_finish(&again);
    renderer_destroy(r);
    return same;
}

static void say(const struct params *p, int frame, int hair, int sky)
{
    struct params def;
    params_defaults(&def);
    printf("  frame %d, %s, %s:", frame, frames_hair_names[hair],
           frames_sky_names[sky]);
    for (int i = 0; i < params_row_count; i++)
        for (int k = 0; k < params_rows[i].count; k++) {
            double a = params_get(p, &params_rows[i], k);
            double b = params_get(&def, &params_rows[i], k);
            if (a != b && !(isnan(a) && isnan(b)))
                printf(" %s.%s[%d]=%.9g", params_rows[i].group_name,
                       params_rows[i].name, k, a);
        }
    printf("\n");
}

struct frames_all frames_run(int count, int every)
{
    struct frames_all all = {0};
    struct renderer *r = NULL;
    struct error err = {0};
    uint64_t state = 2011;
    int was_hair = -1, was_sky = -1;
    for (int i = 0; i < count; i++) {
        // Each pair of hair and sky comes once in 126 frames.
        int hair = i % FRAMES_HAIRS,
            sky = (i + i / FRAMES_HAIRS) % FRAMES_SKIES;
        struct params p;
        struct frames_row one = {0};
        fill_params(&p, &state);
        frames_adapt(&p, hair, sky);
        double began = seconds();
        if (!r) {
            r = scene_renderer(frames_hair(hair), frames_sky(sky), &p);
        } else {
            renderer_set_params(r, &p);
            if (hair != was_hair)
                CHECK(renderer_set_groom(r, frames_hair(hair), &err));
            if (sky != was_sky)
                CHECK(renderer_set_sky(r, frames_sky(sky), &err));
        }
        was_hair = hair;
        was_sky = sky;
        struct buf linear = scene_linear(r);
        one.slowest = seconds() - began;
        judge(&linear, light_of(r, &p), &one);
        if (one.bad)
            say(&p, i, hair, sky);
        if (i % every == every - 1) {
            all.fresh++;
            if (!as_fresh(hair, sky, &p, &linear) && ++all.differ)
                say(&p, i, hair, sky);
        }
        buf_finish(&linear);
        add(&all.hair[hair], &one);
        add(&all.sky[sky], &one);
        all.frames++;
    }
    for (int k = 0; k < FRAMES_HAIRS; k++)
        all.hair[k].what = frames_hair_names[k];
    for (int k = 0; k < FRAMES_SKIES; k++)
        all.sky[k].what = frames_sky_names[k];
    renderer_destroy(r);
    return all;
}
