// How long an edit waits at worst for what is under way when it comes: the
// longest time between two looks of a step (renderer_watch), of the first full
// frame of some edits and of the refinement at rest.
//   bench_waits [GROOM...]        (default: animation straight)
// One JSON line each, at 720x480, 40 lights, default quality: processor and
// wall time of the whole steps, and of the longest and the 95th percentile of
// the stretches between two looks.
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "renderer/metric.h"
#include "renderer/renderer.h"
#include "renderer/timer.h"

enum { LOOKS_MAX = 1 << 16 };

struct stretches {
    pthread_mutex_t lock;
    double wall, cpu; // when the newest began, ms
    double all[2][LOOKS_MAX];
    size_t count;
};

static void must(bool ok, const struct error *err)
{
    if (!ok) {
        fprintf(stderr, "bench_waits: %s\n", err->text);
        exit(1);
    }
}

static double processor(void)
{
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return 1e3 * (double)t.tv_sec + 1e-6 * (double)t.tv_nsec;
}

static void begin(struct stretches *s)
{
    s->wall = 1e3 * timer_now();
    s->cpu = processor();
}

static void end(struct stretches *s)
{
    const double wall = 1e3 * timer_now(), cpu = processor();
    if (s->count < LOOKS_MAX) {
        s->all[0][s->count] = wall - s->wall;
        s->all[1][s->count++] = cpu - s->cpu;
    }
    s->wall = wall;
    s->cpu = cpu;
}

static bool look(void *ctx)
{
    struct stretches *s = ctx;
    pthread_mutex_lock(&s->lock); // whichever thread it is: the work would end
    end(s);
    pthread_mutex_unlock(&s->lock);
    return false;
}

static void fibre(struct params *p)
{
    p->fibre.sigma_a[0] += 0.01f;
}
static void camera(struct params *p)
{
    p->camera.fov += 0.5f;
}
static void sky(struct params *p)
{
    p->light.yaw += 5;
}
static void diameter(struct params *p)
{
    p->hair.diameter += 0.001f;
}
static void lights(struct params *p)
{
    p->sky.lights -= 1;
}
static void plain(struct params *p)
{
    p->sky.fit = !p->sky.fit;
}
static void voxels(struct params *p)
{
    p->shadow.resolution -= 4;
}
static void nothing(struct params *p)
{
    (void)p;
}

static const struct edit {
    const char *name;
    void (*run)(struct params *p);
    int steps;
} edits[] = {
    {"fibre", fibre, 1},
    {"camera", camera, 1},
    {"sky rotation", sky, 1},
    {"shadow.resolution", voxels, 1},
    {"hair.diameter", diameter, 1},
    {"sky.lights", lights, 1},
    {"sky.fit", plain, 1},
    {"refinement", nothing, 3},
};

static double sum_of(const double *x, size_t n)
{
    double sum = 0;
    for (size_t i = 0; i < n; i++)
        sum += x[i];
    return sum;
}

static void measure(struct renderer *r, struct params *p, const char *groom,
                    const struct edit *e)
{
    static struct stretches s = {.lock = PTHREAD_MUTEX_INITIALIZER};
    struct error err = {0};
    bool done;
    for (int k = 0; k < 2; k++) { // the first time warms up
        s.count = 0;
        e->run(p);
        renderer_set_params(r, p);
        renderer_watch(r, look, &s);
        begin(&s);
        for (int i = 0; i < e->steps; i++)
            must(renderer_step(r, &done, &err), &err);
        end(&s);
    }
    struct renderer_stats stats;
    renderer_stats(r, &stats);
    printf("{\"scene\":\"%s\",\"edit\":\"%s\",\"looks\":%zu,\"wall_ms\":%.1f,"
           "\"longest_ms\":%.1f,\"p95_ms\":%.1f,\"cpu_ms\":%.1f,"
           "\"longest_cpu_ms\":%.1f,\"p95_cpu_ms\":%.1f,\"refined\":%s}\n",
           groom, e->name, s.count, sum_of(s.all[0], s.count),
           metric_quantile(s.all[0], s.count, 1),
           metric_quantile(s.all[0], s.count, 0.95), sum_of(s.all[1], s.count),
           metric_quantile(s.all[1], s.count, 1),
           metric_quantile(s.all[1], s.count, 0.95),
           stats.refined ? "true" : "false");
    fflush(stdout);
}

static void scene(const char *name)
{
    struct error err = {0};
    struct params p;
    char source[300];
    bool done;
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
    params_defaults(&p);
    p.hair.diameter = 0.02f;
    renderer_set_params(r, &p);
    must(renderer_step(r, &done, &err), &err);
    for (size_t i = 0; i < sizeof edits / sizeof edits[0]; i++)
        measure(r, &p, name, &edits[i]);
    renderer_destroy(r);
}

int main(int argc, char **argv)
{
    sky_helper_main(argc, argv);
    for (int i = 1; i < argc; i++)
        scene(argv[i]);
    if (argc < 2) {
        scene("animation");
        scene("straight");
    }
    return 0;
}
