// sky_shading.h - how wrong hair becomes when a sky is replaced by lights: a
// double-precision fibre after Marschner 2003, summed over directions.
#ifndef TESTS_NUMERIC_SKY_SHADING_H
#define TESTS_NUMERIC_SKY_SHADING_H

#include "renderer/sky.h"

// Quantile `share` of |x - reference| / max(reference, 5 % of the channel's
// mean) over `frames` random fibres and eyes and the three channels.  The
// reference is the sum over the map's energy, splat to 128 x 64 texels.
// Fibre: eta 1.55, sigma_a 0.15 0.25 0.45, beta_R 7.5 deg, alpha_R -7.5 deg.
void sky_shading_errors(const struct sky_map *map, const struct sky_fit *fit,
                        int frames, double *sorted); // [3 * frames], rising

#endif
