// sky_fit_vector.c - see the header.  Compiled twice where the compiler can:
// for AVX2 and for any processor; contraction to fused multiply-adds is off
// for the whole program, so both give the same bits.
#include "renderer/sky_fit_vector.h"

#include <string.h>

#if defined(__x86_64__) && defined(__has_attribute)
#if __has_attribute(target_clones) && !defined(GLINT_SANITIZED)
#define CLONED __attribute__((target_clones("avx2", "default")))
#endif
#endif
#ifndef CLONED
#define CLONED
#endif

typedef float f8 __attribute__((vector_size(32)));
typedef float f4 __attribute__((vector_size(16)));
typedef double d4 __attribute__((vector_size(32)));

#define LOAD(v, p) memcpy(&(v), (p), sizeof(v))

CLONED double sky_fit_vector_dot(const float *a, const float *b, size_t n)
{
    d4 s0 = {0}, s1 = {0};
    for (size_t i = 0; i < n; i += 8) {
        f4 a0, a1, b0, b1;
        LOAD(a0, a + i);
        LOAD(a1, a + i + 4);
        LOAD(b0, b + i);
        LOAD(b1, b + i + 4);
        s0 += __builtin_convertvector(a0, d4) * __builtin_convertvector(b0, d4);
        s1 += __builtin_convertvector(a1, d4) * __builtin_convertvector(b1, d4);
    }
    s0 += s1;
    return (s0[0] + s0[1]) + (s0[2] + s0[3]);
}

CLONED double sky_fit_vector_dot_fd(const float *a, const double *b, size_t n)
{
    d4 s0 = {0}, s1 = {0};
    for (size_t i = 0; i < n; i += 8) {
        f4 a0, a1;
        d4 b0, b1;
        LOAD(a0, a + i);
        LOAD(a1, a + i + 4);
        LOAD(b0, b + i);
        LOAD(b1, b + i + 4);
        s0 += __builtin_convertvector(a0, d4) * b0;
        s1 += __builtin_convertvector(a1, d4) * b1;
    }
    s0 += s1;
    return (s0[0] + s0[1]) + (s0[2] + s0[3]);
}

CLONED double sky_fit_vector_dot_dd(const double *a, const double *b, size_t n)
{
    d4 s0 = {0}, s1 = {0};
    size_t i = 0;
    for (; i + 8 <= n; i += 8) {
        d4 a0, a1, b0, b1;
        LOAD(a0, a + i);
        LOAD(a1, a + i + 4);
        LOAD(b0, b + i);
        LOAD(b1, b + i + 4);
        s0 += a0 * b0;
        s1 += a1 * b1;
    }
    s0 += s1;
    double sum = (s0[0] + s0[1]) + (s0[2] + s0[3]);
    for (; i < n; i++)
        sum += a[i] * b[i];
    return sum;
}

CLONED void sky_fit_vector_add(double *y, double s, const float *a, size_t n)
{
    for (size_t i = 0; i < n; i += 4) {
        f4 v;
        d4 w;
        LOAD(v, a + i);
        LOAD(w, y + i);
        w += __builtin_convertvector(v, d4) * (d4){s, s, s, s};
        memcpy(y + i, &w, sizeof w);
    }
}

static inline double lanes(const float v[8])
{
    double a = ((double)v[0] + (double)v[1]) + ((double)v[2] + (double)v[3]);
    double b = ((double)v[4] + (double)v[5]) + ((double)v[6] + (double)v[7]);
    return a + b;
}

enum {
    CHUNK = 128,
    TALL = 4,
    WIDE = 2
}; // a chunk of 800 columns fits the
   // second-level cache; eight sums and
   // six loads fit the registers

struct tile {
    const float *a[TALL], *b[WIDE];
};

CLONED static void tile_sums(const struct tile *t, float out[TALL][WIDE][8])
{
    f8 s[TALL][WIDE] = {{{0}}};
    for (size_t i = 0; i < CHUNK; i += 8) {
        f8 a[TALL], b[WIDE];
        for (int k = 0; k < TALL; k++)
            LOAD(a[k], t->a[k] + i);
        for (int k = 0; k < WIDE; k++)
            LOAD(b[k], t->b[k] + i);
        for (int k = 0; k < TALL; k++)
            for (int l = 0; l < WIDE; l++)
                s[k][l] += a[k] * b[l];
    }
    memcpy(out, s, sizeof s);
}

void sky_fit_vector_gram(const float *a, size_t rows, size_t columns,
                         double *out, size_t stride)
{
    for (size_t i = 0; i < columns; i++)
        memset(out + i * stride, 0, (i + 1) * sizeof *out);
    for (size_t r = 0; r < rows; r += CHUNK)
        for (size_t i = 0; i < columns; i += TALL)
            for (size_t j = 0; j < i + TALL && j < columns; j += WIDE) {
                struct tile t;
                float sums[TALL][WIDE][8];
                for (size_t k = 0; k < TALL; k++)
                    t.a[k] = a + (i + k < columns ? i + k : i) * rows + r;
                for (size_t k = 0; k < WIDE; k++)
                    t.b[k] = a + (j + k < columns ? j + k : j) * rows + r;
                tile_sums(&t, sums);
                for (size_t k = 0; k < TALL && i + k < columns; k++)
                    for (size_t l = 0; l < WIDE && j + l <= i + k; l++)
                        out[(i + k) * stride + j + l] += lanes(sums[k][l]);
            }
}

CLONED void sky_fit_vector_patch_dot(const struct sky_fit_vector_patch *p,
                                     double sum[3])
{
    f8 s0 = {0}, s1 = {0}, s2 = {0};
    for (size_t r = 0; r < p->rows; r++) {
        const float *a = p->a + r * p->stride;
        size_t at = r * p->width;
        for (size_t i = 0; i < p->width; i += 8) {
            f8 v, z0, z1, z2;
            LOAD(v, a + i);
            LOAD(z0, p->z[0] + at + i);
            LOAD(z1, p->z[1] + at + i);
            LOAD(z2, p->z[2] + at + i);
            s0 += v * z0;
            s1 += v * z1;
            s2 += v * z2;
        }
    }
    float out[3][8];
    memcpy(out[0], &s0, sizeof s0);
    memcpy(out[1], &s1, sizeof s1);
    memcpy(out[2], &s2, sizeof s2);
    for (int k = 0; k < 3; k++)
        sum[k] = lanes(out[k]);
}
