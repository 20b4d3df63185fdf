// bench_measure.h - time and error of one setting in one view, and the error
// of the view's own setting by cause.
// Thread: the renderer's.
#ifndef SERVER_BENCH_MEASURE_H
#define SERVER_BENCH_MEASURE_H

#include <stdbool.h>

#include "protocol/error.h"
#include "renderer/metric.h"
#include "renderer/renderer.h"
#include "server/bench_knobs.h"
#include "server/bench_time.h"
#include "server/bench_truth.h"

enum { BENCH_CAUSES = 7 };

struct bench_view { // one scene, seen by the base's camera
    const char *name;
    struct renderer *r;
    const struct params *base;
    const struct bench_truth *truth;
    struct bench_effort effort; // for each edit
    int picture_samples;        // of pictures that are compared
};

struct bench_row {
    const struct bench_setting *setting;
    struct bench_times time[BENCH_EDITS]; // the first always
    // Against the sky's texels, rays and path-traced multiple scattering.  All
    // but `picture` are at places; where render.path is forward, of the same
    // shader functions on path direct.
    struct metric_errors whole;
    // Once-scattered light alone, against texels and rays: multiple scattering
    // is excluded.
    struct metric_errors single;
    // Once-scattered light of the same lights without shadows, against exact
    // integrals: fit, visibility and multiple scattering are excluded.  NaN
    // where the setting does not bear upon it.
    struct metric_errors integral;
    // The whole picture, with its edges and samples, against a path-traced one.
    struct metric_errors picture;
    double psnr, ssim;
};

// How a place is lit that is compared: as it is shown, or once, unshadowed.
enum bench_measure_light { BENCH_MEASURE_SHOWN, BENCH_MEASURE_OPEN };
// Radiance of the first `count` places under *p; the caller frees [3 * count].
// NULL on failure.
double *bench_measure_places(const struct bench_view *v, const struct params *p,
                             enum bench_measure_light light, size_t count,
                             struct error *err);

bool bench_measure_row(const struct bench_view *v,
                       const struct bench_setting *s, struct bench_row *out,
                       struct error *err);

// The error `whole` alone, of *p.
bool bench_measure_whole(const struct bench_view *v, const struct params *p,
                         struct metric_errors *out, struct error *err);

struct bench_cause {
    const char *name, *what;     // "light fit"; what is exchanged
    struct metric_errors errors; // of the difference, relative to the mean of
                                 // the whole reference
};

// One thing exchanged at a time, from the renderer's picture to the reference:
// the first four differences add up to the fifth, place by place.
bool bench_measure_causes(const struct bench_view *v,
                          struct bench_cause out[BENCH_CAUSES],
                          struct error *err);

#endif
