#include "tests/render/scene.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static struct groom *empty(int strands, int points)
{
    struct groom *g = bytes_zalloc(1, sizeof *g);
    snprintf(g->name, sizeof g->name, "test");
    g->strands = (uint32_t)strands;
    g->points = (uint32_t)(strands * points);
    g->first = bytes_zalloc((size_t)strands + 1, sizeof *g->first);
    g->position = bytes_zalloc((size_t)g->points * 3, sizeof *g->position);
    for (int k = 0; k <= strands; k++)
        g->first[k] = (uint32_t)(k * points);
    g->default_opacity = 1;
    for (int c = 0; c < 3; c++)
        g->default_colour[c] = 1;
    g->up = 2;
    return g;
}

static void box(struct groom *g)
{
    for (int c = 0; c < 3; c++) {
        g->box_min[c] = INFINITY;
        g->box_max[c] = -INFINITY;
        for (uint32_t i = 0; i < g->points; i++) {
            g->box_min[c] =
                fminf(g->box_min[c], g->position[3 * i + (unsigned)c]);
            g->box_max[c] =
                fmaxf(g->box_max[c], g->position[3 * i + (unsigned)c]);
        }
    }
}

struct groom *scene_fan(int strands, int points, float length, float spacing)
{
    struct groom *g = empty(strands, points);
    int row = (int)ceil(sqrt(strands * 1.5));
    for (int k = 0; k < strands; k++) {
        double a = M_PI * (k + 0.37) / strands;
        double x = (k % row - (row - 1) * 0.5) * spacing + 0.21 * (k % 5);
        double z = (k / row - (strands / row - 1) * 0.5) * spacing;
        for (int i = 0; i < points; i++) {
            double t = length * ((double)i / (points - 1) - 0.5);
            float *p = g->position + 3 * (k * points + i);
            p[0] = (float)(x + t * cos(a));
            p[2] = (float)(z + t * sin(a));
        }
    }
    box(g);
    return g;
}

struct groom *scene_fan_opacity(int strands, float opacity)
{
    struct groom *g = scene_fan(strands, 4, 12, 14);
    g->opacity = bytes_zalloc(g->points, sizeof *g->opacity);
    for (uint32_t i = 0; i < g->points; i++)
        g->opacity[i] = opacity;
    return g;
}

struct groom *scene_lock(int strands, int points)
{
    struct groom *g = empty(strands, points);
    for (int k = 0; k < strands; k++)
        for (int i = 0; i < points; i++) {
            double t = (double)i / (points - 1), a = 2.4 * k, r = 12 + k % 7;
            float *p = g->position + 3 * (k * points + i);
            p[0] = (float)(r * cos(a) * (0.6 + 0.4 * t) + 6 * sin(3 * t + k));
            p[1] = (float)(r * sin(a) * (0.6 + 0.4 * t));
            p[2] = (float)(22 - 44 * t + 4 * cos(a + 2 * t));
        }
    g->head.present = true;
    for (int c = 0; c < 3; c++)
        g->head.radius[c] = 9;
    box(g);
    return g;
}

struct groom *scene_lock_tinted(int strands, int points)
{
    struct groom *g = scene_lock(strands, points);
    g->opacity = bytes_zalloc(g->points, sizeof *g->opacity);
    g->colour = bytes_zalloc(3 * (size_t)g->points, sizeof *g->colour);
    for (uint32_t i = 0; i < g->points; i++) {
        g->opacity[i] = 0.4f + 0.05f * (float)(i % 10);
        for (unsigned c = 0; c < 3; c++)
            g->colour[3 * i + c] = 0.2f + 0.1f * (float)((i + c) % 7);
    }
    return g;
}

void scene_turn(struct groom *g, float degrees)
{
    double c = cos(degrees * M_PI / 180), s = sin(degrees * M_PI / 180);
    for (uint32_t i = 0; i < g->points; i++) {
        float *p = g->position + 3 * (size_t)i;
        double x = p[0], y = p[1];
        p[0] = (float)(c * x - s * y);
        p[1] = (float)(s * x + c * y);
    }
    box(g);
}

static struct sky_map *map(void)
{
    struct sky_map *m = bytes_zalloc(1, sizeof *m);
    snprintf(m->name, sizeof m->name, "test");
    m->width = 64;
    m->height = 32;
    m->rgb = bytes_zalloc(3 * 64 * 32, sizeof *m->rgb);
    return m;
}

struct sky_map *scene_constant_sky(float radiance)
{
    struct sky_map *m = map();
    for (int i = 0; i < 3 * 64 * 32; i++)
        m->rgb[i] = radiance;
    return m;
}

struct sky_map *scene_two_lamps(void)
{
    struct sky_map *m = map();
    for (int y = 0; y < 32; y++)
        for (int x = 0; x < 64; x++) {
            float *p = m->rgb + 3 * (64 * y + x);
            bool warm = abs(x - 50) < 3 && abs(y - 8) < 3;
            bool cool = abs(x - 12) < 4 && abs(y - 14) < 4;
            p[0] = 0.2f + 20 * (float)warm + 2 * (float)cool;
            p[1] = 0.2f + 14 * (float)warm + 4 * (float)cool;
            p[2] = 0.25f + 6 * (float)warm + 8 * (float)cool;
        }
    return m;
}

void scene_params(struct params *p)
{
    params_defaults(p);
    p->image.width = 96;
    p->image.height = 64;
    p->quality.samples = 4;
    p->sky.lights = 8;
    p->shadow.method = 0; // coverage needs no shadows; who does turns it on
    p->camera.fov = 20;
    const float far = 32 / tanf(10 * (float)M_PI / 180);
    memcpy(p->camera.eye, (float[3]){0, -far, 0}, 12);
    memcpy(p->camera.target, (float[3]){0, 0, 0}, 12);
}

void scene_shadowed(struct params *p, int samples, int rays, int resolution)
{
    scene_params(p);
    p->hair.diameter = 0.6f;
    p->quality.samples = samples;
    p->shadow.method = 1;
    p->shadow.rays = rays;
    p->shadow.resolution = resolution;
}

static void must(bool ok, const struct error *err)
{
    if (!ok) {
        printf("not ok scene: %s\n", err->text);
        exit(1);
    }
}

struct renderer *scene_renderer(struct groom *g, struct sky_map *m,
                                const struct params *p)
{
    struct error err = {0};
    struct renderer *r = renderer_create(NULL, &err);
    must(r != NULL, &err);
    renderer_set_params(r, p);
    must(renderer_set_groom(r, g, &err), &err);
    must(renderer_set_sky(r, m, &err), &err);
    return r;
}

bool scene_finish(struct renderer *r)
{
    struct error err = {0};
    bool done = false;
    while (!done)
        must(renderer_step(r, &done, &err), &err);
    return true;
}

struct buf scene_linear(struct renderer *r)
{
    struct error err = {0};
    struct buf b = {0};
    scene_finish(r);
    must(renderer_read_linear(r, &b, &err), &err);
    return b;
}

struct buf scene_display(struct renderer *r)
{
    struct error err = {0};
    struct buf b = {0};
    scene_finish(r);
    must(renderer_read_display(r, &b, &err), &err);
    return b;
}

static const float *floats(const struct buf *b)
{
    return (const float *)(const void *)b->data;
}

double scene_sum(const struct buf *linear, int channel)
{
    double sum = 0;
    for (size_t i = (size_t)channel; i < linear->size / 4; i += 4)
        sum += floats(linear)[i];
    return sum;
}

double scene_difference(const struct buf *a, const struct buf *b)
{
    double difference = 0, all = 0;
    if (a->size != b->size)
        return INFINITY;
    for (size_t i = 0; i < a->size / 4; i++)
        if (i % 4 != 3) {
            difference += fabs(floats(a)[i] - floats(b)[i]);
            all += fabs(floats(b)[i]);
        }
    return difference / all;
}

bool scene_same(const struct buf *a, const struct buf *b)
{
    return a->size == b->size && memcmp(a->data, b->data, a->size) == 0;
}
