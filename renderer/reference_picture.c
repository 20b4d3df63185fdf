// reference_picture.c - a picture by rays through its pixels.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "protocol/bytes.h"
#include "renderer/camera.h"
#include "renderer/reference_private.h"
#include "renderer/shoot_threads.h"
#include "renderer/timer.h"

enum { RGBA = 4 };

struct pixel {
    double mean[RGBA], m2[RGBA];
};

struct view {
    const struct reference *s;
    const struct reference_paths *how;
    struct camera camera;
    int width, height, sample;
    struct pixel *pixel;
};

// The R2 sequence (M. Roberts 2018), shifted for each pixel.
static void within(struct reference_random *random, int k, double out[2])
{
    const double g = 1.32471795724474602596;
    const double x = reference_random_next(random) + k / g;
    const double y = reference_random_next(random) + k / (g * g);
    out[0] = x - floor(x);
    out[1] = y - floor(y);
}

// Through a place of the picture (0..1 from its top left corner), from the near
// plane on.
static void camera_ray(const struct view *v, double x, double y,
                       struct shoot_ray *ray)
{
    const struct camera *c = &v->camera;
    const double tall = (double)c->tan_half, wide = tall * v->width / v->height;
    double n = 0;
    for (int k = 0; k < 3; k++) {
        ray->direction[k] = (double)c->forward[k] +
                            (2 * x - 1) * wide * (double)c->right[k] +
                            (1 - 2 * y) * tall * (double)c->up[k];
        n += ray->direction[k] * ray->direction[k];
        ray->origin[k] =
            (double)c->eye[k] + (double)c->near * ray->direction[k];
    }
    for (int k = 0; k < 3; k++)
        ray->direction[k] /= sqrt(n);
    ray->reach = INFINITY;
    ray->segment = UINT32_MAX;
}

// The ribbon that a ray meets; one of opacity o with chance o.
static bool see(const struct view *v, struct shoot_ray *ray,
                struct reference_random *random, struct reference_vertex *out)
{
    for (;;) {
        uint32_t segment;
        double along;
        const double t = shoot_first(v->s->shoot, ray, &segment, &along);
        if (segment == UINT32_MAX)
            return false;
        struct shoot_point at;
        shoot_point(v->s->shoot, segment, along, &at);
        if (at.opacity >= 1 || reference_random_next(random) < at.opacity) {
            const double back[3] = {-ray->direction[0], -ray->direction[1],
                                    -ray->direction[2]};
            reference_vertex_of(v->s, segment, along, back, out);
            return true;
        }
        reference_ray_past(ray, segment, t);
    }
}

static void take(struct pixel *p, int n, const double x[RGBA])
{
    for (int k = 0; k < RGBA; k++) {
        const double off = x[k] - p->mean[k];
        p->mean[k] += off / n;
        p->m2[k] += off * (x[k] - p->mean[k]);
    }
}

static void row(void *context, size_t y)
{
    const struct view *v = context;
    for (int x = 0; x < v->width; x++) {
        const size_t at = y * (size_t)v->width + (size_t)x;
        struct reference_random random, shift;
        struct shoot_ray ray;
        struct reference_vertex vertex;
        double rgba[RGBA] = {0}, in[2];
        reference_random_begin(&shift, v->how->seed, at, UINT64_MAX);
        reference_random_begin(&random, v->how->seed, at, (uint64_t)v->sample);
        within(&shift, v->sample, in);
        camera_ray(v, (x + in[0]) / v->width, ((double)y + in[1]) / v->height,
                   &ray);
        if (see(v, &ray, &random, &vertex)) {
            struct reference_walk w = {.scene = v->s,
                                       .flags = v->how->flags,
                                       .events = v->how->events,
                                       .random = random};
            reference_walk_run(&w, &vertex);
            for (int n = 0; n < REFERENCE_BOUNCES; n++)
                for (int c = 0; c < 3; c++)
                    rgba[c] += w.bounce[n][c];
            rgba[3] = 1;
        }
        take(&v->pixel[at], v->sample + 1, rgba);
    }
}

bool reference_picture_fits(const struct params *p, int samples,
                            struct error *err)
{
    const uint64_t pixels =
        (uint64_t)p->image.width * (uint64_t)p->image.height;
    if (pixels > REFERENCE_PIXELS_MAX)
        return error_set(err, "limit", "image",
                         "image: %d x %d pixels are more than the %d that a "
                         "reference is made for",
                         p->image.width, p->image.height, REFERENCE_PIXELS_MAX);
    if (pixels * (uint64_t)samples > REFERENCE_PATHS_MAX)
        return error_set(err, "limit", "samples",
                         "%d samples of %d x %d pixels are %llu paths, more "
                         "than the %llu that are allowed: at most %llu samples",
                         samples, p->image.width, p->image.height,
                         (unsigned long long)pixels *
                             (unsigned long long)samples,
                         (unsigned long long)REFERENCE_PATHS_MAX,
                         (unsigned long long)(REFERENCE_PATHS_MAX / pixels));
    return true;
}

static void settle(const struct view *v, float *rgba, float *variance)
{
    const double n = v->sample;
    const size_t pixels = (size_t)v->width * (size_t)v->height;
    for (size_t i = 0; i < pixels; i++)
        for (int k = 0; k < RGBA; k++) {
            const struct pixel *p = &v->pixel[i];
            rgba[RGBA * i + (size_t)k] = (float)p->mean[k];
            variance[RGBA * i + (size_t)k] =
                n > 1 ? (float)(p->m2[k] / (n * (n - 1))) : INFINITY;
        }
}

static bool tell(const struct reference_paths *how, int done, double began)
{
    if (!how->progress)
        return true;
    const struct reference_progress p = {
        .share = (double)done / how->samples,
        .seconds_left = (timer_now() - began) * (how->samples - done) / done,
        .samples = done};
    return how->progress(how->self, &p);
}

bool reference_picture(const struct reference *s,
                       const struct reference_paths *how, float *rgba,
                       float *variance, int *samples, struct error *err)
{
    const struct params *p = &s->params;
    if (!reference_picture_fits(p, how->samples, err))
        return false;
    const double began = timer_now();
    struct view v = {
        .s = s, .how = how, .width = p->image.width, .height = p->image.height};
    camera_resolve(p, s->box_min, s->box_max, &v.camera);
    v.pixel = bytes_zalloc((size_t)v.width * (size_t)v.height, sizeof *v.pixel);
    bool on = true;
    while (on && v.sample < how->samples) {
        shoot_threads((size_t)v.height, row, &v);
        v.sample++;
        on = tell(how, v.sample, began);
    }
    settle(&v, rgba, variance);
    *samples = v.sample;
    free(v.pixel);
    return true;
}
