// utf8.h - UTF-8 as RFC 3629 has it: no overlong form, no surrogate, nothing
// above U+10FFFF.
// Thread: any (no shared state).
#ifndef PROTOCOL_UTF8_H
#define PROTOCOL_UTF8_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "protocol/bytes.h"

// Length of the valid sequence at the start of `text`, 1..4; 0 when there is
// none (also when it is cut off).
size_t utf8_next(struct span text);

bool utf8_valid(struct span text);

// Largest n <= limit such that the first n bytes of a valid text end between
// two characters.
size_t utf8_cut(struct span text, size_t limit);

// Writes code point c (at most 0x10FFFF, no surrogate); returns 1..4.
size_t utf8_put(unsigned char out[4], uint32_t c);

#endif
