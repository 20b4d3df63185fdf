// fast_tables.h - the inner integrals of single and global scattering (Xu 2011,
// eq 12, 28) as tables that are made once an edit of the fibre and serve every
// light: what `render.path=table` reads (shaders/fast.glsl).
//
// The cosine coefficients of N_t over phi come from a sum over h in double
// precision (dual_azimuth.h): exact Fresnel, absorption along the real path,
// TRT smoothed by w_c.  A circular Gaussian of light multiplies each by 2 pi
// e^-kappa I_n(kappa), half a circle by 2 sin(n pi/2)/(pi n).  A compute pass
// sums the series at the middles of cells, a second one makes local quadratics.
// Axes: |theta_d|, ln lambda' from .02 on (below, light narrower than any
// detail of N), |Phi|.  Longitudinal widths and the lights are in no table.
#ifndef RENDERER_FAST_TABLES_H
#define RENDERER_FAST_TABLES_H

#include <stdbool.h>

#include "protocol/error.h"
#include "renderer/dual_tables.h"

enum {
    FAST_TABLES_UNIT = 16, // as shaders/fast.glsl declares it
    FAST_TABLES_D = 24,    // shape: shaders/fast_size.glsl has it too
    FAST_TABLES_L = 24,
    FAST_TABLES_P = 64,
    FAST_TABLES_CELLS = FAST_TABLES_D * (FAST_TABLES_L + 1) * FAST_TABLES_P,
    FAST_TABLES_WAYS = 2048, // entries over theta_j
    FAST_TABLES_TERMS = 64   // of a series, at most
};
#define FAST_TABLES_LAMBDA 0.02 // lambda' of the first cell's edge
#define FAST_TABLES_BETA 1.2    // largest standard deviation
// The largest error that was measured of a sum over a sky's lights, against
// exact integrals: theta_o of 85 to 89 degrees (docs/METHODS.md, 1.6).
#define FAST_TABLES_ERROR 0.066
#define FAST_TABLES_STEP 0.25 // of ln lambda'

struct fast_tables;

// NULL when the fibre can be put into tables; else why it cannot: it is not
// circular, or its caustics are too narrow for the series.
// Thread: any.
const char *fast_tables_refuse(const struct dual_fibre *f);

// Thread: any, one at a time; no GL is called.  Nothing is done for a fibre
// whose cross section is that of the last update.
struct fast_tables *fast_tables_create(void);
void fast_tables_update(struct fast_tables *t, const struct dual_fibre *f);
unsigned
fast_tables_made(const struct fast_tables *t); // how often anything was

// For tests, to see that they notice: from the next update on two cells over
// theta_d share what is made for their middle.
void fast_tables_coarsen(struct fast_tables *t);

// What one crossing does to light (dual_forward of shaders/dual.glsl), finely
// enough that the nearest entry will do.
void fast_tables_forward(struct fast_tables *t, const struct dual_tables *dual);

// e^-kappa I_n(kappa), n < count.
void fast_tables_bessel(double kappa, int count, double *out);

// Makes the cells when the last update is not in them yet, binds the unit.
// Storage buffers 0 and 15 and units 17 to 20 are to be bound anew afterwards.
// Thread: render.
bool fast_tables_bind(struct fast_tables *t, struct error *err);

// Bytes on the device.
unsigned fast_tables_bytes(const struct fast_tables *t);

// Thread: render, once it has been bound.  NULL is allowed.
void fast_tables_destroy(struct fast_tables *t);

#endif
