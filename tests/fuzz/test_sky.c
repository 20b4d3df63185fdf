// test_sky.c - damaged sky files: Radiance bytes through the reader itself,
// OpenEXR files through the helper process, as a user would open them.
// Deterministic; GLINT_LONG=1 tries many more.
#include "renderer/sky.h"

#include <math.h>
#include <stdlib.h>
#include <time.h>

#include "renderer/sky_pixels.h"
#include "tests/check.h"
#include "tests/unit/sky_files.h"

static uint64_t state = 12345;

static uint32_t random32(void)
{
    state = state * 6364136223846793005u + 1442695040888963407u;
    return (uint32_t)(state >> 33);
}

// One to four changes: bits, bytes, numbers that mean something, cuts.
static void damage(struct buf *b)
{
    static const unsigned char telling[] = {0, 1, 2, 127, 128, 129, 255};
    for (uint32_t i = 0, n = 1 + random32() % 4; i < n && b->size > 0; i++) {
        size_t at = random32() % b->size;
        switch (random32() % 5) {
        case 0:
            b->data[at] ^= (unsigned char)(1 << random32() % 8);
            break;
        case 1:
            b->data[at] = (unsigned char)random32();
            break;
        case 2:
            b->data[at] = telling[random32() % sizeof telling];
            break;
        case 3:
            for (size_t k = 0; k < 4 && at + k < b->size; k++)
                b->data[at + k] = telling[random32() % sizeof telling];
            break;
        default:
            if (random32() % 4 == 0)
                b->size = at;
            break;
        }
    }
}

static void rgbe(struct buf *b, bool runs)
{
    buf_text(b, "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 8 +X 16\n");
    for (int y = 0; y < 8; y++) {
        if (runs) {
            buf_append(b, "\x02\x02\0\x10\x90\x05\x88\x07\x08", 9);
            buf_append(b, "12345678\x90\x03\x90\x80", 12);
            continue;
        }
        buf_append(b, "\x10\x20\x30\x80\x01\x01\x01\x0c", 8);
        buf_append(b, "\x10\x20\x30\x81\x10\x20\x30\x82\x10\x20\x30\x83", 12);
    }
}

static void test_rgbe(int tries)
{
    int good = 0;
    check_case("damaged Radiance bytes");
    for (int i = 0; i < tries; i++) {
        struct buf b = {0};
        struct error err = {0};
        struct sky_pixels p;
        rgbe(&b, i % 2);
        damage(&b);
        // A copy of the exact size: a sanitizer sees a read beyond it.
        struct buf exact = {0};
        buf_append(&exact, b.data, b.size);
        bool ok =
            sky_rgbe_read((struct span){exact.data, exact.size}, &p, &err);
        good += ok;
        if (!CHECK(ok ? p.rgb && p.width >= 1 && p.height >= 1
                      : !p.rgb && err.text[0]))
            printf("  try %d: %s\n", i, err.text);
        sky_pixels_finish(&p);
        buf_finish(&exact);
        buf_finish(&b);
    }
    // Neither always refused nor never: the damage reaches the pixels.
    CHECK(good > tries / 20 && good < tries * 19 / 20);
}

static double value(const char *channel, int x, int y)
{
    return channel[0] + x * y;
}

static void exr(struct buf *b)
{
    static const struct sky_files_channel channels[] = {
        {"A", 1, 1}, {"B", 1, 1}, {"G", 2, 1}, {"R", 1, 1}};
    struct sky_files_exr e = {.data = {0, 0, 31, 15},
                              .display = {0, 0, 31, 15},
                              .channels = channels,
                              .channel_count = 4,
                              .envmap = 0,
                              .value = value};
    sky_files_make_exr(b, &e);
}

static void read_all(const char *path, struct buf *b)
{
    FILE *f = fopen(path, "rb");
    char part[4096];
    for (size_t n; f && (n = fread(part, 1, sizeof part, f)) > 0;)
        buf_append(b, part, n);
    if (f)
        fclose(f);
}

static void check_sane(const struct sky_map *m)
{
    for (int i = 0; i < 3 * m->width * m->height; i++)
        if (!(m->rgb[i] >= 0 && m->rgb[i] <= 1e8f)) {
            CHECK(m->rgb[i] >= 0 && m->rgb[i] <= 1e8f);
            return;
        }
}

static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

// Damage near the start hits the header; a whole file is rarely hit there.
static void test_exr(const char *name, const struct buf *seed, int tries)
{
    char words[100];
    snprintf(words, sizeof words, "damaged OpenEXR files: %s", name);
    check_case(words);
    int good = 0;
    double slowest = 0;
    for (int i = 0; i < tries; i++) {
        struct buf b = {0};
        struct error err = {0};
        buf_append(&b, seed->data, seed->size);
        if (i % 2) { // only the first part
            struct buf head = {b.data, b.size < 600 ? b.size : 600, b.cap};
            damage(&head);
        } else {
            damage(&b);
        }
        const char *path = sky_files_write(b.data, b.size);
        double begin = now();
        struct sky_map *m = sky_load(path, &err);
        slowest = fmax(slowest, now() - begin);
        unlink(path);
        if (m)
            check_sane(m);
        else
            CHECK(err.text[0] != 0);
        good += m != NULL;
        sky_map_destroy(m);
        buf_finish(&b);
    }
    printf("  %d of %d loaded, slowest %.2f s\n", good, tries, slowest);
    CHECK_ATMOST(slowest, 5.5);
}

int main(int argc, char **argv)
{
    sky_helper_main(argc, argv);
    bool longer = getenv("GLINT_LONG") != NULL;
    test_rgbe(longer ? 2000000 : 40000);
    struct buf seed = {0};
    exr(&seed);
    test_exr("no compression", &seed, longer ? 20000 : 150);
    static const char *const seeds[][2] = {
        {"env", "pmndrs_apartment.exr"},           // DWAB
        {"exr_features", "AllHalfValues.exr"},     // PIZ
        {"exr_features", "GrayRampsDiagonal.exr"}, // PXR24
        {"exr_features", "Garden.exr"}};           // tiles
    for (int i = 0; i < 4; i++) {
        const char *dir = sky_files_data(seeds[i][0]);
        char path[1100];
        if (!dir)
            continue;
        snprintf(path, sizeof path, "%s/%s", dir, seeds[i][1]);
        buf_clear(&seed);
        read_all(path, &seed);
        test_exr(seeds[i][1], &seed, longer ? 2000 : 40);
    }
    buf_finish(&seed);
    return check_end();
}
