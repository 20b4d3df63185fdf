// best_double.h - the scheme `best` once more, in double precision and without
// tables or polynomials: what the shader must give but for rounding and fits.
#ifndef TESTS_NUMERIC_BEST_DOUBLE_H
#define TESTS_NUMERIC_BEST_DOUBLE_H

#include "renderer/exact.h"

// out[mode] = M_t.
void best_double_modes(const struct exact_case *c, double out[EXACT_MODES]);

#endif
