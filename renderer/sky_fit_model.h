// sky_fit_model.h - lobes on a target, with the amplitudes that fit best.
// Thread: any; an object belongs to one thread at a time.
#ifndef RENDERER_SKY_FIT_MODEL_H
#define RENDERER_SKY_FIT_MODEL_H

#include "renderer/sky_fit_target.h"

struct sky_fit_lobe { // in the target's (blurred) domain
    double centre[3]; // unit
    double l;         // ln lambda
};

struct sky_fit_model {
    const struct sky_fit_target *target; // borrowed
    int count, capacity;
    struct sky_fit_lobe lobe[SKY_LIGHTS_MAX];
    double amplitude[3][SKY_LIGHTS_MAX]; // >= 0
    float *basis;        // [capacity][target->count]: root * lobe
    double *gram;        // [capacity][capacity], symmetric, of the basis
    double *rhs[3];      // basis . value
    double *residual[3]; // value - sum of amplitude * basis
    double f2;           // sum of residual^2 / target->norm2
};

void sky_fit_model_init(struct sky_fit_model *m, const struct sky_fit_target *t,
                        int capacity);
void sky_fit_model_finish(struct sky_fit_model *m);

// The basis column, Gram row and right-hand sides of lobes first..count-1 anew.
// Those before must be up to date.
void sky_fit_model_update(struct sky_fit_model *m, int first);
// Non-negative least squares for the amplitudes, from those that are there.
void sky_fit_model_refit(struct sky_fit_model *m);
// Residual and f2 of the amplitudes as they are.
void sky_fit_model_residual(struct sky_fit_model *m);

#endif
