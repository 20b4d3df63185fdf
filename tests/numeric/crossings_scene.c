#include "tests/numeric/crossings_scene.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// A check here would not count in the test's own file.
static bool must(bool ok, const struct error *err)
{
    if (!ok) {
        printf("not ok scene: %s\n", err->text);
        exit(1);
    }
    return true;
}

static struct groom *new_groom(uint32_t strands, uint32_t each, float diameter)
{
    struct groom *g = bytes_zalloc(1, sizeof *g);
    snprintf(g->name, sizeof g->name, "test");
    g->strands = strands;
    g->points = strands * each;
    g->first = bytes_zalloc((size_t)strands + 1, sizeof *g->first);
    g->position = bytes_zalloc((size_t)g->points * 3, sizeof *g->position);
    for (uint32_t k = 0; k <= strands; k++)
        g->first[k] = k * each;
    g->default_diameter = diameter;
    g->default_opacity = 1;
    g->up = 2;
    return g;
}

static void take_box(struct groom *g)
{
    for (size_t c = 0; c < 3; c++) {
        g->box_min[c] = INFINITY;
        g->box_max[c] = -INFINITY;
        for (size_t i = 0; i < g->points; i++) {
            float x = g->position[3 * i + c];
            g->box_min[c] = fminf(g->box_min[c], x);
            g->box_max[c] = fmaxf(g->box_max[c], x);
        }
    }
}

// n x n strands along z on a square lattice that fills the unit cube.
struct groom *scene_lattice(uint32_t n, float diameter)
{
    struct groom *g = new_groom(n * n, 11, diameter);
    for (uint32_t i = 0; i < g->points; i++) {
        uint32_t k = i / 11;
        g->position[3 * i] = ((float)(k % n) + 0.5f) / (float)n;
        g->position[3 * i + 1] = ((float)(k / n) + 0.5f) / (float)n;
        g->position[3 * i + 2] = (float)(i % 11) / 10;
    }
    take_box(g);
    return g;
}

// Strands that bend at random in the unit cube.
struct groom *scene_tangle(uint32_t n, float diameter)
{
    struct groom *g = new_groom(n, 12, diameter);
    uint64_t state = 9;
    for (uint32_t i = 0; i < g->points; i++)
        for (size_t c = 0; c < 3; c++)
            g->position[3 * i + c] =
                i % 12 == 0
                    ? (float)truth_uniform(&state)
                    : g->position[3 * i + c - 3] +
                          0.08f * (float)(2 * truth_uniform(&state) - 1);
    take_box(g);
    return g;
}

bool scene_open(struct scene *s, struct groom *g, int resolution)
{
    struct error err = {0};
    const struct crossings_options o = {.resolution = resolution};
    must(g != NULL, &err);
    s->groom = g;
    bool ok = strands_build(&s->strands, g, &s->params, &err) &&
              crossings_init(&s->crossings, &err) &&
              crossings_build_grid(&s->crossings, g, &s->params, &o, &err);
    return must(ok, &err);
}

void scene_close(struct scene *s)
{
    crossings_finish(&s->crossings);
    strands_finish(&s->strands);
    groom_destroy(s->groom);
    memset(s, 0, sizeof *s);
}

bool scene_aim(struct scene *s, const struct crossings_light *l, int count,
               enum crossings_quality quality)
{
    struct error err = {0};
    bool ok = crossings_update(&s->crossings, l, count, quality, &err);
    return must(ok, &err);
}

bool scene_look(struct scene *s, int rays, const struct crossings_place *p,
                int count, int lights, struct crossings_result *out)
{
    struct error err = {0};
    struct crossings_probe_run run = {
        .crossings = &s->crossings, .strands = &s->strands, .rays = rays};
    for (int m = 0; m < 4; m++)
        run.attenuation[m] = (float)truth_attenuation[m];
    bool ok = crossings_probe(&run, p, count, lights, out, &err);
    return must(ok, &err);
}

// Node number k, 0 to 1.
double scene_node(const struct crossings_result *r, int k)
{
    return (double)(r->nodes[k / 2] >> 16 * (k % 2) & 0xffff) / 65535;
}

struct crossings_light scene_light(uint64_t *state, float lambda)
{
    double z = 2 * truth_uniform(state) - 1;
    double phi = 2 * M_PI * truth_uniform(state), r = sqrt(1 - z * z);
    return (struct crossings_light){
        {(float)(r * cos(phi)), (float)(r * sin(phi)), (float)z}, lambda, 0};
}
