// lit_sweep.h - the sweep of the tables of each light (renderer/lit_tables.h),
// cells and all: laws for many vectors on the GPU, and which guards they take.
#ifndef TESTS_EXTREMES_LIT_SWEEP_H
#define TESTS_EXTREMES_LIT_SWEEP_H

#include "tests/extremes/guards.h"
#include "tests/extremes/vectors.h"
#include "tests/numeric/cases.h"

enum {
    LIT_SWEEP_LIGHTS = 8, // a fibre's sky
    LIT_SWEEP_VECTORS = 160
};

struct lit_sweep_law { // of one region
    long vectors;      // of fibres that tables hold for
    long refused;      // fibres
    long narrow;       // vectors whose light has no table: too narrow for one
    long bad;          // not finite, below 0, above what a light has
    double top[2];     // largest value over its bound: directly, forward
    long hits[GUARDS_MAX], guarded;
    // of those, against the modes, of which cells are made; all channels added
    struct cases_errors error;
};

// Vectors that break a law are printed.  The caller finishes the errors.
struct lit_sweep_law lit_sweep(enum vectors_region region, int fibres);
void lit_sweep_close(void);

#endif
