// frames_scene.c - see the header.  A picture shows 96 x 64 units.
#include "tests/extremes/frames_scene.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "protocol/bytes.h"
#include "renderer/sky_clean.h"
#include "tests/numeric/cases.h"
#include "tests/render/scene.h"

#define PI 3.14159265358979323846

enum {
    ZERO_SEGMENTS,
    ONE_POINT,
    TWO_POINTS,
    MANY_POINTS,
    NEEDLE,
    HAIRPIN,
    ONE_VOXEL,
    CAMERA_INSIDE,
    SPARSE,
    CHAOTIC,
    CLEAR,
    SHADOW_EDGE,
    HUGE_UNITS,
    TINY_UNITS
};
const char *const frames_hair_names[FRAMES_HAIRS] = {
    "every other segment of no length",
    "all points of a strand in one place",
    "one strand of two points",
    "a strand of 65,535 points",
    "needles, a hundred-thousandth as thick as long",
    "hairpins: the way back on the way there",
    "all strands but one in one voxel",
    "the camera inside the hair",
    "sparse hair: seven strands",
    "chaotic hair: every segment another way",
    "hair that absorbs next to nothing",
    "a hard shadow edge across the hair",
    "a million units a centimetre",
    "a millionth of a unit a centimetre"};

enum { GREY, DIM, BRIGHT, PIXEL, BLACK, LAMPS, BROKEN, BOARD, MANY };
const char *const frames_sky_names[FRAMES_SKIES] = {
    "grey",
    "1e-9 everywhere",
    "1e6 everywhere",
    "one pixel of 1e8 in the dark, one light",
    "black",
    "two lamps",
    "NaN, infinite and negative pixels",
    "a chequerboard of 0 and 1e6",
    "two lamps, fifty and two hundred lights"};

// --- hair -------------------------------------------------------------------
static void box(struct groom *g)
{
    for (int c = 0; c < 3; c++) {
        g->box_min[c] = INFINITY;
        g->box_max[c] = -INFINITY;
        for (uint32_t i = 0; i < g->points; i++) {
            float v = g->position[3 * i + (unsigned)c];
            g->box_min[c] = fminf(g->box_min[c], v);
            g->box_max[c] = fmaxf(g->box_max[c], v);
        }
    }
}

static void spiral(struct groom *g)
{
    for (uint32_t i = 0; i < g->points; i++) {
        double t = (double)i / g->points, a = 400 * t;
        float *p = g->position + 3 * (size_t)i;
        p[0] = (float)(30 * t * cos(a));
        p[1] = (float)(4 * sin(7 * t));
        p[2] = (float)(30 * t * sin(a));
    }
}

static void scatter(struct groom *g, int which)
{
    uint64_t s = 5;
    uint32_t per = g->points / g->strands;
    for (uint32_t i = 0; i < g->points; i++) {
        float *p = g->position + 3 * (size_t)i, *q = p - 3;
        bool far = which == ONE_VOXEL && i < per;
        for (int c = 0; c < 3; c++) {
            double r = cases_uniform(&s, -1, 1);
            if (which == CHAOTIC)
                p[c] = (float)(25 * r);
            else if (which == ONE_VOXEL && !far)
                p[c] = (float)(0.05 * r);
        }
        if (which == ZERO_SEGMENTS && i % 2)
            memcpy(p, q, 3 * sizeof *p);
        if (which == ONE_POINT)
            memcpy(p, g->position + 3 * (size_t)(i - i % per), 3 * sizeof *p);
        if (which == HAIRPIN && i % per > per / 2)
            memcpy(p,
                   g->position + 3 * (size_t)(i - i % per + per - 1 - i % per),
                   3 * sizeof *p);
        if (which == SHADOW_EDGE) // a wall, and one strand in five behind it
            p[1] = i / per % 5 ? 0 : 25;
    }
}

static void scale(struct groom *g, float by)
{
    for (size_t i = 0; i < 3 * (size_t)g->points; i++)
        g->position[i] *= by;
    for (int c = 0; c < 3; c++) {
        g->head.centre[c] *= by;
        g->head.radius[c] *= by;
    }
}

struct groom *frames_hair(int which)
{
    struct groom *g = NULL;
    switch (which) {
    case TWO_POINTS:
        g = scene_fan(1, 2, 40, 1);
        break;
    case MANY_POINTS:
        g = scene_fan(1, 65535, 40, 1);
        spiral(g);
        break;
    case NEEDLE:
        g = scene_fan(12, 2, 1e4f, 6);
        break;
    case SPARSE:
        g = scene_fan(7, 3, 30, 12);
        break;
    case SHADOW_EDGE:
        g = scene_fan(300, 4, 40, 1.5f);
        break;
    default:
        g = scene_lock(60, 12);
    }
    scatter(g, which);
    if (which == HUGE_UNITS)
        scale(g, 1e6f);
    if (which == TINY_UNITS)
        scale(g, 1e-6f);
    box(g);
    return g;
}

// --- skies ------------------------------------------------------------------
struct sky_map *frames_sky(int which)
{
    if (which == LAMPS || which == MANY)
        return scene_two_lamps();
    struct sky_map *m = scene_constant_sky(which == DIM      ? 1e-9f
                                           : which == BRIGHT ? 1e6f
                                           : which == GREY   ? 1
                                                             : 0);
    for (int i = 0; i < m->width * m->height; i++) {
        int x = i % m->width, y = i / m->width;
        float *v = m->rgb + 3 * i;
        for (int c = 0; c < 3; c++)
            if (which == BOARD)
                v[c] = (x / 4 + y / 4) % 2 ? 1e6f : 0;
            else if (which == BROKEN)
                v[c] = i % 7 == 0    ? NAN
                       : i % 31 == 0 ? INFINITY
                       : i % 5 == 0  ? -1
                                     : 0.5f;
    }
    if (which == PIXEL)
        m->rgb[3 * (8 * m->width + 40)] = 1e8f;
    if (which == BROKEN)
        sky_clean_run(m->rgb, m->width, m->height, &m->cleaned);
    return m;
}

void frames_adapt(struct params *p, int hair, int sky)
{
    const float unit = hair == HUGE_UNITS   ? 1e-6f
                       : hair == TINY_UNITS ? 1e6f
                                            : 1;
    if (unit != 1) { // hair.scale goes to 1e-4 and 1e4
        p->hair.scale = unit < 1 ? 1e-4f : 1e4f;
        p->hair.diameter = 0;
        for (int c = 0; c < 3; c++)
            p->camera.eye[c] = p->camera.target[c] = NAN;
    }
    if (hair == NEEDLE)
        p->hair.diameter = 0.1f;
    if (hair == TWO_POINTS) // as wide as a pixel: two samples may miss less
        p->hair.diameter = 4;
    if (hair == CAMERA_INSIDE) {
        memcpy(p->camera.eye, (float[3]){11, 0, 0}, 12);
        memcpy(p->camera.target, (float[3]){12, 3, 1}, 12);
        p->camera.fov = 120;
    }
    if (hair == ONE_VOXEL) {
        memcpy(p->camera.eye, (float[3]){0, -0.3f, 0}, 12);
        p->hair.diameter = 0.002f;
    }
    if (hair == CLEAR)
        memset(p->fibre.sigma_a, 0, sizeof p->fibre.sigma_a);
    if (hair == SHADOW_EDGE) {
        p->sun1.strength = 1e5f;
        p->sun1.azimuth = 3;
        p->sun1.elevation = 0.5f;
    }
    if (sky == PIXEL)
        p->sky.lights = 1;
    if (sky == MANY) {
        p->sky.lights = hair % 4 ? 50 : 200; // a fit of 200 takes seconds
        p->quality.light_bound = 0;
    }
}
