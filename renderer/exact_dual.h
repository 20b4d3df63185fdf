// exact_dual.h - what dual scattering asks of a fibre (Zinke 2008; Xu 2011,
// section 4.3), by brute force in double precision: mean attenuations, shifts
// and variances (eq 32), the half-circle integrals (eq 28), and the global and
// local integrals (eq 27, 29) with psi_f in the form of eq 5.  The yardstick of
// every scheme; it shares no code with tables and shaders.
//
// TRT is smoothed by w_c as in exact.h.  An eccentric fibre is taken at its
// mean index (TRT's paths only): averaged over half a circle of light, little
// else of its shape is left.
// Angles in radians, shifts and widths of S_back in s = theta_i + theta_o.
// Thread: any (no shared state).
#ifndef RENDERER_EXACT_DUAL_H
#define RENDERER_EXACT_DUAL_H

#include <stdbool.h>

#include "renderer/exact.h"

struct exact_dual; // one fibre

// Uses the fibre of *c (eta to a); some ten milliseconds.
struct exact_dual *exact_dual_create(const struct exact_case *c);
void exact_dual_destroy(struct exact_dual *e); // NULL is allowed

struct exact_dual_mean {     // at one inclination of the illumination
    double a_f, a_b;         // attenuation, forward and backward
    double alpha_f, alpha_b; // shift, theta_h
    double beta2_f, beta2_b; // variance, theta_h
    double A_b;              // multiple backscattering, all odd orders
    double delta_b, sigma_b; // its shift and standard deviation, in s
};
void exact_dual_mean(const struct exact_dual *e, double theta,
                     struct exact_dual_mean *out);

// out[mode] = N^G_t(theta_d, phi) of eq 28.
void exact_dual_half(const struct exact_dual *e, double theta_d, double phi,
                     double out[EXACT_MODES]);

enum { EXACT_DUAL_ML = EXACT_MODES, EXACT_DUAL_MLD, EXACT_DUAL_OUTPUTS };

// Of light and view of *c; sigma_f a Xu width.  out: M^G_R, M^G_TT, M^G_TRT,
// M^L, and M^L of the light itself (its own lobe instead of psi_f).  Without
// T_f, solid angle and amplitude of the light and the density factors.
// mean: over phi_o, by which errors are judged; else at phi_o.
void exact_dual_multiple(const struct exact_dual *e, const struct exact_case *c,
                         double sigma_f, bool mean,
                         double out[EXACT_DUAL_OUTPUTS]);

#endif
