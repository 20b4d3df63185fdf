// sky_maps.h - maps for tests of the sky's fit, and fitting them.
#ifndef TESTS_NUMERIC_SKY_MAPS_H
#define TESTS_NUMERIC_SKY_MAPS_H

#include "renderer/sky.h"

// A map of one value everywhere; sky_map_destroy.
struct sky_map *sky_maps_new(int width, int height, float value);

// The fit as hair sees it, without a cache.  False, printed, where it fails.
bool sky_maps_fit(const struct sky_map *m, int lights, struct sky_fit *fit);

// Between two vectors, in degrees.
double sky_maps_angle(const double a[3], const double b[3]);

#endif
