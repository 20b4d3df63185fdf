// dual_tables.h - dual scattering (Zinke 2008; Xu 2011, section 4.3): what is
// made of a fibre once an edit, so that a light costs little.
//
// For every inclination theta of the illumination (the tables are not even in
// it once the cuticle tilts): the mean attenuations, shifts and variances of
// one scattering event, forward and backward, and of all paths that turn back
// inside the hair.  Made in double precision, read by shaders/dual.glsl as a
// 1-D texture array and a uniform block.
//
// Schemes: BEST integrates what eq 32 says, exact Fresnel and absorption, all
// odd orders of backscattering; PAPER has the approximations of the paper with
// its misprints corrected (docs/METHODS.md, section 2).
// Eccentric fibres are taken at their mean index.
#ifndef RENDERER_DUAL_TABLES_H
#define RENDERER_DUAL_TABLES_H

#include "protocol/bytes.h"
#include "renderer/dual_mean.h"

enum {
    DUAL_TABLES_COLUMNS = 256, // theta from -pi/2 to pi/2, both ends included
    DUAL_TABLES_LAYERS = 10,
    // As shaders/dual.glsl declares them.
    DUAL_TABLES_UNIT = 3,
    DUAL_TABLES_BINDING = 6
};

struct dual_tables;

// Thread: any, one at a time; no GL is called.  An update makes what depends on
// what changed since the last one and keeps the rest: the same bits as all of
// it made anew, from any number of threads (crew.h).
struct dual_tables *dual_tables_create(void);
void dual_tables_update(struct dual_tables *t, const struct dual_fibre *f,
                        enum dual_scheme scheme);
double dual_tables_ms(const struct dual_tables *t); // of the last update

// How often each was made.
struct dual_tables_work {
    unsigned sections; // the cross section's energies and series
    unsigned lobes;    // one mode's weights over the inclination
    unsigned means;    // what is made of these, and sent to the device
};
struct dual_tables_work dual_tables_work(const struct dual_tables *t);

// Appends all that goes to the device, to compare.
void dual_tables_bytes(const struct dual_tables *t, struct buf *out);

// As the shader sees it: interpolated between entries.  channel: 0..2.
void dual_tables_mean(const struct dual_tables *t, double theta, int channel,
                      struct dual_mean *out);
// Of that only a_f and beta2_f.
void dual_tables_ahead(const struct dual_tables *t, double theta, int channel,
                       double out[2]);
const struct dual_series *dual_tables_series(const struct dual_tables *t);

// Uploads what an update changed, binds texture unit and uniform block.
// Thread: render.
void dual_tables_bind(struct dual_tables *t);

// Thread: render, once it has been bound.  NULL is allowed.
void dual_tables_destroy(struct dual_tables *t);

#endif
