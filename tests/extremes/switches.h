// switches.h - where a formula gives way to another: how far its value jumps.
#ifndef TESTS_EXTREMES_SWITCHES_H
#define TESTS_EXTREMES_SWITCHES_H

#include "tests/extremes/single.h"

enum { SWITCHES = 17 };
struct switches_row {
    const char *name, *where;
};
extern const struct switches_row switches_rows[SWITCHES];

// What a jump may be: 5e-4 measured where the last node leaves the range
// (curvature of what grows as a square there), 6e-5 elsewhere and nowhere.
#define SWITCHES_LIMIT 1e-3

// Jumps at one switch, in parts of the largest of the four values around it (or
// of 1e-3): `count` cases through a way.  Where a case cannot reach the switch
// another is taken.
void switches_measure(int which, const struct single_way *way, int count,
                      struct cases_errors *jumps);

#endif
