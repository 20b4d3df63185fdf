// sky_fit_vector.h - the few loops in which a fit spends its time.
//
// Sums run in a fixed order over eight lanes whatever the processor offers, so
// a fit has the same bits on every machine with the same libm.
// Thread: any; values only.  Lengths are multiples of 16 where
// nothing else is said.
#ifndef RENDERER_SKY_FIT_VECTOR_H
#define RENDERER_SKY_FIT_VECTOR_H

#include <stddef.h>

// Sum of a[i] b[i]: products of floats are exact in double, sums are double.
double sky_fit_vector_dot(const float *a, const float *b, size_t n);
// The same of a float and a double array.
double sky_fit_vector_dot_fd(const float *a, const double *b, size_t n);
// Any length.
double sky_fit_vector_dot_dd(const double *a, const double *b, size_t n);
// y[i] += s a[i]
void sky_fit_vector_add(double *y, double s, const float *a, size_t n);

// out[i * stride + j] (j <= i < columns) = sum over rows of a_i b_j, for
// columns of `rows` floats one after the other.  Single-precision sums over
// 256 rows (which divides rows), added up in double: good to 1e-6.
// Large ones take a second thread.
void sky_fit_vector_gram(const float *a, size_t rows, size_t columns,
                         double *out, size_t stride);

// A rectangle of a table against the same rectangle of three pictures.
struct sky_fit_vector_patch {
    const float *a; // first value; rows are `stride` apart; need not be aligned
    size_t stride;
    const float *z[3]; // rows follow each other
    size_t width, rows;
};
// sum[k] = sum of a z[k].  Single precision within a lane: good to 1e-5.
void sky_fit_vector_patch_dot(const struct sky_fit_vector_patch *p,
                              double sum[3]);

#endif
