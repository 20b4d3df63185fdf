// lit_double.h - cells of the tables of lights once more, in double precision
// and without packing: a local quadratic from values at the middles of cells,
// as shaders/lit_pack.comp and lit_far_pack.comp make them, read as lit.glsl
// reads them, with what packing may change of it.
#ifndef TESTS_NUMERIC_LIT_DOUBLE_H
#define TESTS_NUMERIC_LIT_DOUBLE_H

#include <stdbool.h>

enum {
    LIT_DOUBLE_SIDE = 3, // the cell's neighbours along s and theta_o, and it
    LIT_DOUBLE_PHIS = 5, // along Phi two to each side
    LIT_DOUBLE_CHANNELS = 3
};

// Values round a cell, [s][theta_o][Phi], the cell in the midst; beyond an end
// those of the last cell.  A light's table is even at Phi = 0 and goes on
// there.
struct lit_double_values {
    double at[LIT_DOUBLE_SIDE][LIT_DOUBLE_SIDE][LIT_DOUBLE_PHIS]
             [LIT_DOUBLE_CHANNELS];
};

struct lit_double_at {
    double x[3];   // from the cell's middle: s, theta_o, Phi; in cells
    bool edge;     // the first or last of theta_o
    int phi, phis; // which of how many over Phi
};

struct lit_double_result {
    double value[LIT_DOUBLE_CHANNELS];
    // What bfloat16 and bytes of 2/127 can make of it.
    double packing[LIT_DOUBLE_CHANNELS];
    bool full; // a second derivative or slope was too large for its bits
};

struct lit_double_result lit_double_near(const struct lit_double_values *v,
                                         const struct lit_double_at *at);

// v: a cell of ln sigma_f before, here and behind; w: of each channel, in cells
// of ln sigma_f from the middle.
struct lit_double_result lit_double_far(const struct lit_double_values v[3],
                                        const struct lit_double_at *at,
                                        const double w[LIT_DOUBLE_CHANNELS]);

#endif
