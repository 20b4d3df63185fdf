// bench_crossings.c - error, time and memory of the shadows' crossings against
// rays: one JSON line a groom, resolution and quality.  Not part of make test.
//   bench_crossings [--places N] [--rays N] [SOURCE[:DIAMETER] ...]
// Times ending in cpu_ms: of all threads, so that they mean something on a busy
// machine with a software renderer.  places: as many seen from outside and as
// many hidden; rays: of the truth, a lobe.  12 aims with lobes of lambda .05,
// .2, .5 and 1 each.
#include <stdio.h>
#include <sys/resource.h>

#include "renderer/egl.h"
#include "renderer/gl.h"
#include "tests/numeric/crossings_truth.h"

static int places = 200, rays = 256;

static void must(bool ok, const struct error *err)
{
    if (!ok) {
        fprintf(stderr, "bench_crossings: %s\n", err->text);
        exit(1);
    }
}

static double cpu_now(void) // seconds, all threads
{
    struct rusage u;
    getrusage(RUSAGE_SELF, &u);
    return (double)(u.ru_utime.tv_sec + u.ru_stime.tv_sec) +
           1e-6 * (double)(u.ru_utime.tv_usec + u.ru_stime.tv_usec);
}

struct scene {
    struct groom *groom;
    struct params params;
    struct strands strands;
    struct truth truth;
    struct crossings crossings;
    struct crossings_result *result;
    double sweep_cpu; // seconds
};

static void line(struct scene *s, const char *quality, int near_rays, double ms)
{
    const struct truth_errors e = truth_compare(&s->truth, s->result);
    struct crossings_stats st;
    crossings_read_stats(&s->crossings, &st);
    printf("{\"groom\":\"%s\",\"size\":[%d,%d,%d],\"quality\":\"%s\","
           "\"rays\":%d,\"clear\":%.4f,\"bias\":%.4f,\"by_width\":[%.3f,%.3f,"
           "%.3f,%.3f],\"visible\":%.3f,\"interior\":%.3f,"
           "\"forward\":[%.4f,%.4f,%.4f,%.4f],\"forward_bias\":[%.3f,%.3f,%.3f,"
           "%.3f],"
           "\"sky\":%.4f,\"noise\":%.4f,\"ways\":%d,\"grid_ms\":%.1f,"
           "\"lists_ms\":%.1f,\"sweep_ms\":%.1f,\"sweep_cpu_ms\":%.1f,\"probe_"
           "cpu_ms\":%.1f,"
           "\"grid_mb\":%.1f,\"ways_mb\":%.1f,\"lists_mb\":%.1f,"
           "\"scratch_mb\":%.1f}\n",
           s->groom->name, st.size[0], st.size[1], st.size[2], quality,
           near_rays, e.clear, e.bias, e.by_width[0], e.by_width[1],
           e.by_width[2], e.by_width[3], e.visible, e.interior, e.forward[0],
           e.forward[1], e.forward[2], e.forward[3], e.forward_bias[0],
           e.forward_bias[1], e.forward_bias[2], e.forward_bias[3], e.sky,
           e.noise, st.ways, st.grid_ms, st.lists_ms, st.sweep_ms,
           1e3 * s->sweep_cpu, ms, 1e-6 * (double)st.grid_bytes,
           1e-6 * (double)st.ways_bytes, 1e-6 * (double)st.lists_bytes,
           1e-6 * (double)st.scratch_bytes);
    fflush(stdout);
}

static void measure(struct scene *s, int near_rays, const char *quality)
{
    struct error err = {0};
    struct crossings_probe_run run = {
        .crossings = &s->crossings, .strands = &s->strands, .rays = near_rays};
    for (int m = 0; m < 4; m++)
        run.attenuation[m] = (float)truth_attenuation[m];
    double best = INFINITY;
    for (int i = 0; i < 2; i++) {
        double began = cpu_now();
        must(crossings_probe(&run, s->truth.place, s->truth.places,
                             TRUTH_LIGHTS, s->result, &err),
             &err);
        best = fmin(best, cpu_now() - began);
    }
    line(s, quality, near_rays, 1e3 * best);
}

static void sweep(struct scene *s, int resolution)
{
    static const char *const name[2] = {"coarse", "fine"};
    struct error err = {0};
    const struct crossings_options o = {.resolution = resolution};
    must(crossings_build_grid(&s->crossings, s->groom, &s->params, &o, &err),
         &err);
    must(crossings_build_lists(&s->crossings, s->groom, &s->params, &err),
         &err);
    for (int q = 0; q < 2; q++) {
        s->sweep_cpu = INFINITY;
        for (int i = 0; i < 2; i++) {
            double began = cpu_now();
            must(crossings_update(&s->crossings, s->truth.light, TRUTH_LIGHTS,
                                  (enum crossings_quality)q, &err),
                 &err);
            gl.Finish();
            s->sweep_cpu = fmin(s->sweep_cpu, cpu_now() - began);
        }
        measure(s, 0, name[q]);
    }
    for (int r = 1; r <= CROSSINGS_RAYS_MAX; r *= 4)
        measure(s, r, name[1]);
}

static bool bench(const char *source)
{
    char name[512];
    struct error err = {0};
    struct scene s = {0};
    params_defaults(&s.params);
    snprintf(name, sizeof name, "%s", source);
    char *colon = strrchr(name, ':');
    if (colon && strchr("0123456789.", colon[1]) && colon[1]) {
        s.params.hair.diameter = strtof(colon + 1, NULL);
        *colon = 0;
    }
    s.groom = groom_open(name, &err);
    must(s.groom, &err);
    struct shoot *shoot = shoot_create(s.groom, &s.params, &err);
    must(shoot, &err);
    truth_make(&s.truth, s.groom, shoot, places, rays);
    shoot_destroy(shoot);
    s.result =
        bytes_zalloc((size_t)s.truth.places * TRUTH_LIGHTS, sizeof *s.result);
    must(strands_build(&s.strands, s.groom, &s.params, &err), &err);
    must(crossings_init(&s.crossings, &err), &err);
    for (int r = 64; r <= 128; r += 32)
        sweep(&s, r);
    crossings_finish(&s.crossings);
    strands_finish(&s.strands);
    truth_free(&s.truth);
    free(s.result);
    groom_destroy(s.groom);
    return true;
}

int main(int argc, char **argv)
{
    static const char *const usual[] = {
        "builtin:animation", "../shared/data/hair/straight.hair:0.1",
        "../shared/data/hair/amd_testhair1.hair:0.2"};
    struct error err = {0};
    struct egl *egl = egl_create(&err);
    must(egl, &err);
    int i = 1;
    for (; i + 1 < argc && argv[i][0] == '-'; i += 2)
        *(strcmp(argv[i], "--rays") == 0 ? &rays : &places) = atoi(argv[i + 1]);
    if (i == argc)
        for (int k = 0; k < 3; k++)
            bench(usual[k]);
    for (; i < argc; i++)
        bench(argv[i]);
    egl_destroy(egl);
    return 0;
}
