// tables.h - the sweep of the tables of render.path=table (renderer/
// fast_tables.h): laws for many vectors on the GPU.
#ifndef TESTS_EXTREMES_TABLES_H
#define TESTS_EXTREMES_TABLES_H

#include "tests/extremes/vectors.h"

enum { TABLES_LIGHTS = 100 }; // lights and views a fibre

struct tables_law {             // of one region
    long vectors, refused, bad; // fibres' vectors; fibres; not finite, below 0,
    double top;                 // or far above single scattering's bound;
};                              // largest value over that bound

// Of `fibres` fibres, but those that tables do not hold for.  Vectors that
// break a law are printed.
struct tables_law tables_sweep(enum vectors_region region, int fibres);
void tables_close(void);

#endif
