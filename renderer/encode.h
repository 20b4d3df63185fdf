// encode.h - pictures to bytes: JPEG, PNG, EXR, all written here but for EXR's
// container and compression, which OpenEXRCore does into memory.
// Rows are top first and packed.  Same input, same bytes.  Output is appended.
// Thread: any; each function keeps its scratch on the stack or in *out.
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
// text: pairs key, value, ..., NULL written as tEXt chunks; NULL for none.
void encode_png(struct buf *out, const unsigned char *rgba, int width,
                int height, bool alpha, const char *const *text);

// Zlib stream (RFC 1950) of `in`; what encode_png uses.
void encode_deflate(struct buf *out, struct span in);

struct encode_layer {
    const char *name;    // "" = R, G, B, A; else "NAME.R" ...
    const float *rgba;   // [4 * width * height], premultiplied linear
    bool alpha;          // write the fourth component
};

struct encode_exr {
    int width, height;
    bool half; // else 32-bit float; halves are clamped to +-65504
    const struct encode_layer *layers;
    int layer_count;
    const char *const *text; // string attributes: key, value, ..., NULL
};

// Single-part scan-line EXR, ZIP compression.
bool encode_exr(struct buf *out, const struct encode_exr *picture,
                struct error *err);

#endif
