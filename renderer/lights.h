// lights.h - the fitted SRBF lights turned into the world, coloured, and those
// that cannot matter dropped.
// Thread: render.
#ifndef RENDERER_LIGHTS_H
#define RENDERER_LIGHTS_H

#include "protocol/params.h"
#include "renderer/sky.h"

enum { LIGHTS_BINDING = 2 }; // of the uniform block

struct lights {
    unsigned block; // uniform buffer
    int used, fitted;
    double dropped_share; // of the sky's light, mean over channels
    float to_map[9];      // row-major: world direction -> map direction
};

void lights_init(struct lights *l);
void lights_finish(struct lights *l);

// Rotation: roll about y, then pitch about x, then yaw about z (light.*);
// colour and exposure from tint.*.  Drops the dimmest lights while together
// they hold at most quality.light_bound of the sky's light.
void lights_update(struct lights *l, const struct sky_fit *fit,
                   const struct params *p);

#endif
