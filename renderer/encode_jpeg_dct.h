// encode_jpeg_dct.h - pixels of one MCU to quantised DCT coefficients.
//
// An MCU is what one turn of a JPEG scan codes: 8x8 pixels and three blocks
// (4:4:4) or 16x16 pixels and six (4:2:0: Y Y Y Y Cb Cr).
// Thread: any (no shared state).
#ifndef RENDERER_ENCODE_JPEG_DCT_H
#define RENDERER_ENCODE_JPEG_DCT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "renderer/encode.h"

struct encode_jpeg_dct {
    // Reciprocals of quantiser times AAN factor, [luma, chroma][8 * u + v].
    _Alignas(32) float scale[2][64];
};

struct encode_jpeg_mcu {
    // u, v: horizontal, vertical frequency.  Index 8 * u + v (a column lies
    // together: the second pass of the transform leaves it that way).
    _Alignas(32) int32_t coef[6][64];
    uint64_t nonzero[6]; // bit 8 * v + u is set where the coefficient is not 0
};

// Transforms the MCU whose first pixel is rgba; stride in bytes.
typedef void encode_jpeg_dct_fn(struct encode_jpeg_mcu *mcu,
                                const struct encode_jpeg_dct *dct,
                                const unsigned char *rgba, size_t stride);

// quant: [luma, chroma][8 * v + u], 1..255.
void encode_jpeg_dct_init(struct encode_jpeg_dct *dct,
                          const unsigned char quant[2][64]);

// The build for this processor; plain = the one that runs anywhere.  Both do
// the same IEEE operations in the same order: their results are equal.
encode_jpeg_dct_fn *encode_jpeg_dct_choose(enum encode_chroma chroma,
                                           bool plain);

#endif
