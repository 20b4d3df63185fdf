// encode_jpeg.c - a baseline JPEG file: headers, quantiser tables and the walk
// over the picture's MCUs.  The transform is in encode_jpeg_dct.c, the entropy
// coding in encode_jpeg_huff.c.
#include "renderer/encode.h"

#include <assert.h>
#include <string.h>

#include "renderer/encode_jpeg_dct.h"
#include "renderer/encode_jpeg_huff.h"

// T.81, tables K.1 and K.2.
static const unsigned char base_quant[2][64] = {
    {16, 11, 10, 16, 24,  40,  51,  61,  12, 12, 14, 19, 26,  58,  60,  55,
     14, 13, 16, 24, 40,  57,  69,  56,  14, 17, 22, 29, 51,  87,  80,  62,
     18, 22, 37, 56, 68,  109, 103, 77,  24, 35, 55, 64, 81,  104, 113, 92,
     49, 64, 78, 87, 103, 121, 120, 101, 72, 92, 95, 98, 112, 100, 103, 99},
    {17, 18, 24, 47, 99, 99, 99, 99, 18, 21, 26, 66, 99, 99, 99, 99,
     24, 26, 56, 99, 99, 99, 99, 99, 47, 66, 99, 99, 99, 99, 99, 99,
     99, 99, 99, 99, 99, 99, 99, 99, 99, 99, 99, 99, 99, 99, 99, 99,
     99, 99, 99, 99, 99, 99, 99, 99, 99, 99, 99, 99, 99, 99, 99, 99}};

// The rule by which libjpeg's qualities are known.
static void scale_quant(unsigned char quant[2][64], int quality)
{
    int percent = quality < 50 ? 5000 / quality : 200 - 2 * quality;
    for (int c = 0; c < 2; c++)
        for (int i = 0; i < 64; i++) {
            int q = (base_quant[c][i] * percent + 50) / 100;
            quant[c][i] = (unsigned char)(q < 1 ? 1 : q > 255 ? 255 : q);
        }
}

static void append_quant(struct buf *out, const unsigned char quant[2][64])
{
    for (int c = 0; c < 2; c++) {
        const unsigned char head[] = {0xff, 0xdb, 0, 67, (unsigned char)c};
        buf_append(out, head, sizeof head);
        for (int z = 0; z < 64; z++)
            buf_byte(out, quant[c][encode_jpeg_huff_order[z]]);
    }
}

static void put16(struct buf *out, int v)
{
    buf_byte(out, (unsigned char)(v >> 8));
    buf_byte(out, (unsigned char)v);
}

static void append_head(struct buf *out, int width, int height,
                        const unsigned char quant[2][64],
                        enum encode_chroma chroma)
{
    // Start of image; JFIF 1.02, square pixels, no thumbnail.
    static const unsigned char jfif[] = {0xff, 0xd8, 0xff, 0xe0, 0, 16, 'J',
                                         'F',  'I',  'F',  0,    1, 2,  0,
                                         0,    1,    0,    1,    0, 0};
    static const unsigned char frame[] = {0xff, 0xc0, 0, 17, 8}; // baseline
    const unsigned char luma = chroma == ENCODE_420 ? 0x22 : 0x11;
    // of each component: number, blocks across and down, quantiser
    const unsigned char components[] = {3, 1, luma, 0, 2, 0x11, 1, 3, 0x11, 1};
    // of each: number, tables of DC and AC; then the whole spectrum
    static const unsigned char scan[] = {0xff, 0xda, 0, 12,   3, 1,  0,
                                         2,    0x11, 3, 0x11, 0, 63, 0};
    buf_append(out, jfif, sizeof jfif);
    append_quant(out, quant);
    buf_append(out, frame, sizeof frame);
    put16(out, height);
    put16(out, width);
    buf_append(out, components, sizeof components);
    encode_jpeg_huff_tables(out);
    buf_append(out, scan, sizeof scan);
}

struct picture {
    const unsigned char *rgba;
    int width, height;
};

// A whole MCU of side n at (x, y) that reaches beyond the picture: the last
// column and row are repeated, which costs the fewest bits.
static void pad_tile(unsigned char *tile, int n, const struct picture *p, int x,
                     int y)
{
    int inside = p->width - x < n ? p->width - x : n;
    for (int row = 0; row < n; row++) {
        int from = y + row < p->height ? y + row : p->height - 1;
        const unsigned char *line =
            p->rgba + 4 * ((size_t)from * (size_t)p->width + (size_t)x);
        unsigned char *to = tile + 4 * n * row;
        memcpy(to, line, 4 * (size_t)inside);
        for (int i = inside; i < n; i++)
            memcpy(to + 4 * i, line + 4 * (inside - 1), 4);
    }
}

static void append_scan(struct buf *out, const struct picture *p,
                        const struct encode_jpeg_dct *dct,
                        enum encode_chroma chroma)
{
    const int n = chroma == ENCODE_420 ? 16 : 8;
    const int blocks = chroma == ENCODE_420 ? 6 : 3;
    encode_jpeg_dct_fn *run = encode_jpeg_dct_choose(chroma, false);
    const size_t stride = 4 * (size_t)p->width;
    struct encode_jpeg_huff huff;
    struct encode_jpeg_mcu mcu;
    unsigned char tile[4 * 16 * 16];
    encode_jpeg_huff_init(&huff);
    for (int y = 0; y < p->height; y += n)
        for (int x = 0; x < p->width; x += n) {
            if (x + n <= p->width && y + n <= p->height) {
                run(&mcu, dct, p->rgba + (size_t)y * stride + 4 * (size_t)x,
                    stride);
            } else {
                pad_tile(tile, n, p, x, y);
                run(&mcu, dct, tile, 4 * (size_t)n);
            }
            buf_reserve(out, 6 * ENCODE_JPEG_HUFF_BLOCK);
            unsigned char *at = out->data + out->size;
            for (int i = 0; i < blocks; i++)
                at = encode_jpeg_huff_block(
                    &huff, at, i < blocks - 2 ? 0 : i - (blocks - 3),
                    mcu.coef[i], mcu.nonzero[i]);
            out->size = (size_t)(at - out->data);
        }
    buf_reserve(out, ENCODE_JPEG_HUFF_BLOCK);
    unsigned char *end = encode_jpeg_huff_end(&huff, out->data + out->size);
    out->size = (size_t)(end - out->data);
}

void encode_jpeg(struct buf *out, const unsigned char *rgba, int width,
                 int height, int quality, enum encode_chroma chroma)
{
    assert(width >= 1 && width <= 8192 && height >= 1 && height <= 8192);
    assert(quality >= 1 && quality <= 100);
    unsigned char quant[2][64];
    struct encode_jpeg_dct dct;
    scale_quant(quant, quality);
    encode_jpeg_dct_init(&dct, (const unsigned char(*)[64])quant);
    append_head(out, width, height, (const unsigned char(*)[64])quant, chroma);
    append_scan(out, &(struct picture){rgba, width, height}, &dct, chroma);
    buf_append(out, (const unsigned char[]){0xff, 0xd9}, 2);
}
