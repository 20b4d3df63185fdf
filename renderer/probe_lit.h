// probe_lit.h - one place lit by one light, as the tables of each light have it
// that draw the default picture (lit_tables.h): cells are made by the very
// passes of a picture and read by its functions.  `glintd probe --what lit` and
// the numeric tests look through it.
// Thread: render (a GL context is current).
#ifndef RENDERER_PROBE_LIT_H
#define RENDERER_PROBE_LIT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "protocol/error.h"
#include "renderer/lit_tables.h"

enum {
    // light (its number), theta_j, Phi, theta_o, sigma_f of each channel
    PROBE_LIT_INPUTS = 7,
    // Three channels each: M_R + M_TT + M_TRT + d_b M^L of the light itself;
    // M^G + d_b M^L of light as wide as sigma_f; both from the tables of modes,
    // of which the cells are made.  Then what was read, as below.
    PROBE_LIT_NEAR = 0,
    PROBE_LIT_FAR = 3,
    PROBE_LIT_NEAR_MODES = 6,
    PROBE_LIT_FAR_MODES = 9,
    PROBE_LIT_NEAR_AT = 12,   // cell: s theta_o Phi; -1: this light has none
    PROBE_LIT_FAR_AT = 15,    // ln sigma_f s theta_o Phi
    PROBE_LIT_NEAR_SIZE = 19, // of that cell, radians
    PROBE_LIT_FAR_SIZE = 22,
    PROBE_LIT_OUTPUTS = 26
};

struct probe_lit;

struct probe_lit *probe_lit_create(struct error *err);
void probe_lit_destroy(struct probe_lit *p); // NULL is allowed

// The fibre of all cases that follow; one that fast_tables_refuse lets pass.
// Without multiple scattering there is neither glow nor far table (indices -1,
// values 0).
void probe_lit_fibre(struct probe_lit *p, const struct lit_fibre *f);

// The lights of a sky: makes all cells of all their tables.  Where each has its
// own (lit_plan_apart) and there is room for all, a light's cells depend on no
// other light; the far table begins with the narrowest one.
bool probe_lit_lights(struct probe_lit *p, const struct lit_lights *lights,
                      struct error *err);

// Any count, done in batches, after fibre and lights.  Values must be legal;
// nothing is checked here.
bool probe_lit_run(struct probe_lit *p, const float *cases, size_t count,
                   float *results, struct error *err);

// As probe_note_guards of probe.h; those of the tables of lights alone.
void probe_lit_note_guards(struct probe_lit *p, uint32_t *hits);

#endif
