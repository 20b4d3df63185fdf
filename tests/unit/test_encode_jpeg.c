// test_encode_jpeg.c - what encode_jpeg writes is decoded by a strict decoder
// written apart from it, and every coefficient is compared with a transform in
// double precision of the same pixels.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "renderer/encode.h"
#include "renderer/encode_jpeg_dct.h"
#include "tests/check.h"
#include "tests/unit/encode_jpeg_decoder.h"
#include "tests/unit/encode_picture.h"

struct picture {
    int width, height;
    unsigned char *rgba;
};

static struct picture picture_make(int width, int height)
{
    size_t n = 4 * (size_t)width * (size_t)height;
    return (struct picture){width, height, bytes_zalloc(n, 1)};
}

static struct picture picture_noise(int width, int height, uint64_t seed)
{
    struct picture p = picture_make(width, height);
    for (size_t i = 0; i < 4 * (size_t)width * (size_t)height; i++)
        p.rgba[i] = (unsigned char)picture_random(&seed);
    return p;
}

// Soft colours with some noise: what quantisers of every quality meet.
static struct picture picture_mixed(int width, int height)
{
    struct picture p = picture_make(width, height);
    uint64_t seed = 7;
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++) {
            unsigned char *q =
                p.rgba + 4 * ((size_t)y * (size_t)width + (size_t)x);
            double noise = 60 * (double)picture_uniform(&seed) - 30;
            q[0] = (unsigned char)(127 + 90 * sin(0.31 * x) + noise);
            q[1] = (unsigned char)(127 + 90 * sin(0.17 * y) - noise);
            q[2] = (unsigned char)(127 + 90 * sin(0.11 * (x + y)) + noise);
            q[3] = (unsigned char)picture_random(&seed); // must not matter
        }
    return p;
}

// BT.601 (JFIF 1.02) of the pixel at (x, y), edges repeated; c 0..2 = Y Cb Cr,
// Y less 128, Cb and Cr about 0.
static double sample(const struct picture *p, int c, int x, int y)
{
    static const double weight[3][3] = {{0.299, 0.587, 0.114},
                                        {-0.299 / 1.772, -0.587 / 1.772, 0.5},
                                        {0.5, -0.587 / 1.402, -0.114 / 1.402}};
    x = x < p->width ? x : p->width - 1;
    y = y < p->height ? y : p->height - 1;
    const unsigned char *q =
        p->rgba + 4 * ((size_t)y * (size_t)p->width + (size_t)x);
    double s = c == 0 ? -128 : 0;
    for (int i = 0; i < 3; i++)
        s += weight[c][i] * q[i];
    return s;
}

static double basis(int k, int x) // T.81, A.3.3
{
    static double table[8][8];
    if (table[0][0] == 0)
        for (int i = 0; i < 8; i++)
            for (int j = 0; j < 8; j++)
                table[i][j] = 0.5 * cos((2 * j + 1) * i * M_PI / 16) *
                              (i ? 1 : sqrt(0.5));
    return table[k][x];
}

// out[8 v + u] = sum over y, x of in[8 y + x] basis(v, y) basis(u, x), or, if
// back, its inverse.
static void transform(double out[64], const double in[64], bool back)
{
    double half[64];
    for (int y = 0; y < 8; y++)
        for (int u = 0; u < 8; u++) {
            double s = 0;
            for (int x = 0; x < 8; x++)
                s += in[8 * y + x] * (back ? basis(x, u) : basis(u, x));
            half[8 * y + u] = s;
        }
    for (int v = 0; v < 8; v++)
        for (int u = 0; u < 8; u++) {
            double s = 0;
            for (int y = 0; y < 8; y++)
                s += half[8 * y + u] * (back ? basis(y, v) : basis(v, y));
            out[8 * v + u] = s;
        }
}

static void reference_block(const struct picture *p, int c, int step, int bx,
                            int by, double out[64])
{
    double in[64];
    for (int i = 0; i < 64; i++) {
        int x = (8 * bx + i % 8) * step, y = (8 * by + i / 8) * step;
        in[i] = 0;
        for (int k = 0; k < step * step; k++)
            in[i] += sample(p, c, x + k % step, y + k / step);
        in[i] /= step * step;
    }
    transform(out, in, false);
}

struct compared {
    double worst;    // |coefficient - exact / quantiser|
    double error[3]; // mean square error per component, of what it keeps
    double step[3];  // mean of quantiser^2 / 12
};

// The exact transform of every block against the decoded coefficients.
static struct compared compare(const struct decoder *d, const struct picture *p)
{
    struct compared out = {0};
    for (int c = 0; c < 3; c++) {
        const struct decoder_component *k = &d->part[c];
        const int *quant = d->quant[k->quant];
        const int blocks = k->blocks_x * k->blocks_y;
        for (int b = 0; b < blocks; b++) {
            double exact[64];
            reference_block(p, c, d->max_h / k->h, b % k->blocks_x,
                            b / k->blocks_x, exact);
            for (int i = 0; i < 64; i++) {
                double off = k->coef[64 * b + i] - exact[i] / quant[i];
                out.worst = fmax(out.worst, fabs(off));
                out.error[c] += off * off * quant[i] * quant[i] / 64;
            }
        }
        out.error[c] /= blocks;
        for (int i = 0; i < 64; i++)
            out.step[c] += quant[i] * quant[i] / 12.0 / 64;
    }
    return out;
}

static bool decode(struct decoder *d, const struct picture *p, int quality,
                   enum encode_chroma chroma)
{
    struct buf out = {0};
    encode_jpeg(&out, p->rgba, p->width, p->height, quality, chroma);
    bool ok = decoder_run(d, (struct span){out.data, out.size});
    if (!ok)
        printf("  %dx%d quality %d chroma %d: %s\n", p->width, p->height,
               quality, chroma == ENCODE_420 ? 420 : 444, d->why);
    buf_finish(&out);
    return ok;
}

// A coefficient is the exact one, rounded; float arithmetic may decide
// otherwise only where the exact one lies half-way.  Coefficients reach 1024,
// float holds 2^-24 of that in each of some twenty operations: 1e-3.
static const double half_way = 0.5 + 1e-3;

static void check_picture(const struct picture *p, int quality)
{
    for (int chroma = 0; chroma < 2; chroma++) {
        struct decoder d;
        int side = chroma == ENCODE_420 ? 2 : 1;
        if (CHECK(decode(&d, p, quality, (enum encode_chroma)chroma)) &&
            CHECK(d.width == p->width && d.height == p->height) &&
            CHECK(d.part[0].h == side && d.part[0].v == side))
            CHECK_ATMOST(compare(&d, p).worst, half_way);
        decoder_finish(&d);
    }
}

static void test_sizes(void)
{
    static const int sizes[][2] = {{1, 1},   {2, 1},   {1, 2},    {7, 5},
                                   {8, 8},   {9, 8},   {15, 17},  {16, 16},
                                   {17, 16}, {33, 31}, {8192, 1}, {1, 8192}};
    check_case("jpeg_sizes");
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
        struct picture p = picture_noise(sizes[i][0], sizes[i][1], 3 + i);
        check_picture(&p, 90);
        free(p.rgba);
    }
}

static void test_qualities(void)
{
    check_case("jpeg_coefficients_at_every_quality");
    struct picture p = picture_mixed(50, 37);
    for (int quality = 1; quality <= 100; quality++)
        check_picture(&p, quality);
    free(p.rgba);
}

// T.81, tables K.1 and K.2, in zigzag order.
static const unsigned char luma[64] = {
    16, 11, 12,  14,  12,  10, 16, 14,  13,  14,  18,  17,  16, 19,  24,  40,
    26, 24, 22,  22,  24,  49, 35, 37,  29,  40,  58,  51,  61, 60,  57,  51,
    56, 55, 64,  72,  92,  78, 64, 68,  87,  69,  55,  56,  80, 109, 81,  87,
    95, 98, 103, 104, 103, 62, 77, 113, 121, 112, 100, 120, 92, 101, 103, 99};
static const unsigned char chroma_start[13] = {17, 18, 18, 24, 21, 24, 47,
                                               26, 26, 47, 99, 66, 56};

static int scaled(int base, int quality) // libjpeg's rule
{
    int percent = quality < 50 ? 5000 / quality : 200 - 2 * quality;
    int q = (base * percent + 50) / 100;
    return q < 1 ? 1 : q > 255 ? 255 : q;
}

static void test_quantisers(void)
{
    check_case("jpeg_quantisers_follow_libjpeg");
    struct picture p = picture_noise(8, 8, 1);
    for (int quality = 1; quality <= 100; quality++) {
        struct decoder d;
        CHECK(decode(&d, &p, quality, ENCODE_444));
        int wrong = d.part[0].quant != 0 || d.part[1].quant != 1 ||
                    d.part[2].quant != 1;
        for (int z = 0; z < 64; z++) {
            int base = z < 13 ? chroma_start[z] : z == 13 ? 66 : 99;
            wrong += d.quant_zigzag[0][z] != scaled(luma[z], quality);
            wrong += d.quant_zigzag[1][z] != scaled(base, quality);
        }
        CHECK_ATMOST(wrong, 0);
        decoder_finish(&d);
    }
    free(p.rgba);
}

static void test_tables(void)
{
    check_case("jpeg_huffman_tables_hold_every_symbol_once");
    struct picture p = picture_noise(8, 8, 1);
    struct decoder d;
    CHECK(decode(&d, &p, 50, ENCODE_420));
    for (int c = 0; c < 2; c++) {
        int seen[2][256] = {0};
        for (int k = 0; k < 2; k++)
            for (int i = 0; i < d.table[k][c].symbols; i++)
                seen[k][d.table[k][c].symbol[i]]++;
        for (int s = 0; s < 256; s++) { // T.81, F.1.2.1.1 and F.1.2.2.1
            bool size = (s & 15) >= 1 && (s & 15) <= 10;
            CHECK(seen[0][s] == (s < 12));
            CHECK(seen[1][s] == (size || s == 0 || s == 0xf0));
        }
    }
    decoder_finish(&d);
    free(p.rgba);
}

// Runs of more than 15 zeros, stuffed bytes, the largest steps of DC.
static void test_corners(void)
{
    check_case("jpeg_long_runs_stuffing_and_large_steps");
    struct picture p = picture_make(64, 64);
    for (int i = 0; i < 64 * 64; i++) {
        int x = i % 64, y = i / 64;
        int v = x / 16 % 2 ? 255 : 0;
        if (y >= 32) // the highest frequency alone: a run of 62
            v = (int)(127.5 + 120 * basis(7, x % 8) * basis(7, y % 8) * 4);
        memset(p.rgba + 4 * i, v, 4);
    }
    for (int quality = 10; quality <= 100; quality += 30)
        check_picture(&p, quality);
    struct decoder d;
    CHECK(decode(&d, &p, 100, ENCODE_444));
    CHECK(d.long_runs > 0);
    CHECK(d.largest_dc == 11);
    decoder_finish(&d);
    free(p.rgba);
    p = picture_noise(64, 64, 9);
    CHECK(decode(&d, &p, 100, ENCODE_444));
    CHECK(d.stuffed > 0);
    decoder_finish(&d);
    free(p.rgba);
}

// The largest error of a decoded flat colour, in levels of R, G, B before they
// are rounded, and that which its quantisers allow.
static void check_flat(const unsigned char rgb[3], int quality,
                       enum encode_chroma chroma)
{
    struct picture p = picture_make(9, 9);
    for (int i = 0; i < 81; i++)
        memcpy(p.rgba + 4 * i, rgb, 3);
    struct decoder d;
    CHECK(decode(&d, &p, quality, chroma));
    double yuv[3], allowed[3];
    int waves = 0; // coefficients that a flat colour does not have
    for (int c = 0; c < 3; c++) {
        const struct decoder_component *k = &d.part[c];
        const int *quant = d.quant[k->quant];
        yuv[c] = k->coef[0] * quant[0] / 8.0 + (c == 0 ? 128 : 0);
        allowed[c] = quant[0] / 16.0 + 1e-3; // half a step of DC
        for (int i = 0; i < 64 * k->blocks_x * k->blocks_y; i++)
            if (k->coef[i] != (i % 64 == 0 ? k->coef[0] : 0))
                waves++;
    }
    CHECK_ATMOST(waves, 0);
    double r = yuv[0] + 1.402 * yuv[2], b = yuv[0] + 1.772 * yuv[1];
    double g = (yuv[0] - 0.299 * r - 0.114 * b) / 0.587;
    CHECK_ATMOST(fabs(r - rgb[0]), allowed[0] + 1.402 * allowed[2]);
    CHECK_ATMOST(fabs(b - rgb[2]), allowed[0] + 1.772 * allowed[1]);
    CHECK_ATMOST(fabs(g - rgb[1]),
                 allowed[0] + 0.3442 * allowed[1] + 0.7142 * allowed[2]);
    if (quality == 100) { // within a level once rounded
        CHECK_ATMOST(fabs(round(r) - rgb[0]), 1);
        CHECK_ATMOST(fabs(round(g) - rgb[1]), 1);
        CHECK_ATMOST(fabs(round(b) - rgb[2]), 1);
    }
    decoder_finish(&d);
    free(p.rgba);
}

static void test_flat(void)
{
    check_case("jpeg_flat_colours");
    for (int i = 0; i < 125; i++) {
        unsigned char rgb[3] = {(unsigned char)(i % 5 * 255 / 4),
                                (unsigned char)(i / 5 % 5 * 255 / 4),
                                (unsigned char)(i / 25 * 255 / 4)};
        check_flat(rgb, 100, i % 2 ? ENCODE_420 : ENCODE_444);
        check_flat(rgb, 1 + i * 98 / 124, i % 2 ? ENCODE_444 : ENCODE_420);
    }
}

// A quantiser of step q that meets all remainders alike leaves q^2 / 12; what
// it drops whole, because it is smaller than q / 2, leaves less or at most
// three times that.  Hair is mostly of the first kind at high quality.
static void test_hair(void)
{
    check_case("jpeg_hair_720x480");
    struct picture p = picture_make(720, 480);
    picture_hair8(p.rgba, p.width, p.height);
    double before = INFINITY;
    static const int qualities[] = {30, 75, 95};
    for (int i = 0; i < 3; i++) {
        struct decoder d;
        CHECK(decode(&d, &p, qualities[i], i == 1 ? ENCODE_420 : ENCODE_444));
        struct compared c = compare(&d, &p);
        CHECK_ATMOST(c.worst, half_way);
        for (int k = 0; k < 3; k++)
            CHECK_ATMOST(c.error[k], c.step[k]);
        CHECK_ATMOST(c.error[0], before);
        before = c.error[0];
        decoder_finish(&d);
    }
    free(p.rgba);
}

// The samples of one component, [8 blocks_y][8 blocks_x].
static double *samples_of(const struct decoder *d, int c)
{
    const struct decoder_component *k = &d->part[c];
    const int wide = 8 * k->blocks_x, *quant = d->quant[k->quant];
    double *out = bytes_alloc(sizeof *out * 8 * (size_t)(wide * k->blocks_y));
    for (int b = 0; b < k->blocks_x * k->blocks_y; b++) {
        double in[64], block[64];
        for (int i = 0; i < 64; i++)
            in[i] = k->coef[64 * b + i] * quant[i];
        transform(block, in, true);
        for (int i = 0; i < 64; i++)
            out[(b / k->blocks_x * 8 + i / 8) * wide + b % k->blocks_x * 8 +
                i % 8] = block[i];
    }
    return out;
}

static double level(double v) // as a picture viewer has it
{
    return fmax(0, fmin(255, round(v)));
}

// Signal to noise of R, G and B as a plain viewer shows them, in dB.
static double psnr(const struct decoder *d, const struct picture *p)
{
    double *plane[3], sum = 0;
    for (int c = 0; c < 3; c++)
        plane[c] = samples_of(d, c);
    for (int y = 0; y < p->height; y++)
        for (int x = 0; x < p->width; x++) {
            const unsigned char *q = p->rgba + 4 * (y * p->width + x);
            double s[3];
            for (int c = 0; c < 3; c++) {
                const struct decoder_component *k = &d->part[c];
                int fx = x * k->h / d->max_h, fy = y * k->v / d->max_v;
                s[c] = plane[c][fy * 8 * k->blocks_x + fx];
            }
            double luma_s = s[0] + 128;
            double r = level(luma_s + 1.402 * s[2]) - q[0];
            double g = level(luma_s - 0.344136 * s[1] - 0.714136 * s[2]) - q[1];
            double b = level(luma_s + 1.772 * s[1]) - q[2];
            sum += r * r + g * g + b * b;
        }
    for (int c = 0; c < 3; c++)
        free(plane[c]);
    return 10 * log10(255 * 255 * 3.0 * p->width * p->height / sum);
}

// At quality 100 all steps are 1.  Remainders that are spread evenly leave 1/12
// in Y, Cb, Cr, which the way back to R, G, B makes 0.243 on average, and the
// rounding of those adds 1/12 again: 0.326, 53.0 dB.  Coefficients that are
// nearer to zero leave less.
static void test_noise(void)
{
    check_case("jpeg_better_quality_less_noise");
    struct picture p = picture_make(240, 161);
    picture_hair8(p.rgba, p.width, p.height);
    double before[2] = {0, 0};
    for (int quality = 1; quality <= 100; quality += quality == 1 ? 9 : 10) {
        double now[2] = {0, 0};
        for (int chroma = 0; chroma < 2; chroma++) {
            struct decoder d;
            if (CHECK(decode(&d, &p, quality, (enum encode_chroma)chroma)))
                now[chroma] = psnr(&d, &p);
            CHECK(now[chroma] > before[chroma]);
            before[chroma] = now[chroma];
            decoder_finish(&d);
        }
        CHECK(now[ENCODE_444] >= now[ENCODE_420]);
    }
    CHECK(before[ENCODE_444] >= 52.9);
    free(p.rgba);
}

static void test_same_bytes(void)
{
    check_case("jpeg_appended_and_deterministic");
    struct picture p = picture_mixed(123, 77);
    struct buf a = {0}, b = {0};
    buf_text(&a, "before");
    buf_reserve(&b, 1 << 20);
    encode_jpeg(&a, p.rgba, p.width, p.height, 80, ENCODE_420);
    for (int i = 3; i < 4 * p.width * p.height; i += 4)
        p.rgba[i] ^= 0x55; // alpha is ignored
    encode_jpeg(&b, p.rgba, p.width, p.height, 80, ENCODE_420);
    CHECK(memcmp(a.data, "before", 6) == 0);
    CHECK(a.size == b.size + 6 && memcmp(a.data + 6, b.data, b.size) == 0);
    buf_finish(&a);
    buf_finish(&b);
    free(p.rgba);
}

static void test_builds(void)
{
    check_case("jpeg_transform_is_the_same_on_every_processor");
    unsigned char quant[2][64];
    uint64_t seed = 5;
    for (int i = 0; i < 128; i++)
        quant[i / 64][i % 64] = (unsigned char)(1 + i % 7);
    struct encode_jpeg_dct dct;
    int unequal = 0, untold = 0;
    encode_jpeg_dct_init(&dct, (const unsigned char(*)[64])quant);
    for (int turn = 0; turn < 2000; turn++) {
        struct picture p = picture_noise(16, 16, seed++);
        enum encode_chroma chroma = turn % 2 ? ENCODE_420 : ENCODE_444;
        struct encode_jpeg_mcu one = {0}, other = {0};
        encode_jpeg_dct_choose(chroma, true)(&one, &dct, p.rgba, 64);
        encode_jpeg_dct_choose(chroma, false)(&other, &dct, p.rgba, 64);
        unequal += memcmp(&one, &other, sizeof one) != 0;
        for (int b = 0; b < (turn % 2 ? 6 : 3); b++)
            for (int i = 0; i < 64; i++) {
                bool told = one.nonzero[b] >> (i % 8 * 8 + i / 8) & 1;
                untold += told != (one.coef[b][i] != 0);
            }
        free(p.rgba);
    }
    CHECK_ATMOST(unequal, 0);
    CHECK_ATMOST(untold, 0);
}

int main(void)
{
    test_sizes();
    test_qualities();
    test_quantisers();
    test_tables();
    test_corners();
    test_flat();
    test_hair();
    test_noise();
    test_same_bytes();
    test_builds();
    return check_end();
}
