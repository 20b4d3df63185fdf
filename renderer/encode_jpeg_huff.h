// encode_jpeg_huff.h - quantised coefficients to the bits of a baseline scan,
// with the Huffman tables that T.81 prints as typical (Annex K.3).
// Thread: any (no shared state).
#ifndef RENDERER_ENCODE_JPEG_HUFF_H
#define RENDERER_ENCODE_JPEG_HUFF_H

#include <stdint.h>

#include "protocol/bytes.h"

struct encode_jpeg_huff {
    // Code words, already shifted to leave room for the value's own bits, and
    // in the low 5 bits the length of both.  Class 0 luma, 1 chroma.
    uint32_t dc[2][12], ac[2][256];
    uint64_t zigzag[16][16]; // nibble of a natural-order mask to zigzag mask
    uint64_t bits;           // pending, the newest lowest
    int count;               // of pending bits, < 32 between calls
    int last_dc[3];
};

// The bytes that one block can need at most: 20 bits of DC and 63 times 26 of
// AC, each byte stuffed, and what is pending.
enum { ENCODE_JPEG_HUFF_BLOCK = 2 * (208 + 8) };

void encode_jpeg_huff_init(struct encode_jpeg_huff *h);

// Appends the four DHT segments.
void encode_jpeg_huff_tables(struct buf *out);

// Codes one block (coef, nonzero as in encode_jpeg_dct.h) of component 0..2 at
// `at`, where ENCODE_JPEG_HUFF_BLOCK bytes are free; returns the new end.
unsigned char *encode_jpeg_huff_block(struct encode_jpeg_huff *h,
                                      unsigned char *at, int component,
                                      const int32_t coef[64], uint64_t nonzero);

// Pads the last byte with ones.
unsigned char *encode_jpeg_huff_end(struct encode_jpeg_huff *h,
                                    unsigned char *at);

extern const unsigned char encode_jpeg_huff_order[64]; // zigzag to 8 * v + u

#endif
