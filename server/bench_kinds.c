// bench_kinds.c - the tables, and how each kind changes parameters.
#include "server/bench_kinds.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

// By little, to and fro, never the same twice running, never nothing.
static float by(int k)
{
    return 0.01f * (float)(1 + k % 7) * (k % 2 ? -1.0f : 1.0f);
}

// --- fibre -------------------------------------------------------------------

const char *const bench_kinds_fibre[BENCH_KINDS_FIBRE + 1] = {
    "eta",    "sigma_a", "alpha_r",  "alpha_tt", "alpha_trt",
    "beta_r", "beta_tt", "beta_trt", "w_c",      "delta_eta",
    "d_f",    "d_b",     NULL};

// Fisher and Yates; each round of twelve anew, by a seed of its own.
int bench_kinds_fibre_at(int k)
{
    int order[BENCH_KINDS_FIBRE];
    uint64_t state = 2011 + (uint64_t)(k / BENCH_KINDS_FIBRE);
    for (int i = 0; i < BENCH_KINDS_FIBRE; i++)
        order[i] = i;
    for (int i = BENCH_KINDS_FIBRE - 1; i > 0; i--) {
        state = state * 6364136223846793005u + 1442695040888963407u;
        const int other = (int)((state >> 33) % (uint64_t)(i + 1));
        const int kept = order[i];
        order[i] = order[other];
        order[other] = kept;
    }
    return order[k % BENCH_KINDS_FIBRE];
}

// What `auto` comes to (params.def).
static double automatic(const struct params *p, const char *name)
{
    const double alpha = (double)p->fibre.alpha_r;
    const double beta = (double)p->fibre.beta_r;
    return strcmp(name, "alpha_tt") == 0    ? -alpha / 2
           : strcmp(name, "alpha_trt") == 0 ? -1.5 * alpha
           : strcmp(name, "beta_tt") == 0   ? beta / 2
                                            : 2 * beta;
}

void bench_kinds_any_fibre(const void *self, struct params *p, int k)
{
    char name[40] = "fibre.";
    const char *own = bench_kinds_fibre[bench_kinds_fibre_at(k)];
    (void)self;
    strcat(name, own);
    const struct params_row *row = params_find(name, strlen(name));
    for (int c = 0; row && c < row->count; c++) {
        double v = params_get(p, row, c);
        if (isnan(v))
            v = automatic(p, own);
        const double more = v != 0 ? (double)by(k) * v : 0.01;
        v = v + more > row->max || v + more < row->min ? v - more : v + more;
        params_put(p, row, c, v);
    }
}

static void absorption(const void *self, struct params *p, int k)
{
    (void)self;
    for (int c = 0; c < 3; c++)
        p->fibre.sigma_a[c] = p->fibre.sigma_a[c] * (1 + by(k)) + 0.001f;
}

// --- light, view, camera -----------------------------------------------------

static void colour(const void *self, struct params *p, int k)
{
    (void)self;
    p->tint.colour[k % 3] *= 1 + by(k);
}
static void intensity(const void *self, struct params *p, int k)
{
    (void)self;
    p->tint.exposure += 3 * by(k);
}
static void turn(const void *self, struct params *p, int k)
{
    (void)self;
    p->light.yaw += 4.0f + 7.0f * (float)(k % 13);
}
static void exposure(const void *self, struct params *p, int k)
{
    (void)self;
    p->view.exposure += 5 * by(k);
}
static void curve(const void *self, struct params *p, int k)
{
    (void)self;
    p->view.curve = k % 2 ? 0 : 1;
}
// Colour, sky and nothing in turn.
static void background(const void *self, struct params *p, int k)
{
    (void)self;
    p->view.background = k % 3;
    p->view.colour[1] += 0.01f * (float)(k % 7);
}
// The eye on a circle about the vertical through what it looks at.
static void orbit(const void *self, struct params *p, int k)
{
    const struct bench_kinds_scene *s = self;
    const float angle = (float)M_PI / 180 * (3.0f + 5.0f * (float)(k % 11)) *
                        (k % 2 ? -1.0f : 1.0f);
    const float x = s->eye[0] - s->target[0], y = s->eye[1] - s->target[1];
    memcpy(p->camera.target, s->target, sizeof s->target);
    p->camera.eye[0] = s->target[0] + cosf(angle) * x - sinf(angle) * y;
    p->camera.eye[1] = s->target[1] + sinf(angle) * x + cosf(angle) * y;
    p->camera.eye[2] = s->eye[2];
}

// --- tables ------------------------------------------------------------------

enum { M = BENCH_KINDS_MOVED, L = BENCH_KINDS_LONG, C = BENCH_KINDS_CHIEF };

// clang-format off
#define NO {NAN, NAN, NAN}
#define FIBRE_MS {45, 60, 90}
static const struct bench_kind kinds[] = {
    {"fibre parameter", "", bench_kinds_any_fibre, BENCH_WAY_EDIT,
     BENCH_EDIT_FIBRE, C, FIBRE_MS},
    {"light colour", "", colour, BENCH_WAY_EDIT,
     BENCH_EDIT_COLOUR, C, {25, 30, NAN}},
    {"light intensity", "", intensity, BENCH_WAY_EDIT,
     BENCH_EDIT_COLOUR, 0, {25, 30, NAN}},
    {"sky rotation, while dragging", "", turn, BENCH_WAY_DRAG,
     BENCH_EDIT_SKY, C, {120, 150, NAN}},
    {"sky rotation, full frame", "", turn, BENCH_WAY_EDIT,
     BENCH_EDIT_SKY, M | C, {500, 600, NAN}},
    {"sky rotation, at rest by rays", "shadow.rays=1", turn, BENCH_WAY_EDIT,
     BENCH_EDIT_SKY, M | L, {500, 600, NAN}},
    {"display exposure", "", exposure, BENCH_WAY_EDIT,
     -1, C, {8, 8, NAN}},
    {"tone curve", "", curve, BENCH_WAY_EDIT,
     -1, 0, {8, 8, NAN}},
    {"background", "", background, BENCH_WAY_EDIT,
     -1, 0, {8, 8, NAN}},
    {"camera, full frame", "", orbit, BENCH_WAY_EDIT,
     BENCH_EDIT_CAMERA, M | C, {150, 300, NAN}},
    {"first usable frame: fibre", "", absorption, BENCH_WAY_DRAG,
     BENCH_EDIT_FIBRE, C, {33, 33, NAN}},
    {"first usable frame: light colour", "", colour, BENCH_WAY_DRAG,
     BENCH_EDIT_COLOUR, 0, {33, 33, NAN}},
    {"first usable frame: sky rotation", "", turn, BENCH_WAY_DRAG,
     BENCH_EDIT_SKY, 0, {33, 33, NAN}},
    {"first usable frame: camera", "", orbit, BENCH_WAY_DRAG,
     BENCH_EDIT_CAMERA, C, {33, 33, NAN}},
    {"cold start to first frame", "", NULL, BENCH_WAY_COLD,
     -1, L | C, {1000, 2000, NAN}},
    {"fibre parameter, a = 0.9", "fibre.a=0.9", bench_kinds_any_fibre,
     BENCH_WAY_EDIT, BENCH_EDIT_FIBRE, 0, FIBRE_MS},
    {"fibre parameter, w_c = 5 deg", "fibre.w_c=5", bench_kinds_any_fibre,
     BENCH_WAY_EDIT, BENCH_EDIT_FIBRE, 0, FIBRE_MS},
    {"fibre parameter, beta_r = 3 deg", "fibre.beta_r=3",
     bench_kinds_any_fibre, BENCH_WAY_EDIT,
     BENCH_EDIT_FIBRE, 0, FIBRE_MS},
};
static const struct bench_kind file_kinds[] = {
    {"fibre parameter", "", bench_kinds_any_fibre, BENCH_WAY_EDIT,
     BENCH_EDIT_FIBRE, C, NO},
    {"light colour", "", colour, BENCH_WAY_EDIT,
     BENCH_EDIT_COLOUR, C, NO},
    {"camera, full frame", "", orbit, BENCH_WAY_EDIT,
     BENCH_EDIT_CAMERA, M | C, NO},
    {"first usable frame: fibre", "", absorption, BENCH_WAY_DRAG,
     BENCH_EDIT_FIBRE, C, NO},
};
const struct bench_paper_scene bench_kinds_paper[6] = {
    {"animation", 40, 8.3}, {"straight", 41, 5.9}, {"natural", 40, 5.8},
    {"bob", 30, 10.6},      {"dark", 36, 6.2},     {"ponytail", 42, 8.9}};
// clang-format on

const struct bench_kind *bench_kinds(int *count)
{
    *count = (int)(sizeof kinds / sizeof kinds[0]);
    return kinds;
}

const struct bench_kind *bench_kinds_file(int *count)
{
    *count = (int)(sizeof file_kinds / sizeof file_kinds[0]);
    return file_kinds;
}

int bench_kinds_scene(const char *hair)
{
    for (int i = 0; i < BENCH_KINDS_SCENES; i++)
        if (strcmp(hair, bench_kinds_paper[i].hair) == 0)
            return i;
    return -1;
}

const struct bench_paper_scene *bench_kinds_paper_of(const char *hair)
{
    for (int i = 0; i < 6; i++)
        if (strcmp(hair, bench_kinds_paper[i].hair) == 0)
            return &bench_kinds_paper[i];
    return NULL;
}
