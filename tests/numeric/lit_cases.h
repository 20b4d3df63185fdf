// lit_cases.h - fibres, lights and places for the tests of the tables of
// lights, by region; their errors against what cells are made of and against
// the direct evaluation in double precision.
#ifndef TESTS_NUMERIC_LIT_CASES_H
#define TESTS_NUMERIC_LIT_CASES_H

#include "renderer/dual_tables.h"
#include "renderer/fast_tables.h"
#include "renderer/probe_dual.h"
#include "renderer/probe_lit.h"
#include "tests/numeric/cases.h"

enum lit_region {
    LIT_TYPICAL, // the papers' values in use
    LIT_BROAD,   // cases.h
    LIT_SHARP,   // one thing changed of typical: lobes .5 to 2 degrees
    LIT_WIDE,    // lobes 20 to 40 degrees
    LIT_NARROW,  // lambda .02 to .1
    LIT_BRIGHT,  // lambda 1 to 2
    LIT_VIEW_60, // theta_o 60 to 75 degrees
    LIT_VIEW_75,
    LIT_VIEW_85, // to 89.9
    LIT_LOW,     // theta_j 85 to 90 degrees
    LIT_CLEAR,   // sigma_a to .01
    LIT_DARK,    // sigma_a 2 to 10
    LIT_OPAQUE,  // R alone is drawn
    LIT_SINGLE,  // light that one fibre scatters alone
    LIT_SHARED,  // a sky of 38 lights, most of which share tables
    LIT_REGIONS
};
extern const char *const lit_region_names[LIT_REGIONS];

enum { LIT_CHANNELS = 3 };

// A fibre, one sigma_a a channel, and its sky: no light wider than 2, each with
// its own table but in LIT_SHARED.
struct lit_sky {
    enum lit_region region;
    struct exact_case grey; // its fibre, sigma_a of the first channel
    struct lit_fibre fibre;
    struct lit_lights lights;
};
struct lit_sky lit_cases_sky(uint64_t *state, enum lit_region region,
                             int lights);
// A place that one lobe or another reaches, as the probe wants it.
void lit_cases_place(const struct lit_sky *sky, uint64_t *state,
                     float out[PROBE_LIT_INPUTS]);

// The direct evaluation of one channel in double precision (best_double.h,
// dual_double.h): near, far.  dual: of the sky's fibre.
void lit_cases_direct(const struct lit_sky *sky, const struct dual_tables *dual,
                      const float place[PROBE_LIT_INPUTS], int channel,
                      double out[2]);

// The tables' shape, as probe_lit.h has it.
void lit_cases_plan(const struct lit_sky *sky, struct lit_plan *plan);

#endif
