// dual_mean.h - what one scattering event does on average, forward and
// backward, and from that all paths that turn back inside the hair (Zinke 2008,
// section 3.2; Xu 2011, section 4.3). Thread: any.
#ifndef RENDERER_DUAL_MEAN_H
#define RENDERER_DUAL_MEAN_H

#include "renderer/dual_azimuth.h"

enum dual_scheme { DUAL_SCHEME_BEST, DUAL_SCHEME_PAPER };

struct dual_mean {   // at one inclination of the illumination, one channel
    double a_f, a_b; // attenuation: 1 - a_f^2 > 0, A_b + a_b <= 1
    double alpha_f, alpha_b; // shift, theta_h
    double beta2_f, beta2_b; // variance, theta_h: theta has four times that
    double A_b;              // multiple backscattering
    double delta_b, sigma_b; // shift, standard deviation in theta_i + theta_o
};

// s: what half a space makes of each channel (dual_bounce.h).  out: red, green,
// blue.
void dual_mean_take(const struct dual_fibre *f, enum dual_scheme scheme,
                    const struct dual_energy *s, struct dual_mean out[3]);

#endif
