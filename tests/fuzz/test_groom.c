// test_groom.c - damaged .hair files: whatever the bytes, the reader either
// refuses with a reason or makes a groom that keeps every promise of groom.h.
// The seed is fixed; GLINT_LONG runs twenty times as many.
#include "tests/check.h"

#include <stdint.h>
#include <stdlib.h>

#include "renderer/groom.h"

static uint64_t state = 0x9e3779b97f4a7c15u;

static uint32_t draw(void) // xorshift64*
{
    state ^= state >> 12;
    state ^= state << 25;
    state ^= state >> 27;
    return (uint32_t)((state * 0x2545f4914f6cdd1du) >> 32);
}

static uint32_t below(uint32_t n)
{
    return (uint32_t)(((uint64_t)draw() * n) >> 32);
}

static void put_u32(struct buf *b, uint32_t v)
{
    for (int i = 0; i < 4; i++)
        buf_byte(b, (unsigned char)(v >> (8 * i)));
}

static void put_f32(struct buf *b, float f)
{
    uint32_t bits;
    memcpy(&bits, &f, sizeof bits);
    put_u32(b, bits);
}

// A valid file of a few strands, the first of two points or more, with a random
// set of arrays.
static void make_file(struct buf *b)
{
    buf_clear(b);
    uint32_t strands = 1 + below(7), arrays = 2 | (draw() & 31);
    uint32_t even = 1 + below(4), points = 0;
    unsigned segments[8];
    for (uint32_t s = 0; s < strands; s++) {
        segments[s] = arrays & 1 ? (s > 0 ? below(6) : 1 + below(5)) : even;
        points += segments[s] + 1;
    }
    buf_append(b, "HAIR", 4);
    put_u32(b, strands);
    put_u32(b, points);
    put_u32(b, arrays);
    put_u32(b, even);
    for (int i = 0; i < 5; i++)
        put_f32(b, 0.5f);
    while (b->size < 128)
        buf_byte(b, 0);
    for (uint32_t s = 0; s < strands && (arrays & 1); s++) {
        buf_byte(b, (unsigned char)segments[s]);
        buf_byte(b, 0);
    }
    uint32_t floats =
        3 + ((arrays >> 2) & 1) + ((arrays >> 3) & 1) + 3 * ((arrays >> 4) & 1);
    for (uint32_t i = 0; i < points * floats; i++)
        put_f32(b, (float)below(1000) / 1000);
}

// Values at which arithmetic goes wrong.
static const uint32_t odd[] = {
    0,          1,          2,          0xff,       0xffff,     0x10000,
    0x7fffffff, 0x80000000, 0xffffffff, 0x7f800000, 0xff800000, 0x7fc00000,
    0x55555555, 0xaaaaaaab, 7999999,    8000000,    8000001,    0x00000001,
};

static void damage(struct buf *b)
{
    for (uint32_t n = 1 + below(3); n > 0 && b->size > 0; n--) {
        uint32_t size = (uint32_t)b->size;
        uint32_t at = below(draw() & 1 ? size : size < 40 ? size : 40);
        switch (below(5)) {
        case 0:
            b->data[at] ^= (unsigned char)(1u << below(8));
            break;
        case 1:
            b->data[at] = (unsigned char)draw();
            break;
        case 2: // a whole field of the header, or a float
            at &= ~3u;
            for (uint32_t i = 0, v = odd[below(18)]; i < 4; i++)
                if (at + i < size)
                    b->data[at + i] = (unsigned char)(v >> (8 * i));
            break;
        case 3:
            b->size -= below(size) / 2;
            break;
        default:
            for (uint32_t i = below(40); i > 0; i--)
                buf_byte(b, (unsigned char)draw());
        }
    }
}

static bool in_range(const float *v, size_t n, float low, float high)
{
    for (size_t i = 0; v && i < n; i++)
        if (!(v[i] >= low && v[i] <= high))
            return false;
    return true;
}

static bool keeps_promises(const struct groom *g)
{
    size_t n = g->points;
    bool ok = g->strands >= 1 && g->first[0] == 0 &&
              g->first[g->strands] == g->points && n <= 8000000;
    for (uint32_t s = 0; ok && s < g->strands; s++)
        ok = g->first[s] + 2 <= g->first[s + 1];
    ok = ok && in_range(g->position, 3 * n, -1e9f, 1e9f) &&
         in_range(g->diameter, n, 0, 1e9f) && in_range(g->opacity, n, 0, 1) &&
         in_range(g->colour, 3 * n, 0, 1000) &&
         in_range(&g->default_diameter, 1, 0, 1e9f) &&
         in_range(&g->default_opacity, 1, 0, 1) &&
         in_range(g->default_colour, 3, 0, 1000) && g->up >= 0 && g->up <= 2;
    for (size_t i = 0; ok && i < 3 * n; i++)
        ok = g->position[i] >= g->box_min[i % 3] &&
             g->position[i] <= g->box_max[i % 3];
    return ok && isfinite(groom_auto_diameter(g));
}

// The bytes stand at the end of their own allocation, so that the address
// sanitizer sees a read of one byte too many.
static struct groom *parse_exact(const struct buf *b, struct error *err)
{
    unsigned char *copy = malloc(b->size ? b->size : 1);
    if (b->size > 0)
        memcpy(copy, b->data, b->size);
    struct groom *g = groom_parse((struct span){copy, b->size}, "f.hair", err);
    free(copy);
    return g;
}

int main(void)
{
    long rounds = getenv("GLINT_LONG") ? 20000000 : 1000000;
#ifdef GLINT_SANITIZED
    rounds /= 5;
#endif
    struct buf b = {0};
    long read = 0, refused = 0, silent = 0, broken = 0, whole = 0;
    for (long i = 0; i < rounds; i++) {
        make_file(&b);
        bool spared = i % 16 == 0;
        if (!spared)
            damage(&b);
        struct error err = {0};
        struct groom *g = parse_exact(&b, &err);
        if (g)
            broken += !keeps_promises(g);
        else
            silent += !err.code[0] || !err.text[0];
        g ? read++ : refused++;
        whole += spared && !g;
        groom_destroy(g);
    }
    buf_finish(&b);
    printf("  %ld files: %ld read, %ld refused\n", rounds, read, refused);
    check_case("groom fuzz: what is read keeps every promise");
    CHECK(broken == 0);
    check_case("groom fuzz: what is refused has a reason");
    CHECK(silent == 0);
    check_case("groom fuzz: undamaged files are read");
    CHECK(whole == 0);
    check_case("groom fuzz: damage does both");
    CHECK(read > rounds / 10 && refused > rounds / 10);
    return check_end();
}
