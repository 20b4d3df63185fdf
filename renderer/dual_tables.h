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

#include "renderer/dual_azimuth.h"

enum dual_scheme { DUAL_SCHEME_BEST, DUAL_SCHEME_PAPER };

enum {
    DUAL_TABLES_COLUMNS = 256, // theta from -pi/2 to pi/2, both ends included
    DUAL_TABLES_LAYERS = 10,
    // As shaders/dual.glsl declares them.
    DUAL_TABLES_UNIT = 3,
    DUAL_TABLES_BINDING = 6
};

struct dual_mean {   // at one inclination of the illumination, one channel
    double a_f, a_b; // attenuation: 1 - a_f^2 > 0, A_b + a_b <= 1
    double alpha_f, alpha_b; // shift, theta_h
    double beta2_f, beta2_b; // variance, theta_h: theta has four times that
    double A_b;              // multiple backscattering
    double delta_b, sigma_b; // shift, standard deviation in theta_i + theta_o
};

struct dual_tables;

// Thread: any, one at a time; no GL is called.
struct dual_tables *dual_tables_create(void);
void dual_tables_update(struct dual_tables *t, const struct dual_fibre *f,
                        enum dual_scheme scheme);
double dual_tables_ms(const struct dual_tables *t); // of the last update

// As the shader sees it: interpolated between entries.  channel: 0..2.
void dual_tables_mean(const struct dual_tables *t, double theta, int channel,
                      struct dual_mean *out);
const struct dual_series *dual_tables_series(const struct dual_tables *t);

// Uploads what an update changed, binds texture unit and uniform block.
// Thread: render.
void dual_tables_bind(struct dual_tables *t);

// Thread: render, once it has been bound.  NULL is allowed.
void dual_tables_destroy(struct dual_tables *t);

#endif
