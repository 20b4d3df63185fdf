// bench_truth.h - the reference of one view, made once and kept on disk.
//
// What is kept has a name that is the digest of everything that enters it:
// groom and sky by content, the parameters that light or hair depend on, the
// places, counts and seeds, and a few values that the reference gives now.
// Thread: the renderer's.
#ifndef SERVER_BENCH_TRUTH_H
#define SERVER_BENCH_TRUTH_H

#include <stdbool.h>
#include <stddef.h>

#include "protocol/error.h"
#include "protocol/params.h"
#include "renderer/places.h"
#include "renderer/renderer.h"

enum { BENCH_TRUTH_WIDTH = 160, BENCH_TRUTH_HEIGHT = 107 };

struct bench_truth_ask {
    const struct params *params; // of the view; the renderer's picture is
                                 // theirs and done
    size_t places;               // random visible ones
    size_t exact;      // of these, places at which single lights are integrated
    int paths;         // for each place
    int picture_paths; // for each pixel of the picture; 0: no picture
    bool no_lights;    // leaves `lights` out
    const char *hair_sha, *sky_sha; // hexadecimal
    const char *cache;              // directory, or NULL: keep nothing
};

struct bench_truth { // zero-initialised is empty
    size_t count, exact;
    struct places_item *place;
    // [3 * count]: once scattered by texels and rays; by paths what several
    // fibres scattered, with its variance; the sum of both
    double *single, *multiple, *variance, *whole;
    // [3 * exact]: once scattered by the renderer's lights, integrated exactly:
    // times a transmittance by rays each; without shadows
    double *lights, *open;
    float *picture; // RGBA, linear, premultiplied, BENCH_TRUTH_WIDTH x HEIGHT
    double *picture_variance; // [3 * pixels], of its means
    double picture_noise; // sqrt(mean variance of covered pixels) / their mean
    double seconds;       // spent on making what was not kept
    int made, kept;       // parts
};

bool bench_truth_make(struct bench_truth *t, struct renderer *r,
                      const struct bench_truth_ask *ask, struct error *err);
void bench_truth_finish(struct bench_truth *t);

// The same seeded places in the renderer's present picture: radiance[3 * count]
// of the first `count` places.  Fails when the picture sees others.
bool bench_truth_radiance(const struct bench_truth *t, struct renderer *r,
                          size_t count, double *radiance, struct error *err);

#endif
