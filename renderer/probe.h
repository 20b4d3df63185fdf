// probe.h - single scattering integrals, one at a time, from the renderer's own
// shader functions: what `glintd probe` and the numeric tests look through.
// Thread: render (a GL context is current).
#ifndef RENDERER_PROBE_H
#define RENDERER_PROBE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "protocol/error.h"

enum {
    PROBE_INPUTS = 15,     // in the order of struct exact_case (exact.h)
    PROBE_OUTPUTS = 3,     // M_R M_TT M_TRT
    PROBE_GUARD_WORDS = 3, // of bits, guard N bit N % 32 of word N / 32
    PROBE_BATCH = 16384
};

struct probe_setup {
    int m;           // segments, 2..256
    bool fine_nodes; // the layout that converges, else the printed one
    int tables;      // times the paper's resolution, 1..8
    double delta_eta;
    bool opaque; // the variant without TT and TRT
    bool best;   // scheme `best`, to which all but `opaque` is nothing; else
                 // `paper`
};

struct probe; // two program variants, buffers and tables

struct probe *probe_create(const struct probe_setup *setup, struct error *err);
void probe_destroy(struct probe *p); // NULL is allowed

// cases: PROBE_INPUTS floats each, results: PROBE_OUTPUTS floats each; any
// count, done in batches; scheme `best` wants cases of one fibre (the first ten
// numbers but the angles) side by side.  Values must be legal; nothing is
// checked here.
bool probe_run(struct probe *p, const float *cases, size_t count,
               float *results, struct error *err);

// The runs that follow note which guards (shaders/guard.glsl) each case hits:
// PROBE_GUARD_WORDS a case into the caller's array, one run's after the
// other's; NULL: none are noted.
void probe_note_guards(struct probe *p, uint32_t *hits);

#endif
