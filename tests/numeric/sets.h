// sets.h - many cases at once through the probe, and their errors.
#ifndef TESTS_NUMERIC_SETS_H
#define TESTS_NUMERIC_SETS_H

#include "tests/numeric/cases.h"

struct set { // cases with what they make
    size_t count;
    struct exact_case *c;
    float *in, *out;
    double (*want)[EXACT_MODES], (*mean)[EXACT_MODES];
};

void *sets_array(size_t count, size_t size); // zeros; the caller frees it
struct set sets_create(size_t count);
void sets_destroy(struct set *s);

// All over the legal box; and eta = 2 from both sides, ever closer, where
// caustics meet.
struct set sets_wild(size_t count);

// s->out of s->c; false, and said, when the GPU refuses.
bool sets_on_gpu(struct set *s, struct probe_setup setup);

// Errors of s->out against s->want, of the modes that hold more than 1e-5 of
// the brightest one: what is below cannot be seen, and single precision need
// not resolve it.
void sets_compare(struct set *s, struct cases_errors *e);

// False, and said, where s->out is no radiance: negative, endless, no number.
bool sets_sane(const struct set *s);

#endif
