// probe_fast.h - single integrals as the tables of render.path=table give them
// (fast_tables.h), cells and all: `glintd probe --scheme fast` and the numeric
// tests look through it.
// Thread: render (a GL context is current).
#ifndef RENDERER_PROBE_FAST_H
#define RENDERER_PROBE_FAST_H

#include <stdbool.h>
#include <stddef.h>

#include "protocol/error.h"
#include "renderer/fast_tables.h"

enum {
    // lambda_j theta_j phi_j theta_o phi_o, sigma_f of each colour channel
    PROBE_FAST_INPUTS = 8,
    // M_R M_TT M_TRT, M^G_R M^G_TT M^G_TRT: three channels each
    PROBE_FAST_OUTPUTS = 18
};

struct probe_fast;

struct probe_fast *probe_fast_create(struct error *err);
void probe_fast_destroy(struct probe_fast *p); // NULL is allowed

// The fibre of all cases that follow; one that fast_tables_refuse lets pass.
void probe_fast_fibre(struct probe_fast *p, const struct dual_fibre *f);

// From the next fibre on as fast_tables_coarsen.
void probe_fast_coarsen(struct probe_fast *p);

// Any count, done in batches.  Values must be legal; nothing is checked here.
bool probe_fast_run(struct probe_fast *p, const float *cases, size_t count,
                    float *results, struct error *err);

#endif
