// bench_reference.c - how far the picture is from the references, place by
// place: light scattered once with and without shadows, split into its causes,
// and all light against path tracing, for four colours of hair.
// Usage: bench_reference [hair=builtin:animation] [env=builtin:studio]
//        [places=300] [paths=256] [only=blond] [GROUP.NAME=VALUE ...]
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "protocol/edit.h"
#include "renderer/metric.h"
#include "renderer/reference.h"
#include "renderer/renderer.h"
#include "renderer/timer.h"

// Places at which the SRBF lights are integrated exactly: a second each.
enum { SPLIT = 60 };

struct bench {
    const char *hair, *env, *only;
    int places, paths;
    struct params p;
    struct renderer *r;
    struct places_item *place;
    size_t count;
};

static void must(bool ok, const struct error *err)
{
    if (!ok) {
        fprintf(stderr, "bench_reference: %s\n", err->text);
        exit(1);
    }
}

static void set(struct params *p, const char *text)
{
    struct error err = {0};
    must(edit_apply_text(p, text, &err), &err);
}

// Renders and reads the places; the same ones every time, for nothing that
// decides what is visible changes.
static void render(struct bench *b, const struct params *p)
{
    struct error err = {0};
    bool done = false;
    renderer_set_params(b->r, p);
    while (!done)
        must(renderer_step(b->r, &done, &err), &err);
    must(renderer_places(b->r, (size_t)b->places, 1, b->place, &b->count, &err),
         &err);
}

static double *radiance_of(const struct bench *b)
{
    double *x = bytes_alloc(3 * b->count * sizeof *x);
    for (size_t i = 0; i < 3 * b->count; i++)
        x[i] = (double)b->place[i / 3].radiance[i % 3];
    return x;
}

static double *sums_of(const struct bench *b, const struct reference *s,
                       unsigned flags)
{
    struct reference_single *out = bytes_alloc(b->count * sizeof *out);
    double *x = bytes_alloc(3 * b->count * sizeof *x);
    reference_single(s, b->place, b->count, flags, 1, out);
    for (size_t i = 0; i < 3 * b->count; i++)
        x[i] = out[i / 3].sum[i % 3];
    free(out);
    return x;
}

static void row(const struct bench *b, const char *name, const double *x,
                const double *r, const double *variance)
{
    const struct metric_pairs pairs = {b->count, x, r, variance};
    struct metric_errors e;
    double mx[3] = {0}, mr[3] = {0};
    metric_errors(&pairs, &e);
    for (size_t i = 0; i < 3 * b->count; i++) {
        mx[i % 3] += x[i] / (double)b->count;
        mr[i % 3] += r[i] / (double)b->count;
    }
    printf("%-44s rel RMSE %.3f [%.3f %.3f]  signed %+.3f [%+.3f %+.3f]  "
           "noise %.3f  mean %.3f %.3f %.3f (true %.3f %.3f %.3f)\n",
           name, e.rel_rmse.value, e.rel_rmse.low, e.rel_rmse.high,
           e.mean_signed.value, e.mean_signed.low, e.mean_signed.high, e.noise,
           mx[0], mx[1], mx[2], mr[0], mr[1], mr[2]);
    fflush(stdout);
}

static void once(struct bench *b, bool split)
{
    struct error err = {0};
    struct params p = b->p;
    set(&p, "render.components=single");
    set(&p, "shadow.method=off");
    render(b, &p);
    struct reference *s = renderer_reference(b->r, FIBRE_EXACT, &err);
    must(s != NULL, &err);
    double *bare = radiance_of(b);
    double *true_bare = sums_of(b, s, REFERENCE_UNSHADOWED);
    double *true_all = sums_of(b, s, 0);
    row(b, "  once, no shadows: picture", bare, true_bare, NULL);
    const size_t count = b->count;
    if (split) {
        b->count = count < SPLIT ? count : SPLIT;
        double *lights = sums_of(b, s, REFERENCE_UNSHADOWED | REFERENCE_SRBF);
        double *shadowed = sums_of(b, s, REFERENCE_SRBF);
        row(b, "  once, no shadows: exact, SRBF lights", lights, true_bare,
            NULL);
        row(b, "  once, no shadows: picture of SRBF lights", bare, lights,
            NULL);
        row(b, "  once, shadows: exact, SRBF, mean of each", shadowed, true_all,
            NULL);
        free(lights);
        free(shadowed);
        b->count = count;
    }
    for (int rays = 0; rays <= 16; rays += 16) {
        char text[32];
        snprintf(text, sizeof text, "shadow.rays=%d", rays);
        set(&p, "shadow.method=crossings");
        set(&p, text);
        render(b, &p);
        double *x = radiance_of(b);
        row(b,
            rays ? "  once, shadows by 16 rays: picture"
                 : "  once, shadows by the field: picture",
            x, true_all, NULL);
        free(x);
    }
    free(bare);
    free(true_bare);
    free(true_all);
    reference_destroy(s);
}

static void all(struct bench *b)
{
    static const char *const ways[][3] = {
        {"  all: picture", "render.multiple=best", "shadow.rays=0"},
        {"  all: picture, 16 rays", "render.multiple=best", "shadow.rays=16"},
        {"  all: picture, multiple=paper", "render.multiple=paper",
         "shadow.rays=0"},
        {"  all: picture, multiple=off", "render.multiple=off",
         "shadow.rays=0"},
    };
    struct error err = {0};
    struct params p = b->p;
    render(b, &p);
    struct reference *s = renderer_reference(b->r, FIBRE_EXACT, &err);
    must(s != NULL, &err);
    const double began = timer_now();
    const struct reference_paths how = {.samples = b->paths, .seed = 2};
    struct reference_estimate *e = bytes_alloc(b->count * sizeof *e);
    double *r = bytes_alloc(6 * b->count * sizeof *r);
    double *variance = r + 3 * b->count, share = 0, sum = 0, events = 0;
    double *once_scattered = sums_of(b, s, 0); // has far less noise
    reference_path(s, b->place, b->count, &how, e);
    for (size_t i = 0; i < 3 * b->count; i++) {
        r[i] = once_scattered[i] + e[i / 3].multiple[i % 3];
        variance[i] = e[i / 3].multiple_variance[i % 3];
        share += e[i / 3].multiple[i % 3];
        sum += r[i];
        events += e[i / 3].events / (3 * (double)b->count);
    }
    printf("  paths: %d x %zu in %.1f s, %.1f scatterings each, multiple is "
           "%.2f of the light\n",
           b->paths, b->count, timer_now() - began, events, share / sum);
    for (size_t k = 0; k < sizeof ways / sizeof ways[0]; k++) {
        set(&p, ways[k][1]);
        set(&p, ways[k][2]);
        render(b, &p);
        double *x = radiance_of(b);
        row(b, ways[k][0], x, r, variance);
        free(x);
    }
    free(e);
    free(r);
    free(once_scattered);
    reference_destroy(s);
}

static void parse(struct bench *b, int argc, char **argv)
{
    for (int i = 1; i < argc; i++) {
        const char *value = strchr(argv[i], '=');
        value = value ? value + 1 : "";
        if (strncmp(argv[i], "hair=", 5) == 0)
            b->hair = value;
        else if (strncmp(argv[i], "env=", 4) == 0)
            b->env = value;
        else if (strncmp(argv[i], "only=", 5) == 0)
            b->only = value;
        else if (strncmp(argv[i], "places=", 7) == 0)
            b->places = atoi(value);
        else if (strncmp(argv[i], "paths=", 6) == 0)
            b->paths = atoi(value);
        else
            set(&b->p, argv[i]);
    }
    if (b->places < 1 || b->places > 100000 || b->paths < 2) {
        fprintf(stderr, "bench_reference: places 1..100000, paths 2...\n");
        exit(2);
    }
}

int main(int argc, char **argv)
{
    sky_helper_main(argc, argv);
    // per radius; Marschner 2003, Table 1 has .2 and more
    static const char *const colours[][2] = {
        {"black", "fibre.sigma_a=3.35,5.58,10.96"},
        {"brown", "fibre.sigma_a=0.54,0.91,1.78"},
        {"blond", "fibre.sigma_a=0.15,0.25,0.45"},
        {"white", "fibre.sigma_a=0,0,0"},
    };
    struct error err = {0};
    struct bench b = {.hair = "builtin:animation",
                      .env = "builtin:studio",
                      .places = 300,
                      .paths = 256};
    params_defaults(&b.p);
    b.p.quality.samples = 1;
    parse(&b, argc, argv);
    b.place = bytes_alloc((size_t)b.places * sizeof *b.place);
    b.r = renderer_create(NULL, &err);
    must(b.r != NULL, &err);
    renderer_set_params(b.r, &b.p);
    struct groom *g = groom_open(b.hair, &err);
    must(g != NULL && renderer_set_groom(b.r, g, &err), &err);
    struct sky_map *m = sky_open(b.env, &err);
    must(m != NULL && renderer_set_sky(b.r, m, &err), &err);
    for (size_t k = 0; k < sizeof colours / sizeof colours[0]; k++) {
        if (b.only && strcmp(b.only, colours[k][0]) != 0)
            continue;
        printf("%s hair (%s)\n", colours[k][0], colours[k][1]);
        set(&b.p, colours[k][1]);
        once(&b, k == 2);
        all(&b);
    }
    renderer_destroy(b.r);
    free(b.place);
    return 0;
}
