// fibre.h - what one fibre does with light of one direction: the scattering
// function S of a pair of directions, in double precision, fast enough to be
// asked for millions of times, and directions drawn from it.
//
// S_t = M_t N_t / cos^2 theta_d for t = R, TT, TRT (Marschner 2003, eq 8 and
// 9):
//   M_t = Gaussian of theta_i about 2 alpha_t - theta_o, of standard deviation
//         2 beta_t, so that its integral over theta_i is 1 (docs/METHODS.md,
//         1.4),
//   N_t from the roots of phi(h), the dielectric Fresnel term and absorption
//         along the real path.
// Two models of N:
//   EXACT      exact roots; N_TRT convolved with a normalised circular Gaussian
//              of Xu width w_c; for a != 1 Marschner's index eta* in the paths
//              of TRT only.  It is what exact.h integrates.
//   MARSCHNER  the practical procedure of Marschner 2003, section 5: cubic
//              Snell's law, caustics replaced (k_g, delta_h_m, delta_eta), eta*
//              in all of TRT.
// Frame of the fibre: METHODS, section 1; both directions point away from it.
// Angles in radians.
// Thread: fibre_create uses all cores; a finished one is immutable and may be
// asked from any thread.
#ifndef RENDERER_FIBRE_H
#define RENDERER_FIBRE_H

#include <stdbool.h>
#include <stddef.h>

#include "protocol/params.h"

enum { FIBRE_R, FIBRE_TT, FIBRE_TRT, FIBRE_MODES };
enum fibre_model { FIBRE_EXACT, FIBRE_MARSCHNER };

struct fibre_spec {
    enum fibre_model model;
    double eta, sigma_a[3], a; // sigma_a: RGB, per radius
    double alpha[FIBRE_MODES]; // shift in theta_h
    double beta[FIBRE_MODES];  // standard deviation in theta_h
    double w_c;                // Xu width
    double delta_eta, k_g, delta_h_m;
};
// fibre.* with what is `auto` resolved, in radians.
void fibre_spec_of(const struct params *p, enum fibre_model model,
                   struct fibre_spec *out);

struct fibre;
// Never NULL.  A tenth of a second of processor time, spread over the cores; a
// few seconds for the narrowest w_c.
struct fibre *fibre_create(const struct fibre_spec *s);
void fibre_destroy(struct fibre *f); // NULL is allowed
const struct fibre_spec *fibre_spec(const struct fibre *f);
size_t fibre_bytes(const struct fibre *f);

struct fibre_direction {
    double theta, phi;
};

// n[mode][channel] = N_t(theta_d, phi) / cos^2 theta_d.  twice = phi_i + phi_o,
// of which only eccentric fibres take notice.
void fibre_azimuth(const struct fibre *f, double theta_d, double phi,
                   double twice, double n[FIBRE_MODES][3]);

// s[mode][channel] = S_t cos theta_i: what light of radiance 1 from the solid
// angle d omega_i adds, per d omega_i, to the radiance of a ribbon as wide as
// the fibre.  The view is o.
void fibre_scatter(const struct fibre *f, const struct fibre_direction *o,
                   const struct fibre_direction *i, double s[FIBRE_MODES][3]);

// The integral of the above over all i: what a sky of radiance 1 makes of a
// fibre seen at theta; a != 1: of the mean over phi_o.  By quadrature.
void fibre_albedo(const struct fibre *f, double theta,
                  double a[FIBRE_MODES][3]);

// --- directions drawn from it -----------------------------------------------

struct fibre_view { // an o that directions are drawn for
    struct fibre_direction o;
    double share[FIBRE_MODES]; // chance of each mode; all 0: nothing is sent
    double centre[FIBRE_MODES], low[FIBRE_MODES], high[FIBRE_MODES],
        mass[FIBRE_MODES]; // of the Gaussian cut at theta_i = +-pi/2
};
// weight: how much each channel matters.
void fibre_look(const struct fibre *f, const struct fibre_direction *o,
                const double weight[3], struct fibre_view *v);

// i from three numbers of [0, 1).  False when nothing is sent.  The density is
// fibre_pdf, exactly.
bool fibre_sample(const struct fibre *f, const struct fibre_view *v,
                  const double u[3], struct fibre_direction *i);
// Per solid angle; its integral over the sphere is 1.
double fibre_pdf(const struct fibre *f, const struct fibre_view *v,
                 const struct fibre_direction *i);

#endif
