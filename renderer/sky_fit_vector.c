// sky_fit_vector.c - see the header.  Compiled twice where the compiler can:
// for AVX2 and for any processor; contraction to fused multiply-adds is off
// for the whole program, so both give the same bits.
#include "renderer/sky_fit_vector.h"

#include <pthread.h>
#include <string.h>

// clang 14 gives an exported clone another name, so that nobody finds it.
#if defined(__x86_64__) && defined(__has_attribute) && !defined(__clang__)
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

// A chunk of 320 columns (80 lights) fits the second-level cache; eight sums
// and three operands fit the registers.
enum { CHUNK = 256, TALL = 4, WIDE = 2, THREAD_COLUMNS = 128 };

struct tile {
    const float *a[TALL], *b[WIDE];
};

// Written out: sums in arrays would live in memory at -O2.
CLONED static void tile_sums(const struct tile *t, float out[TALL][WIDE][8])
{
    f8 s00 = {0}, s01 = {0}, s10 = {0}, s11 = {0};
    f8 s20 = {0}, s21 = {0}, s30 = {0}, s31 = {0};
    const float *a0 = t->a[0], *a1 = t->a[1], *a2 = t->a[2], *a3 = t->a[3];
    const float *b0 = t->b[0], *b1 = t->b[1];
    for (size_t i = 0; i < CHUNK; i += 8) {
        f8 x, y, v;
        LOAD(x, b0 + i);
        LOAD(y, b1 + i);
        LOAD(v, a0 + i);
        s00 += v * x;
        s01 += v * y;
        LOAD(v, a1 + i);
        s10 += v * x;
        s11 += v * y;
        LOAD(v, a2 + i);
        s20 += v * x;
        s21 += v * y;
        LOAD(v, a3 + i);
        s30 += v * x;
        s31 += v * y;
    }
    const f8 s[TALL][WIDE] = {{s00, s01}, {s10, s11}, {s20, s21}, {s30, s31}};
    memcpy(out, s, sizeof s);
}

struct gram { // rows begin..end - 1 of the triangle
    const float *a;
    size_t rows, columns, stride, begin, end;
    double *out;
};

static void gram_tile(const struct gram *g, size_t r, size_t i, size_t j)
{
    struct tile t;
    float sums[TALL][WIDE][8];
    for (size_t k = 0; k < TALL; k++)
        t.a[k] = g->a + (i + k < g->columns ? i + k : i) * g->rows + r;
    for (size_t k = 0; k < WIDE; k++)
        t.b[k] = g->a + (j + k < g->columns ? j + k : j) * g->rows + r;
    tile_sums(&t, sums);
    for (size_t k = 0; k < TALL && i + k < g->end; k++)
        for (size_t l = 0; l < WIDE && j + l <= i + k; l++)
            g->out[(i + k) * g->stride + j + l] += lanes(sums[k][l]);
}

static void *gram_part(void *argument)
{
    const struct gram *g = argument;
    for (size_t i = g->begin; i < g->end; i++)
        memset(g->out + i * g->stride, 0, (i + 1) * sizeof *g->out);
    for (size_t r = 0; r < g->rows; r += CHUNK)
        for (size_t i = g->begin; i < g->end; i += TALL)
            for (size_t j = 0; j < i + TALL && j < g->columns; j += WIDE)
                gram_tile(g, r, i, j);
    return NULL;
}

void sky_fit_vector_gram(const float *a, size_t rows, size_t columns,
                         double *out, size_t stride)
{
    struct gram whole = {a, rows, columns, stride, 0, columns, out};
    struct gram half = whole;
    pthread_t thread;
    // 0.7 of the rows hold half of a triangle.  Every sum is made by one
    // thread in one order, so the bits do not depend on the threads.
    half.end = columns * 7 / 10 / TALL * TALL;
    if (columns < THREAD_COLUMNS ||
        pthread_create(&thread, NULL, gram_part, &half) != 0) {
        gram_part(&whole);
        return;
    }
    whole.begin = half.end;
    gram_part(&whole);
    pthread_join(thread, NULL);
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
