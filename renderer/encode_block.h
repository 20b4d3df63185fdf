// encode_block.h - the blocks of a deflate stream (RFC 1951): literals and
// matches in, bits with dynamic Huffman codes out.
// Thread: any (no shared state).
#ifndef RENDERER_ENCODE_BLOCK_H
#define RENDERER_ENCODE_BLOCK_H

#include <stdbool.h>
#include <stdint.h>

#include "protocol/bytes.h"

enum {
    ENCODE_BLOCK_TOKENS = 16384,
    ENCODE_BLOCK_LENGTH_MAX = 258,
    ENCODE_BLOCK_DISTANCE_MAX = 32768
};

struct encode_block {
    struct buf *out; // borrowed
    uint64_t bits;   // pending, the oldest lowest
    int bit_count;   // of them, < 8 between blocks
    int count;
    uint32_t token[ENCODE_BLOCK_TOKENS]; // length << 16 | distance, or literal
    uint8_t length_code[ENCODE_BLOCK_LENGTH_MAX + 1];
};

void encode_block_init(struct encode_block *b, struct buf *out);

// Writes the tokens as one block and forgets them; after the last block also
// fills up the last byte.
void encode_block_end(struct encode_block *b, bool last);

// A literal byte; or a match, see below.
static inline void encode_block_add(struct encode_block *b, uint32_t token)
{
    if (b->count == ENCODE_BLOCK_TOKENS)
        encode_block_end(b, false);
    b->token[b->count++] = token;
}

// length 3..258, distance 1..32768.
static inline void encode_block_match(struct encode_block *b, int length,
                                      int distance)
{
    encode_block_add(b, (uint32_t)length << 16 | (uint32_t)distance);
}

#endif
