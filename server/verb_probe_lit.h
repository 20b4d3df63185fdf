// verb_probe_lit.h - `glintd probe --what lit`: what one light does to a fibre,
// all modes together, directly and once it came forward through other fibres:
// by the direct path, or as cells of the tables that draw the default picture,
// with what cells they are.
// Thread: render (a GL context is current).
#ifndef SERVER_VERB_PROBE_LIT_H
#define SERVER_VERB_PROBE_LIT_H

#include <stddef.h>

#include "renderer/exact.h"
#include "renderer/probe.h"

enum {
    // M_R + M_TT + M_TRT + d_b M^L of the light itself; M^G + d_b M^L of light
    // as wide as sigma_f
    VERB_PROBE_LIT_SUMS = 2,
    // the same from the tables of modes; cells and their sizes (probe_lit.h)
    VERB_PROBE_LIT_CELLS = 18
};

struct verb_probe_lit_line {
    struct exact_case c;
    double sigma_f;
};

struct verb_probe_lit;

// cells: from tables where these hold; else, and where not, as `setup` says.
struct verb_probe_lit *verb_probe_lit_create(const struct probe_setup *setup,
                                             bool cells, double d_b,
                                             struct error *err);
void verb_probe_lit_destroy(struct verb_probe_lit *v); // NULL is allowed

// A line's light is the only one that there is, so that neighbours change
// nothing.  out: VERB_PROBE_LIT_SUMS are written for each, or with cells
// VERB_PROBE_LIT_CELLS: indices -1 where no table was read.
bool verb_probe_lit_run(struct verb_probe_lit *v,
                        const struct verb_probe_lit_line *line, size_t count,
                        double (*out)[VERB_PROBE_LIT_CELLS], struct error *err);

// The sums by brute force; any thread, no GL.  e: of the line's fibre.
struct exact_dual;
void verb_probe_lit_exact(const struct exact_dual *e,
                          const struct verb_probe_lit_line *line, double d_b,
                          double out[VERB_PROBE_LIT_SUMS]);

#endif
