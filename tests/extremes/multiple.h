// multiple.h - the sweep of dual scattering: laws for many vectors through the
// tables (`fibre`) and on the GPU (`multiple`), errors against brute force for
// fewer.
#ifndef TESTS_EXTREMES_MULTIPLE_H
#define TESTS_EXTREMES_MULTIPLE_H

#include "renderer/probe_dual.h"
#include "tests/extremes/guards.h"
#include "tests/extremes/vectors.h"
#include "tests/numeric/cases.h"

enum { MULTIPLE_SCHEMES = 2, MULTIPLE_LIGHTS = 50 }; // lights a fibre

struct multiple_law { // of one scheme in one region
    long vectors, bad;
    double top; // largest value over its bound
    long hits[GUARDS_MAX], guarded;
    double energy; // `fibre`: largest a_f + a_b
};
struct multiple_laws {
    struct multiple_law fibre, multiple;
};
// A probe of a scheme, made when it is first asked for; kept until
// multiple_close.
struct probe_dual *multiple_probe(enum dual_scheme scheme);
void multiple_close(void);

// Of `fibres` fibres with MULTIPLE_LIGHTS inclinations, lights and views each.
struct multiple_laws multiple_sweep(enum dual_scheme scheme,
                                    enum vectors_region region, int fibres);

// Vectors that sweeps of millions found and that a sweep of seconds would miss:
// those that break a law.
long multiple_seen(void);

struct multiple_truth {                           // of one region, both schemes
    struct cases_errors fibre[MULTIPLE_SCHEMES];  // of a_f, absolute
    struct cases_errors global[MULTIPLE_SCHEMES]; // of M^G, the sum
    struct cases_errors local[MULTIPLE_SCHEMES];  // of M^L
};
void multiple_compare(enum vectors_region region, int fibres,
                      struct multiple_truth *out);
void multiple_finish(struct multiple_truth *t);

#endif
