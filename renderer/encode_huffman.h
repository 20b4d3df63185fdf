// encode_huffman.h - canonical Huffman codes with a limit on their length, bits
// reversed as deflate wants them (RFC 1951, 3.2.2).
// Thread: any.
#ifndef RENDERER_ENCODE_HUFFMAN_H
#define RENDERER_ENCODE_HUFFMAN_H

#include <stdint.h>

enum { ENCODE_HUFFMAN_MAX = 288 };

struct encode_huffman {
    uint16_t code[ENCODE_HUFFMAN_MAX];
    uint8_t length[ENCODE_HUFFMAN_MAX]; // 0: the symbol is not used
};

// use: how often each of `count` symbols (2..ENCODE_HUFFMAN_MAX) occurs.  The
// code is the shortest of those with no length above `longest` (at most 15, and
// 2^longest >= count), and it is complete: where fewer than two symbols are
// used, others get a code as well.
void encode_huffman_build(struct encode_huffman *h, const uint32_t *use,
                          int count, int longest);

#endif
