// groom_files.h - .hair files for the tests, written byte by byte from the
// format (docs/FORMATS.md) and not from the reader.
#ifndef TESTS_UNIT_GROOM_FILES_H
#define TESTS_UNIT_GROOM_FILES_H

#include <stdint.h>
#include <string.h>

#include "renderer/groom.h"

enum {
    SEGMENTS = 1,
    POINTS = 2,
    THICKNESS = 4,
    TRANSPARENCY = 8,
    COLOURS = 16
};

static inline void put_u16(struct buf *b, unsigned v)
{
    buf_byte(b, (unsigned char)v);
    buf_byte(b, (unsigned char)(v >> 8));
}

static inline void put_u32(struct buf *b, uint32_t v)
{
    put_u16(b, v & 0xffff);
    put_u16(b, v >> 16);
}

static inline void put_f32(struct buf *b, float f)
{
    uint32_t bits;
    memcpy(&bits, &f, sizeof bits);
    put_u32(b, bits);
}

static inline void set_u32(struct buf *b, size_t at, uint32_t v)
{
    for (size_t i = 0; i < 4; i++)
        b->data[at + i] = (unsigned char)(v >> (8 * i));
}

static inline void set_f32(struct buf *b, size_t at, float f)
{
    uint32_t bits;
    memcpy(&bits, &f, sizeof bits);
    set_u32(b, at, bits);
}

static inline void put_header(struct buf *b, uint32_t strands, uint32_t points,
                              uint32_t arrays)
{
    buf_append(b, "HAIR", 4);
    put_u32(b, strands);
    put_u32(b, points);
    put_u32(b, arrays);
    put_u32(b, 2);      // default segments
    put_f32(b, 0.25f);  // default thickness
    put_f32(b, 0.125f); // default transparency
    put_f32(b, 0.5f);
    put_f32(b, 0.25f);
    put_f32(b, 0.75f);
    while (b->size < 128)
        buf_byte(b, 0);
}

// Three strands of 2, 1 and 3 segments with every array that `arrays` names:
// an odd count, so all floats stand 2 bytes off.
static const unsigned three[3] = {2, 1, 3};
static inline struct buf three_strands(uint32_t arrays)
{
    struct buf b = {0};
    put_header(&b, 3, 9, arrays);
    for (int s = 0; s < 3 && (arrays & SEGMENTS); s++)
        put_u16(&b, three[s]);
    for (int i = 0; i < 27; i++)
        put_f32(&b, (float)i * 0.5f - 3);
    for (int i = 0; i < 9 && (arrays & THICKNESS); i++)
        put_f32(&b, 0.01f * (float)(i + 1));
    for (int i = 0; i < 9 && (arrays & TRANSPARENCY); i++)
        put_f32(&b, (float)i / 8);
    for (int i = 0; i < 27 && (arrays & COLOURS); i++)
        put_f32(&b, (float)i / 26);
    return b;
}
static const uint32_t all_arrays = 31;
// Offsets in the file that three_strands(31) makes.
enum {
    AT_SEGMENTS = 128,
    AT_POINTS = AT_SEGMENTS + 6,
    AT_THICKNESS = AT_POINTS + 108,
    AT_TRANSPARENCY = AT_THICKNESS + 36,
    AT_COLOURS = AT_TRANSPARENCY + 36,
    AT_END = AT_COLOURS + 108
};

static inline struct groom *parse(struct buf *b, struct error *err)
{
    *err = (struct error){0};
    return groom_parse((struct span){b->data, b->size}, "dir/x.hair", err);
}

#endif
