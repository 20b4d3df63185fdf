// What an edit of the fibre costs by forward shading (Xu 2011, section 5) and
// by direct shading: the two in turn, so that whatever else the machine does
// bears on both alike.
//   bench_forward [--runs N] [GROOM...]     (default: 7; animation straight)
// One JSON line for each groom and way: medians of N edits of fibre.sigma_a
// after two to warm up, from the edit to the pixels of the first sample, at
// 720x480, 40 lights (none left out), smooth shadows, multiple scattering,
// render.m = 4.  Then how far the two pictures are apart: what shading at the
// middle of a cell instead of at the fragment makes.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "renderer/renderer_private.h"
#include "renderer/timer.h"

enum { RUNS_MAX = 100, COLUMNS = RENDERER_STAGES + 2 }; // + wall, CPU

struct way {
    const char *name;
    int path;          // render.path
    int lights_a_pass; // 0: as ever
    bool unkept;       // transmittances are looked up by the fragments
    bool anew;         // the pre-pass runs for every edit
    struct renderer *r;
    struct params p;
    double ms[COLUMNS][RUNS_MAX];
};

static struct way ways[] = {
    {.name = "direct", .path = RENDERER_DIRECT},
    {.name = "forward", .path = RENDERER_FORWARD},
    {.name = "forward, one pass for all lights",
     .path = RENDERER_FORWARD,
     .lights_a_pass = 200},
    {.name = "forward, pre-pass for every edit",
     .path = RENDERER_FORWARD,
     .anew = true},
    {.name = "forward, transmittances looked up by fragments",
     .path = RENDERER_FORWARD,
     .unkept = true},
};
enum { WAYS = sizeof ways / sizeof ways[0] };

static int compare(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double median(const double *values, int n)
{
    double sorted[RUNS_MAX];
    memcpy(sorted, values, (size_t)n * sizeof *sorted);
    qsort(sorted, (size_t)n, sizeof *sorted, compare);
    return 0.5 * (sorted[(n - 1) / 2] + sorted[n / 2]);
}

static void must(bool ok, const struct error *err)
{
    if (!ok) {
        fprintf(stderr, "bench_forward: %s\n", err->text);
        exit(1);
    }
}

static void begin(struct way *w, const char *groom)
{
    struct error err = {0};
    params_defaults(&w->p);
    w->p.render.path = w->path;
    w->p.render.m = 4;
    w->p.shadow.rays = 0;
    w->p.quality.samples = 1;
    w->p.quality.light_bound = 0;
    w->r = renderer_create(NULL, &err);
    must(w->r != NULL, &err);
    w->r->forward.lights_a_pass = w->lights_a_pass;
    w->r->nodes_budget = w->unkept ? 1 : 0;
    struct groom *g = groom_open(groom, &err);
    must(g != NULL, &err);
    struct sky_map *m = sky_open("builtin:studio", &err);
    must(m != NULL, &err);
    must(renderer_set_groom(w->r, g, &err), &err);
    must(renderer_set_sky(w->r, m, &err), &err);
}

static void edit(struct way *w, int k)
{
    struct error err = {0};
    struct renderer_stats s;
    struct buf pixels = {0};
    bool done;
    w->p.fibre.sigma_a[0] = 0.15f + 0.01f * (float)(k + 3);
    if (w->anew)
        forward_forget(&w->r->forward);
    double began = timer_now();
    clock_t cpu = clock(); // of all threads: other work does not count
    renderer_set_params(w->r, &w->p);
    must(renderer_step(w->r, &done, &err), &err);
    must(renderer_read_display(w->r, &pixels, &err), &err);
    double wall = 1e3 * (timer_now() - began);
    double used = 1e3 * (double)(clock() - cpu) / CLOCKS_PER_SEC;
    buf_finish(&pixels);
    renderer_stats(w->r, &s);
    for (int i = 0; k >= 0 && i < RENDERER_STAGES; i++)
        w->ms[i][k] = s.stage_ms[i];
    if (k >= 0) {
        w->ms[RENDERER_STAGES][k] = wall;
        w->ms[RENDERER_STAGES + 1][k] = used;
    }
}

static void report(const struct way *w, const char *groom, int runs)
{
    struct renderer_stats s;
    renderer_stats(w->r, &s);
    const double ms = median(w->ms[RENDERER_STAGES], runs);
    const double direct = median(ways[0].ms[RENDERER_STAGES], runs);
    printf("{\"scene\":\"%s\",\"way\":\"%s\",\"median_ms\":%.1f,"
           "\"of_direct\":%.2f,\"cpu_ms\":%.1f,\"stages\":{",
           groom, w->name, ms, ms / direct,
           median(w->ms[RENDERER_STAGES + 1], runs));
    const char *comma = "";
    for (int i = 0; i < RENDERER_STAGES; i++)
        if (w->ms[i][0] >= 0) {
            printf("%s\"%s\":%.2f", comma, renderer_stage_names[i],
                   median(w->ms[i], runs));
            comma = ",";
        }
    printf("},\"shaded\":%u,\"lights\":%d,\"device\":\"%s\"}\n",
           s.visible_points, s.lights_used, renderer_device(w->r));
    fflush(stdout);
}

// Sum of |a - b| over sum of b, and quantiles of |a - b| of pixels that see
// hair, in the mean radiance of hair.
static void apart(const char *groom, struct renderer *a, struct renderer *b)
{
    struct error err = {0};
    struct buf of[2] = {{0}, {0}};
    must(renderer_read_linear(a, &of[0], &err), &err);
    must(renderer_read_linear(b, &of[1], &err), &err);
    const float *x = (const float *)(const void *)of[0].data;
    const float *y = (const float *)(const void *)of[1].data;
    const size_t pixels = of[0].size / 16;
    double *each = bytes_alloc(pixels * sizeof *each);
    double sum = 0, all = 0, mean = 0;
    size_t n = 0;
    for (size_t i = 0; i < pixels; i++) {
        if (y[4 * i + 3] <= 0)
            continue;
        double d = 0;
        for (size_t c = 0; c < 3; c++) {
            d += fabs(x[4 * i + c] - y[4 * i + c]);
            all += y[4 * i + c];
        }
        sum += d;
        mean += (x[4 * i] - y[4 * i]) + (x[4 * i + 1] - y[4 * i + 1]) +
                (x[4 * i + 2] - y[4 * i + 2]);
        each[n++] = d;
    }
    qsort(each, n, sizeof *each, compare);
    const double unit = all / (double)(n ? n : 1);
    printf("{\"scene\":\"%s\",\"samples\":%d,\"apart\":%.5f,\"bias\":%.6f,"
           "\"median\":%.5f,\"p90\":%.5f,\"p99\":%.5f,\"pixels\":%zu}\n",
           groom, a->samples, sum / all, mean / all, each[n / 2] / unit,
           each[n * 9 / 10] / unit, each[n * 99 / 100] / unit, n);
    free(each);
    buf_finish(&of[0]);
    buf_finish(&of[1]);
}

static void finish(struct way *w, int samples)
{
    struct error err = {0};
    bool done = false;
    w->p.quality.samples = samples;
    renderer_set_params(w->r, &w->p);
    while (!done)
        must(renderer_step(w->r, &done, &err), &err);
}

static void scene(const char *name, int runs)
{
    char source[300];
    snprintf(source, sizeof source, "%s%s",
             strchr(name, '/') || strchr(name, ':') ? "" : "builtin:", name);
    for (int i = 0; i < WAYS; i++)
        begin(&ways[i], source);
    for (int k = -2; k < runs; k++)
        for (int i = 0; i < WAYS; i++)
            edit(&ways[i], k);
    for (int i = 0; i < WAYS; i++)
        report(&ways[i], name, runs);
    apart(name, ways[0].r, ways[1].r);
    fflush(stdout);
    finish(&ways[0], 4);
    finish(&ways[1], 4);
    apart(name, ways[0].r, ways[1].r);
    for (int i = 0; i < WAYS; i++)
        renderer_destroy(ways[i].r);
    fflush(stdout);
}

int main(int argc, char **argv)
{
    static const char *const usual[] = {"animation", "straight"};
    int runs = 7, first = 1;
    sky_helper_main(argc, argv);
    if (argc > 2 && strcmp(argv[1], "--runs") == 0) {
        runs = atoi(argv[2]);
        first = 3;
    }
    if (runs < 1 || runs > RUNS_MAX) {
        fprintf(stderr, "bench_forward: --runs: 1 to %d\n", RUNS_MAX);
        return 2;
    }
    for (int i = first; i < argc; i++)
        scene(argv[i], runs);
    for (size_t i = 0; first >= argc && i < 2; i++)
        scene(usual[i], runs);
    return 0;
}
