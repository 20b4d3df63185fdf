// encode_jpeg_dct.c - colour conversion, forward DCT and quantisation of one
// MCU, in float, eight lanes wide.  Which pixels form an MCU, and what becomes
// of the coefficients, is left to encode_jpeg.c and encode_jpeg_huff.c.
//
// A block is eight vectors, one per row.  The column transform is then plain
// arithmetic on whole vectors; the block is transposed once, transformed again
// and left transposed.  Functions take vectors by address, because passing
// them by value depends on the instruction set of caller and callee.
#include "renderer/encode_jpeg_dct.h"

#include <math.h>
#include <string.h>

typedef float v8f __attribute__((vector_size(32)));
typedef int32_t v8i __attribute__((vector_size(32)));
typedef uint32_t v8u __attribute__((vector_size(32)));

#define INLINE static inline __attribute__((always_inline))

#if defined(__has_builtin)
#if __has_builtin(__builtin_shufflevector)
#define SHUFFLE(a, b, ...) __builtin_shufflevector(a, b, __VA_ARGS__)
#endif
#endif
#ifndef SHUFFLE // gcc before 12
#define PICK(a, b, i) ((i) < 8 ? (a)[(i)&7] : (b)[(i)&7])
#define SHUFFLE(a, b, i, j, k, l, m, n, o, p) \
    { \
        PICK(a, b, i), PICK(a, b, j), PICK(a, b, k), PICK(a, b, l), \
            PICK(a, b, m), PICK(a, b, n), PICK(a, b, o), PICK(a, b, p) \
    }
#endif

// Full-range BT.601 (JFIF 1.02): weights of R, G, B.
static const float to_y[3] = {0.299f, 0.587f, 0.114f};
static const float to_cb[3] = {-0.168735892f, -0.331264108f, 0.5f};
static const float to_cr[3] = {0.5f, -0.418687589f, -0.081312411f};

struct rgb8 {
    v8f r, g, b;
};

INLINE void to_float(v8f *out, const v8u *in)
{
    v8i s = (v8i)*in; // below 2^31: the signed conversion is one instruction
    *out = __builtin_convertvector(s, v8f);
}

INLINE void load_pixels(v8u *out, const unsigned char *rgba)
{
    memcpy(out, rgba, sizeof *out);
#if __BYTE_ORDER__ == __ORDER_BIG_ENDIAN__
    for (int i = 0; i < 8; i++)
        (*out)[i] = __builtin_bswap32((*out)[i]);
#endif
}

INLINE void split_pixels(struct rgb8 *c, const unsigned char *rgba)
{
    v8u p, one;
    load_pixels(&p, rgba);
    one = p & 255;
    to_float(&c->r, &one);
    one = (p >> 8) & 255;
    to_float(&c->g, &one);
    one = (p >> 16) & 255;
    to_float(&c->b, &one);
}

INLINE void mix(v8f *out, const struct rgb8 *c, const float w[3], float offset)
{
    *out = c->r * w[0] + c->g * w[1] + c->b * w[2] + offset;
}

// Sums of 2x2 pixels, eight of them from 16x2 pixels.
INLINE void sum_quads(struct rgb8 *c, const unsigned char *rgba, size_t stride)
{
    v8u p, rb[2], g[2]; // red and blue travel in the two halves of one lane
    for (int i = 0; i < 2; i++) {
        load_pixels(&p, rgba + 32 * i);
        rb[i] = p & 0xff00ff;
        g[i] = (p >> 8) & 255;
        load_pixels(&p, rgba + stride + 32 * i);
        rb[i] += p & 0xff00ff;
        g[i] += (p >> 8) & 255;
    }
    v8u even = SHUFFLE(rb[0], rb[1], 0, 2, 4, 6, 8, 10, 12, 14);
    v8u odd = SHUFFLE(rb[0], rb[1], 1, 3, 5, 7, 9, 11, 13, 15);
    v8u sum = even + odd, one = sum & 0xffff;
    to_float(&c->r, &one);
    one = sum >> 16;
    to_float(&c->b, &one);
    even = (v8u)SHUFFLE(g[0], g[1], 0, 2, 4, 6, 8, 10, 12, 14);
    odd = (v8u)SHUFFLE(g[0], g[1], 1, 3, 5, 7, 9, 11, 13, 15);
    sum = even + odd;
    to_float(&c->g, &sum);
}

// One-dimensional DCT of the eight vectors in b, lane by lane.  The flow graph
// is that of Arai, Agui and Nakajima (1988), figure 4: five multiplications;
// coefficient k comes out as 2 sqrt(2) cos(k pi / 16) times the orthonormal
// one for k > 0, 2 sqrt(2) times for k = 0, which the quantiser's factor
// takes back.
INLINE void transform(v8f b[8])
{
    v8f s07 = b[0] + b[7], d07 = b[0] - b[7];
    v8f s16 = b[1] + b[6], d16 = b[1] - b[6];
    v8f s25 = b[2] + b[5], d25 = b[2] - b[5];
    v8f s34 = b[3] + b[4], d34 = b[3] - b[4];

    v8f outer = s07 + s34, outer_d = s07 - s34;
    v8f inner = s16 + s25, inner_d = s16 - s25;
    b[0] = outer + inner;
    b[4] = outer - inner;
    v8f turn = (inner_d + outer_d) * 0.707106781f; // cos(pi/4)
    b[2] = outer_d + turn;
    b[6] = outer_d - turn;

    v8f low = d34 + d25, mid = d25 + d16, high = d16 + d07;
    v8f both = (low - high) * 0.382683433f; // sin(pi/8)
    v8f a = low * 0.541196100f + both;      // cos(pi/8) - sin(pi/8)
    v8f c = high * 1.306562965f + both;     // cos(pi/8) + sin(pi/8)
    v8f m = mid * 0.707106781f;
    v8f plus = d07 + m, minus = d07 - m;
    b[1] = plus + c;
    b[7] = plus - c;
    b[5] = minus + a;
    b[3] = minus - a;
}

INLINE void transpose(v8f b[8])
{
    v8f t[8], u[8];
    for (int i = 0; i < 8; i += 2) { // pairs of rows, lanes interleaved
        t[i] = (v8f)SHUFFLE(b[i], b[i + 1], 0, 8, 1, 9, 4, 12, 5, 13);
        t[i + 1] = (v8f)SHUFFLE(b[i], b[i + 1], 2, 10, 3, 11, 6, 14, 7, 15);
    }
    for (int i = 0; i < 8; i += 4)
        for (int j = 0; j < 2; j++) {
            const v8f *p = &t[i + j], *q = &t[i + j + 2];
            u[i + 2 * j] = (v8f)SHUFFLE(*p, *q, 0, 1, 8, 9, 4, 5, 12, 13);
            u[i + 2 * j + 1] = (v8f)SHUFFLE(*p, *q, 2, 3, 10, 11, 6, 7, 14, 15);
        }
    for (int i = 0; i < 4; i++) { // halves of 128 bits
        b[i] = (v8f)SHUFFLE(u[i], u[i + 4], 0, 1, 2, 3, 8, 9, 10, 11);
        b[i + 4] = (v8f)SHUFFLE(u[i], u[i + 4], 4, 5, 6, 7, 12, 13, 14, 15);
    }
}

INLINE void finish_block(struct encode_jpeg_mcu *mcu, int block, v8f b[8],
                         const float scale[64])
{
    transform(b);
    transpose(b);
    transform(b);
    // Adding 1.5 * 2^23 leaves the rounded value in the low bits.
    const float magic = 12582912.0f;
    v8i seen = {0}, bit = {1, 1, 1, 1, 1, 1, 1, 1};
    for (int u = 0; u < 8; u++) {
        v8f s;
        memcpy(&s, scale + 8 * u, sizeof s);
        v8i q = (v8i)(b[u] * s + magic) - 0x4b400000;
        memcpy(&mcu->coef[block][8 * u], &q, sizeof q);
        seen |= (q != 0) & bit;
        bit += bit;
    }
    uint64_t nonzero = 0;
    for (int v = 0; v < 8; v++)
        nonzero |= (uint64_t)(uint32_t)seen[v] << (8 * v);
    mcu->nonzero[block] = nonzero;
}

INLINE void mcu_444(struct encode_jpeg_mcu *mcu,
                    const struct encode_jpeg_dct *dct,
                    const unsigned char *rgba, size_t stride)
{
    v8f y[8], cb[8], cr[8];
    for (int row = 0; row < 8; row++) {
        struct rgb8 c;
        split_pixels(&c, rgba + (size_t)row * stride);
        mix(&y[row], &c, to_y, -128);
        mix(&cb[row], &c, to_cb, 0);
        mix(&cr[row], &c, to_cr, 0);
    }
    finish_block(mcu, 0, y, dct->scale[0]);
    finish_block(mcu, 1, cb, dct->scale[1]);
    finish_block(mcu, 2, cr, dct->scale[1]);
}

INLINE void mcu_420(struct encode_jpeg_mcu *mcu,
                    const struct encode_jpeg_dct *dct,
                    const unsigned char *rgba, size_t stride)
{
    v8f b[8], cr[8];
    struct rgb8 c;
    for (int block = 0; block < 4; block++) {
        const unsigned char *at =
            rgba + (size_t)(block >> 1) * 8 * stride + (block & 1) * 32;
        for (int row = 0; row < 8; row++) {
            split_pixels(&c, at + (size_t)row * stride);
            mix(&b[row], &c, to_y, -128);
        }
        finish_block(mcu, block, b, dct->scale[0]);
    }
    for (int row = 0; row < 8; row++) { // a quarter: the mean of 2x2 pixels
        sum_quads(&c, rgba + (size_t)row * 2 * stride, stride);
        mix(&b[row], &c, to_cb, 0);
        mix(&cr[row], &c, to_cr, 0);
        b[row] *= 0.25f;
        cr[row] *= 0.25f;
    }
    finish_block(mcu, 4, b, dct->scale[1]);
    finish_block(mcu, 5, cr, dct->scale[1]);
}

#define BUILDS(suffix, attribute) \
    attribute static void run_444_##suffix(struct encode_jpeg_mcu *m, \
                                           const struct encode_jpeg_dct *d, \
                                           const unsigned char *p, size_t s) \
    { \
        mcu_444(m, d, p, s); \
    } \
    attribute static void run_420_##suffix(struct encode_jpeg_mcu *m, \
                                           const struct encode_jpeg_dct *d, \
                                           const unsigned char *p, size_t s) \
    { \
        mcu_420(m, d, p, s); \
    }
BUILDS(plain, )
#if defined(__x86_64__)
// Without "fma": a contracted multiplication would round differently.
BUILDS(avx2, __attribute__((target("avx2"))))
#endif

encode_jpeg_dct_fn *encode_jpeg_dct_choose(enum encode_chroma chroma,
                                           bool plain)
{
    bool quarter = chroma == ENCODE_420;
#if defined(__x86_64__)
    // Chosen here and not by target_clones: its resolver would run before a
    // sanitizer's runtime is up, and compilers differ in where they allow it.
    if (!plain && __builtin_cpu_supports("avx2"))
        return quarter ? run_420_avx2 : run_444_avx2;
#endif
    (void)plain;
    return quarter ? run_420_plain : run_444_plain;
}

void encode_jpeg_dct_init(struct encode_jpeg_dct *dct,
                          const unsigned char quant[2][64])
{
    double factor[8];
    for (int k = 0; k < 8; k++)
        factor[k] = k ? 4 * cos(k * 3.14159265358979323846 / 16) : sqrt(8);
    for (int c = 0; c < 2; c++)
        for (int u = 0; u < 8; u++)
            for (int v = 0; v < 8; v++)
                dct->scale[c][8 * u + v] =
                    (float)(1 / (factor[u] * factor[v] * quant[c][8 * v + u]));
}
