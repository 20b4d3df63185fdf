// dual_azimuth.h - what one cross section of a fibre does with light from half
// a circle: how much goes on, how much turns back, and N^G (Xu 2011, eq 28) as
// a short series.  Exact Fresnel, absorption along the real path, TRT smoothed
// by w_c; no root of phi(h) is sought: everything is a sum over h.
//
// Channels: R; TT red, green, blue; TRT red, green, blue.
// Thread: any.
#ifndef RENDERER_DUAL_AZIMUTH_H
#define RENDERER_DUAL_AZIMUTH_H

#include <stdbool.h>

enum { DUAL_R, DUAL_TT, DUAL_TRT = DUAL_TT + 3, DUAL_CHANNELS = DUAL_TRT + 3 };

// Angles in radians, nothing left `auto`.
struct dual_fibre {
    double eta;
    double sigma_a[3]; // RGB, per radius
    double a;          // eccentricity: only its mean index is seen
    double alpha[3];   // R, TT, TRT: shift in theta_h
    double beta[3];    // standard deviation in theta_h
    double w_c;        // Xu width
    double delta_eta;
};

// What a cross section is made of: nothing here depends on anything else of a
// fibre, so what was made of one holds while these are the same.
struct dual_section {
    double eta, sigma_a[3], a, w_c;
};
struct dual_section dual_azimuth_section(const struct dual_fibre *f);
bool dual_azimuth_same(const struct dual_section *a,
                       const struct dual_section *b);

// Both divided by cos^2 theta_d, but R's: they go to zero with it.
struct dual_energy {
    double ahead[DUAL_CHANNELS]; // Int |phi|/pi N dphi (eq 33)
    double all[DUAL_CHANNELS];   // Int N dphi
};

// N^G(theta_d, Phi) = scale sum_m W_m(Phi) sum_p row[m][p] x^p,
//   W_m = sum_k wave[m][k] cos(n_k Phi), n_k = 0, 1, 3, 5, ...,
//   x = 2 eta/eta'(theta_d) - 1, which is in [-1, 1],
//   scale: R 1; TT cos^2 theta_d; TRT that times schlick(cos theta_d).
// A mode's channels share its waves.
enum {
    DUAL_HARMONICS = 8, // of R and TT
    DUAL_HARMONICS_TRT = 12,
    DUAL_WAVES_R = 3,
    DUAL_WAVES_TT = 4,
    DUAL_WAVES_TRT = 6,
    DUAL_POWERS = 8,
    DUAL_POWERS_TRT = 9
};
struct dual_series {
    double wave_r[DUAL_WAVES_R][DUAL_HARMONICS];
    double wave_tt[DUAL_WAVES_TT][DUAL_HARMONICS];
    double wave_trt[DUAL_WAVES_TRT][DUAL_HARMONICS_TRT];
    double r[DUAL_WAVES_R][DUAL_POWERS];
    double tt[3][DUAL_WAVES_TT][DUAL_POWERS];
    double trt[3][DUAL_WAVES_TRT][DUAL_POWERS_TRT];
};

struct dual_azimuth { // private
    struct dual_section section;
    double eta_path;   // index in TRT's paths
    double smooth[16]; // I_n / I_0 of the smoothing Gaussian, n = 1, 3, 5, ...
};

void dual_azimuth_init(struct dual_azimuth *z, const struct dual_section *s);
void dual_azimuth_energy(const struct dual_azimuth *z, double cos_d,
                         struct dual_energy *out);
// out[n][channel] of N_t(phi) = sum_n out cos(n phi), n < count <= 64, TRT's
// not smoothed; TT's and TRT's divided by cos^2 theta_d.  Up to n = 64 the 64
// nodes in gamma resolve what they sum (phi turns by 2 radians a radian at
// most).
void dual_azimuth_cosines(const struct dual_azimuth *z, double cos_d, int count,
                          double (*out)[DUAL_CHANNELS]);

// The series in two steps whose pieces do not depend on each other: samples
// over x, then the waves and rows of R (0), TT (1), TRT (2).
enum { DUAL_SAMPLES = 24 };
struct dual_sample { // one theta_d: coefficients of cos(n_k Phi)
    double x;
    double e[DUAL_CHANNELS][DUAL_HARMONICS_TRT];
};
void dual_azimuth_sample(const struct dual_azimuth *z, int i,
                         struct dual_sample *out);
void dual_azimuth_fit(const struct dual_sample s[DUAL_SAMPLES], int mode,
                      struct dual_series *out);

// The factor by which TRT's series is smooth: Fresnel's F, about.
double dual_azimuth_schlick(double eta, double cos_d);

#endif
