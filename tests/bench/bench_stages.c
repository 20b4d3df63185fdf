// Milliseconds of an edit, stage by stage, and what leaving things out saves.
//   bench_stages [--runs N] [--only WORD] GROOM...
// (default: animation straight; WORD: edits that have it in their name)
// One JSON line for each groom and edit: medians over N runs (default 10) after
// two to warm up, at 720x480, 40 lights, one sample, JPEG 75 4:2:0.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "renderer/encode.h"
#include "renderer/renderer.h"
#include "renderer/timer.h"

enum { RUNS_MAX = 100, COLUMNS = RENDERER_STAGES + 2 }; // + encode, wall

static int compare(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double quantile(const double *values, int n, double q)
{
    double sorted[RUNS_MAX];
    memcpy(sorted, values, (size_t)n * sizeof *sorted);
    qsort(sorted, (size_t)n, sizeof *sorted, compare);
    int i = (int)ceil(q * n) - 1;
    return sorted[i < 0 ? 0 : i];
}

static void must(bool ok, const struct error *err)
{
    if (!ok) {
        fprintf(stderr, "bench_stages: %s\n", err->text);
        exit(1);
    }
}

static size_t frame(struct renderer *r, const struct params *p, double *ms)
{
    struct error err = {0};
    struct renderer_stats s;
    struct buf pixels = {0}, jpeg = {0};
    bool done;
    double began = timer_now();
    renderer_set_params(r, p);
    must(renderer_step(r, &done, &err), &err);
    must(renderer_read_display(r, &pixels, &err), &err);
    double read = timer_now();
    encode_jpeg(&jpeg, pixels.data, p->image.width, p->image.height, 75,
                ENCODE_420);
    double end = timer_now();
    renderer_stats(r, &s);
    for (int i = 0; i < RENDERER_STAGES; i++)
        ms[i] = s.stage_ms[i];
    ms[RENDERER_STAGES] = 1e3 * (end - read);
    ms[RENDERER_STAGES + 1] = 1e3 * (end - began);
    size_t bytes = jpeg.size;
    buf_finish(&pixels);
    buf_finish(&jpeg);
    return bytes;
}

// Edits number k of a kind; every one differs from the one before.
typedef void edit_fn(struct params *p, int k);
static void edit_sigma(struct params *p, int k)
{
    p->fibre.sigma_a[0] = 0.15f + 0.01f * (float)(k + 1);
}
static void edit_beta(struct params *p, int k)
{
    p->fibre.beta_r = 7 + 0.1f * (float)k;
}
static void edit_tint(struct params *p, int k)
{
    p->tint.colour[1] = 0.5f + 0.02f * (float)k;
}
static void edit_yaw(struct params *p, int k)
{
    p->light.yaw = 3 * (float)(k + 1);
}
static void edit_fov(struct params *p, int k)
{
    p->camera.fov = 30 + 0.1f * (float)(k + 1);
}
static void edit_view(struct params *p, int k)
{
    p->view.exposure = 0.1f * (float)(k + 1);
}
static void edit_eccentric(struct params *p, int k)
{
    p->fibre.a = 0.9f + 0.002f * (float)k;
}
static void edit_opaque(struct params *p, int k)
{
    for (int c = 0; c < 3; c++)
        p->fibre.sigma_a[c] = 20 + (float)k;
}
static void edit_all_lights(struct params *p, int k)
{
    p->quality.light_bound = 0;
    edit_sigma(p, k);
}
static void edit_few_lights(struct params *p, int k)
{
    p->quality.light_bound = 0.02f;
    edit_sigma(p, k);
}

static void edit_best(struct params *p, int k)
{
    p->render.path = 0;
    p->render.scheme = 1;
    edit_sigma(p, k);
}
static void edit_paper(struct params *p, int k)
{
    p->render.scheme = 0;
    edit_sigma(p, k);
}
static void edit_single_best(struct params *p, int k)
{
    p->render.multiple = 0;
    edit_best(p, k);
}
static void edit_single_paper(struct params *p, int k)
{
    p->render.multiple = 0;
    edit_paper(p, k);
}
static void edit_eccentric_best(struct params *p, int k)
{
    edit_eccentric(p, k);
    p->render.multiple = 0;
    p->render.scheme = 1;
}
static void edit_eccentric_paper(struct params *p, int k)
{
    edit_eccentric(p, k);
    p->render.multiple = p->render.scheme = 0;
}

static void edit_sigma_direct(struct params *p, int k)
{
    p->render.path = 0;
    edit_sigma(p, k);
}
static void edit_beta_direct(struct params *p, int k)
{
    p->render.path = 0;
    edit_beta(p, k);
}
static void edit_tint_direct(struct params *p, int k)
{
    p->render.path = 0;
    edit_tint(p, k);
}

static const struct edit {
    const char *name;
    edit_fn *run;
} edits[] = {
    {"sigma_a", edit_sigma},
    {"beta_r", edit_beta},
    {"light colour", edit_tint},
    {"sky rotation", edit_yaw},
    {"camera", edit_fov},
    {"display exposure", edit_view},
    {"sigma_a, a = 0.9 (eccentricity not left out)", edit_eccentric},
    {"sigma_a > 20 (TT, TRT left out)", edit_opaque},
    {"sigma_a, light_bound = 0 (no light left out)", edit_all_lights},
    {"sigma_a, light_bound = 0.02", edit_few_lights},
    {"sigma_a, path = direct", edit_sigma_direct},
    {"beta_r, path = direct", edit_beta_direct},
    {"light colour, path = direct", edit_tint_direct},
    {"sigma_a, scheme paper", edit_paper},
    {"sigma_a, scheme best", edit_best},
    {"sigma_a, scheme paper, multiple off", edit_single_paper},
    {"sigma_a, scheme best, multiple off", edit_single_best},
    {"sigma_a, scheme paper, multiple off, a = 0.9", edit_eccentric_paper},
    {"sigma_a, scheme best, multiple off, a = 0.9", edit_eccentric_best},
};

static void measure(struct renderer *r, const char *groom, const struct edit *e,
                    int runs)
{
    static double ms[COLUMNS][RUNS_MAX];
    struct params p;
    struct renderer_stats s;
    params_defaults(&p);
    p.quality.samples = 1;
    size_t bytes = 0;
    for (int k = -2; k < runs; k++) {
        double one[COLUMNS];
        e->run(&p, k + 2);
        bytes = frame(r, &p, one);
        for (int c = 0; k >= 0 && c < COLUMNS; c++)
            ms[c][k] = one[c];
    }
    renderer_stats(r, &s);
    printf("{\"scene\":\"%s\",\"edit\":\"%s\",\"median_ms\":%.1f,"
           "\"p95_ms\":%.1f,\"stages\":{",
           groom, e->name, quantile(ms[COLUMNS - 1], runs, 0.5),
           quantile(ms[COLUMNS - 1], runs, 0.95));
    for (int c = 0; c < RENDERER_STAGES; c++)
        if (ms[c][0] >= 0)
            printf("\"%s\":%.2f,", renderer_stage_names[c],
                   quantile(ms[c], runs, 0.5));
    printf("\"encode\":%.2f},\"points\":%u,\"lights\":%d,\"jpeg_bytes\":%zu}\n",
           quantile(ms[RENDERER_STAGES], runs, 0.5), s.visible_points,
           s.lights_used, bytes);
    fflush(stdout);
}

// only: edits that have this in their name; NULL: all.
static void scene(const char *name, const char *only, int runs)
{
    struct error err = {0};
    struct params p;
    char source[300];
    params_defaults(&p);
    double began = timer_now(), ms[COLUMNS];
    struct renderer *r = renderer_create(NULL, &err);
    must(r != NULL, &err);
    snprintf(source, sizeof source, "%s%s",
             strchr(name, '/') || strchr(name, ':') ? "" : "builtin:", name);
    struct groom *g = groom_open(source, &err);
    must(g != NULL, &err);
    struct sky_map *m = sky_open("builtin:studio", &err);
    must(m != NULL, &err);
    must(renderer_set_groom(r, g, &err), &err);
    must(renderer_set_sky(r, m, &err), &err);
    frame(r, &p, ms);
    printf("{\"scene\":\"%s\",\"edit\":\"start to first frame\","
           "\"median_ms\":%.1f,\"device\":\"%s\"}\n",
           name, 1e3 * (timer_now() - began), renderer_device(r));
    for (size_t i = 0; i < sizeof edits / sizeof edits[0]; i++)
        if (!only || strstr(edits[i].name, only))
            measure(r, name, &edits[i], runs);
    renderer_destroy(r);
}

int main(int argc, char **argv)
{
    static const char *const usual[] = {"animation", "straight"};
    const char *only = NULL;
    int runs = 10, first = 1;
    sky_helper_main(argc, argv);
    for (; argc > first + 1 && argv[first][0] == '-'; first += 2)
        if (strcmp(argv[first], "--runs") == 0)
            runs = atoi(argv[first + 1]);
        else
            only = argv[first + 1];
    if (runs < 1 || runs > RUNS_MAX) {
        fprintf(stderr, "bench_stages: --runs: 1 to %d\n", RUNS_MAX);
        return 2;
    }
    for (int i = first; i < argc; i++)
        scene(argv[i], only, runs);
    for (size_t i = 0; first >= argc && i < 2; i++)
        scene(usual[i], only, runs);
    return 0;
}
