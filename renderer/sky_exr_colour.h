// sky_exr_colour.h - other primaries to Rec. 709.
// Thread: any; values only.
#ifndef RENDERER_SKY_EXR_COLOUR_H
#define RENDERER_SKY_EXR_COLOUR_H

#include "renderer/sky_pixels.h"

// primaries: xy of red, green, blue and white.  Multiplies every pixel by the
// matrix from these to Rec. 709 with D65, white mapped to white (Bradford).
// Leaves pixels alone when the matrix is the identity within 0.002 (what
// rounding of written primaries amounts to) or the primaries are no triangle.
// Returns whether pixels were changed.
bool sky_exr_colour_convert(struct sky_pixels *p, const double primaries[4][2]);

#endif
