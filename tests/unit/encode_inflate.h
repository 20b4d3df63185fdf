// encode_inflate.h - a zlib stream undone, bit by bit, from RFC 1950 and 1951.
// Stricter than a decoder need be: every code must be complete (a Kraft sum of
// exactly one) and nothing may follow the stream.
#ifndef TESTS_UNIT_ENCODE_INFLATE_H
#define TESTS_UNIT_ENCODE_INFLATE_H

#include <stdbool.h>
#include <stdint.h>
#include <string.h>

#include "protocol/bytes.h"

struct inflate {
    struct span in;
    size_t at; // bits read
    struct buf out;
    const char *bad; // the first thing wrong, NULL: nothing
    int blocks;
    int longest;  // code of a literal or length, in bits
    int farthest; // distance
};

struct inflate_code { // how many codes of a length; their symbols in order
    int count[16], symbol[288];
};

static inline void inflate_bad(struct inflate *z, const char *why)
{
    if (!z->bad)
        z->bad = why;
}

static inline unsigned inflate_bits(struct inflate *z, int n)
{
    unsigned v = 0;
    for (int i = 0; i < n; i++, z->at++) {
        if (z->at / 8 >= z->in.size) {
            inflate_bad(z, "the stream ends early");
            return 0;
        }
        v |= (unsigned)(z->in.data[z->at / 8] >> (z->at % 8) & 1) << i;
    }
    return v;
}

static inline void inflate_make(struct inflate *z, struct inflate_code *code,
                                const int *length, int n)
{
    int next[17] = {0}, kraft = 0;
    memset(code, 0, sizeof *code);
    for (int s = 0; s < n; s++)
        code->count[length[s]]++;
    code->count[0] = 0;
    for (int l = 1; l < 16; l++) {
        kraft += code->count[l] << (15 - l);
        next[l + 1] = next[l] + code->count[l];
    }
    if (kraft != 1 << 15)
        inflate_bad(z, "a code is not complete");
    for (int s = 0; s < n; s++)
        if (length[s] > 0)
            code->symbol[next[length[s]]++] = s;
}

static inline int inflate_symbol(struct inflate *z,
                                 const struct inflate_code *code)
{
    int value = 0, first = 0, index = 0;
    for (int l = 1; l < 16 && !z->bad; l++) {
        value = value << 1 | (int)inflate_bits(z, 1);
        if (value - first < code->count[l])
            return code->symbol[index + value - first];
        index += code->count[l];
        first = (first + code->count[l]) << 1;
    }
    inflate_bad(z, "no such code");
    return 0;
}

static inline void inflate_header(struct inflate *z,
                                  struct inflate_code code[2])
{
    static const int order[19] = {16, 17, 18, 0, 8,  7, 9,  6, 10, 5,
                                  11, 4,  12, 3, 13, 2, 14, 1, 15};
    int literals = 257 + (int)inflate_bits(z, 5);
    int distances = 1 + (int)inflate_bits(z, 5);
    int listed = 4 + (int)inflate_bits(z, 4);
    int length[320] = {0}, n = 0;
    struct inflate_code lengths;
    for (int i = 0; i < listed; i++)
        length[order[i]] = (int)inflate_bits(z, 3);
    inflate_make(z, &lengths, length, 19);
    memset(length, 0, sizeof length);
    while (n < literals + distances && !z->bad) {
        int s = inflate_symbol(z, &lengths), value = 0, run = 1;
        if (s == 16 && n == 0)
            inflate_bad(z, "a repetition of nothing");
        if (s < 16)
            value = s;
        else if (s == 16 && n > 0)
            value = length[n - 1];
        if (s >= 16)
            run =
                (s == 18 ? 11 : 3) + (int)inflate_bits(z, s == 18 ? 7 : s - 14);
        if (n + run > literals + distances) {
            inflate_bad(z, "too many lengths");
            return;
        }
        while (run-- > 0)
            length[n++] = value;
    }
    for (int s = 0; s < literals; s++)
        z->longest = length[s] > z->longest ? length[s] : z->longest;
    inflate_make(z, &code[0], length, literals);
    inflate_make(z, &code[1], length + literals, distances);
}

static inline void inflate_copy(struct inflate *z, int length, int distance)
{
    if ((size_t)distance > z->out.size) {
        inflate_bad(z, "a distance before the beginning");
        return;
    }
    z->farthest = distance > z->farthest ? distance : z->farthest;
    for (int i = 0; i < length; i++)
        buf_byte(&z->out, z->out.data[z->out.size - (size_t)distance]);
}

static inline void inflate_match(struct inflate *z, int symbol,
                                 const struct inflate_code *far)
{
    // RFC 1951, 3.2.5: lengths in groups of four codes, distances of two
    int l = symbol - 257, extra = l < 8 || l == 28 ? 0 : l / 4 - 1;
    int length = l == 28 ? 258
                 : l < 8
                     ? 3 + l
                     : 3 + ((4 + l % 4) << extra) + (int)inflate_bits(z, extra);
    int d = inflate_symbol(z, far);
    extra = d < 4 ? 0 : d / 2 - 1;
    int distance =
        d < 4 ? 1 + d
              : 1 + ((2 + d % 2) << extra) + (int)inflate_bits(z, extra);
    if (l > 28 || d > 29)
        inflate_bad(z, "a symbol that must not occur");
    if (!z->bad)
        inflate_copy(z, length, distance);
}

static inline void inflate_block(struct inflate *z)
{
    struct inflate_code code[2];
    z->blocks++;
    if (inflate_bits(z, 2) != 2) {
        inflate_bad(z, "not a block with dynamic codes");
        return;
    }
    inflate_header(z, code);
    while (!z->bad) {
        int s = inflate_symbol(z, &code[0]);
        if (s == 256)
            return;
        if (s < 256)
            buf_byte(&z->out, (unsigned char)s);
        else
            inflate_match(z, s, &code[1]);
    }
}

// false: z->bad tells why.  z->out is the caller's to finish.
static inline bool inflate(struct inflate *z, struct span in)
{
    uint32_t a = 1, b = 0;
    bool last = false;
    *z = (struct inflate){.in = in, .at = 16};
    if (in.size < 6 || in.data[0] != 0x78 ||
        (in.data[0] << 8 | in.data[1]) % 31 != 0 || in.data[1] & 0x20)
        inflate_bad(z, "the zlib header");
    while (!last && !z->bad) {
        last = inflate_bits(z, 1);
        inflate_block(z);
    }
    for (size_t i = 0; i < z->out.size; i++) {
        a = (a + z->out.data[i]) % 65521;
        b = (b + a) % 65521;
    }
    z->at = (z->at + 7) & ~(size_t)7;
    for (int shift = 24; shift >= 0; shift -= 8)
        if (inflate_bits(z, 8) != ((b << 16 | a) >> shift & 255))
            inflate_bad(z, "Adler-32");
    if (!z->bad && z->at != 8 * in.size)
        inflate_bad(z, "something follows");
    return !z->bad;
}

#endif
