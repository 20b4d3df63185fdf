// dual_bounce.h - what one scattering event sends into half a space (Xu 2011,
// eq 32 and 33): the integral over the inclination, of which the weights depend
// on a mode's shift and width alone, the energies on the cross section alone.
// Thread: any.
#ifndef RENDERER_DUAL_BOUNCE_H
#define RENDERER_DUAL_BOUNCE_H

#include "renderer/dual_azimuth.h"

enum {
    DUAL_BOUNCE_NODES = 20,
    DUAL_BOUNCE_ENERGIES = 96 // intervals of cos theta_d from 0 to 1
};

struct dual_bounce { // of one mode and one inclination
    int count;       // of nodes: 0 where the lobe points beyond the fibre
    double cosine[DUAL_BOUNCE_NODES], weight[DUAL_BOUNCE_NODES];
};

// x, w: Gauss-Legendre on [0, 1].  alpha, beta: the mode's.
struct dual_bounce_rule {
    double x[DUAL_BOUNCE_NODES], w[DUAL_BOUNCE_NODES];
};
struct dual_bounce_lobe {
    int mode; // R, TT, TRT
    double alpha, beta;
};
void dual_bounce_weigh(struct dual_bounce *b,
                       const struct dual_bounce_rule *rule, double theta,
                       const struct dual_bounce_lobe *lobe);

// The energy that a node at interval i stands for, at cos theta_d of i /
// DUAL_BOUNCE_ENERGIES.
void dual_bounce_energy(const struct dual_azimuth *z, int i,
                        struct dual_energy *out);

// What half a space makes of a mode's channels, into *s; others stay.
void dual_bounce_add(const struct dual_bounce *b, int mode,
                     const struct dual_energy energy[DUAL_BOUNCE_ENERGIES + 1],
                     struct dual_energy *s);

// First and one past the last channel of a mode.
extern const int dual_bounce_channels[3][2];

#endif
