// digest.h - SHA-1 and base64 for the WebSocket handshake, SHA-256 for naming
// files by what they hold (FIPS 180-4; RFC 4648, section 4).
// Thread: any; an object belongs to one thread at a time.
#ifndef PROTOCOL_DIGEST_H
#define PROTOCOL_DIGEST_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "protocol/bytes.h"

void digest_sha1(struct span in, unsigned char out[20]);
void digest_sha256(struct span in, unsigned char out[32]);

struct digest { // incremental SHA-256
    uint32_t state[8];
    uint64_t size;
    unsigned char block[64];
};
void digest_begin(struct digest *d);
void digest_add(struct digest *d, struct span in);
void digest_end(struct digest *d, unsigned char out[32]);

// Lower-case digits and a NUL: out has room for 2 * size + 1.
void digest_hex(const unsigned char *in, size_t size, char *out);

// Padded base64 and a NUL: out has room for 4 * ((size + 2) / 3) + 1.
void digest_base64(const unsigned char *in, size_t size, char *out);
// True when text is canonical padded base64 of exactly `size` bytes.
bool digest_is_base64(struct span text, size_t size);

#endif
