// exact.h - single scattering of one SRBF light by one fibre, by brute force in
// double precision.  The yardstick of every scheme; it shares no code with the
// shaders.
//
// What is integrated (Xu 2011, eq 11, no approximation of section 4.2):
//   M_t = Int Int G_j(omega_i) M_t(theta_i) N_t(theta_d, phi)
//         cos^2 theta_i / cos^2 theta_d  dphi_i dtheta_i
// with the circular Gaussian in theta and phi, M_t normalised over theta_i,
// the dielectric Fresnel term and absorption along the real path.  N_TRT is
// convolved with a normalised circular Gaussian of Xu width w_c, which is what
// keeps its caustics finite.  For a != 1 the index of refraction depends on
// the azimuth (Marschner 2003, section 5.2.3) in the paths of TRT only; Fresnel
// and absorption keep the fibre's own.
// Angles in radians.  L_j, the fibre's diameter and transmittance are 1.
// Thread: any (no shared state).
#ifndef RENDERER_EXACT_H
#define RENDERER_EXACT_H

enum { EXACT_R, EXACT_TT, EXACT_TRT, EXACT_MODES, EXACT_PANELS_MAX = 24 };

// One fibre, one light, one view.  The first fifteen are the columns of
// `glintd probe`, in their order.
struct exact_case {
    double eta;
    double sigma_a;            // per fibre radius
    double alpha[EXACT_MODES]; // shift in theta_h
    double beta[EXACT_MODES];  // standard deviation in theta_h
    double w_c;                // Xu width: standard deviation times sqrt 2
    double a;                  // eccentricity; 1 is circular
    double lambda_j;           // Xu width of the light
    double theta_j, phi_j;     // its centre, in the fibre's frame
    double theta_o, phi_o;     // view, away from the fibre
    double delta_eta;          // Xu 2011, section 4.2.4; not used here
};

// out[mode] = M_t.  Relative error 1e-7 for the parameters of the table; about
// a millisecond, for a != 1 some tens of them.
void exact_modes(const struct exact_case *c, double out[EXACT_MODES]);

// The mean of M_t over phi_o: the scale of a mode, by which errors where it is
// almost dark are judged.  For a != 1 that of the circular fibre.
void exact_means(const struct exact_case *c, double out[EXACT_MODES]);

// e^{-x} I_0(x), x >= 0; relative error 1e-14.
double exact_i0e(double x);

// Integral of f over consecutive panels edge[0..panels]; adaptive, to a
// relative error of `tolerance`.  f(self, x) is never asked for at an edge.
typedef double exact_integrand(void *self, double x);
double exact_integral(exact_integrand *f, void *self, const double *edge,
                      int panels, double tolerance);

// Unpolarised reflectance of a smooth dielectric; cos_i in [0, 1].
double exact_fresnel(double eta, double cos_i);

#endif
