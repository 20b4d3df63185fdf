// switches_dual.h - where a formula of dual scattering gives way to another:
// how far its value jumps.  As switches.h.
#ifndef TESTS_EXTREMES_SWITCHES_DUAL_H
#define TESTS_EXTREMES_SWITCHES_DUAL_H

#include "tests/extremes/multiple.h"
#include "tests/extremes/switches.h"

enum { SWITCHES_DUAL = 8 };
extern const struct switches_row switches_dual_rows[SWITCHES_DUAL];

// Jumps of M^G_t, M^L and M^L of the light itself, in parts of the largest of
// the four values around the switch (or of 1e-3).
void switches_dual_measure(int which, enum dual_scheme scheme, int count,
                           struct cases_errors *jumps);

#endif
