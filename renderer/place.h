// place.h - where a groom stands in the world: axes, scale, diameter, head.
// One place, so that what is drawn and what is shot at are the same.
// Thread: any (no state).
#ifndef RENDERER_PLACE_H
#define RENDERER_PLACE_H

#include <stdbool.h>
#include <stdint.h>

#include "protocol/params.h"
#include "renderer/groom.h"

// The file's axis that points up, 0..2: hair.up, or the groom's own.
int place_up(const struct groom *g, const struct params *p);

// File axes to world axes, without scale: a cyclic change, so handedness is
// kept; a y-up file's +z is the world's -y, its front.
void place_axes(int up, const float in[3], float out[3]);

// Point i in the world.
void place_point(const struct groom *g, const struct params *p, uint32_t i,
                 float out[3]);

// Diameter at point i in file units: hair.diameter, the file's, its default,
// or the automatic one.
float place_diameter(const struct groom *g, const struct params *p, uint32_t i);
// True when place_diameter depends on i.
bool place_diameter_varies(const struct groom *g, const struct params *p);
// A diameter of the file in the world; never 0, so that its sign is free.
float place_width(const struct params *p, float diameter);

// The head's ellipsoid in the world.  False when there is none.
bool place_head(const struct groom *g, const struct params *p, float centre[3],
                float radius[3]);

#endif
