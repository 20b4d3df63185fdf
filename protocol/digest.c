// digest.c - SHA-1, SHA-256 (FIPS 180-4) and base64 (RFC 4648, section 4).
// SHA-1 serves the WebSocket handshake only, where it guards nothing.
#include "protocol/digest.h"

#include <string.h>

static uint32_t rol(uint32_t x, int n)
{
    return x << n | x >> (32 - n);
}

static uint32_t ror(uint32_t x, int n)
{
    return x >> n | x << (32 - n);
}

static uint32_t load_be(const unsigned char *p)
{
    return (uint32_t)p[0] << 24 | (uint32_t)p[1] << 16 | (uint32_t)p[2] << 8 |
           p[3];
}

static void store_be(unsigned char *p, uint32_t v)
{
    for (int i = 0; i < 4; i++)
        p[i] = (unsigned char)(v >> (24 - 8 * i));
}

typedef void compress_fn(uint32_t *state, const unsigned char *block);

// --- compression functions --------------------------------------------------

// FIPS 180-4, section 6.1.2.
static void sha1_block(uint32_t *state, const unsigned char *block)
{
    static const uint32_t k[4] = {0x5a827999, 0x6ed9eba1, 0x8f1bbcdc,
                                  0xca62c1d6};
    uint32_t w[80];
    for (int t = 0; t < 16; t++)
        w[t] = load_be(block + 4 * t);
    for (int t = 16; t < 80; t++)
        w[t] = rol(w[t - 3] ^ w[t - 8] ^ w[t - 14] ^ w[t - 16], 1);
    uint32_t a = state[0], b = state[1], c = state[2], d = state[3],
             e = state[4];
    for (int t = 0; t < 80; t++) {
        uint32_t f = t < 20   ? (b & c) ^ (~b & d)
                     : t < 40 ? b ^ c ^ d
                     : t < 60 ? (b & c) ^ (b & d) ^ (c & d)
                              : b ^ c ^ d;
        uint32_t next = rol(a, 5) + f + e + k[t / 20] + w[t];
        e = d, d = c, c = rol(b, 30), b = a, a = next;
    }
    state[0] += a, state[1] += b, state[2] += c, state[3] += d, state[4] += e;
}

// FIPS 180-4, section 4.2.2: the cube roots of the first 64 primes.
static const uint32_t k256[64] = {
    0x428a2f98, 0x71374491, 0xb5c0fbcf, 0xe9b5dba5, 0x3956c25b, 0x59f111f1,
    0x923f82a4, 0xab1c5ed5, 0xd807aa98, 0x12835b01, 0x243185be, 0x550c7dc3,
    0x72be5d74, 0x80deb1fe, 0x9bdc06a7, 0xc19bf174, 0xe49b69c1, 0xefbe4786,
    0x0fc19dc6, 0x240ca1cc, 0x2de92c6f, 0x4a7484aa, 0x5cb0a9dc, 0x76f988da,
    0x983e5152, 0xa831c66d, 0xb00327c8, 0xbf597fc7, 0xc6e00bf3, 0xd5a79147,
    0x06ca6351, 0x14292967, 0x27b70a85, 0x2e1b2138, 0x4d2c6dfc, 0x53380d13,
    0x650a7354, 0x766a0abb, 0x81c2c92e, 0x92722c85, 0xa2bfe8a1, 0xa81a664b,
    0xc24b8b70, 0xc76c51a3, 0xd192e819, 0xd6990624, 0xf40e3585, 0x106aa070,
    0x19a4c116, 0x1e376c08, 0x2748774c, 0x34b0bcb5, 0x391c0cb3, 0x4ed8aa4a,
    0x5b9cca4f, 0x682e6ff3, 0x748f82ee, 0x78a5636f, 0x84c87814, 0x8cc70208,
    0x90befffa, 0xa4506ceb, 0xbef9a3f7, 0xc67178f2};

// FIPS 180-4, section 6.2.2.
static void sha256_block(uint32_t *state, const unsigned char *block)
{
    uint32_t w[64], s[8];
    for (int t = 0; t < 16; t++)
        w[t] = load_be(block + 4 * t);
    for (int t = 16; t < 64; t++) {
        uint32_t x = w[t - 15], y = w[t - 2];
        w[t] = w[t - 16] + (ror(x, 7) ^ ror(x, 18) ^ x >> 3) + w[t - 7] +
               (ror(y, 17) ^ ror(y, 19) ^ y >> 10);
    }
    memcpy(s, state, sizeof s);
    for (int t = 0; t < 64; t++) {
        uint32_t e = s[4], a = s[0];
        uint32_t t1 = s[7] + (ror(e, 6) ^ ror(e, 11) ^ ror(e, 25)) +
                      ((e & s[5]) ^ (~e & s[6])) + k256[t] + w[t];
        uint32_t t2 = (ror(a, 2) ^ ror(a, 13) ^ ror(a, 22)) +
                      ((a & s[1]) ^ (a & s[2]) ^ (s[1] & s[2]));
        memmove(s + 1, s, 7 * sizeof *s);
        s[4] += t1;
        s[0] = t1 + t2;
    }
    for (int i = 0; i < 8; i++)
        state[i] += s[i];
}

// --- messages of any length -------------------------------------------------

static void feed(struct digest *d, compress_fn *compress, struct span in)
{
    size_t have = d->size % 64;
    d->size += in.size;
    while (in.size > 0) {
        size_t take = 64 - have < in.size ? 64 - have : in.size;
        memcpy(d->block + have, in.data, take);
        in.data += take;
        in.size -= take;
        have += take;
        if (have == 64) {
            compress(d->state, d->block);
            have = 0;
        }
    }
}

// Padding: a one bit, zeros, and the length in bits as 64 bits.
static void pad(struct digest *d, compress_fn *compress)
{
    unsigned char tail[72] = {0x80};
    uint64_t bits = d->size * 8;
    size_t zeros = 63 - (size_t)((d->size + 8) % 64);
    store_be(tail + 1 + zeros, (uint32_t)(bits >> 32));
    store_be(tail + 5 + zeros, (uint32_t)bits);
    feed(d, compress, (struct span){tail, zeros + 9});
}

void digest_begin(struct digest *d)
{
    static const uint32_t first[8] = {0x6a09e667, 0xbb67ae85, 0x3c6ef372,
                                      0xa54ff53a, 0x510e527f, 0x9b05688c,
                                      0x1f83d9ab, 0x5be0cd19};
    *d = (struct digest){0};
    memcpy(d->state, first, sizeof first);
}

void digest_add(struct digest *d, struct span in)
{
    feed(d, sha256_block, in);
}

void digest_end(struct digest *d, unsigned char out[32])
{
    pad(d, sha256_block);
    for (int i = 0; i < 8; i++)
        store_be(out + 4 * i, d->state[i]);
}

void digest_sha256(struct span in, unsigned char out[32])
{
    struct digest d;
    digest_begin(&d);
    digest_add(&d, in);
    digest_end(&d, out);
}

void digest_sha1(struct span in, unsigned char out[20])
{
    static const uint32_t first[5] = {0x67452301, 0xefcdab89, 0x98badcfe,
                                      0x10325476, 0xc3d2e1f0};
    struct digest d = {0};
    memcpy(d.state, first, sizeof first);
    feed(&d, sha1_block, in);
    pad(&d, sha1_block);
    for (int i = 0; i < 5; i++)
        store_be(out + 4 * i, d.state[i]);
}

// --- as text ----------------------------------------------------------------

void digest_hex(const unsigned char *in, size_t size, char *out)
{
    static const char hex[] = "0123456789abcdef";
    for (size_t i = 0; i < size; i++) {
        out[2 * i] = hex[in[i] >> 4];
        out[2 * i + 1] = hex[in[i] & 15];
    }
    out[2 * size] = 0;
}

static const char base64[] =
    "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";

void digest_base64(const unsigned char *in, size_t size, char *out)
{
    for (size_t i = 0; i < size; i += 3, out += 4) {
        size_t n = size - i < 3 ? size - i : 3;
        uint32_t bits = (uint32_t)in[i] << 16;
        if (n > 1)
            bits |= (uint32_t)in[i + 1] << 8;
        if (n > 2)
            bits |= in[i + 2];
        for (size_t k = 0; k < 4; k++)
            out[k] = k <= n ? base64[bits >> (18 - 6 * k) & 63] : '=';
    }
    *out = 0;
}

bool digest_is_base64(struct span text, size_t size)
{
    size_t padding = (3 - size % 3) % 3;
    if (text.size != (size + 2) / 3 * 4)
        return false;
    size_t digits = text.size - padding;
    const char *last = NULL;
    for (size_t i = 0; i < digits; i++) {
        last = text.data[i] ? strchr(base64, text.data[i]) : NULL;
        if (!last)
            return false;
    }
    for (size_t i = digits; i < text.size; i++)
        if (text.data[i] != '=')
            return false;
    // The bits of the last digit that stand for no byte are zero.
    unsigned unused = padding == 2 ? 15 : padding == 1 ? 3 : 0;
    return !last || ((size_t)(last - base64) & unused) == 0;
}
