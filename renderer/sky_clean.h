// sky_clean.h - makes radiance of what a file holds.
// Thread: any; values only.
#ifndef RENDERER_SKY_CLEAN_H
#define RENDERER_SKY_CLEAN_H

#include "renderer/sky.h"

// NaN and negative values become 0, +infinity 65,504 (the largest half: a sun
// must not vanish), finite values are kept up to 1e8 (far above any sun, far
// below where squares overflow a float).  rgb: [3 * width * height], lat-long.
void sky_clean_run(float *rgb, int width, int height,
                   struct sky_cleaned *cleaned);

// Solid angle of a pixel in row y of a lat-long map.
double sky_clean_solid_angle(int y, int width, int height);

#endif
