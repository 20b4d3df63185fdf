// raster_truth.h - which segment each pixel of a small picture sees, by the
// rule that raster_walk.comp states, in double precision and without lists.
#ifndef TESTS_RENDER_RASTER_TRUTH_H
#define TESTS_RENDER_RASTER_TRUTH_H

#include "renderer/renderer_private.h"

enum {
    TRUTH_WIDTH = 96, // the size of scene_params
    TRUTH_HEIGHT = 64,
    TRUTH_PIXELS = TRUTH_WIDTH * TRUTH_HEIGHT
};
#define TRUTH_NONE 0xffffffffu // RASTER_NONE

struct raster_truth {
    const struct renderer *r;
    float *point, *opacity; // as uploaded: x, y, z, diameter; NULL: 1
    uint32_t *strand;
    double jitter[2]; // of the sample, clip units
    double depth[TRUTH_PIXELS];
    uint32_t seen[TRUTH_PIXELS];
    bool close[TRUTH_PIXELS]; // rounding may decide otherwise
};

// Of sample 0, of a renderer that has drawn it; free it.
struct raster_truth *raster_truth_make(const struct renderer *r);
void raster_truth_free(struct raster_truth *t);

#endif
