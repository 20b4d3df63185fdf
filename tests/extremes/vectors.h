// vectors.h - fibres, lights and views at and near the limits of what may be
// asked for, by region: each parameter alone, then several together.
#ifndef TESTS_EXTREMES_VECTORS_H
#define TESTS_EXTREMES_VECTORS_H

#include <stdint.h>

#include "renderer/exact.h"

enum vectors_region {
    VECTORS_TYPICAL, // the papers' values in use
    VECTORS_BROAD,   // a good deal around them
    VECTORS_FIRST,   // one parameter extreme, the rest typical
    VECTORS_ETA = VECTORS_FIRST,
    VECTORS_MERGE,
    VECTORS_CLEAR,
    VECTORS_DARK,
    VECTORS_TILTED,
    VECTORS_SHARP,
    VECTORS_WIDE,
    VECTORS_CAUSTIC,
    VECTORS_FLAT,
    VECTORS_NARROW_LIGHT,
    VECTORS_WIDE_LIGHT,
    VECTORS_GRAZING_LIGHT,
    VECTORS_GRAZING_VIEW,
    VECTORS_TURN,
    VECTORS_SEVERAL, // two to five of them
    VECTORS_BOX,     // anything that is legal
    VECTORS_CORNER,  // everything at a limit
    VECTORS_ROUND,   // what random numbers never meet
    VECTORS_REGIONS
};

struct vectors_region_row {
    const char *name, *what;
};
extern const struct vectors_region_row vectors_regions[VECTORS_REGIONS];

// Reproducible: the same state gives the same case.  Every number is a float,
// inside its legal range (lambda_j: 1e-3 to 10).
struct exact_case vectors_case(uint64_t *state, enum vectors_region region);

// The width that up to 50 crossings give to the light of *c; a Xu width.
double vectors_widened(const struct exact_case *c, uint64_t *state);

#endif
