// A drag as the daemon renders it: drafts, and the full first frame that each
// of them stands for, in one run.
//   bench_drafts [--budget MS] [--runs N] [--cold 1] GROOM...
// (default: 33 ms, 12, animation straight)  One JSON line for each groom and
// edit: medians of wall and processor time, from the edit to JPEG 75 4:2:0, at
// 720x480, 40 lights, one sample.  Before each drag the picture rests and
// drafts are rehearsed (--cold: they are not); first_ms is the drag's first
// draft, rest_ms what all rehearsals took.  draft null: the full frame is in
// time.
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "renderer/encode.h"
#include "renderer/metric.h"
#include "renderer/renderer.h"
#include "renderer/timer.h"
#include "server/haste.h"
#include "server/rehearsal.h"

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
    bool cold;
};

struct took {
    double wall, cpu, tail;
    struct renderer_stats stats;
};

static void sigma_a(struct params *p, int k)
{
    p->fibre.sigma_a[0] = 0.15f + 0.01f * (float)(k + 1);
}
static void camera(struct params *p, int k)
{
    p->camera.fov = 30 + 0.2f * (float)(k + 1);
}
static void sky(struct params *p, int k)
{
    p->light.yaw = 3 * (float)(k + 1);
}
static void tint(struct params *p, int k)
{
    p->tint.colour[0] = 1 - 0.01f * (float)(k + 1);
}
static void exposure(struct params *p, int k)
{
    p->tint.exposure = 0.05f * (float)(k + 1);
}
static void display(struct params *p, int k)
{
    p->view.exposure = 0.05f * (float)(k + 1);
}
static void diameter(struct params *p, int k)
{
    p->hair.diameter = 0.02f + 0.0005f * (float)(k + 1);
}
static void scale(struct params *p, int k)
{
    p->hair.scale = 1 + 0.01f * (float)(k + 1);
}
static void lights(struct params *p, int k)
{
    p->sky.lights = 37 - k % 30;
}

static const struct edit {
    const char *name;
    void (*run)(struct params *p, int k);
    bool slow; // fewer full frames do
} edits[] = {
    {"sigma_a", sigma_a, false},        {"camera", camera, false},
    {"sky rotation", sky, false},       {"tint.colour", tint, false},
    {"tint.exposure", exposure, false}, {"view.exposure", display, false},
    {"hair.diameter", diameter, true},  {"hair.scale", scale, true},
    {"sky.lights", lights, true},
};
enum { EDITS = sizeof edits / sizeof edits[0] };

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
    struct haste_ask ask;
    renderer_set_params(b->r, &b->p);
    rehearsal_ask(b->r, &b->p, &ask);
    ask.budget_ms = b->budget;
    if (!renderer_forecast(b->r, forecast) ||
        !haste_choose(&b->haste, forecast, &ask, how))
        return false;
    *t = frame(b, how);
    haste_draft(&b->haste, forecast, how, t->stats.stage_ms);
    haste_draft_tail(&b->haste, t->tail);
    return true;
}

// As the studio does it at rest.
static double rest(struct bench *b)
{
    const double began = timer_now();
    for (int k = 0; !b->cold && k < 16; k++)
        if (!rehearsal_next(&b->haste, b->r, &b->p))
            break;
    return 1e3 * (timer_now() - began);
}

struct line {
    const char *groom, *edit;
    double wall[2][RUNS_MAX], cpu[2][RUNS_MAX], first, rest;
    size_t count[2]; // drafts, full frames
    struct renderer_draft how;
    struct took last;
};

static void put(const struct line *l)
{
    const struct took *t = &l->last;
    const size_t n = l->count[0], m = l->count[1];
    printf("{\"scene\":\"%s\",\"edit\":\"%s\",\"full_ms\":%.1f,"
           "\"full_cpu_ms\":%.1f,\"draft\":",
           l->groom, l->edit, metric_quantile(l->wall[1], m, 0.5),
           metric_quantile(l->cpu[1], m, 0.5));
    if (n == 0) {
        printf("null}\n");
        return;
    }
    printf("{\"first_ms\":%.1f,\"median_ms\":%.1f,\"p95_ms\":%.1f,"
           "\"cpu_ms\":%.1f,\"rest_ms\":%.0f,\"divisor\":%d,\"stride\":%d,"
           "\"ratio_cpu\":%.3f,\"bytes\":%llu,\"stages\":{",
           l->first, metric_quantile(l->wall[0], n, 0.5),
           metric_quantile(l->wall[0], n, 0.95),
           metric_quantile(l->cpu[0], n, 0.5), l->rest, l->how.divisor,
           l->how.stride,
           metric_quantile(l->cpu[0], n, 0.5) /
               metric_quantile(l->cpu[1], m, 0.5),
           (unsigned long long)t->stats.memory_draft);
    bool comma = false;
    for (int i = 0; i < RENDERER_STAGES; i++)
        if (t->stats.stage_ms[i] >= 0) {
            printf("%s\"%s\":%.2f", comma ? "," : "", renderer_stage_names[i],
                   t->stats.stage_ms[i]);
            comma = true;
        }
    printf("}}}\n");
    fflush(stdout);
}

static void measure(struct bench *b, const char *groom, const struct edit *e)
{
    struct line l = {.groom = groom, .edit = e->name};
    const int full_runs = e->slow ? 3 : 5;
    for (int k = 0; k < full_runs + 1; k++) { // full frames, one to warm up
        e->run(&b->p, k);
        const struct took t = full(b);
        if (k > 0) {
            l.wall[1][k - 1] = t.wall;
            l.cpu[1][k - 1] = t.cpu;
        }
    }
    l.count[1] = (size_t)full_runs;
    l.rest = rest(b);
    for (int k = 0; k <= b->runs; k++) {
        e->run(&b->p, k + 20);
        if (!draft(b, &l.last, &l.how)) {
            full(b);
            break;
        }
        if (k == 0)
            l.first = l.last.wall;
        else {
            l.wall[0][k - 1] = l.last.wall;
            l.cpu[0][k - 1] = l.last.cpu;
            l.count[0] = (size_t)k;
        }
    }
    put(&l);
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
    for (int i = 0; i < EDITS; i++)
        measure(b, name, &edits[i]);
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
        else if (strcmp(argv[first], "--cold") == 0)
            b.cold = atoi(argv[first + 1]) != 0;
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
