// A drag as the daemon renders it: drafts, and the full first frame that each
// of them stands for, in one run.
//   bench_drafts [--budget MS] [--runs N] GROOM...
// (default: 33 ms, 12, animation straight)  One JSON line for each groom and
// edit: medians of wall and processor time, from the edit to JPEG 75 4:2:0, at
// 720x480, 40 lights, one sample.  first_ms: of the drag's first draft.
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "renderer/encode.h"
#include "renderer/metric.h"
#include "renderer/renderer.h"
#include "renderer/timer.h"
#include "server/haste.h"

enum { RUNS_MAX = 100 };

static void must(bool ok, const struct error *err)
{
    if (!ok) {
        fprintf(stderr, "bench_drafts: %s\n", err->text);
        exit(1);
    }
}

static double processor(void)
{
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return 1e3 * (double)t.tv_sec + 1e-6 * (double)t.tv_nsec;
}

struct bench {
    struct renderer *r;
    struct params p;
    struct haste haste;
    double budget;
    int runs;
};

struct took {
    double wall, cpu, tail;
    struct renderer_stats stats;
};

static void edit(struct params *p, int kind, int k)
{
    if (kind == 0)
        p->fibre.sigma_a[0] = 0.15f + 0.01f * (float)(k + 1);
    else if (kind == 1)
        p->camera.fov = 30 + 0.2f * (float)(k + 1);
    else
        p->light.yaw = 3 * (float)(k + 1);
}

// From the edit to bytes; how: NULL for the full frame.
static struct took frame(struct bench *b, struct renderer_draft *how)
{
    struct took t = {0};
    struct error err = {0};
    struct buf pixels = {0}, jpeg = {0};
    bool done;
    const double began = timer_now(), used = processor();
    renderer_set_params(b->r, &b->p);
    if (how)
        must(renderer_draft(b->r, how, &err), &err);
    else
        must(renderer_step(b->r, &done, &err), &err);
    const double made = timer_now();
    must(renderer_read_display(b->r, &pixels, &err), &err);
    encode_jpeg(&jpeg, pixels.data, b->p.image.width, b->p.image.height, 75,
                ENCODE_420);
    t.wall = 1e3 * (timer_now() - began);
    t.tail = 1e3 * (timer_now() - made);
    t.cpu = processor() - used;
    renderer_stats(b->r, &t.stats);
    buf_finish(&pixels);
    buf_finish(&jpeg);
    return t;
}

static struct took full(struct bench *b)
{
    const struct took t = frame(b, NULL);
    haste_full(&b->haste, t.stats.stage_ms);
    haste_full_tail(&b->haste, t.tail);
    return t;
}

static bool draft(struct bench *b, struct took *t, struct renderer_draft *how)
{
    double forecast[RENDERER_STAGES];
    renderer_set_params(b->r, &b->p);
    if (!renderer_forecast(b->r, forecast) ||
        !haste_choose(&b->haste, forecast, b->budget, b->p.image.height, how))
        return false;
    *t = frame(b, how);
    haste_draft(&b->haste, forecast, how, t->stats.stage_ms);
    haste_draft_tail(&b->haste, t->tail);
    return true;
}

static void measure(struct bench *b, const char *groom, int kind)
{
    static const char *const names[] = {"sigma_a", "camera", "sky rotation"};
    double wall[2][RUNS_MAX], cpu[2][RUNS_MAX], first = 0;
    struct renderer_draft how = {0};
    struct took t = {0};
    for (int k = -2; k < 5; k++) { // full frames, two to warm up
        edit(&b->p, kind, k + 2);
        t = full(b);
        if (k >= 0) {
            wall[1][k] = t.wall;
            cpu[1][k] = t.cpu;
        }
    }
    for (int k = -4; k < b->runs; k++) { // a drag; its size settles first
        edit(&b->p, kind, k + 20);
        if (!draft(b, &t, &how)) {
            printf("{\"scene\":\"%s\",\"edit\":\"%s\",\"full_ms\":%.1f,"
                   "\"draft\":null}\n",
                   groom, names[kind], metric_quantile(wall[1], 5, 0.5));
            return;
        }
        if (k == -4)
            first = t.wall;
        if (k >= 0) {
            wall[0][k] = t.wall;
            cpu[0][k] = t.cpu;
        }
    }
    const size_t n = (size_t)b->runs;
    printf("{\"scene\":\"%s\",\"edit\":\"%s\",\"draft_ms\":%.1f,"
           "\"draft_p95_ms\":%.1f,\"draft_cpu_ms\":%.1f,\"first_ms\":%.1f,"
           "\"divisor\":%d,\"stride\":%d,\"full_ms\":%.1f,\"full_cpu_ms\":%.1f,"
           "\"ratio_cpu\":%.3f,\"draft_bytes\":%llu,\"stages\":{",
           groom, names[kind], metric_quantile(wall[0], n, 0.5),
           metric_quantile(wall[0], n, 0.95), metric_quantile(cpu[0], n, 0.5),
           first, how.divisor, how.stride, metric_quantile(wall[1], 5, 0.5),
           metric_quantile(cpu[1], 5, 0.5),
           metric_quantile(cpu[0], n, 0.5) / metric_quantile(cpu[1], 5, 0.5),
           (unsigned long long)t.stats.memory_draft);
    bool comma = false;
    for (int i = 0; i < RENDERER_STAGES; i++)
        if (t.stats.stage_ms[i] >= 0) {
            printf("%s\"%s\":%.2f", comma ? "," : "", renderer_stage_names[i],
                   t.stats.stage_ms[i]);
            comma = true;
        }
    printf("}}\n");
    fflush(stdout);
}

static void scene(struct bench *b, const char *name)
{
    struct error err = {0};
    char source[300];
    b->haste = (struct haste){0};
    b->r = renderer_create(NULL, &err);
    must(b->r != NULL, &err);
    snprintf(source, sizeof source, "%s%s",
             strchr(name, '/') || strchr(name, ':') ? "" : "builtin:", name);
    struct groom *g = groom_open(source, &err);
    must(g != NULL, &err);
    struct sky_map *m = sky_open("builtin:studio", &err);
    must(m != NULL, &err);
    must(renderer_set_groom(b->r, g, &err), &err);
    must(renderer_set_sky(b->r, m, &err), &err);
    params_defaults(&b->p);
    b->p.quality.samples = 1;
    b->p.shadow.rays = 0; // they come after the first sample
    for (int kind = 0; kind < 3; kind++)
        measure(b, name, kind);
    renderer_destroy(b->r);
}

int main(int argc, char **argv)
{
    static const char *const usual[] = {"animation", "straight"};
    struct bench b = {.budget = 33, .runs = 12};
    int first = 1;
    sky_helper_main(argc, argv);
    for (; argc > first + 1 && argv[first][0] == '-'; first += 2)
        if (strcmp(argv[first], "--runs") == 0)
            b.runs = atoi(argv[first + 1]);
        else
            b.budget = atof(argv[first + 1]);
    if (b.runs < 1 || b.runs > RUNS_MAX || !(b.budget > 0)) {
        fprintf(stderr, "bench_drafts: --runs 1 to %d, --budget > 0\n",
                RUNS_MAX);
        return 2;
    }
    for (int i = first; i < argc; i++)
        scene(&b, argv[i]);
    for (size_t i = 0; first >= argc && i < 2; i++)
        scene(&b, usual[i]);
    return 0;
}
