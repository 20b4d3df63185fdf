// encode_png.c - PNG (ISO/IEC 15948): rows filtered by the smallest sum of
// absolute differences, one IDAT, CRCs.
#include "renderer/encode.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

static uint32_t crc_table[256];

static uint32_t crc(const unsigned char *p, size_t n)
{
    if (!crc_table[1]) // the same values whoever writes them first
        for (uint32_t i = 0; i < 256; i++) {
            uint32_t c = i;
            for (int k = 0; k < 8; k++)
                c = c & 1 ? 0xedb88320u ^ (c >> 1) : c >> 1;
            crc_table[i] = c;
        }
    uint32_t c = 0xffffffffu;
    for (size_t i = 0; i < n; i++)
        c = crc_table[(c ^ p[i]) & 0xff] ^ (c >> 8);
    return ~c;
}

static void put32(struct buf *out, uint32_t v)
{
    const unsigned char b[4] = {(unsigned char)(v >> 24),
                                (unsigned char)(v >> 16),
                                (unsigned char)(v >> 8), (unsigned char)v};
    buf_append(out, b, 4);
}

static size_t chunk_begin(struct buf *out, const char *type)
{
    size_t at = out->size;
    put32(out, 0);
    buf_append(out, type, 4);
    return at;
}

static void chunk_end(struct buf *out, size_t at)
{
    uint32_t size = (uint32_t)(out->size - at - 8);
    for (int i = 0; i < 4; i++)
        out->data[at + (size_t)i] = (unsigned char)(size >> (24 - 8 * i));
    put32(out, crc(out->data + at + 4, size + 4));
}

static unsigned char paeth(int a, int b, int c)
{
    int pa = abs(b - c), pb = abs(a - c), pc = abs(a + b - 2 * c);
    return (unsigned char)(pa <= pb && pa <= pc ? a : pb <= pc ? b : c);
}

// Filters a row in one way; up is the row above, zeros for the first.
// Both rows have `step` zero bytes in front.
static unsigned filter(int kind, const unsigned char *row,
                       const unsigned char *up, unsigned char *out,
                       const size_t size[2])
{
    const size_t n = size[0], step = size[1];
    unsigned sum = 0;
    for (size_t i = 0; i < n; i++) {
        int a = row[i - step], b = up[i], c = up[i - step], v = row[i];
        switch (kind) {
        case 1:
            v -= a;
            break;
        case 2:
            v -= b;
            break;
        case 3:
            v -= (a + b) >> 1;
            break;
        case 4:
            v -= paeth(a, b, c);
            break;
        default:
            break;
        }
        out[i] = (unsigned char)v;
        sum += (unsigned)abs((signed char)out[i]);
    }
    return sum;
}

static void fetch(const unsigned char *rgba, size_t width, size_t step,
                  unsigned char *row)
{
    if (step == 4) {
        memcpy(row, rgba, 4 * width);
        return;
    }
    for (size_t x = 0; x < width; x++)
        memcpy(row + 3 * x, rgba + 4 * x, 3);
}

static void put_pixels(struct buf *out, const unsigned char *rgba, size_t width,
                       size_t height, size_t step)
{
    const size_t n = width * step;
    unsigned char *space = bytes_zalloc(4, n + step);
    unsigned char *row = space + step, *up = row + n + step;
    unsigned char *tried = up + n, *best = tried + n + step;
    struct buf raw = {0};
    buf_reserve(&raw, height * (n + 1));
    for (size_t y = 0; y < height; y++) {
        unsigned least = ~0u;
        unsigned char kind = 0;
        fetch(rgba + 4 * width * y, width, step, row);
        for (int k = 0; k < 5; k++) {
            unsigned sum = filter(k, row, up, tried, (size_t[2]){n, step});
            if (sum >= least)
                continue;
            least = sum;
            kind = (unsigned char)k;
            unsigned char *swap = best;
            best = tried;
            tried = swap;
        }
        buf_byte(&raw, kind);
        buf_append(&raw, best, n);
        memcpy(up, row, n);
    }
    size_t at = chunk_begin(out, "IDAT");
    encode_deflate(out, (struct span){raw.data, raw.size});
    chunk_end(out, at);
    buf_finish(&raw);
    free(space);
}

void encode_png(struct buf *out, const unsigned char *rgba, int width,
                int height, bool alpha, const char *const *text)
{
    static const unsigned char magic[8] = {0x89, 'P',  'N',  'G',
                                           '\r', '\n', 0x1a, '\n'};
    buf_append(out, magic, sizeof magic);
    size_t at = chunk_begin(out, "IHDR");
    put32(out, (uint32_t)width);
    put32(out, (uint32_t)height);
    const unsigned char how[5] = {8, alpha ? 6 : 2, 0, 0, 0};
    buf_append(out, how, sizeof how);
    chunk_end(out, at);
    at = chunk_begin(out, "sRGB");
    buf_byte(out, 0);
    chunk_end(out, at);
    for (; text && text[0]; text += 2) {
        at = chunk_begin(out, "tEXt");
        buf_append(out, text[0], strlen(text[0]) + 1);
        buf_text(out, text[1]);
        chunk_end(out, at);
    }
    put_pixels(out, rgba, (size_t)width, (size_t)height, alpha ? 4 : 3);
    at = chunk_begin(out, "IEND");
    chunk_end(out, at);
}
