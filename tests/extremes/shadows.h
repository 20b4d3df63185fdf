// shadows.h - what is read from a light's four shadow numbers, from no fibre
// crossed to hundreds: against the Poisson mean, and which guards it takes.
#ifndef TESTS_EXTREMES_SHADOWS_H
#define TESTS_EXTREMES_SHADOWS_H

#include "tests/extremes/guards.h"

enum { SHADOWS_REGIONS = 6 };

struct shadows_row {
    const char *what;
    double from, to;  // fibres crossed
    long places, bad; // not finite, out of order, or beyond [0, 1]
    double error;     // largest |T_f - exp(-n (1 - a))|
    double jump;      // largest second difference of T_f along n
    long hits[32];    // of the guards' third word
};

// All ways of a light cross n fibres; the head hides nothing, half or nearly
// all.  Attenuations 0 to 1.
void shadows_measure(struct shadows_row rows[SHADOWS_REGIONS]);

#endif
