// bench_crossings.c - error, time and memory of the shadows' transmittances
// against rays: one JSON line a groom, method, resolution, quality and number
// of rays.  Not part of make test; docs/SHADOWS.md is made of it.
//   bench_crossings [--places N] [--rays N] [--only RESOLUTION]
//                   [SOURCE[:DIAMETER] ...]
// Times are of all threads together (CPU), so that they mean something on a
// busy machine with a software renderer.  places: as many seen from outside and
// as many hidden; rays: of the truth, a lobe.  12 aims with lobes of lambda
// .05, .2, .5 and 1 each.
#include <stdio.h>
#include <sys/resource.h>

#include "renderer/egl.h"
#include "renderer/gl.h"
#include "tests/numeric/crossings_truth.h"

static int places = 100, rays = 256, only;
static const int resolutions[] = {32, 64, 96, 128, 192};

static void must(bool ok, const struct error *err)
{
    if (!ok) {
        fprintf(stderr, "bench_crossings: %s\n", err->text);
        exit(1);
    }
}

static double cpu_ms(void) // all threads
{
    struct rusage u;
    getrusage(RUSAGE_SELF, &u);
    return 1e3 * (double)(u.ru_utime.tv_sec + u.ru_stime.tv_sec) +
           1e-3 * (double)(u.ru_utime.tv_usec + u.ru_stime.tv_usec);
}

struct scene {
    struct groom *groom;
    struct params params;
    struct strands strands;
    struct truth truth;
    struct crossings crossings;
    struct crossings_result *result;
    int resolution;
    double grid_ms, lists_ms, sweep_ms;
};

static void list(const char *name, const double *x, int n)
{
    printf(",\"%s\":[", name);
    for (int i = 0; i < n; i++)
        printf("%s%.4f", i ? "," : "", x[i]);
    printf("]");
}

static void line(struct scene *s, const char *method, int near_rays, double ms)
{
    const struct truth_errors e = truth_compare(&s->truth, s->result);
    struct crossings_stats st;
    crossings_read_stats(&s->crossings, &st);
    const double lookups = (double)s->truth.places * TRUTH_LIGHTS;
    printf("{\"groom\":\"%s\",\"method\":\"%s\",\"resolution\":%d,\"rays\":%d",
           s->groom->name, method, s->resolution, near_rays);
    printf(",\"places\":%d,\"lights\":%d,\"truth_rays\":%d", s->truth.places,
           TRUTH_LIGHTS, rays);
    printf(",\"clear\":%.4f,\"p95\":%.4f,\"bias\":%.4f,\"visible\":%.4f,"
           "\"interior\":%.4f,\"sky\":%.4f,\"noise\":%.4f",
           e.clear, e.p95, e.bias, e.visible, e.interior, e.sky, e.noise);
    list("class_mean", e.class_mean, 3);
    list("class_p95", e.class_p95, 3);
    list("forward", e.forward, 4);
    list("forward_bias", e.forward_bias, 4);
    printf(",\"ways\":%d,\"grid_ms\":%.1f,\"lists_ms\":%.1f,\"sweep_ms\":%.1f,"
           "\"lookup_us\":%.3f,\"field_mb\":%.2f,\"lists_mb\":%.2f}\n",
           st.ways, s->grid_ms, near_rays > 0 ? s->lists_ms : 0, s->sweep_ms,
           1e3 * ms / lookups,
           1e-6 * (double)(st.grid_bytes + st.ways_bytes + st.map_bytes),
           near_rays > 0 ? 1e-6 * (double)st.lists_bytes : 0);
    fflush(stdout);
}

static void measure(struct scene *s, const char *method, int near_rays)
{
    struct error err = {0};
    struct crossings_probe_run run = {
        .crossings = &s->crossings, .strands = &s->strands, .rays = near_rays};
    for (int m = 0; m < 4; m++)
        run.attenuation[m] = (float)truth_attenuation[m];
    double ms[2];
    for (int i = 0; i < 2; i++) { // one place: what compiling takes
        const double began = cpu_ms();
        must(crossings_probe(&run, s->truth.place, i ? s->truth.places : 1,
                             TRUTH_LIGHTS, s->result, &err),
             &err);
        ms[i] = cpu_ms() - began;
    }
    line(s, method, near_rays, fmax(0, ms[1] - ms[0]));
}

static void grid(struct scene *s, bool map)
{
    struct error err = {0};
    const struct crossings_options o = {.resolution = s->resolution,
                                        .map = map ? &s->strands : NULL};
    const double began = cpu_ms();
    must(crossings_build_grid(&s->crossings, s->groom, &s->params, &o, &err),
         &err);
    s->grid_ms = cpu_ms() - began;
}

static void sweep(struct scene *s, enum crossings_quality quality)
{
    struct error err = {0};
    s->sweep_ms = INFINITY;
    // the first allocates, which counts little where there is much to do
    for (int i = 0; i < (s->resolution < 96 ? 2 : 1); i++) {
        const double began = cpu_ms();
        must(crossings_update(&s->crossings, s->truth.light, TRUTH_LIGHTS,
                              quality, &err),
             &err);
        gl.Finish();
        s->sweep_ms = fmin(s->sweep_ms, cpu_ms() - began);
    }
}

static void all_of(struct scene *s)
{
    struct error err = {0};
    grid(s, true);
    sweep(s, CROSSINGS_FINE);
    measure(s, "map", 0);
    grid(s, false);
    const double began = cpu_ms();
    must(crossings_build_lists(&s->crossings, s->groom, &s->params, &err),
         &err);
    s->lists_ms = cpu_ms() - began;
    sweep(s, CROSSINGS_COARSE);
    measure(s, "coarse", 0);
    // the 48 lights' 348 tiles of 192 voxels would take 2 GB
    const char *usual = s->resolution > 128 ? "coarse" : "fine";
    if (s->resolution <= 128) {
        sweep(s, CROSSINGS_FINE);
        measure(s, "fine", 0);
    }
    for (int r = 1; r <= CROSSINGS_RAYS_MAX; r *= 4)
        measure(s, usual, r);
}

static void bench(const char *source)
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
    for (size_t i = 0; i < sizeof resolutions / sizeof *resolutions; i++)
        if (only == 0 || only == resolutions[i]) {
            s.resolution = resolutions[i];
            all_of(&s);
        }
    crossings_finish(&s.crossings);
    strands_finish(&s.strands);
    truth_free(&s.truth);
    free(s.result);
    groom_destroy(s.groom);
}

int main(int argc, char **argv)
{
    static const char *const files[] = {"straight.hair:0.1",
                                        "amd_testhair1.hair:0.2"};
    const char *data = getenv("GLINT_DATA");
    struct error err = {0};
    struct egl *egl = egl_create(&err);
    must(egl, &err);
    int i = 1;
    for (; i + 1 < argc && argv[i][0] == '-'; i += 2) {
        int *to = strcmp(argv[i], "--rays") == 0   ? &rays
                  : strcmp(argv[i], "--only") == 0 ? &only
                                                   : &places;
        *to = atoi(argv[i + 1]);
    }
    if (i == argc)
        bench("builtin:animation");
    for (int k = 0; i == argc && k < 2; k++) {
        char source[512];
        snprintf(source, sizeof source, "%s/hair/%s",
                 data ? data : "../shared/data", files[k]);
        bench(source);
    }
    for (; i < argc; i++)
        bench(argv[i]);
    egl_destroy(egl);
    return 0;
}
