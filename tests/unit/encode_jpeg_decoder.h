// encode_jpeg_decoder.h - a baseline JPEG decoder in double precision,
// written from ISO/IEC 10918-1 (T.81) and apart from the encoder.  It is
// strict: what a baseline stream may not hold makes it fail, with the reason in
// `why`. It counts what the stream uses, so that a test can tell what it
// exercised.
#ifndef TESTS_UNIT_ENCODE_JPEG_DECODER_H
#define TESTS_UNIT_ENCODE_JPEG_DECODER_H

#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "protocol/bytes.h"

struct decoder_table { // T.81, F.2.2.3
    bool present;
    int first_code[17], first_index[17], count[17];
    unsigned char symbol[256];
    int symbols;
};

struct decoder_component {
    int h, v, quant;
    int blocks_x, blocks_y; // whole MCUs
    int *coef;              // [blocks_y * blocks_x][64], quantised, 8 * v + u
    int last_dc;
};

struct decoder {
    const unsigned char *at, *end;
    const char *why;
    int width, height, max_h, max_v;
    int quant[4][64]; // 8 * v + u
    int quant_zigzag[4][64];
    struct decoder_table table[2][4]; // [DC, AC][id]
    struct decoder_component part[3];
    uint32_t bits;
    int bit_count;
    int long_runs, stuffed, largest_dc; // what the stream made use of
};

static inline bool decoder_bad(struct decoder *d, const char *why)
{
    if (!d->why)
        d->why = why;
    return false;
}

static inline int decoder_place(int z) // T.81, figure A.6, walked
{
    int u = 0, v = 0;
    for (; z > 0; z--)
        if ((u + v) % 2 == 0) { // going up and right
            if (u == 7)
                v++;
            else if (v == 0)
                u++;
            else
                u++, v--;
        } else {
            if (v == 7)
                u++;
            else if (u == 0)
                v++;
            else
                v++, u--;
        }
    return 8 * v + u;
}

static inline bool decoder_quant(struct decoder *d, const unsigned char *p,
                                 int n)
{
    for (; n >= 65; p += 65, n -= 65) {
        if (p[0] > 3)
            return decoder_bad(d, "DQT: not 8 bits, or id above 3");
        for (int z = 0; z < 64; z++) {
            d->quant_zigzag[p[0]][z] = p[1 + z];
            d->quant[p[0]][decoder_place(z)] = p[1 + z];
        }
    }
    return n == 0 || decoder_bad(d, "DQT: length");
}

static inline bool decoder_huffman(struct decoder *d, const unsigned char *p,
                                   int n)
{
    if (n < 17 || p[0] > 0x11 || (p[0] & 15) > 1)
        return decoder_bad(d, "DHT: head");
    struct decoder_table *t = &d->table[p[0] >> 4][p[0] & 15];
    memset(t, 0, sizeof *t);
    int code = 0;
    for (int l = 1; l <= 16; l++) {
        t->first_code[l] = code;
        t->first_index[l] = t->symbols;
        t->count[l] = p[l];
        t->symbols += p[l];
        code += p[l];
        if (code > (1 << l) - 1) // all ones is not a code
            return decoder_bad(d, "DHT: too many codes");
        code <<= 1;
    }
    if (n != 17 + t->symbols || t->symbols > 256)
        return decoder_bad(d, "DHT: length");
    memcpy(t->symbol, p + 17, (size_t)t->symbols);
    t->present = true;
    return true;
}

static inline bool decoder_frame(struct decoder *d, const unsigned char *p,
                                 int n)
{
    if (n != 15 || p[0] != 8 || p[5] != 3)
        return decoder_bad(d, "SOF0: not 8 bits and three components");
    d->height = p[1] << 8 | p[2];
    d->width = p[3] << 8 | p[4];
    for (int c = 0; c < 3; c++) {
        struct decoder_component *k = &d->part[c];
        if (p[6 + 3 * c] != c + 1) // JFIF
            return decoder_bad(d, "SOF0: component id");
        k->h = p[7 + 3 * c] >> 4;
        k->v = p[7 + 3 * c] & 15;
        k->quant = p[8 + 3 * c];
        d->max_h = k->h > d->max_h ? k->h : d->max_h;
        d->max_v = k->v > d->max_v ? k->v : d->max_v;
    }
    int mcus_x = (d->width + 8 * d->max_h - 1) / (8 * d->max_h);
    int mcus_y = (d->height + 8 * d->max_v - 1) / (8 * d->max_v);
    for (int c = 0; c < 3; c++) {
        struct decoder_component *k = &d->part[c];
        k->blocks_x = mcus_x * k->h;
        k->blocks_y = mcus_y * k->v;
        k->coef = bytes_zalloc((size_t)k->blocks_x * (size_t)k->blocks_y,
                               64 * sizeof *k->coef);
    }
    return true;
}

static inline int decoder_bit(struct decoder *d)
{
    if (d->bit_count == 0) {
        if (d->at >= d->end)
            return decoder_bad(d, "scan: ends early");
        d->bits = *d->at++;
        d->bit_count = 8;
        if (d->bits == 0xff) {
            if (d->at >= d->end || *d->at++ != 0)
                return decoder_bad(d, "scan: marker inside");
            d->stuffed++;
        }
    }
    d->bit_count--;
    return d->bits >> d->bit_count & 1;
}

static inline int decoder_symbol(struct decoder *d,
                                 const struct decoder_table *t)
{
    int code = 0;
    for (int l = 1; l <= 16 && !d->why; l++) {
        code = code << 1 | decoder_bit(d);
        int i = code - t->first_code[l];
        if (i >= 0 && i < t->count[l])
            return t->symbol[t->first_index[l] + i];
    }
    decoder_bad(d, "scan: no such code");
    return 0;
}

static inline int decoder_value(struct decoder *d, int size) // F.2.2.1
{
    int v = 0;
    for (int i = 0; i < size; i++)
        v = v << 1 | decoder_bit(d);
    return size > 0 && v < 1 << (size - 1) ? v - (1 << size) + 1 : v;
}

static inline void decoder_block(struct decoder *d, int c, int *coef)
{
    struct decoder_component *k = &d->part[c];
    int size = decoder_symbol(d, &d->table[0][c > 0]);
    if (size > 11)
        decoder_bad(d, "scan: DC size");
    if (d->why)
        return;
    d->largest_dc = size > d->largest_dc ? size : d->largest_dc;
    k->last_dc += decoder_value(d, size);
    coef[0] = k->last_dc;
    for (int z = 1; z < 64 && !d->why; z++) {
        int symbol = decoder_symbol(d, &d->table[1][c > 0]);
        if (symbol == 0)
            return;
        z += symbol >> 4;
        size = symbol & 15;
        d->long_runs += symbol == 0xf0;
        if (z > 63 || size > 10 || (size == 0 && symbol != 0xf0))
            decoder_bad(d, "scan: AC symbol");
        else if (size > 0)
            coef[decoder_place(z)] = decoder_value(d, size);
    }
}

static inline bool decoder_scan(struct decoder *d)
{
    const int nx = d->part[0].blocks_x / d->part[0].h;
    const int ny = d->part[0].blocks_y / d->part[0].v;
    for (int m = 0; m < nx * ny && !d->why; m++)
        for (int c = 0; c < 3; c++) {
            const struct decoder_component *k = &d->part[c];
            for (int i = 0; i < k->h * k->v && !d->why; i++) {
                int x = m % nx * k->h + i % k->h;
                int y = m / nx * k->v + i / k->h;
                decoder_block(d, c, k->coef + 64 * (y * k->blocks_x + x));
            }
        }
    while (d->bit_count > 0 && !d->why)
        if (decoder_bit(d) != 1) // F.1.2.3
            decoder_bad(d, "scan: padding is not ones");
    return !d->why;
}

static inline bool decoder_segment(struct decoder *d, int marker, int n)
{
    const unsigned char *p = d->at;
    switch (marker) {
    case 0xe0:
        return (n >= 14 && memcmp(p, "JFIF", 5) == 0) ||
               decoder_bad(d, "APP0: not JFIF");
    case 0xdb:
        return decoder_quant(d, p, n);
    case 0xc4:
        return decoder_huffman(d, p, n);
    case 0xc0:
        return decoder_frame(d, p, n);
    case 0xda:
        return (n == 10 && memcmp(p, "\3\1\0\2\x11\3\x11\0\77\0", 10) == 0) ||
               decoder_bad(d, "SOS: components or spectral range");
    default:
        return decoder_bad(d, "unexpected marker");
    }
}

// Decodes to quantised coefficients; false with d->why.  decoder_finish frees.
static inline bool decoder_run(struct decoder *d, struct span in)
{
    memset(d, 0, sizeof *d);
    d->at = in.data;
    d->end = in.data + in.size;
    if (in.size < 4 || d->at[0] != 0xff || d->at[1] != 0xd8)
        return decoder_bad(d, "no SOI");
    for (d->at += 2; !d->why;) {
        if (d->end - d->at < 4 || d->at[0] != 0xff)
            return decoder_bad(d, "no marker");
        int marker = d->at[1], n = (d->at[2] << 8 | d->at[3]) - 2;
        d->at += 4;
        if (n < 0 || n > d->end - d->at || !decoder_segment(d, marker, n))
            return decoder_bad(d, "segment length");
        d->at += n;
        if (marker == 0xda)
            break;
    }
    if (!d->part[0].coef)
        return decoder_bad(d, "no SOF0");
    if (!decoder_scan(d))
        return false;
    return (d->end - d->at == 2 && memcmp(d->at, "\xff\xd9", 2) == 0) ||
           decoder_bad(d, "no EOI where the scan ends");
}

static inline void decoder_finish(struct decoder *d)
{
    for (int c = 0; c < 3; c++)
        free(d->part[c].coef);
}

#endif
