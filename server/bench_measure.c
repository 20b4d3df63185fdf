// bench_measure.c - asks the renderer for what a setting makes of the view, and
// compares.  The reference is bench_truth.c's, the metrics are metric.h's.
#include "server/bench_measure.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "protocol/bytes.h"
#include "protocol/edit.h"

static void words(struct params *p, const char *const *assignments)
{
    struct error err = {0};
    for (; *assignments; assignments++)
        edit_apply_text(p, *assignments, &err); // constants of this file
}

static const char *const as_shown[] = {"quality.samples=1", NULL};
static const char *const once[] = {"quality.samples=1",
                                   "render.components=single", NULL};
static const char *const once_by_rays[] = {
    "quality.samples=1", "render.components=single", "shadow.rays=16", NULL};
static const char *const once_open[] = {
    "quality.samples=1", "render.components=single", "shadow.method=off", NULL};

// Forward drawing shades fragments, so it has no radiance of a place; the same
// functions do, where they shade cells.
static const char *const directly[] = {"render.path=direct", NULL};

// Radiance of the first `count` places with some of *p set otherwise; the
// caller frees.  NULL on failure.
static double *radiance(const struct bench_view *v, const struct params *p,
                        const char *const *change, size_t count,
                        struct error *err)
{
    struct params other = *p;
    words(&other, change);
    if (bench_knobs_forward(p))
        words(&other, directly);
    double *out = bytes_alloc(3 * (count + 1) * sizeof *out);
    if (bench_time_finish(v->r, &other, NULL, err) &&
        bench_truth_radiance(v->truth, v->r, count, out, err))
        return out;
    free(out);
    return NULL;
}

double *bench_measure_places(const struct bench_view *v, const struct params *p,
                             enum bench_measure_light light, size_t count,
                             struct error *err)
{
    return radiance(v, p, light == BENCH_MEASURE_OPEN ? once_open : as_shown,
                    count, err);
}

static bool compare(const struct bench_view *v, const struct params *p,
                    const char *const *change, struct metric_pairs pairs,
                    struct metric_errors *out, struct error *err)
{
    double *x = radiance(v, p, change, pairs.count, err);
    if (!x)
        return false;
    pairs.x = x;
    metric_errors(&pairs, out);
    free(x);
    return true;
}

bool bench_measure_whole(const struct bench_view *v, const struct params *p,
                         struct metric_errors *out, struct error *err)
{
    const struct bench_truth *t = v->truth;
    const struct metric_pairs whole = {t->count, NULL, t->whole, t->variance};
    return compare(v, p, as_shown, whole, out, err);
}

// --- pictures ----------------------------------------------------------------

enum { PIXELS = BENCH_TRUTH_WIDTH * BENCH_TRUTH_HEIGHT };

static bool picture(const struct bench_view *v, const struct params *p,
                    int samples, struct buf *out, struct error *err)
{
    struct params small = *p;
    small.image.width = BENCH_TRUTH_WIDTH;
    small.image.height = BENCH_TRUTH_HEIGHT;
    small.quality.samples = samples;
    return bench_time_finish(v->r, &small, NULL, err) &&
           renderer_read_linear(v->r, out, err);
}

// Over pixels that the reference covers; variance: of r, or NULL.
static void compare_pixels(const float *x, const float *r,
                           const double *variance, struct metric_errors *out)
{
    double *pairs = bytes_zalloc(9 * PIXELS, sizeof *pairs);
    size_t n = 0;
    for (size_t i = 0; i < PIXELS; i++) {
        if (!(r[4 * i + 3] > 0))
            continue;
        for (size_t c = 0; c < 3; c++) {
            pairs[3 * n + c] = (double)x[4 * i + c];
            pairs[3 * (PIXELS + n) + c] = (double)r[4 * i + c];
            if (variance)
                pairs[3 * (2 * PIXELS + n) + c] = variance[3 * i + c];
        }
        n++;
    }
    const struct metric_pairs p = {n, pairs, pairs + 3 * PIXELS,
                                   pairs + 6 * PIXELS};
    metric_errors(&p, out);
    free(pairs);
}

static bool compare_picture(const struct bench_view *v,
                            const struct bench_setting *s,
                            struct bench_row *out, struct error *err)
{
    struct buf linear = {0};
    const struct params *p = &s->params;
    const int samples = s->flags & BENCH_KNOBS_PICTURE ? p->quality.samples
                                                       : v->picture_samples;
    const bool ok = picture(v, p, samples, &linear, err);
    if (ok) {
        const float *x = (const float *)(const void *)linear.data;
        uint8_t *a = bytes_alloc(6 * PIXELS), *b = a + 3 * PIXELS;
        compare_pixels(x, v->truth->picture, v->truth->picture_variance,
                       &out->picture);
        metric_display(x, PIXELS, p->view.colour, (double)p->view.exposure, a);
        metric_display(v->truth->picture, PIXELS, p->view.colour,
                       (double)p->view.exposure, b);
        out->psnr = metric_psnr(a, b, 3 * PIXELS);
        out->ssim = metric_ssim(a, b, BENCH_TRUTH_WIDTH, BENCH_TRUTH_HEIGHT);
        free(a);
    }
    buf_finish(&linear);
    return ok;
}

// --- a setting ---------------------------------------------------------------

bool bench_measure_row(const struct bench_view *v,
                       const struct bench_setting *s, struct bench_row *out,
                       struct error *err)
{
    const struct bench_truth *t = v->truth;
    const struct params *p = &s->params;
    *out = (struct bench_row){.setting = s};
    metric_errors(&(struct metric_pairs){0}, &out->integral);
    for (int e = 0; e < BENCH_EDITS; e++) {
        const bool timed = e == BENCH_EDIT_FIBRE ||
                           strcmp(s->group, "default") == 0 ||
                           (e == BENCH_EDIT_SKY && s->flags & BENCH_KNOBS_SKY);
        if (timed && !bench_time(v->r, p, (enum bench_edit)e, &v->effort,
                                 &out->time[e], err))
            return false;
    }
    const struct metric_pairs single = {t->count, NULL, t->single, NULL};
    const struct metric_pairs open = {t->exact, NULL, t->open, NULL};
    return bench_measure_whole(v, p, &out->whole, err) &&
           compare(v, p, once, single, &out->single, err) &&
           (!(s->flags & BENCH_KNOBS_INTEGRAL) || t->exact == 0 ||
            compare(v, p, once_open, open, &out->integral, err)) &&
           compare_picture(v, s, out, err);
}

// --- causes ------------------------------------------------------------------

struct states { // [3 * exact] each
    double *shown, *once, *rays, *open;
};

// The difference x - y, judged against the whole reference.
static void difference(const struct bench_view *v, const double *x,
                       const double *y, const double *variance,
                       struct metric_errors *out)
{
    const struct bench_truth *t = v->truth;
    double *moved = bytes_alloc(3 * (t->exact + 1) * sizeof *moved);
    for (size_t c = 0; c < 3 * t->exact; c++)
        moved[c] = t->whole[c] + (x[c] - y[c]);
    metric_errors(&(struct metric_pairs){t->exact, moved, t->whole, variance},
                  out);
    free(moved);
}

static bool sampling(const struct bench_view *v, struct metric_errors *out,
                     struct error *err)
{
    struct buf one = {0}, many = {0};
    const bool ok = picture(v, v->base, 64, &many, err) &&
                    picture(v, v->base, 1, &one, err);
    if (ok)
        compare_pixels((const float *)(const void *)one.data,
                       (const float *)(const void *)many.data, NULL, out);
    buf_finish(&one);
    buf_finish(&many);
    return ok;
}

static void differences(const struct bench_view *v, const struct states *s,
                        struct bench_cause *out)
{
    const struct bench_truth *t = v->truth;
    double *several = bytes_alloc(3 * (t->exact + 1) * sizeof *several);
    for (size_t c = 0; c < 3 * t->exact; c++)
        several[c] = s->shown[c] - s->once[c];
    out[0] = (struct bench_cause){
        .name = "light fit",
        .what = "the lights, with one transmittance each, instead of the "
                "sky's texels; by rays, exact"};
    difference(v, t->lights, t->single, NULL, &out[0].errors);
    out[1] = (struct bench_cause){
        .name = "scattering integral",
        .what = "the scheme instead of exact integrals; the same lights, by "
                "rays"};
    difference(v, s->rays, t->lights, NULL, &out[1].errors);
    out[2] = (struct bench_cause){
        .name = "visibility",
        .what = "the field of crossings instead of rays; once-scattered light"};
    difference(v, s->once, s->rays, NULL, &out[2].errors);
    out[3] = (struct bench_cause){
        .name = "multiple scattering",
        .what = "the model instead of paths; all that is scattered more than "
                "once"};
    difference(v, several, t->multiple, t->variance, &out[3].errors);
    out[4] = (struct bench_cause){
        .name = "all of these",
        .what = "the picture instead of the reference, at the same places"};
    difference(v, s->shown, t->whole, t->variance, &out[4].errors);
    out[5] = (struct bench_cause){
        .name = "integral, unshadowed",
        .what = "the scheme instead of exact integrals, without shadows"};
    difference(v, s->open, t->open, NULL, &out[5].errors);
    free(several);
}

bool bench_measure_causes(const struct bench_view *v,
                          struct bench_cause out[BENCH_CAUSES],
                          struct error *err)
{
    const size_t n = v->truth->exact;
    const struct params *p = v->base;
    struct states s = {0};
    const bool ok = (s.shown = radiance(v, p, as_shown, n, err)) &&
                    (s.once = radiance(v, p, once, n, err)) &&
                    (s.rays = radiance(v, p, once_by_rays, n, err)) &&
                    (s.open = radiance(v, p, once_open, n, err)) &&
                    sampling(v, &out[6].errors, err);
    if (ok) {
        differences(v, &s, out);
        out[6].name = "sampling";
        out[6].what = "one sample a pixel instead of 64, in a picture of 160 x "
                      "107; relative to its own mean";
    }
    free(s.shown);
    free(s.once);
    free(s.rays);
    free(s.open);
    return ok;
}
