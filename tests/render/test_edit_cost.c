// What an edit costs, in numbers that are the same on every machine: stages
// that run, dispatches, draws, bytes sent to the GPU, memory and programs asked
// for; and ratios of processor time within one run.  No time by itself.
#include "tests/check.h"
#include "tests/render/scene.h"

#include <stdlib.h>
#include <time.h>

#include "renderer/metric.h"

// --- one edit ----------------------------------------------------------------

struct cost {
    char stages[200];
    struct gl_counts work;
    double cpu; // ms of the whole process
};

static double cpu_ms(void)
{
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return 1e3 * (double)t.tv_sec + 1e-6 * (double)t.tv_nsec;
}

// The first sample of *p, as it is displayed.
static struct cost frame(struct renderer *r, const struct params *p)
{
    struct cost c = {.cpu = cpu_ms()};
    struct renderer_stats s;
    struct error err = {0};
    struct buf pixels = {0};
    bool done;
    renderer_set_params(r, p);
    if (!renderer_step(r, &done, &err) ||
        !renderer_read_display(r, &pixels, &err)) {
        printf("  %s\n", err.text);
        exit(1);
    }
    buf_finish(&pixels);
    c.cpu = cpu_ms() - c.cpu;
    renderer_stats(r, &s);
    c.work = s.work;
    for (int i = 0; i < RENDERER_STAGES; i++)
        if (s.stage_ms[i] >= 0) {
            strcat(c.stages, c.stages[0] ? " " : "");
            strcat(c.stages, renderer_stage_names[i]);
        }
    return c;
}

// Edit number k of a kind, each other than the one before.
static void exposure(struct params *p, int k)
{
    p->view.exposure = 0.1f * (float)(k + 1);
}
static void colour(struct params *p, int k)
{
    p->tint.colour[1] = 0.9f - 0.01f * (float)k;
}
static void absorption(struct params *p, int k)
{
    p->fibre.sigma_a[0] = 0.2f + 0.01f * (float)k;
}
static void width(struct params *p, int k)
{
    p->fibre.beta_r = 7 + 0.1f * (float)k;
}
static void shift(struct params *p, int k)
{
    p->fibre.alpha_trt = 10 + 0.1f * (float)k;
}
static void density(struct params *p, int k)
{
    p->fibre.d_f = 0.9f - 0.01f * (float)k;
}
static void turn(struct params *p, int k)
{
    p->light.yaw = 3 + 2 * (float)k;
}
static void zoom(struct params *p, int k)
{
    p->camera.fov = 25 + 0.1f * (float)k;
}

// What such an edit was measured to ask for.  How much a stage needs is its
// room's affair, so twice that is let pass; beyond, a number here is raised
// only by who says why.
// (Of an absorption edit's and a camera's a good half are of one thread, before
// each program that reads buffer textures: program_use.)
static const struct kind {
    const char *name;
    void (*edit)(struct params *p, int k);
    const char *stages;
    uint64_t dispatches, upload_bytes, allocations;
    bool by_hair; // the hair itself decides how much: no limit
} kinds[] = {
    {"display exposure", exposure, "display read", 1, 1488, 0, false},
    {"light colour", colour, "tint display read", 1, 1488, 0, false},
    {"absorption", absorption, "fibre shade resolve display read", 17, 115728,
     0, false},
    {"width of a lobe", width, "fibre shade resolve display read", 13, 82896, 0,
     false},
    {"shift of a lobe", shift, "fibre shade resolve display read", 13, 78864, 0,
     false},
    {"density", density, "fibre shade resolve display read", 5, 2976, 0, false},
    {"sky rotation", turn,
     "light tint crossings shadow shade resolve display read", 231, 2394528, 1,
     true},
    {"camera", zoom, "visible shadow shade resolve display read", 33, 1920, 0,
     true},
};
enum { ABSORPTION = 2, SHIFT = 4, DENSITY = 5 };
enum { KINDS = sizeof kinds / sizeof kinds[0] };

static void base(struct params *p)
{
    scene_shadowed(p, 1, 0, 40);
}

// The third edit of a kind: the first ones may make what is kept.
static struct cost settled(struct renderer *r, const struct params *start,
                           const struct kind *k)
{
    struct params p = *start;
    struct cost c = {.cpu = 0};
    for (int i = 0; i < 3; i++) {
        k->edit(&p, i);
        c = frame(r, &p);
    }
    frame(r, start);
    return c;
}

// --- counts ------------------------------------------------------------------

static void limits(const struct kind *k, const struct cost *c)
{
    char name[96];
    snprintf(name, sizeof name, "%s: stages, dispatches, bytes", k->name);
    check_case(name);
    printf("  %s: %llu dispatches, %llu draws, %llu uploads of %llu bytes, "
           "%llu allocations\n",
           k->name, (unsigned long long)c->work.dispatches,
           (unsigned long long)c->work.draws,
           (unsigned long long)c->work.uploads,
           (unsigned long long)c->work.upload_bytes,
           (unsigned long long)c->work.allocations);
    CHECK_STR(c->stages, k->stages);
    CHECK_ATMOST(c->work.dispatches, 2 * k->dispatches);
    CHECK_ATMOST(c->work.upload_bytes, 2 * k->upload_bytes);
    CHECK(c->work.programs == 0); // no edit waits for a compiler
    CHECK_ATMOST(c->work.allocations, 2 * k->allocations);
    if (strcmp(k->name, "camera") != 0)
        CHECK(c->work.draws == 0); // what pixels see is kept
}

static bool same_work(const struct gl_counts *a, const struct gl_counts *b)
{
    return a->dispatches == b->dispatches && a->draws == b->draws &&
           a->uploads == b->uploads && a->upload_bytes == b->upload_bytes;
}

// The same edits of more hair, of more pixels: nothing more is asked for.
static void growth(const struct cost *few, struct renderer *r,
                   const struct params *p, const char *of)
{
    char name[96];
    frame(r, p);
    for (int i = 0; i < KINDS; i++) {
        const struct cost c = settled(r, p, &kinds[i]);
        if (kinds[i].by_hair)
            continue;
        snprintf(name, sizeof name, "%s asks for the same with %s",
                 kinds[i].name, of);
        check_case(name);
        CHECK(same_work(&c.work, &few[i].work));
    }
}

static void counts(void)
{
    struct params p;
    struct cost few[KINDS];
    base(&p);
    struct renderer *r =
        scene_renderer(scene_lock(40, 10), scene_two_lamps(), &p);
    frame(r, &p);
    for (int i = 0; i < KINDS; i++) {
        few[i] = settled(r, &p, &kinds[i]);
        limits(&kinds[i], &few[i]);
        const struct cost again = settled(r, &p, &kinds[i]);
        CHECK(same_work(&few[i].work, &again.work));
    }
    // Absorption changes cross sections, a shift what lights make of them, the
    // density only what places do with that.
    check_case("an edit makes the tables that it touches, no others");
    CHECK(few[ABSORPTION].work.dispatches > few[SHIFT].work.dispatches &&
          few[SHIFT].work.dispatches > few[DENSITY].work.dispatches);
    CHECK(few[ABSORPTION].work.upload_bytes > few[SHIFT].work.upload_bytes &&
          few[SHIFT].work.upload_bytes > few[DENSITY].work.upload_bytes);
    check_case("nothing changed: as much as the display alone");
    struct cost none = frame(r, &p);
    CHECK_STR(none.stages, "display read");
    CHECK(same_work(&none.work, &few[0].work));
    renderer_destroy(r);
    r = scene_renderer(scene_lock(400, 30), scene_two_lamps(), &p);
    growth(few, r, &p, "30 times the strand points");
    p.image.width *= 3;
    p.image.height *= 3;
    growth(few, r, &p, "9 times the pixels as well");
    renderer_destroy(r);
}

// --- ratios ------------------------------------------------------------------

enum { RUNS = 5 };

// Everything but the strands and the fit.
static void everything(struct params *p, int k)
{
    turn(p, k);
    zoom(p, k);
    absorption(p, k);
}

enum { WHOLE, FIBRE, TINT, VIEW, SKY, CAMERA, SHARES };
static void (*const shares[SHARES])(struct params *p, int k) = {
    everything, absorption, colour, exposure, turn, zoom};

// Medians of the processors' ms.  One kind after the other and over again, so
// that what else the machine does meets all of them.
static void medians(struct renderer *r, struct params *p, double out[SHARES])
{
    double ms[SHARES][RUNS];
    int step = 0;
    for (int k = -1; k < RUNS; k++) // the first is not counted
        for (int i = 0; i < SHARES; i++) {
            shares[i](p, step++);
            ms[i][k < 0 ? 0 : k] = frame(r, p).cpu;
        }
    for (int i = 0; i < SHARES; i++)
        out[i] = metric_quantile(ms[i], RUNS, 0.5);
}

static void ratios(void)
{
    struct params p;
    struct error err = {0};
    params_defaults(&p);
    p.image.width = 360;
    p.image.height = 240;
    p.quality.samples = 1;
    p.shadow.rays = 0;
    p.sky.lights = 20;
    struct renderer *r =
        scene_renderer(groom_builtin("ponytail", &err), scene_two_lamps(), &p);
    frame(r, &p);
    double ms[SHARES];
    medians(r, &p, ms);
    const double whole = ms[WHOLE];
    printf("  of a whole frame: fibre %.3f, colour %.3f, display %.3f, sky "
           "%.3f, camera %.3f\n",
           ms[FIBRE] / whole, ms[TINT] / whole, ms[VIEW] / whole,
           ms[SKY] / whole, ms[CAMERA] / whole);
    // Measured: .05, .006, .006, .9, .11, on a machine six times overbooked
    // .08, .012, .011, 1.28, .15.  A whole frame is mostly shadows, which may
    // become cheaper, so the limits are several times that; sky and camera are
    // parts of it.
    check_case("an edit takes its share of a whole frame, not more");
    CHECK_ATMOST(ms[FIBRE], 0.4 * whole);
    CHECK_ATMOST(ms[TINT], 0.1 * whole);
    CHECK_ATMOST(ms[VIEW], 0.1 * whole);
    CHECK_ATMOST(ms[SKY], 2 * whole);
    CHECK_ATMOST(ms[CAMERA], 0.8 * whole);
    // Colour is a factor of the whole where no sun shines, .12 of a fibre edit.
    CHECK_ATMOST(ms[TINT], 0.6 * ms[FIBRE]);
    renderer_destroy(r);
}

int main(int argc, char **argv)
{
    sky_helper_main(argc, argv);
    counts();
    ratios();
    return check_end();
}
