// single.h - the sweep of single scattering: laws for many vectors on the GPU,
// errors against brute force for fewer.
#ifndef TESTS_EXTREMES_SINGLE_H
#define TESTS_EXTREMES_SINGLE_H

#include "renderer/probe.h"
#include "tests/extremes/guards.h"
#include "tests/extremes/vectors.h"
#include "tests/numeric/cases.h"

enum { SINGLE_WAYS_MAX = 8 };
struct single_way {
    const char *name;
    struct probe_setup setup;
};
// Every scheme there is; the same number for all.
extern const struct single_way single_ways[];
extern const int single_way_count;

struct single_law {          // of one way in one region
    long vectors, bad;       // not finite, below 0, or above the bound
    double top;              // largest value over its bound
    struct exact_case worst; // where that was
    long hits[GUARDS_MAX], guarded;
};

// A probe of a way, made when it is first asked for; kept until single_close.
// NULL, printed, when it cannot be made.
struct probe *single_probe(const struct single_way *way);
void single_close(void);

// Sends `count` vectors of a region through a way.  Vectors that break a law
// are printed.
struct single_law single_sweep(const struct single_way *way,
                               enum vectors_region region, long count);

// The most that a mode may send (docs/EXTREMES.md): for any scheme and the
// reference.
void single_bound(const struct exact_case *c, double out[EXACT_MODES]);

struct single_truth {  // of one region
    long vectors, bad; // of the reference itself
    double top;
    struct cases_errors copy;                 // shader against its double copy
    struct cases_errors way[SINGLE_WAYS_MAX]; // against brute force, the sum
    struct cases_errors guarded[SINGLE_WAYS_MAX]; // those that hit a guard
};

// Brute force on all processors.
void single_compare(enum vectors_region region, long count,
                    struct single_truth *out);
void single_finish(struct single_truth *t);

#endif
