// encode_jpeg_huff.c - entropy coding of JPEG blocks.  Only coefficients that
// are not zero are visited: their places come from a 64-bit mask.
#include "renderer/encode_jpeg_huff.h"

#include <string.h>

const unsigned char encode_jpeg_huff_order[64] = {
    0,  1,  8,  16, 9,  2,  3,  10, 17, 24, 32, 25, 18, 11, 4,  5,
    12, 19, 26, 33, 40, 48, 41, 34, 27, 20, 13, 6,  7,  14, 21, 28,
    35, 42, 49, 56, 57, 50, 43, 36, 29, 22, 15, 23, 30, 37, 44, 51,
    58, 59, 52, 45, 38, 31, 39, 46, 53, 60, 61, 54, 47, 55, 62, 63};

struct table { // T.81, B.2.4.2: codes per length, symbols by length
    unsigned char counts[16];
    unsigned char symbols[162];
};

// T.81, tables K.3 and K.4.
static const struct table dc_tables[2] = {
    {{0, 1, 5, 1, 1, 1, 1, 1, 1}, {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11}},
    {{0, 3, 1, 1, 1, 1, 1, 1, 1, 1, 1}, {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11}},
};

// T.81, tables K.5 and K.6.
static const struct table ac_tables[2] = {
    {{0, 2, 1, 3, 3, 2, 4, 3, 5, 5, 4, 4, 0, 0, 1, 125},
     {0x01, 0x02, 0x03, 0x00, 0x04, 0x11, 0x05, 0x12, 0x21, 0x31, 0x41, 0x06,
      0x13, 0x51, 0x61, 0x07, 0x22, 0x71, 0x14, 0x32, 0x81, 0x91, 0xa1, 0x08,
      0x23, 0x42, 0xb1, 0xc1, 0x15, 0x52, 0xd1, 0xf0, 0x24, 0x33, 0x62, 0x72,
      0x82, 0x09, 0x0a, 0x16, 0x17, 0x18, 0x19, 0x1a, 0x25, 0x26, 0x27, 0x28,
      0x29, 0x2a, 0x34, 0x35, 0x36, 0x37, 0x38, 0x39, 0x3a, 0x43, 0x44, 0x45,
      0x46, 0x47, 0x48, 0x49, 0x4a, 0x53, 0x54, 0x55, 0x56, 0x57, 0x58, 0x59,
      0x5a, 0x63, 0x64, 0x65, 0x66, 0x67, 0x68, 0x69, 0x6a, 0x73, 0x74, 0x75,
      0x76, 0x77, 0x78, 0x79, 0x7a, 0x83, 0x84, 0x85, 0x86, 0x87, 0x88, 0x89,
      0x8a, 0x92, 0x93, 0x94, 0x95, 0x96, 0x97, 0x98, 0x99, 0x9a, 0xa2, 0xa3,
      0xa4, 0xa5, 0xa6, 0xa7, 0xa8, 0xa9, 0xaa, 0xb2, 0xb3, 0xb4, 0xb5, 0xb6,
      0xb7, 0xb8, 0xb9, 0xba, 0xc2, 0xc3, 0xc4, 0xc5, 0xc6, 0xc7, 0xc8, 0xc9,
      0xca, 0xd2, 0xd3, 0xd4, 0xd5, 0xd6, 0xd7, 0xd8, 0xd9, 0xda, 0xe1, 0xe2,
      0xe3, 0xe4, 0xe5, 0xe6, 0xe7, 0xe8, 0xe9, 0xea, 0xf1, 0xf2, 0xf3, 0xf4,
      0xf5, 0xf6, 0xf7, 0xf8, 0xf9, 0xfa}},
    {{0, 2, 1, 2, 4, 4, 3, 4, 7, 5, 4, 4, 0, 1, 2, 119},
     {0x00, 0x01, 0x02, 0x03, 0x11, 0x04, 0x05, 0x21, 0x31, 0x06, 0x12, 0x41,
      0x51, 0x07, 0x61, 0x71, 0x13, 0x22, 0x32, 0x81, 0x08, 0x14, 0x42, 0x91,
      0xa1, 0xb1, 0xc1, 0x09, 0x23, 0x33, 0x52, 0xf0, 0x15, 0x62, 0x72, 0xd1,
      0x0a, 0x16, 0x24, 0x34, 0xe1, 0x25, 0xf1, 0x17, 0x18, 0x19, 0x1a, 0x26,
      0x27, 0x28, 0x29, 0x2a, 0x35, 0x36, 0x37, 0x38, 0x39, 0x3a, 0x43, 0x44,
      0x45, 0x46, 0x47, 0x48, 0x49, 0x4a, 0x53, 0x54, 0x55, 0x56, 0x57, 0x58,
      0x59, 0x5a, 0x63, 0x64, 0x65, 0x66, 0x67, 0x68, 0x69, 0x6a, 0x73, 0x74,
      0x75, 0x76, 0x77, 0x78, 0x79, 0x7a, 0x82, 0x83, 0x84, 0x85, 0x86, 0x87,
      0x88, 0x89, 0x8a, 0x92, 0x93, 0x94, 0x95, 0x96, 0x97, 0x98, 0x99, 0x9a,
      0xa2, 0xa3, 0xa4, 0xa5, 0xa6, 0xa7, 0xa8, 0xa9, 0xaa, 0xb2, 0xb3, 0xb4,
      0xb5, 0xb6, 0xb7, 0xb8, 0xb9, 0xba, 0xc2, 0xc3, 0xc4, 0xc5, 0xc6, 0xc7,
      0xc8, 0xc9, 0xca, 0xd2, 0xd3, 0xd4, 0xd5, 0xd6, 0xd7, 0xd8, 0xd9, 0xda,
      0xe2, 0xe3, 0xe4, 0xe5, 0xe6, 0xe7, 0xe8, 0xe9, 0xea, 0xf2, 0xf3, 0xf4,
      0xf5, 0xf6, 0xf7, 0xf8, 0xf9, 0xfa}},
};

static int symbol_count(const struct table *t)
{
    int n = 0;
    for (int i = 0; i < 16; i++)
        n += t->counts[i];
    return n;
}

// T.81, Annex C: codes count upwards within a length, doubled between.
static void make_codes(uint32_t *codes, const struct table *t)
{
    uint32_t code = 0;
    const unsigned char *symbol = t->symbols;
    for (int length = 1; length <= 16; length++, code <<= 1)
        for (int i = 0; i < t->counts[length - 1]; i++, code++, symbol++) {
            uint32_t extra = *symbol & 15;
            codes[*symbol] = (code << extra) << 5 | ((uint32_t)length + extra);
        }
}

void encode_jpeg_huff_init(struct encode_jpeg_huff *h)
{
    memset(h, 0, sizeof *h);
    for (int c = 0; c < 2; c++) {
        make_codes(h->dc[c], &dc_tables[c]);
        make_codes(h->ac[c], &ac_tables[c]);
    }
    for (int z = 0; z < 64; z++) {
        int place = encode_jpeg_huff_order[z];
        for (int nibble = 0; nibble < 16; nibble++)
            if (nibble >> (place & 3) & 1)
                h->zigzag[place >> 2][nibble] |= (uint64_t)1 << z;
    }
}

static void append_table(struct buf *out, const struct table *t, int id)
{
    int n = symbol_count(t), size = 2 + 1 + 16 + n;
    const unsigned char head[5] = {0xff, 0xc4, 0, (unsigned char)size,
                                   (unsigned char)id};
    buf_append(out, head, sizeof head);
    buf_append(out, t->counts, 16);
    buf_append(out, t->symbols, (size_t)n);
}

void encode_jpeg_huff_tables(struct buf *out)
{
    for (int c = 0; c < 2; c++) {
        append_table(out, &dc_tables[c], c);
        append_table(out, &ac_tables[c], 0x10 | c);
    }
}

// Writes 32 bits; a zero byte follows each 0xff (T.81, B.1.1.5).
static inline unsigned char *write_word(unsigned char *at, uint32_t w)
{
    if ((~w - 0x01010101) & w & 0x80808080) { // some byte is 0xff
        for (int shift = 24; shift >= 0; shift -= 8) {
            *at++ = (unsigned char)(w >> shift);
            if ((w >> shift & 0xff) == 0xff)
                *at++ = 0;
        }
        return at;
    }
    const unsigned char b[4] = {(unsigned char)(w >> 24),
                                (unsigned char)(w >> 16),
                                (unsigned char)(w >> 8), (unsigned char)w};
    memcpy(at, b, 4);
    return at + 4;
}

struct writer { // the pending bits, in registers while a block is coded
    uint64_t bits;
    int count;
    unsigned char *at;
};

static inline void put(struct writer *w, uint32_t entry, uint32_t extra)
{
    int length = (int)(entry & 31);
    w->bits = w->bits << length | (entry >> 5 | extra);
    w->count += length;
    if (w->count >= 32) {
        w->count -= 32;
        w->at = write_word(w->at, (uint32_t)(w->bits >> w->count));
    }
}

static inline uint32_t size_of(int32_t v) // T.81, table F.1
{
    return v ? 32 - (uint32_t)__builtin_clz((uint32_t)(v < 0 ? -v : v)) : 0;
}

static inline uint32_t bits_of(int32_t v, uint32_t size)
{
    return ((uint32_t)v - (v < 0)) & ((1u << size) - 1);
}

static inline uint64_t to_zigzag(const struct encode_jpeg_huff *h,
                                 uint64_t nonzero)
{
    uint64_t mask = 0;
    for (int i = 0; i < 16; i++)
        mask |= h->zigzag[i][nonzero >> (4 * i) & 15];
    return mask;
}

unsigned char *encode_jpeg_huff_block(struct encode_jpeg_huff *h,
                                      unsigned char *at, int component,
                                      const int32_t coef[64], uint64_t nonzero)
{
    const uint32_t *ac = h->ac[component > 0];
    struct writer w = {h->bits, h->count, at};
    int32_t diff = coef[0] - h->last_dc[component];
    h->last_dc[component] = coef[0];
    uint32_t size = size_of(diff);
    put(&w, h->dc[component > 0][size], bits_of(diff, size));

    int last = 0;
    uint64_t mask = to_zigzag(h, nonzero) & ~(uint64_t)1;
    for (; mask; mask &= mask - 1) {
        int z = __builtin_ctzll(mask), run = z - last - 1;
        last = z;
        for (; run > 15; run -= 16)
            put(&w, ac[0xf0], 0);
        int place = encode_jpeg_huff_order[z];
        int32_t v = coef[(place & 7) * 8 + (place >> 3)];
        size = size_of(v);
        put(&w, ac[(uint32_t)run << 4 | size], bits_of(v, size));
    }
    if (last < 63)
        put(&w, ac[0], 0);
    h->bits = w.bits;
    h->count = w.count;
    return w.at;
}

unsigned char *encode_jpeg_huff_end(struct encode_jpeg_huff *h,
                                    unsigned char *at)
{
    int fill = (8 - h->count % 8) % 8;
    uint64_t bits = h->bits << fill | ((1u << fill) - 1);
    for (int left = h->count + fill - 8; left >= 0; left -= 8) {
        *at++ = (unsigned char)(bits >> left);
        if ((bits >> left & 0xff) == 0xff)
            *at++ = 0;
    }
    h->count = 0;
    return at;
}
