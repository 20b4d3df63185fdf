// test_encode_deflate.c - Huffman codes against the shortest there can be;
// blocks and zlib streams against a decoder of our own.
#include <stdlib.h>
#include <string.h>

#include "renderer/encode.h"
#include "renderer/encode_block.h"
#include "renderer/encode_huffman.h"
#include "tests/check.h"
#include "tests/unit/encode_inflate.h"
#include "tests/unit/encode_picture.h"

// --- Huffman -----------------------------------------------------------------

static int by_weight(const void *a, const void *b)
{
    uint64_t x = *(const uint64_t *)a, y = *(const uint64_t *)b;
    return (x > y) - (x < y);
}

// Bits of the best code whose lengths are at most `longest`: the coin
// collector's way (Larmore and Hirschberg 1990), weights only.
static uint64_t best_cost(const uint32_t *use, int count, int longest)
{
    uint64_t item[ENCODE_HUFFMAN_MAX], list[2 * ENCODE_HUFFMAN_MAX];
    int n = 0, m = 0;
    for (int s = 0; s < count; s++)
        if (use[s] > 0)
            item[n++] = use[s];
    while (n < 2)
        item[n++] = 0;
    for (int level = 0; level < longest; level++) {
        int pairs = m / 2;
        for (int i = 0; i < pairs; i++)
            list[i] = list[2 * i] + list[2 * i + 1];
        memcpy(list + pairs, item, (size_t)n * sizeof *item);
        m = pairs + n;
        qsort(list, (size_t)m, sizeof *list, by_weight);
    }
    uint64_t cost = 0;
    for (int i = 0; i < 2 * n - 2; i++)
        cost += list[i];
    return cost;
}

// A code is right if it is complete, within the limit, and no symbol that is
// used more has a longer code.  Returns its longest length.
static int check_code(const uint32_t *use, int count, int longest)
{
    struct encode_huffman h;
    uint64_t cost = 0, best = best_cost(use, count, longest);
    int64_t kraft = 0;
    int used = 0, made = 0, deepest = 0;
    bool ordered = true;
    encode_huffman_build(&h, use, count, longest);
    for (int s = 0; s < count; s++) {
        used += use[s] > 0;
        made += h.length[s] > 0;
        ordered = ordered && (use[s] == 0 || h.length[s] > 0);
        deepest = h.length[s] > deepest ? h.length[s] : deepest;
        kraft += h.length[s] ? (int64_t)1 << (longest - h.length[s]) : 0;
        cost += (uint64_t)use[s] * h.length[s];
        for (int t = 0; t < s; t++)
            if (h.length[t] && h.length[s] && use[t] > use[s])
                ordered = ordered && h.length[t] <= h.length[s];
    }
    CHECK(made == (used < 2 ? 2 : used));
    CHECK(ordered);
    CHECK(kraft == (int64_t)1 << longest);
    CHECK_ATMOST(deepest, longest);
    if (!CHECK(cost == best))
        printf("  %d symbols, limit %d: %.0f bits, %.0f would do\n", used,
               longest, (double)cost, (double)best);
    return deepest;
}

static void test_huffman_random(void)
{
    uint64_t random = 7;
    check_case("huffman: random counts, complete and as short as can be");
    for (int turn = 0; turn < 300; turn++) {
        uint32_t use[286] = {0};
        int count = 2 + (int)(picture_random(&random) % 285);
        int shift = (int)(picture_random(&random) % 31);
        for (int s = 0; s < count; s++)
            if (picture_random(&random) % 4)
                use[s] = picture_random(&random) >> shift >>
                         picture_random(&random) % 12;
        check_code(use, count, 15);
        if (count <= 64)
            check_code(use, count, 7);
    }
}

static void test_huffman_extremes(void)
{
    uint32_t use[286] = {0};
    check_case("huffman: nothing, one symbol, two, all alike");
    check_code(use, 286, 15);
    check_code(use, 2, 7);
    use[285] = 9;
    CHECK(check_code(use, 286, 15) == 1);
    use[0] = 1u << 31;
    CHECK(check_code(use, 286, 15) == 1);
    for (int s = 0; s < 286; s++)
        use[s] = 5;
    CHECK(check_code(use, 286, 15) == 9);
    check_case("huffman: Fibonacci's numbers press against the limit");
    for (int n = 2; n <= 46; n++) { // the 47th is beyond 32 bits
        memset(use, 0, sizeof use);
        use[0] = use[1] = 1;
        for (int s = 2; s < n; s++)
            use[s] = use[s - 1] + use[s - 2];
        CHECK(check_code(use, n, 15) == (n - 1 < 15 ? n - 1 : 15));
        CHECK(check_code(use, n, 7) == (n - 1 < 7 ? n - 1 : 7));
    }
    check_case("huffman: powers of four, of 286 symbols, press harder");
    for (int s = 0; s < 286; s++)
        use[s] = s < 270 ? 1 : 1u << 2 * (s - 270);
    CHECK(check_code(use, 286, 15) == 15);
}

// --- streams -----------------------------------------------------------------

// Deflates behind other bytes, inflates, compares; returns the stream's size.
static size_t round_trip(struct span in, struct inflate *z)
{
    struct buf out = {0};
    buf_text(&out, "before");
    encode_deflate(&out, in);
    CHECK(memcmp(out.data, "before", 6) == 0);
    size_t size = out.size - 6;
    bool ok = inflate(z, (struct span){out.data + 6, size});
    if (!CHECK(ok))
        printf("  %zu bytes: %s\n", in.size, z->bad);
    CHECK(z->out.size == in.size);
    CHECK(in.size == 0 || (z->out.size == in.size &&
                           memcmp(z->out.data, in.data, in.size) == 0));
    CHECK_ATMOST(size, (double)in.size * 1.01 + 128); // encode.h says so
    buf_finish(&z->out);
    buf_finish(&out);
    return size;
}

enum { BIG = 1400000 };

static void test_sizes(unsigned char *data)
{
    static const size_t sizes[] = {
        0,     1,     2,     3,     4,     5,     7,     8,     257,   258,
        259,   260,   516,   520,   16383, 16384, 16385, 16386, 32766, 32767,
        32768, 32769, 32770, 49152, 65535, 65536, 65537, BIG};
    static const struct {
        const char *name;
        int bits;  // a byte, so that matches are found or not
        int least; // times smaller, of the whole
    } kinds[] = {
        {"deflate: sizes, all zeros", 0, 500},
        {"deflate: sizes, one random bit a byte", 1, 4},
        {"deflate: sizes, three random bits a byte", 3, 2},
        {"deflate: sizes, random bytes", 8, 0},
    };
    uint64_t random = 99;
    for (size_t k = 0; k < sizeof kinds / sizeof *kinds; k++) {
        struct inflate z;
        check_case(kinds[k].name);
        for (size_t i = 0; i < BIG; i++)
            data[i] = (unsigned char)(picture_random(&random) >> 24 &
                                      ((1u << kinds[k].bits) - 1));
        for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
            // at the end of the block: what lies beyond must not be read
            unsigned char *exact = bytes_alloc(sizes[i]);
            if (sizes[i] > 0)
                memcpy(exact, data, sizes[i]);
            size_t n = round_trip((struct span){exact, sizes[i]}, &z);
            if (sizes[i] == BIG)
                CHECK_ATMOST((double)n * kinds[k].least, BIG);
            free(exact);
        }
    }
    check_case("deflate: no bytes at no address");
    struct inflate z;
    round_trip((struct span){NULL, 0}, &z);
}

static void test_periods(unsigned char *data)
{
    static const int periods[] = {1,     2,     3,     4,     5,     6,    7,
                                  8,     9,     255,   257,   258,   259,  4096,
                                  16384, 32766, 32767, 32768, 32769, 40000};
    uint64_t random = 5;
    check_case("deflate: noise that repeats, up to the window's edge");
    for (size_t k = 0; k < sizeof periods / sizeof *periods; k++) {
        const size_t period = (size_t)periods[k], n = 4 * period + 300;
        struct inflate z;
        for (size_t i = 0; i < n; i++)
            data[i] = i < period ? (unsigned char)picture_random(&random)
                                 : data[i - period];
        size_t size = round_trip((struct span){data, n}, &z);
        // what repeats within the window is found, and nothing farther
        if (period < 32768)
            CHECK_ATMOST(size, (double)period * 1.2 + 300);
        else
            CHECK(size > 2 * period && z.farthest < 32768);
    }
    check_case("deflate: same bytes in, same bytes out, whatever was before");
    struct buf a = {0}, b = {0};
    encode_deflate(&a, (struct span){data, 70000});
    memset(data + 70000, 1, 70000);
    encode_deflate(&b, (struct span){data + 70000, 70000});
    buf_clear(&b);
    encode_deflate(&b, (struct span){data, 70000});
    CHECK(a.size == b.size && memcmp(a.data, b.data, a.size) == 0);
    buf_finish(&a);
    buf_finish(&b);
}

// --- blocks ------------------------------------------------------------------

// What encode_deflate puts around the blocks.
static bool inflate_blocks(struct inflate *z, struct buf *out,
                           const struct buf *want)
{
    uint32_t a = 1, b = 0;
    for (size_t i = 0; i < want->size; i++) {
        a = (a + want->data[i]) % 65521;
        b = (b + a) % 65521;
    }
    for (int shift = 24; shift >= 0; shift -= 8)
        buf_byte(out, (unsigned char)((b << 16 | a) >> shift));
    bool ok = inflate(z, (struct span){out->data, out->size});
    if (!ok)
        printf("  %s\n", z->bad);
    ok = ok && z->out.size == want->size &&
         memcmp(z->out.data, want->data, want->size) == 0;
    buf_finish(&z->out);
    return ok;
}

static void test_longest_codes(void)
{
    struct encode_block *b = bytes_alloc(sizeof *b);
    struct buf out = {0}, want = {0};
    struct inflate z;
    check_case("block: literals as frequent as Fibonacci's numbers: 15 bits");
    buf_append(&out, (const unsigned char[]){0x78, 0x5e}, 2);
    encode_block_init(b, &out);
    // the end of the block occurs once, the first literal as well
    for (int s = 0, now = 1, before = 1; s < 18; s++) {
        for (int i = 0; i < now; i++) {
            encode_block_add(b, (uint32_t)s * 13);
            buf_byte(&want, (unsigned char)(s * 13));
        }
        int next = now + before;
        before = now;
        now = next;
    }
    encode_block_end(b, true);
    CHECK(inflate_blocks(&z, &out, &want));
    CHECK(z.longest == 15 && z.blocks == 1);
    buf_finish(&out);
    buf_finish(&want);
    free(b);
}

// Forty symbols that occur once, behind others so frequent that the code's
// limit is reached: forty codes of about 15 bits in a row, at every alignment.
static void test_rare_literals(void)
{
    struct encode_block *b = bytes_alloc(sizeof *b);
    struct buf out = {0}, want = {0};
    struct inflate z;
    double often = 25;
    check_case("block: forty of the longest literals in a row");
    buf_append(&out, (const unsigned char[]){0x78, 0x5e}, 2);
    encode_block_init(b, &out);
    for (int s = 200; s < 212; s++, often *= 1.618)
        for (int i = 0; i < (int)often; i++)
            buf_byte(&want, (unsigned char)s);
    for (int s = 0; s < 40; s++)
        buf_byte(&want, (unsigned char)(5 * s));
    for (size_t i = 0; i < want.size; i++)
        encode_block_add(b, want.data[i]);
    encode_block_end(b, true);
    CHECK(inflate_blocks(&z, &out, &want));
    CHECK(z.longest == 15 && z.blocks == 1);
    buf_finish(&out);
    buf_finish(&want);
    free(b);
}

static void copy(struct buf *to, int length, int distance)
{
    for (int i = 0; i < length; i++)
        buf_byte(to, to->data[to->size - (size_t)distance]);
}

// Also distances that the search never uses, and the least and the most that
// each code of lengths and distances stands for.
static void test_every_match(void)
{
    struct encode_block *b = bytes_alloc(sizeof *b);
    struct buf out = {0}, want = {0};
    struct inflate z;
    uint64_t random = 3;
    check_case("block: every length; every distance's code; empty blocks");
    buf_append(&out, (const unsigned char[]){0x78, 0x5e}, 2);
    encode_block_init(b, &out);
    encode_block_end(b, false);
    for (int i = 0; i < 32768; i++) {
        unsigned char c = (unsigned char)picture_random(&random);
        encode_block_add(b, c);
        buf_byte(&want, c);
    }
    for (int length = 3; length <= 258; length++) {
        encode_block_match(b, length, 32768 - length);
        copy(&want, length, 32768 - length);
    }
    for (int distance = 1; distance <= 32768; distance++) {
        bool border = distance < 600 || (distance & (distance - 1)) < 4 ||
                      distance % 4096 < 2 || distance > 32760;
        if (!border)
            continue;
        encode_block_match(b, 3, distance);
        copy(&want, 3, distance);
    }
    encode_block_end(b, false);
    encode_block_end(b, true);
    CHECK(inflate_blocks(&z, &out, &want));
    CHECK(z.farthest == 32768 && z.blocks >= 5);
    buf_finish(&out);
    buf_finish(&want);
    free(b);
}

// Tokens of up to 48 bits, which is all there is room for, at every alignment:
// what is rare here has also the most extra bits.  Rank r is drawn 0.618 times
// as often as r - 1, so that the codes become as unequal as Fibonacci's numbers
// make them.
static void add_ranked(struct encode_block *b, struct buf *want,
                       uint64_t *random)
{
    static const int lengths[18] = {3,  4,  5,  6,  7,  8,   9,   10,  11,
                                    13, 15, 17, 19, 23, 150, 190, 220, 257};
    int rank = 0;
    while (rank < 17 && picture_uniform(random) < 0.618f)
        rank++;
    if (picture_random(random) % 2) {
        encode_block_add(b, (uint32_t)rank);
        buf_byte(want, (unsigned char)rank);
        return;
    }
    uint32_t extra = picture_random(random) & 4095; // of the last four codes
    int distance =
        rank < 14 ? 1 << rank % 13 : 8193 + (int)extra + (rank - 14) * 6000;
    encode_block_match(b, lengths[rank], distance);
    copy(want, lengths[rank], distance);
}

static void test_longest_tokens(void)
{
    struct encode_block *b = bytes_alloc(sizeof *b);
    check_case("block: the longest tokens, one after another");
    for (uint64_t seed = 1; seed <= 8; seed++) {
        struct buf out = {0}, want = {0};
        struct inflate z;
        uint64_t random = seed;
        buf_append(&out, (const unsigned char[]){0x78, 0x5e}, 2);
        encode_block_init(b, &out);
        for (int i = 0; i < 32768; i++) {
            unsigned char c = (unsigned char)picture_random(&random);
            encode_block_add(b, c);
            buf_byte(&want, c);
        }
        for (int i = 0; i < 3 * ENCODE_BLOCK_TOKENS; i++)
            add_ranked(b, &want, &random);
        encode_block_end(b, true);
        CHECK(inflate_blocks(&z, &out, &want));
        CHECK(z.longest >= 14);
        buf_finish(&out);
        buf_finish(&want);
    }
    free(b);
}

int main(void)
{
    unsigned char *data = bytes_alloc(BIG);
    test_huffman_random();
    test_huffman_extremes();
    test_sizes(data);
    test_periods(data);
    test_longest_codes();
    test_rare_literals();
    test_every_match();
    test_longest_tokens();
    free(data);
    return check_end();
}
