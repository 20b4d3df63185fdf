// test_sky_rgbe.c - Radiance files: run lengths old and new, orientations,
// refusals by name; and what is no sky file at all.
#include "renderer/sky.h"

#include <stdlib.h>

#include "tests/check.h"
#include "tests/unit/sky_files.h"

// Loads, and expects the error to hold `words`.
static void expect_refusal(const struct buf *b, const char *words)
{
    struct error err = {0};
    struct sky_map *m = sky_files_load(b, &err);
    CHECK(m == NULL);
    if (!strstr(err.text, words)) {
        printf("  error \"%s\" does not say \"%s\"\n", err.text, words);
        CHECK(strstr(err.text, words) != NULL);
    }
    sky_map_destroy(m);
}

static const char rgbe_head[] =
    "#?RADIANCE\nEXPOSURE=2.0\nFORMAT=32-bit_rle_rgbe\n\n";

// 4 x 2 pixels, red = 1 + index of the pixel in the file, as 2^7 mantissas.
static void rgbe_flat(struct buf *b, const char *resolution)
{
    buf_text(b, rgbe_head);
    buf_text(b, resolution);
    for (int i = 0; i < 8; i++) {
        unsigned char p[4] = {(unsigned char)(16 * (i + 1)), 128, 0, 129};
        buf_append(b, p, 4);
    }
}

static void test_rgbe_orientations(void)
{
    // Index of the file's pixel that must come out at (0,0), (3,0), (0,1).
    static const struct {
        const char *resolution;
        int want[3];
    } cases[] = {
        {"-Y 2 +X 4\n", {0, 3, 4}}, {"-Y 2 -X 4\n", {3, 0, 7}},
        {"+Y 2 +X 4\n", {4, 7, 0}}, {"+Y 2 -X 4\n", {7, 4, 3}},
        {"+X 4 -Y 2\n", {0, 6, 1}}, {"-X 4 -Y 2\n", {6, 0, 7}},
        {"+X 4 +Y 2\n", {1, 7, 0}}, {"-X 4 +Y 2\n", {7, 1, 6}},
    };
    check_case("rgbe orientations");
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        struct buf b = {0};
        struct error err = {0};
        rgbe_flat(&b, cases[i].resolution);
        struct sky_map *m = sky_files_load(&b, &err);
        CHECK_STR(err.text, "");
        if (CHECK(m && m->width == 4 && m->height == 2)) {
            const float *at[3] = {sky_files_pixel(m, 0, 0),
                                  sky_files_pixel(m, 3, 0),
                                  sky_files_pixel(m, 0, 1)};
            for (int k = 0; k < 3; k++)
                CHECK_NEAR((double)at[k][0], 0.125 * (cases[i].want[k] + 1), 0);
            // EXPOSURE is ignored: 128 / 256 * 2^(129 - 128).
            CHECK_NEAR((double)at[0][1], 1, 0);
            CHECK_NEAR((double)at[0][2], 0, 0);
        }
        sky_map_destroy(m);
        buf_finish(&b);
    }
}

// 16 x 8 pixels of value (y + 1, x + 1, 3) / 256, exponent 128.
static void check_rle(const struct buf *b)
{
    struct error err = {0};
    struct sky_map *m = sky_files_load(b, &err);
    CHECK_STR(err.text, "");
    for (int y = 0; m && y < 8; y++)
        for (int x = 0; x < 16; x++) {
            CHECK_NEAR((double)sky_files_pixel(m, x, y)[0] * 256, y + 1, 0);
            CHECK_NEAR((double)sky_files_pixel(m, x, y)[1] * 256,
                       x < 9 ? 5 : x + 1, 0);
            CHECK_NEAR((double)sky_files_pixel(m, x, y)[2] * 256, 3, 0);
        }
    sky_map_destroy(m);
}

static void rgbe_new(struct buf *b)
{
    buf_text(b, rgbe_head);
    buf_text(b, "-Y 8 +X 16\n");
    for (int y = 0; y < 8; y++) {
        buf_append(b, "\x02\x02\0\x10", 4);
        buf_byte(b, 128 + 16);
        buf_byte(b, (unsigned char)(y + 1));
        buf_byte(b, 128 + 9);
        buf_byte(b, 5);
        buf_byte(b, 7);
        for (int x = 9; x < 16; x++)
            buf_byte(b, (unsigned char)(x + 1));
        buf_append(b, "\x90\x03\x90\x80", 4);
    }
}

static void test_rgbe_runs(void)
{
    struct buf b = {0};
    check_case("rgbe new run lengths");
    rgbe_new(&b);
    check_rle(&b);
    check_case("rgbe old run lengths");
    buf_clear(&b);
    buf_text(&b, rgbe_head);
    buf_text(&b, "-Y 8 +X 16\n");
    for (int y = 0; y < 8; y++) {
        unsigned char p[4] = {(unsigned char)(y + 1), 5, 3, 128};
        buf_append(&b, p, 4);
        buf_append(&b, "\x01\x01\x01\x08", 4);
        for (int x = 9; x < 16; x++) {
            p[1] = (unsigned char)(x + 1);
            buf_append(&b, p, 4);
        }
    }
    check_rle(&b);
    check_case("rgbe old run lengths beyond 255");
    buf_clear(&b);
    buf_text(&b, rgbe_head);
    buf_text(&b, "-Y 300 +X 600\n");
    for (int y = 0; y < 300; y++) { // 1 + 0x57 + 2 * 256 = 600
        unsigned char p[12] = {128, 64, 32, 128, 1, 1, 1, 0x57, 1, 1, 1, 2};
        buf_append(&b, p, sizeof p);
    }
    struct error err = {0};
    struct sky_map *m = sky_files_load(&b, &err);
    CHECK_STR(err.text, "");
    if (CHECK(m != NULL))
        CHECK_NEAR((double)sky_files_pixel(m, 599, 299)[0], 0.5, 0);
    sky_map_destroy(m);
    buf_finish(&b);
}

static void test_rgbe_refusals(void)
{
    struct buf b = {0};
    check_case("rgbe refusals");
    buf_text(&b, "#?RADIANCE\nFORMAT=32-bit_rle_xyze\n\n-Y 1 +X 2\n12345678");
    expect_refusal(&b, "XYZE");
    buf_clear(&b);
    buf_text(&b, "#?RADIANCE\n\n-Y 2 +Y 4\n");
    expect_refusal(&b, "resolution line");
    buf_clear(&b);
    buf_text(&b, "#?RADIANCE\n\n-Y 20000 +X 30000\n");
    expect_refusal(&b, "megapixels");
    buf_clear(&b);
    buf_text(&b, "#?RADIANCE\n\n-Y 4 +X 3\n");
    expect_refusal(&b, "twice as wide");
    buf_clear(&b);
    rgbe_new(&b);
    b.size -= 3;
    expect_refusal(&b, "scan line 8 of 8");
    buf_clear(&b);
    buf_text(&b, "\x89PNG\r\n");
    expect_refusal(&b, "neither an OpenEXR nor a Radiance");
    buf_clear(&b);
    expect_refusal(&b, "too short");
    struct error err = {0};
    CHECK(sky_load("/nonexistent/a.exr", &err) == NULL);
    CHECK_STR(err.text, "a.exr: No such file or directory");
    CHECK(sky_load("/tmp", &err) == NULL);
    CHECK(strstr(err.text, "not a regular file") != NULL);
    buf_finish(&b);
}

int main(int argc, char **argv)
{
    sky_helper_main(argc, argv);
    test_rgbe_orientations();
    test_rgbe_runs();
    test_rgbe_refusals();
    return check_end();
}
