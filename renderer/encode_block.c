// encode_block.c - counts the symbols of a block, makes its two codes, writes
// their lengths and then the tokens.  Which tokens there are is decided in
// encode_deflate.c; how a code is made, in encode_huffman.c.
#include "renderer/encode_block.h"

#include <assert.h>
#include <string.h>

#include "renderer/encode_huffman.h"

enum {
    LITERALS = 286, // 256 bytes, end of block, 29 lengths
    END = 256,
    DISTANCES = 30,
    TOKEN_BITS = 15 + 5 + 15 + 13, // a match at its longest
    // 14 bits and 19 lengths of 3, then 316 symbols of at most 7 + 7 bits
    HEADER_BYTES = (3 + 14 + 57 + (LITERALS + DISTANCES) * 14) / 8 + 1,
    ROOM = HEADER_BYTES + (ENCODE_BLOCK_TOKENS + 1) * TOKEN_BITS / 8 + 16
};

// RFC 1951, 3.2.5.
static const uint16_t length_base[29] = {
    3,  4,  5,  6,  7,  8,  9,  10, 11,  13,  15,  17,  19,  23, 27,
    31, 35, 43, 51, 59, 67, 83, 99, 115, 131, 163, 195, 227, 258};
static const uint8_t length_extra[29] = {0, 0, 0, 0, 0, 0, 0, 0, 1, 1,
                                         1, 1, 2, 2, 2, 2, 3, 3, 3, 3,
                                         4, 4, 4, 4, 5, 5, 5, 5, 0};

void encode_block_init(struct encode_block *b, struct buf *out)
{
    b->out = out;
    b->bits = 0;
    b->bit_count = b->count = 0;
    for (int length = 3, code = 0; length <= ENCODE_BLOCK_LENGTH_MAX;
         length++) {
        while (code < 28 && length_base[code + 1] <= length)
            code++;
        b->length_code[length] = (uint8_t)code;
    }
}

// Two codes for each power of two, and as many extra bits as that leaves: the
// table of RFC 1951, 3.2.5, in closed form.
static inline int distance_code(int distance)
{
    if (distance <= 4)
        return distance - 1;
    int top = 31 - __builtin_clz((unsigned)distance - 1); // >= 2
    return 2 * top + (((distance - 1) >> (top - 1)) & 1);
}

static inline int distance_extra(int code)
{
    return code < 4 ? 0 : (code >> 1) - 1;
}

// --- bits --------------------------------------------------------------------

struct writer { // in registers while tokens are written
    uint64_t bits;
    int count;
    unsigned char *at;
};

static inline void put(struct writer *w, uint32_t value, int count)
{
    w->bits |= (uint64_t)value << w->count;
    w->count += count;
}

// Leaves fewer than 8 bits pending.  Writes 8 bytes, of which whole ones count.
static inline void spill(struct writer *w)
{
    for (int i = 0; i < 8; i++) // becomes one store
        w->at[i] = (unsigned char)(w->bits >> (8 * i));
    w->at += w->count >> 3;
    w->bits >>= w->count & ~7;
    w->count &= 7;
}

// --- a block -----------------------------------------------------------------

static void put_match(struct writer *w, const struct encode_block *b,
                      uint32_t token, const struct encode_huffman code[2])
{
    int length = (int)(token >> 16), far = (int)(token & 0xffff);
    int l = b->length_code[length], f = distance_code(far);
    put(w, code[0].code[END + 1 + l], code[0].length[END + 1 + l]);
    put(w, (uint32_t)(length - length_base[l]), length_extra[l]);
    put(w, code[1].code[f], code[1].length[f]);
    int extra = distance_extra(f);
    put(w, ((uint32_t)far - 1) & ((1u << extra) - 1), extra);
}

static void put_tokens(struct writer *w, const struct encode_block *b,
                       const struct encode_huffman code[2])
{
    for (int i = 0; i < b->count; i++) {
        uint32_t t = b->token[i];
        if (t < END) {
            if (w->count > 64 - 15)
                spill(w);
            put(w, code[0].code[t], code[0].length[t]);
        } else {
            if (w->count > 64 - TOKEN_BITS)
                spill(w);
            put_match(w, b, t, code);
        }
    }
    spill(w);
    put(w, code[0].code[END], code[0].length[END]);
    spill(w);
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

static int used(const struct encode_huffman *code, int count, int least)
{
    while (count > least && code->length[count - 1] == 0)
        count--;
    return count;
}

static void put_header(struct writer *w, const struct encode_huffman code[2],
                       bool last)
{
    static const uint8_t order[19] = {16, 17, 18, 0, 8,  7, 9,  6, 10, 5,
                                      11, 4,  12, 3, 13, 2, 14, 1, 15};
    static const uint8_t extra[3] = {2, 3, 7};
    int literals = used(&code[0], LITERALS, 257);
    int distances = used(&code[1], DISTANCES, 1);
    uint8_t lengths[LITERALS + DISTANCES];
    uint16_t runs[LITERALS + DISTANCES];
    memcpy(lengths, code[0].length, (size_t)literals);
    memcpy(lengths + literals, code[1].length, (size_t)distances);
    int run_count = run_lengths(lengths, literals + distances, runs);
    uint32_t use[19] = {0};
    for (int i = 0; i < run_count; i++)
        use[runs[i] & 0xff]++;
    struct encode_huffman h;
    encode_huffman_build(&h, use, 19, 7);
    int listed = 19;
    while (listed > 4 && h.length[order[listed - 1]] == 0)
        listed--;
    put(w, (uint32_t)last | 2 << 1, 3); // 2: dynamic codes
    put(w, (uint32_t)(literals - 257), 5);
    put(w, (uint32_t)(distances - 1), 5);
    put(w, (uint32_t)(listed - 4), 4);
    for (int i = 0; i < listed; i++, spill(w))
        put(w, h.length[order[i]], 3);
    for (int i = 0; i < run_count; i++, spill(w)) {
        int symbol = runs[i] & 0xff;
        put(w, h.code[symbol], h.length[symbol]);
        if (symbol >= 16)
            put(w, runs[i] >> 8, extra[symbol - 16]);
    }
}

static void make_codes(struct encode_huffman code[2],
                       const struct encode_block *b)
{
    uint32_t literal_use[LITERALS] = {0}, distance_use[DISTANCES] = {0};
    literal_use[END] = 1;
    for (int i = 0; i < b->count; i++) {
        uint32_t t = b->token[i];
        if (t < END) {
            literal_use[t]++;
        } else {
            literal_use[END + 1 + b->length_code[t >> 16]]++;
            distance_use[distance_code((int)(t & 0xffff))]++;
        }
    }
    encode_huffman_build(&code[0], literal_use, LITERALS, 15);
    encode_huffman_build(&code[1], distance_use, DISTANCES, 15);
}

void encode_block_end(struct encode_block *b, bool last)
{
    struct encode_huffman code[2];
    make_codes(code, b);
    buf_reserve(b->out, ROOM);
    unsigned char *begin = b->out->data + b->out->size;
    struct writer w = {b->bits, b->bit_count, begin};
    put_header(&w, code, last);
    put_tokens(&w, b, code);
    if (last) {
        w.count = (w.count + 7) & ~7;
        spill(&w);
    }
    assert(w.at <= begin + ROOM - 8);
    b->out->size += (size_t)(w.at - begin);
    b->bits = w.bits;
    b->bit_count = w.count;
    b->count = 0;
}
