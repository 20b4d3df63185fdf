// metric.h - how far a picture is from its reference, and how sure that is.
//
// Radiance is compared at places (or pixels), three channels each, linear:
//   rel_rmse     sqrt(mean (x - r)^2) / mean r
//   rel_mse      mean ((x - r)^2 / (r^2 + 0.01))
//   mean_signed  mean (x - r) / mean r
//   p99          99th percentile of |x - r| / mean r
// all over places and channels alike.  A reference that is itself a mean of
// random paths has a variance; its share of the squares is taken off the first
// two, so that they mean the error and not the noise (a result below zero
// counts as zero).  p99 keeps the noise.
// Pictures as displayed, 8 bits: PSNR, and SSIM after Z. Wang et al. 2004.
// Thread: any (no state).
#ifndef RENDERER_METRIC_H
#define RENDERER_METRIC_H

#include <stddef.h>
#include <stdint.h>

struct metric_pairs {
    size_t count;           // places
    const double *x;        // [3 * count] what is judged
    const double *r;        // [3 * count] what is true
    const double *variance; // [3 * count] of r, or NULL: r is exact
};

struct metric_value {
    double value, low, high; // low, high: 95 % interval
};

struct metric_errors {
    struct metric_value rel_rmse, rel_mse, mean_signed, p99;
    double noise; // sqrt(mean variance) / mean r: what was taken off
    double mean;  // mean r
};

// Intervals by the bootstrap over places (percentile method, 1000 times, the
// same random numbers on every call).  No places or a black reference: NaN.
void metric_errors(const struct metric_pairs *p, struct metric_errors *out);

// The q-quantile by nearest rank: the smallest value that at least q of all do
// not exceed.  n >= 1; values may be in any order and stay.
double metric_quantile(const double *values, size_t n, double q);

// The median with the interval that order statistics give: between two ranks
// that enclose the median in at least 95 % of all samples, whatever their
// distribution; the extremes where n < 6 has no such ranks.
struct metric_value metric_median(const double *values, size_t n);

// Linear premultiplied RGBA over a background colour, times 2^stops, by the
// sRGB curve to 8 bits (IEC 61966-2-1); out: 3 * pixels.
void metric_display(const float *rgba, size_t pixels, const float colour[3],
                    double stops, uint8_t *out);

// Of 8-bit values, dB; infinite where all are equal.
double metric_psnr(const uint8_t *a, const uint8_t *b, size_t values);

// Mean SSIM of the lumas (Rec. 709 weights) of two RGB8 pictures: Gaussian
// window of 11 x 11, deviation 1.5, K1 = 0.01, K2 = 0.03, range 255 (Wang
// 2004, eq 13 and section III-C), windows wholly inside.  NaN where none fits.
double metric_ssim(const uint8_t *a, const uint8_t *b, int width, int height);

#endif
