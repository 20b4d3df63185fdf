// cases.h - random and extreme cases for the numeric tests, and the way in
// which their errors are measured.
#ifndef TESTS_NUMERIC_CASES_H
#define TESTS_NUMERIC_CASES_H

#include <stddef.h>
#include <stdint.h>

#include "renderer/exact.h"
#include "renderer/probe.h"

enum cases_kind {
    CASES_TYPICAL, // the papers' values in use, |theta| < 60 deg
    CASES_BROAD,   // eta 1.3..2, beta 2..20 deg apart, |theta| < 85 deg
    CASES_KINDS
};

// Reproducible: the same state gives the same cases everywhere.
double cases_uniform(uint64_t *state, double lo, double hi);

// Every number is a float, so that the shader sees the same case.  One in
// seven is eccentric when `eccentric` is set.
struct exact_case cases_random(uint64_t *state, enum cases_kind kind,
                               int eccentric);

void cases_to_floats(const struct exact_case *c, float out[PROBE_INPUTS]);
struct exact_case cases_from_doubles(const double in[PROBE_INPUTS]);

// |got - want| / max(|want|, 5 % of the mode's mean over phi_o): where a mode
// is almost dark its error is judged by the light that it has elsewhere.
double cases_error(double got, double want, double mean);

// A list of errors and what is asked of it.
struct cases_errors {
    double *error;
    size_t count, cap;
};
void cases_add(struct cases_errors *e, double error);
// The share-th quantile, 0..1; NaN counts as infinite.  Sorts.
double cases_quantile(struct cases_errors *e, double share);
void cases_finish(struct cases_errors *e);

// What must be the same: mirrored in the normal plane (0: all theta and alpha
// change sign), mirrored along the fibre (1: all phi change sign), the ellipse
// turned by a quarter with its axes exchanged (2).
struct exact_case cases_mirror(struct exact_case c, int kind);

#endif
