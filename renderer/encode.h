// encode.h - pictures to bytes: JPEG, PNG, EXR, all written here but for EXR's
// container and compression, which OpenEXRCore does into memory.
// Rows are top first and packed.  Same input, same bytes.  Output is appended.
// Arguments out of range are the caller's bug (assert), but for EXR.
// Thread: any; no state is shared.
#ifndef RENDERER_ENCODE_H
#define RENDERER_ENCODE_H

#include <stdbool.h>

#include "protocol/bytes.h"
#include "protocol/error.h"

enum encode_chroma { ENCODE_420, ENCODE_444 }; // order of output.chroma

// Baseline JPEG, JFIF, full-range BT.601 YCbCr; alpha is ignored.
// quality 1..100 as libjpeg scales its tables.  1 <= width, height <= 8192.
void encode_jpeg(struct buf *out, const unsigned char *rgba, int width,
                 int height, int quality, enum encode_chroma chroma);

// PNG, 8 bits, RGBA or (alpha = false) RGB; lossless, filtered and deflated.
// Alpha is straight (PNG's rule): the caller un-premultiplies.
// text: pairs key, value, ..., NULL written as tEXt chunks, or as iTXt where a
// value is not ASCII; NULL for none.  A key is ASCII, of 1..79 characters.
// 1 <= width, height <= 16384.
void encode_png(struct buf *out, const unsigned char *rgba, int width,
                int height, bool alpha, const char *const *text);

// Zlib stream (RFC 1950) of `in`, below 2^31 - 2^15 bytes; what encode_png
// uses.  At most 1 % + 128 bytes larger than `in`.
void encode_deflate(struct buf *out, struct span in);

struct encode_layer {
    const char *name;  // "" = R, G, B, A; else "NAME.R" ...
    const float *rgba; // [4 * width * height], premultiplied linear
    bool alpha;        // write the fourth component
};

struct encode_exr {
    int width, height;
    // Else 32-bit float, bit for bit.  Halves are rounded to the nearest and
    // clamped to +-65504, infinities too; NaN stays NaN in both.
    bool half;
    const struct encode_layer *layers;
    int layer_count;
    const char *const *text; // string attributes: key, value, ..., NULL
};

// Single-part scan-line EXR, ZIP compression.  Fails, and leaves *out as it
// was, when there are not 1..32 layers, a side is not 1..16384, two channels
// have one name, a key is that of one of the format's own attributes, or a key
// or a channel's name is empty or longer than 31 bytes.
bool encode_exr(struct buf *out, const struct encode_exr *picture,
                struct error *err);

#endif
