// sky_fit_solve.h - dense linear algebra of a fit, in double.
// Thread: any; values only.
#ifndef RENDERER_SKY_FIT_SOLVE_H
#define RENDERER_SKY_FIT_SOLVE_H

#include <stdbool.h>
#include <stddef.h>

// Lower triangle of a -> its Cholesky factor, in place.  Row i begins at
// a + i * stride.  False when a is not positive definite (or holds NaN).
bool sky_fit_solve_cholesky(double *a, size_t n, size_t stride);
// x := L^-1 x, and x := L^-T x.
void sky_fit_solve_forward(const double *l, size_t n, size_t stride, double *x);
void sky_fit_solve_backward(const double *l, size_t n, size_t stride,
                            double *x);

// Least x.(a x)/2 - x.b over x >= 0 for a symmetric positive definite a (both
// triangles filled): Lawson and Hanson's active set, from a feasible x, which
// is most of the answer when the problem changed little.
void sky_fit_solve_nnls(const double *a, size_t n, size_t stride,
                        const double *b, double *x);

#endif
