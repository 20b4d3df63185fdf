// encode_png.c - PNG (ISO/IEC 15948): chunks and their checksums.  Filters are
// in encode_filter.c, the compression in encode_deflate.c.
#include "renderer/encode.h"

#include <assert.h>
#include <stdbool.h>
#include <stdint.h>
#include <string.h>

#include "renderer/encode_filter.h"

enum { SIDE_MAX = 16384 }; // rows of 64 KiB, 1 GiB in all: sizes fit an int

struct png {
    struct buf *out;
    // crc[k][b]: what byte b contributes when k more bytes follow.  Made anew
    // for each picture, in microseconds: nothing is shared between threads.
    uint32_t crc[8][256];
};

static void make_crc(uint32_t crc[8][256])
{
    for (uint32_t b = 0; b < 256; b++) {
        uint32_t c = b;
        for (int bit = 0; bit < 8; bit++)
            c = c & 1 ? 0xedb88320u ^ (c >> 1) : c >> 1;
        crc[0][b] = c;
    }
    for (int k = 1; k < 8; k++)
        for (int b = 0; b < 256; b++)
            crc[k][b] = crc[0][crc[k - 1][b] & 255] ^ (crc[k - 1][b] >> 8);
}

// CRC-32 (ISO/IEC 15948, annex D), eight bytes a turn.
static uint32_t checksum(const struct png *png, const unsigned char *p,
                         size_t n)
{
    uint32_t c = 0xffffffffu;
    for (; n >= 8; p += 8, n -= 8) {
        c ^= (uint32_t)p[0] | (uint32_t)p[1] << 8 | (uint32_t)p[2] << 16 |
             (uint32_t)p[3] << 24;
        c = png->crc[7][c & 255] ^ png->crc[6][c >> 8 & 255] ^
            png->crc[5][c >> 16 & 255] ^ png->crc[4][c >> 24] ^
            png->crc[3][p[4]] ^ png->crc[2][p[5]] ^ png->crc[1][p[6]] ^
            png->crc[0][p[7]];
    }
    for (; n > 0; p++, n--)
        c = png->crc[0][(c ^ *p) & 255] ^ (c >> 8);
    return ~c;
}

static void put32(struct buf *out, uint32_t v)
{
    const unsigned char b[4] = {(unsigned char)(v >> 24),
                                (unsigned char)(v >> 16),
                                (unsigned char)(v >> 8), (unsigned char)v};
    buf_append(out, b, 4);
}

static size_t chunk_begin(struct png *png, const char *type)
{
    size_t at = png->out->size;
    put32(png->out, 0); // the size, known at the end
    buf_append(png->out, type, 4);
    return at;
}

static void chunk_end(struct png *png, size_t at)
{
    struct buf *out = png->out;
    size_t size = out->size - at - 8;
    assert(size <= INT32_MAX); // PNG's own limit
    for (size_t i = 0; i < 4; i++)
        out->data[at + i] = (unsigned char)(size >> (24 - 8 * i));
    put32(out, checksum(png, out->data + at + 4, size + 4));
}

static bool ascii(const char *text)
{
    for (; *text; text++)
        if ((unsigned char)*text > 127)
            return false;
    return true;
}

// tEXt is Latin-1 by definition, and names of files need not be.
static void put_text(struct png *png, const char *key, const char *value)
{
    static const char flags[4] = {0}; // not compressed, no language, no other
                                      // spelling of the key
    size_t length = strlen(key);
    assert(length >= 1 && length <= 79);
    bool latin = ascii(value);
    size_t at = chunk_begin(png, latin ? "tEXt" : "iTXt");
    buf_append(png->out, key, length + 1);
    if (!latin)
        buf_append(png->out, flags, sizeof flags);
    buf_text(png->out, value);
    chunk_end(png, at);
}

static void put_pixels(struct png *png, const unsigned char *rgba, size_t width,
                       size_t height, size_t step)
{
    struct buf rows = {0};
    size_t n = height * (1 + width * step);
    encode_filter(buf_grow(&rows, n), rgba, width, height, step);
    size_t at = chunk_begin(png, "IDAT");
    encode_deflate(png->out, (struct span){rows.data, n});
    chunk_end(png, at);
    buf_finish(&rows);
}

void encode_png(struct buf *out, const unsigned char *rgba, int width,
                int height, bool alpha, const char *const *text)
{
    static const unsigned char magic[8] = {0x89, 'P',  'N',  'G',
                                           '\r', '\n', 0x1a, '\n'};
    assert(width >= 1 && width <= SIDE_MAX);
    assert(height >= 1 && height <= SIDE_MAX);
    struct png png;
    png.out = out;
    make_crc(png.crc);
    buf_append(out, magic, sizeof magic);
    size_t at = chunk_begin(&png, "IHDR");
    put32(out, (uint32_t)width);
    put32(out, (uint32_t)height);
    const unsigned char how[5] = {8, alpha ? 6 : 2, 0, 0, 0};
    buf_append(out, how, sizeof how);
    chunk_end(&png, at);
    at = chunk_begin(&png, "sRGB");
    buf_byte(out, 0); // perceptual
    chunk_end(&png, at);
    for (; text && text[0]; text += 2)
        put_text(&png, text[0], text[1]);
    put_pixels(&png, rgba, (size_t)width, (size_t)height, alpha ? 4 : 3);
    at = chunk_begin(&png, "IEND");
    chunk_end(&png, at);
}
