// probe_dual.h - dual scattering, one integral at a time, from the renderer's
// own tables and shader functions: `glintd probe --what half|multiple` and the
// numeric tests look through it.
// Thread: render (a GL context is current).
#ifndef RENDERER_PROBE_DUAL_H
#define RENDERER_PROBE_DUAL_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "protocol/error.h"
#include "renderer/dual_tables.h"
#include "renderer/exact.h"
#include "renderer/probe.h"

enum {
    // lambda_j theta_j phi_j theta_o phi_o, sigma_f of each colour channel
    PROBE_DUAL_INPUTS = 8,
    // M^G_R M^G_TT M^G_TRT, M^L, M^L of the light itself: three channels each
    PROBE_DUAL_OUTPUTS = 15,
    PROBE_DUAL_HALF_INPUTS = 2, // theta_d Phi
    PROBE_DUAL_HALF_OUTPUTS = 3 // N^G_R N^G_TT N^G_TRT of the first channel
};

struct probe_dual;

// Of *setup, m, nodes and tables are for scheme `paper` alone; opaque is the
// variant without TT and TRT.
struct probe_dual *probe_dual_create(const struct probe_setup *setup,
                                     enum dual_scheme scheme,
                                     struct error *err);
void probe_dual_destroy(struct probe_dual *p); // NULL is allowed

// The fibre of *c, grey.
struct dual_fibre probe_dual_grey(const struct exact_case *c);
// The fibre of all cases that follow.
void probe_dual_fibre(struct probe_dual *p, const struct dual_fibre *f);
const struct dual_tables *probe_dual_tables(const struct probe_dual *p);

// Any count, done in batches.  Values must be legal; nothing is checked here.
bool probe_dual_multiple(struct probe_dual *p, const float *cases, size_t count,
                         float *results, struct error *err);
bool probe_dual_half(struct probe_dual *p, const float *cases, size_t count,
                     float *results, struct error *err);

// As probe_note_guards of probe.h.
void probe_dual_note_guards(struct probe_dual *p, uint32_t *hits);

#endif
