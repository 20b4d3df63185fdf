// encode_filter.c - all five filters of a row at once, sixteen bytes wide, in
// eight-bit arithmetic throughout; then the cheapest is copied.
//
// Unlike the decoder, which needs each byte before the next, the encoder knows
// all neighbours beforehand: a, b and c (left, above, above left) are the same
// rows read at other offsets.
#include "renderer/encode_filter.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "protocol/bytes.h"

typedef uint8_t v16 __attribute__((vector_size(16)));
typedef uint16_t v8 __attribute__((vector_size(16)));

enum {
    KINDS = 5, // none, sub, up, average, Paeth
    WIDE = 16,
    TALLY_MAX = 255 // vectors until a lane of v8, at most 256 each, could wrap
};

struct rows {
    unsigned char *row, *up; // zeros before and after
    unsigned char *made[KINDS];
    size_t n;    // bytes a row
    size_t step; // bytes a pixel
};

static inline v16 load(const unsigned char *p)
{
    v16 v;
    memcpy(&v, p, sizeof v);
    return v;
}

static inline v16 choose(v16 mask, v16 yes, v16 no)
{
    return (yes & mask) | (no & ~mask);
}

static inline v16 apart(v16 x, v16 y)
{
    v16 minus = (v16)(x < y);
    return ((x - y) ^ minus) - minus;
}

// Which of a, b, c is nearest to a + b - c; in doubt a, then b.
static inline v16 paeth(v16 a, v16 b, v16 c)
{
    v16 pa = apart(b, c), pb = apart(a, c);
    // c's distance is |(b - c) + (a - c)|.  Where both have one sign it exceeds
    // pa and pb, so any large number will do; where one is zero, a or b is
    // nearest whatever c's distance.
    v16 opposite = (v16)(b > c) ^ (v16)(a > c);
    v16 pc = apart(pa, pb) | ~opposite;
    v16 take_a = (v16)(pa <= pb) & (v16)(pa <= pc);
    return choose(take_a, a, choose((v16)(pb <= pc), b, c));
}

static inline void keep(unsigned char *to, v16 difference, v16 inside, v8 *sum)
{
    memcpy(to, &difference, sizeof difference);
    v16 minus = (v16)(difference > 127);
    v8 pairs = (v8)(((difference ^ minus) - minus) & inside);
    *sum += (pairs & 255) + (pairs >> 8);
}

static inline void filter_at(const struct rows *r, size_t i, v16 inside,
                             v8 sum[KINDS])
{
    v16 x = load(r->row + i), a = load(r->row + i - r->step);
    v16 b = load(r->up + i), c = load(r->up + i - r->step);
    keep(r->made[0] + i, x, inside, &sum[0]);
    keep(r->made[1] + i, x - a, inside, &sum[1]);
    keep(r->made[2] + i, x - b, inside, &sum[2]);
    v16 mean = (a & b) + ((a ^ b) >> 1); // of a + b, without the ninth bit
    keep(r->made[3] + i, x - mean, inside, &sum[3]);
    keep(r->made[4] + i, x - paeth(a, b, c), inside, &sum[4]);
}

static void filter_row(const struct rows *r, uint32_t total[KINDS])
{
    static const unsigned char edge[2 * WIDE] = {
        255, 255, 255, 255, 255, 255, 255, 255,
        255, 255, 255, 255, 255, 255, 255, 255}; // then zeros
    memset(total, 0, KINDS * sizeof *total);
    for (size_t i = 0; i < r->n;) {
        v8 sum[KINDS] = {{0}};
        for (int k = 0; k < TALLY_MAX && i < r->n; k++, i += WIDE) {
            size_t left = r->n - i;
            filter_at(r, i, load(edge + (left < WIDE ? WIDE - left : 0)), sum);
        }
        for (int kind = 0; kind < KINDS; kind++)
            for (int lane = 0; lane < 8; lane++)
                total[kind] += sum[kind][lane];
    }
}

static void fetch(const struct rows *r, const unsigned char *rgba, size_t width)
{
    if (r->step == 4) {
        memcpy(r->row, rgba, 4 * width);
        return;
    }
    for (size_t x = 0; x < width; x++)
        memcpy(r->row + 3 * x, rgba + 4 * x, 3);
}

static void swap_rows(struct rows *r)
{
    unsigned char *above = r->row;
    r->row = r->up;
    r->up = above;
}

void encode_filter(unsigned char *out, const unsigned char *rgba, size_t width,
                   size_t height, size_t step)
{
    struct rows r = {.n = width * step, .step = step};
    const size_t room = WIDE + r.n + WIDE;
    unsigned char *space = bytes_zalloc(2 + KINDS, room);
    r.row = space + WIDE;
    r.up = r.row + room;
    for (int kind = 0; kind < KINDS; kind++)
        r.made[kind] = space + (2 + (size_t)kind) * room;
    for (size_t y = 0; y < height; y++) {
        uint32_t total[KINDS];
        int best = 0;
        fetch(&r, rgba + 4 * width * y, width);
        filter_row(&r, total);
        for (int kind = 1; kind < KINDS; kind++)
            if (total[kind] < total[best])
                best = kind;
        *out++ = (unsigned char)best;
        memcpy(out, r.made[best], r.n);
        out += r.n;
        swap_rows(&r);
    }
    free(space);
}
