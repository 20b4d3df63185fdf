// sky_fit_target.h - what a fit sees of a sky: samples on a small lat-long
// grid, blurred as hair blurs it (or not at all), with their weights.
// Thread: any; an object belongs to one thread at a time.
#ifndef RENDERER_SKY_FIT_TARGET_H
#define RENDERER_SKY_FIT_TARGET_H

#include "renderer/sky.h"

struct sky_fit_target {
    enum sky_fit_mode mode;
    int width, height;             // of the grid; width is a multiple of 16
    size_t count;                  // width * height samples, top row first
    double blur;                   // kappa of the blur; 0: none
    double lambda_min, lambda_max; // of lobes in this (blurred) domain
    int turn; // the samples' frame is the map's, turned by so many 1/32 about z
    double *direction[3]; // unit, x, y, z of each sample, in that frame
    double *root;         // sqrt(v_i), the weight's root
    double *value[3];     // root * T_i
    double norm2;         // sum over channels and samples of value^2
    double map_energy[3]; // integral of the map's radiance over the sphere
    bool black;           // the map holds no light at all
};

// lights sets the upper bound of lambda in the hair mode: 2.2 / sqrt(lights)
// before the blur (wide lobes and shadows do not go together).
void sky_fit_target_init(struct sky_fit_target *t, const struct sky_map *map,
                         int lights, enum sky_fit_mode mode);
void sky_fit_target_finish(struct sky_fit_target *t);

// A direction of the samples' frame in the map's, and back.
void sky_fit_target_to_map(const struct sky_fit_target *t, const double in[3],
                           double out[3]);
void sky_fit_target_from_map(const struct sky_fit_target *t, const double in[3],
                             double out[3]);

// Integral over the sphere of exp(kappa (cos - 1)), also for kappa = 0.
double sky_fit_target_omega(double kappa);

#endif
