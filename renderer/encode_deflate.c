// encode_deflate.c - a zlib stream: LZ77 by hash chains with one step of
// laziness, then dynamic Huffman blocks (RFC 1951), Adler-32 (RFC 1950).
#include "renderer/encode.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "renderer/encode_huffman.h"

enum {
    WINDOW = 32768,
    HASH_BITS = 15,
    TOKENS = 16384,  // a block
    MATCH_MIN = 4,   // three bytes hardly ever pay
    MATCH_MAX = 258,
    CHAIN = 12,      // candidates looked at
    GOOD = 48        // a match this long is taken at once
};

static const uint16_t length_base[29] = {
    3,  4,  5,  6,  7,  8,  9,  10, 11,  13,  15,  17,  19,  23, 27,
    31, 35, 43, 51, 59, 67, 83, 99, 115, 131, 163, 195, 227, 258};
static const uint8_t length_extra[29] = {0, 0, 0, 0, 0, 0, 0, 0, 1, 1,
                                         1, 1, 2, 2, 2, 2, 3, 3, 3, 3,
                                         4, 4, 4, 4, 5, 5, 5, 5, 0};
static const uint16_t distance_base[30] = {
    1,   2,   3,   4,   5,   7,    9,    13,   17,   25,
    33,  49,  65,  97,  129, 193,  257,  385,  513,  769,
    1025, 1537, 2049, 3073, 4097, 6145, 8193, 12289, 16385, 24577};
static const uint8_t distance_extra[30] = {0, 0, 0,  0,  1,  1,  2,  2,  3, 3,
                                           4, 4, 5,  5,  6,  6,  7,  7,  8, 8,
                                           9, 9, 10, 10, 11, 11, 12, 12, 13, 13};

struct deflate {
    struct buf *out;
    uint64_t bits;
    int bit_count;
    int token_count;
    uint32_t literal_use[286], distance_use[30];
    uint32_t token[TOKENS]; // length << 16 | distance, or the literal
    int32_t head[1 << HASH_BITS], previous[WINDOW];
};

static void put(struct deflate *d, uint32_t value, int count)
{
    d->bits |= (uint64_t)value << d->bit_count;
    d->bit_count += count;
    while (d->bit_count >= 8) {
        buf_byte(d->out, (unsigned char)d->bits);
        d->bits >>= 8;
        d->bit_count -= 8;
    }
}

static int length_code(int length)
{
    int code = 0;
    while (code < 28 && length_base[code + 1] <= length)
        code++;
    return code;
}

static int distance_code(int distance)
{
    if (distance <= 4)
        return distance - 1;
    int top = 31 - __builtin_clz((unsigned)distance - 1); // >= 2
    return 2 * top + (((distance - 1) >> (top - 1)) & 1);
}

// --- a block -----------------------------------------------------------------

static void put_tokens(struct deflate *d, const struct encode_huffman *literal,
                       const struct encode_huffman *distance)
{
    for (int i = 0; i < d->token_count; i++) {
        uint32_t t = d->token[i];
        if (t < 256) {
            put(d, literal->code[t], literal->length[t]);
            continue;
        }
        int length = (int)(t >> 16), far = (int)(t & 0xffff);
        int l = length_code(length), f = distance_code(far);
        put(d, literal->code[257 + l], literal->length[257 + l]);
        put(d, (uint32_t)(length - length_base[l]), length_extra[l]);
        put(d, distance->code[f], distance->length[f]);
        put(d, (uint32_t)(far - distance_base[f]), distance_extra[f]);
    }
    put(d, literal->code[256], literal->length[256]);
}

// The code lengths, run-length coded with the symbols 16, 17 and 18 (RFC 1951,
// 3.2.7): value | extra bits << 8.
static int run_lengths(const uint8_t *length, int n, uint16_t *out)
{
    int count = 0;
    for (int i = 0; i < n;) {
        int run = 1;
        while (i + run < n && length[i + run] == length[i])
            run++;
        i += run;
        int value = length[i - 1];
        if (value > 0) {
            out[count++] = (uint16_t)value;
            run--;
        }
        while (run >= 3) {
            int most = value > 0 ? 6 : 138, take = run < most ? run : most;
            if (value > 0)
                out[count++] = (uint16_t)(16 | (take - 3) << 8);
            else if (take <= 10)
                out[count++] = (uint16_t)(17 | (take - 3) << 8);
            else
                out[count++] = (uint16_t)(18 | (take - 11) << 8);
            run -= take;
        }
        while (run-- > 0)
            out[count++] = (uint16_t)value;
    }
    return count;
}

static void put_header(struct deflate *d, const uint8_t *lengths, int literals,
                       int distances, bool last)
{
    static const uint8_t order[19] = {16, 17, 18, 0, 8,  7, 9,  6, 10, 5,
                                      11, 4,  12, 3, 13, 2, 14, 1, 15};
    static const uint8_t extra[3] = {2, 3, 7};
    uint16_t runs[320];
    int run_count = run_lengths(lengths, literals + distances, runs);
    uint32_t use[19] = {0};
    for (int i = 0; i < run_count; i++)
        use[runs[i] & 0xff]++;
    struct encode_huffman h;
    encode_huffman_build(&h, use, 19, 7);
    int listed = 19;
    while (listed > 4 && h.length[order[listed - 1]] == 0)
        listed--;
    put(d, last, 1);
    put(d, 2, 2); // dynamic codes
    put(d, (uint32_t)(literals - 257), 5);
    put(d, (uint32_t)(distances - 1), 5);
    put(d, (uint32_t)(listed - 4), 4);
    for (int i = 0; i < listed; i++)
        put(d, h.length[order[i]], 3);
    for (int i = 0; i < run_count; i++) {
        int symbol = runs[i] & 0xff;
        put(d, h.code[symbol], h.length[symbol]);
        if (symbol >= 16)
            put(d, runs[i] >> 8, extra[symbol - 16]);
    }
}

static void end_block(struct deflate *d, bool last)
{
    struct encode_huffman literal, distance;
    uint8_t lengths[286 + 30];
    d->literal_use[256] = 1;
    encode_huffman_build(&literal, d->literal_use, 286, 15);
    encode_huffman_build(&distance, d->distance_use, 30, 15);
    int literals = 286, distances = 30;
    while (literals > 257 && literal.length[literals - 1] == 0)
        literals--;
    while (distances > 1 && distance.length[distances - 1] == 0)
        distances--;
    memcpy(lengths, literal.length, (size_t)literals);
    memcpy(lengths + literals, distance.length, (size_t)distances);
    put_header(d, lengths, literals, distances, last);
    put_tokens(d, &literal, &distance);
    d->token_count = 0;
    memset(d->literal_use, 0, sizeof d->literal_use);
    memset(d->distance_use, 0, sizeof d->distance_use);
}

static void add_token(struct deflate *d, uint32_t token)
{
    if (d->token_count == TOKENS)
        end_block(d, false);
    d->token[d->token_count++] = token;
    if (token < 256) {
        d->literal_use[token]++;
    } else {
        d->literal_use[257 + length_code((int)(token >> 16))]++;
        d->distance_use[distance_code((int)(token & 0xffff))]++;
    }
}

// --- matches -----------------------------------------------------------------

static uint32_t hash_at(const unsigned char *p)
{
    uint32_t v;
    memcpy(&v, p, 4);
    return (v * 2654435761u) >> (32 - HASH_BITS);
}

static int common(const unsigned char *a, const unsigned char *b, int most)
{
    int n = 0;
    while (n + 8 <= most) {
        uint64_t x, y;
        memcpy(&x, a + n, 8);
        memcpy(&y, b + n, 8);
        if (x != y)
            return n + (__builtin_ctzll(x ^ y) >> 3);
        n += 8;
    }
    while (n < most && a[n] == b[n])
        n++;
    return n;
}

// Enters position `at`, and finds the longest match there: token or 0.
static uint32_t find(struct deflate *d, struct span in, int at)
{
    int left = (int)in.size - at;
    if (left < MATCH_MIN)
        return 0;
    uint32_t h = hash_at(in.data + at);
    int32_t candidate = d->head[h];
    d->head[h] = at;
    d->previous[at % WINDOW] = candidate;
    int most = left < MATCH_MAX ? left : MATCH_MAX, best = MATCH_MIN - 1;
    uint32_t token = 0;
    for (int tries = 0; tries < CHAIN && candidate >= 0; tries++) {
        int distance = at - candidate;
        if (distance > WINDOW - 1)
            break;
        if (in.data[candidate + best] == in.data[at + best] || best >= most) {
            int n = common(in.data + candidate, in.data + at, most);
            if (n > best) {
                best = n;
                token = (uint32_t)n << 16 | (uint32_t)distance;
                if (n >= GOOD || n == most)
                    break;
            }
        }
        candidate = d->previous[candidate % WINDOW];
    }
    return token;
}

static void compress(struct deflate *d, struct span in)
{
    const int size = (int)in.size;
    uint32_t here = size > 0 ? find(d, in, 0) : 0;
    for (int at = 0; at < size;) {
        uint32_t next = 0;
        if (here == 0 || here >> 16 < GOOD)
            next = find(d, in, at + 1);
        else
            find(d, in, at + 1);
        if (here == 0 || next >> 16 > here >> 16) {
            add_token(d, in.data[at]);
            here = next;
            at++;
            continue;
        }
        add_token(d, here);
        int end = at + (int)(here >> 16);
        for (int i = at + 2; i < end; i++)
            find(d, in, i);
        at = end;
        here = at == end && at < size ? find(d, in, at) : 0;
    }
    end_block(d, true);
    if (d->bit_count > 0)
        put(d, 0, 8 - d->bit_count);
}

static uint32_t adler(struct span in)
{
    uint32_t a = 1, b = 0;
    for (size_t i = 0; i < in.size;) {
        size_t stop = i + 5552 < in.size ? i + 5552 : in.size;
        for (; i < stop; i++) {
            a += in.data[i];
            b += a;
        }
        a %= 65521;
        b %= 65521;
    }
    return b << 16 | a;
}

void encode_deflate(struct buf *out, struct span in)
{
    struct deflate *d = bytes_zalloc(1, sizeof *d);
    d->out = out;
    memset(d->head, 0xff, sizeof d->head); // -1: nothing seen
    buf_byte(out, 0x78);
    buf_byte(out, 0x5e);
    compress(d, in);
    uint32_t sum = adler(in);
    for (int shift = 24; shift >= 0; shift -= 8)
        buf_byte(out, (unsigned char)(sum >> shift));
    free(d);
}
