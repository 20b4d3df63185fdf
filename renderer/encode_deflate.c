// encode_deflate.c - a zlib stream (RFC 1950): finds repetitions by hash chains
// and a little patience.  Turning them into bits is left to encode_block.c.
//
// Tuned for filtered rows of pictures: long runs of equal bytes, which must
// cost next to nothing, and noise, in which searching long finds little.
#include "renderer/encode.h"

#include <assert.h>
#include <limits.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "renderer/encode_block.h"

enum {
    HASH_BITS = 15,
    WINDOW = ENCODE_BLOCK_DISTANCE_MAX,
    MATCH_MIN = 4, // three bytes hardly ever pay
    // Measured on pictures of hair, filtered: twice the tries take a quarter
    // longer and save one byte in a hundred.
    TRIES = 8, // candidates looked at
    LAZY = 16, // a match this long is taken at once
    ENTER = 32 // of a longer match only the last positions are entered
};

struct match {
    int length, distance; // length 0: none
};

struct deflate {
    const unsigned char *in;
    int size;
    int entered;                  // positions before this one are in the chains
    int32_t head[1 << HASH_BITS]; // newest position of a hash, -1: none
    uint16_t back[WINDOW];        // from there to the one before, 0: none
    struct encode_block block;
};

static inline uint32_t load32(const unsigned char *p)
{
    uint32_t v;
    memcpy(&v, p, 4);
    return v;
}

static inline uint32_t hash(uint32_t bytes)
{
    return (bytes * 2654435761u) >> (32 - HASH_BITS);
}

static inline int common(const unsigned char *a, const unsigned char *b,
                         int most)
{
    int n = 0;
    for (; n + 8 <= most; n += 8) {
        uint64_t x, y;
        memcpy(&x, a + n, 8);
        memcpy(&y, b + n, 8);
        if (x != y)
            return n + (__builtin_ctzll(x ^ y) >> 3);
    }
    while (n < most && a[n] == b[n])
        n++;
    return n;
}

static inline void enter(struct deflate *d, int at)
{
    int32_t *head = &d->head[hash(load32(d->in + at))];
    int back = at - *head;
    d->back[at % WINDOW] = *head < 0 || back >= WINDOW ? 0 : (uint16_t)back;
    *head = at;
}

static inline void enter_to(struct deflate *d, int end)
{
    if (end - d->entered > ENTER)
        d->entered = end - ENTER;
    for (; d->entered < end; d->entered++)
        enter(d, d->entered);
}

// The longest match at `at` among the newest candidates, if it is longer than
// `least` (>= 3); enters `at` and what was passed over.
static struct match find(struct deflate *d, int at, int least, int tries)
{
    struct match best = {0, 0};
    int most = d->size - at;
    if (most > ENCODE_BLOCK_LENGTH_MAX)
        most = ENCODE_BLOCK_LENGTH_MAX;
    if (most <= least)
        return best; // also where four bytes for the hash are not left
    enter_to(d, at + 1);
    const unsigned char *here = d->in + at;
    int far = 0, length = least;
    for (int back = d->back[at % WINDOW]; tries > 0 && back; tries--) {
        far += back;
        if (far >= WINDOW) // its link has been overwritten
            break;
        // a longer match has these four bytes in common as well
        if (load32(here - far + length - 3) == load32(here + length - 3)) {
            int n = common(here - far, here, most);
            if (n > length) {
                best = (struct match){n, far};
                length = n;
                if (n >= LAZY || n == most)
                    break;
            }
        }
        back = d->back[(at - far) % WINDOW];
    }
    return best;
}

static void compress(struct deflate *d)
{
    for (int at = 0; at < d->size;) {
        struct match m = find(d, at, MATCH_MIN - 1, TRIES);
        if (m.length == 0) {
            encode_block_add(&d->block, d->in[at++]);
            continue;
        }
        while (m.length < LAZY) { // does one literal buy a longer match?
            struct match next = find(d, at + 1, m.length, TRIES / 2);
            if (next.length == 0)
                break;
            encode_block_add(&d->block, d->in[at++]);
            m = next;
        }
        encode_block_match(&d->block, m.length, m.distance);
        at += m.length;
    }
    encode_block_end(&d->block, true);
}

static uint32_t adler(struct span in)
{
    uint32_t a = 1, b = 0;
    for (size_t i = 0; i < in.size;) {
        // as many as 32 bits can hold before the remainder is taken
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
    assert(in.size <= INT_MAX - WINDOW);
    struct deflate *d = bytes_alloc(sizeof *d);
    d->in = in.data;
    d->size = (int)in.size;
    d->entered = 0;
    memset(d->head, 0xff, sizeof d->head); // -1
    encode_block_init(&d->block, out);
    buf_append(out, (const unsigned char[]){0x78, 0x5e}, 2);
    compress(d);
    uint32_t sum = adler(in);
    for (int shift = 24; shift >= 0; shift -= 8)
        buf_byte(out, (unsigned char)(sum >> shift));
    free(d);
}
