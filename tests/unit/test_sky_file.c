// test_sky_file.c - what is read from OpenEXR files, and how: values,
// orientation, windows, cleaning, refusals by name; real files.  Radiance is in
// test_sky_rgbe.c, the helper process in test_sky_helper.c.
#include "renderer/sky.h"

#include <math.h>
#include <stdlib.h>

#include "renderer/sky_clean.h"
#include "renderer/sky_pixels.h"
#include "tests/check.h"
#include "tests/unit/sky_files.h"

// The pixel in which a direction lies, by the rule of sky.h.
static const float *toward(const struct sky_map *m, double x, double y,
                           double z)
{
    const double pi = acos(-1);
    double r = sqrt(x * x + y * y + z * z);
    double u = 0.5 - atan2(y, x) / (2 * pi), v = 0.5 - asin(z / r) / pi;
    int px = (int)floor(u * m->width), py = (int)floor(v * m->height);
    return sky_files_pixel(m, (px + m->width) % m->width,
                           py < m->height ? py : m->height - 1);
}

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

// --- OpenEXR ---------------------------------------------------------------

static double ramp(const char *channel, int x, int y)
{
    if (strcmp(channel, "Y") == 0)
        return 0.25 * (x + 1);
    if (strcmp(channel, "RY") == 0 || strcmp(channel, "BY") == 0)
        return 0;
    return channel[0] == 'R' ? x + 0.5 : channel[0] == 'G' ? y : 2;
}

static const struct sky_files_channel rgb_half[] = {
    {"B", 1, 1}, {"G", 1, 1}, {"R", 1, 1}};
static const struct sky_files_channel abgr_mixed[] = {
    {"A", 1, 1}, {"B", 2, 1}, {"G", 1, 1}, {"R", 2, 1}};
static const struct sky_files_channel luma[] = {{"Y", 2, 1}};
static const struct sky_files_channel chroma[] = {
    {"BY", 1, 2}, {"RY", 1, 2}, {"Y", 1, 1}};
static const struct sky_files_channel depth[] = {{"Z", 2, 1}, {"left.R", 1, 1}};
static const struct sky_files_channel integers[] = {{"R", 0, 1}};

static struct sky_map *load_exr(const struct sky_files_exr *e,
                                struct error *err)
{
    struct buf b = {0};
    sky_files_make_exr(&b, e);
    struct sky_map *m = sky_files_load(&b, err);
    buf_finish(&b);
    return m;
}

static void test_exr_channels(void)
{
    struct sky_files_exr e = {.data = {0, 0, 16, 8}, // odd sizes
                              .display = {0, 0, 16, 8},
                              .envmap = -1,
                              .value = ramp};
    const struct sky_files_channel *lists[] = {rgb_half, abgr_mixed};
    const int counts[] = {3, 4};
    check_case("exr half and float, three and four channels");
    for (int i = 0; i < 2; i++) {
        struct error err = {0};
        e.channels = lists[i];
        e.channel_count = counts[i];
        struct sky_map *m = load_exr(&e, &err);
        CHECK_STR(err.text, "");
        if (CHECK(m && m->width == 17 && m->height == 9)) {
            CHECK_NEAR((double)sky_files_pixel(m, 5, 7)[0], 5.5, 0);
            CHECK_NEAR((double)sky_files_pixel(m, 5, 7)[1], 7, 0);
            CHECK_NEAR((double)sky_files_pixel(m, 16, 8)[2], 2, 0);
        }
        sky_map_destroy(m);
    }
    check_case("exr luminance alone is grey");
    struct error err = {0};
    e.channels = luma;
    e.channel_count = 1;
    struct sky_map *m = load_exr(&e, &err);
    CHECK_STR(err.text, "");
    for (int k = 0; m && k < 3; k++)
        CHECK_NEAR((double)sky_files_pixel(m, 7, 3)[k], 2, 0);
    sky_map_destroy(m);
    check_case("exr luminance and chroma");
    e = (struct sky_files_exr){{0, 0, 15, 7}, {0, 0, 15, 7}, chroma, 3, -1,
                               NULL,          ramp};
    m = load_exr(&e, &err);
    CHECK_STR(err.text, "");
    // No chroma: grey; the library's filter rounds to half (2^-11).
    for (int k = 0; m && k < 3; k++)
        CHECK_NEAR((double)sky_files_pixel(m, 7, 3)[k], 2, 0.001);
    sky_map_destroy(m);
}

static void test_exr_windows(void)
{
    // The data window is the lower right part of a larger display window.
    struct sky_files_exr e = {.data = {4, 2, 11, 5},
                              .display = {-4, -2, 11, 5},
                              .channels = rgb_half,
                              .channel_count = 3,
                              .envmap = -1,
                              .value = ramp};
    struct error err = {0};
    check_case("exr display window without envmap");
    struct sky_map *m = load_exr(&e, &err);
    CHECK_STR(err.text, "");
    if (CHECK(m && m->width == 16 && m->height == 8)) {
        CHECK_NEAR((double)sky_files_pixel(m, 0, 0)[0], 0, 0);
        CHECK_NEAR((double)sky_files_pixel(m, 8, 4)[0], 4.5, 0);
        CHECK_NEAR((double)sky_files_pixel(m, 15, 7)[0], 11.5, 0);
    }
    sky_map_destroy(m);
    check_case("exr overscan is cut");
    struct sky_files_exr wide = e;
    wide.display[0] = 6;
    wide.display[2] = 9;
    wide.display[1] = 3;
    wide.display[3] = 4;
    m = load_exr(&wide, &err);
    if (CHECK(m && m->width == 4 && m->height == 2))
        CHECK_NEAR((double)sky_files_pixel(m, 3, 1)[0], 9.5, 0);
    sky_map_destroy(m);
    check_case("exr data window with envmap");
    e.envmap = 0;
    m = load_exr(&e, &err);
    if (CHECK(m && m->width == 8 && m->height == 4))
        CHECK_NEAR((double)sky_files_pixel(m, 0, 0)[0], 4.5, 0);
    sky_map_destroy(m);
}

static void test_exr_refusals(void)
{
    struct sky_files_exr e = {.data = {0, 0, 7, 3},
                              .display = {0, 0, 7, 3},
                              .channels = rgb_half,
                              .channel_count = 3,
                              .envmap = 1,
                              .value = ramp};
    struct buf b = {0};
    check_case("exr refusals");
    sky_files_make_exr(&b, &e);
    expect_refusal(&b, "cube map");
    buf_clear(&b);
    e.envmap = -1;
    e.channels = depth;
    e.channel_count = 2;
    sky_files_make_exr(&b, &e);
    expect_refusal(&b, "no channel R, G, B or Y; it has Z, left.R");
    buf_clear(&b);
    e.channels = integers;
    e.channel_count = 1;
    sky_files_make_exr(&b, &e);
    expect_refusal(&b, "integers");
    buf_clear(&b);
    e.channels = rgb_half;
    e.channel_count = 3;
    sky_files_make_exr(&b, &e);
    b.size -= 10;
    expect_refusal(&b, "damaged OpenEXR file");
    buf_clear(&b);
    e.display[2] = e.data[2] = 9000;
    e.display[3] = e.data[3] = 8000;
    e.data[1] = 7999; // so that the file stays small
    sky_files_make_exr(&b, &e);
    expect_refusal(&b, "display window");
    buf_finish(&b);
}

// Rec. 2020 red is known in Rec. 709: (1.6605, -0.1246, -0.0182) (ITU-R
// BT.2087); negative parts are cleaned away, and counted.
static double red(const char *channel, int x, int y)
{
    (void)x, (void)y;
    return channel[0] == 'R';
}

static void test_exr_primaries(void)
{
    static const float rec2020[8] = {0.708f, 0.292f, 0.170f,  0.797f,
                                     0.131f, 0.046f, 0.3127f, 0.3290f};
    struct sky_files_exr e = {{0, 0, 7, 3}, {0, 0, 7, 3}, rgb_half, 3,
                              -1,           rec2020,      red};
    struct error err = {0};
    check_case("exr primaries");
    struct sky_map *m = load_exr(&e, &err);
    CHECK_STR(err.text, "");
    if (CHECK(m != NULL)) {
        // The published matrix has four digits.
        CHECK_NEAR((double)m->rgb[0], 1.6605, 1e-4);
        CHECK_NEAR((double)m->rgb[1], 0, 0);
        CHECK(m->cleaned.negative == 2 * 8 * 4);
    }
    sky_map_destroy(m);
}

static double odd_values(const char *channel, int x, int y)
{
    if (channel[0] != 'R' || y != 2)
        return 1;
    return x == 0 ? NAN : x == 1 ? INFINITY : x == 2 ? -3 : x == 3 ? 60000 : 1;
}

static void test_cleaning(void)
{
    static const struct sky_files_channel floats[] = {
        {"B", 2, 1}, {"G", 2, 1}, {"R", 2, 1}};
    struct sky_files_exr e = {{0, 0, 7, 3}, {0, 0, 7, 3}, floats,    3,
                              -1,           NULL,         odd_values};
    struct error err = {0};
    check_case("cleaning");
    struct sky_map *m = load_exr(&e, &err);
    CHECK_STR(err.text, "");
    if (!CHECK(m != NULL))
        return;
    CHECK_NEAR((double)sky_files_pixel(m, 0, 2)[0], 0, 0);
    CHECK_NEAR((double)sky_files_pixel(m, 1, 2)[0], 65504, 0);
    CHECK_NEAR((double)sky_files_pixel(m, 2, 2)[0], 0, 0);
    CHECK_NEAR((double)sky_files_pixel(m, 3, 2)[0], 60000, 0);
    CHECK(m->cleaned.nan == 1 && m->cleaned.infinite == 1 &&
          m->cleaned.negative == 1);
    double q = sky_clean_solid_angle(2, 8, 4);
    double energy = q * (65504 + 60000) + 4 * acos(-1) - 4 * q;
    CHECK_NEAR(m->cleaned.energy_share, q * (65504 + 3) / energy / 3, 1e-9);
    sky_map_destroy(m);
}

// --- real files ------------------------------------------------------------

// The picture shows the axes of OpenEXR's rule (y up): our x, y, z are its Z,
// X, Y.  In each of four directions a black line leads from the horizon
// upwards, and one along the horizon towards the next axis; beyond them is
// white.
static void test_orientation(void)
{
    check_case("orientation of a lat-long map");
    const char *dir = sky_files_data("env");
    if (!dir) {
        check_skip("no data");
        return;
    }
    char path[1100];
    snprintf(path, sizeof path, "%s/OrientationLatLong.exr", dir);
    struct error err = {0};
    struct sky_map *m = sky_load(path, &err);
    if (!CHECK(m != NULL)) {
        printf("  %s\n", err.text);
        return;
    }
    static const double axis[4][2] = {{1, 0}, {0, 1}, {-1, 0}, {0, -1}};
    for (int i = 0; i < 4; i++) {
        double x = axis[i][0], y = axis[i][1];
        CHECK(toward(m, x, y, 0.2)[1] < 0.5f);   // upright stroke
        CHECK(toward(m, x, y, -0.06)[1] > 0.5f); // nothing below
    }
    // At +x and -x (its +Z, -Z) the other stroke is its X, our y; at +y and -y
    // (its +X, -X) it is its Z, our x.
    for (int i = 0; i < 4; i++) {
        double x = axis[i][0], y = axis[i][1];
        bool on_x = i % 2 == 0;
        CHECK(toward(m, x + (on_x ? 0 : 0.2), y + (on_x ? 0.2 : 0), 0.003)[1] <
              0.5f);
        CHECK(toward(m, x - (on_x ? 0 : 0.2), y - (on_x ? 0.2 : 0), 0.003)[1] >
              0.5f);
    }
    sky_map_destroy(m);
}

static void mean_of(const char *name, double mean[3])
{
    char path[1100];
    struct error err = {0};
    snprintf(path, sizeof path, "%s/%s", sky_files_data("env"), name);
    struct sky_map *m = sky_load(path, &err);
    mean[0] = mean[1] = mean[2] = -1;
    if (!CHECK(m != NULL)) {
        printf("  %s\n", err.text);
        return;
    }
    for (int k = 0; k < 3; k++)
        mean[k] = 0;
    for (int y = 0; y < m->height; y++)
        for (int x = 0; x < m->width; x++)
            for (int k = 0; k < 3; k++)
                mean[k] += (double)sky_files_pixel(m, x, y)[k] *
                           sky_clean_solid_angle(y, m->width, m->height);
    sky_map_destroy(m);
}

// The same sky as DWAB and as RGBE.  The codec is lossy, some maps were made
// smaller, and ringing below zero around lamps is cut off: 1 %.
static void test_pairs(void)
{
    static const char *const pairs[4][2] = {
        {"pmndrs_dawn.exr", "kiara_1_dawn_1k.hdr"},
        {"pmndrs_apartment.exr", "lebombo_1k.hdr"},
        {"pmndrs_studio.exr", "studio_small_03_1k.hdr"},
        {"blender_sunset.exr", "venice_sunset_1k.hdr"}};
    check_case("DWAB and RGBE agree");
    if (!sky_files_data("env")) {
        check_skip("no data");
        return;
    }
    for (int i = 0; i < 4; i++) {
        double a[3], b[3];
        mean_of(pairs[i][0], a);
        mean_of(pairs[i][1], b);
        for (int k = 0; k < 3; k++)
            if (!CHECK(fabs(a[k] - b[k]) <= 0.01 * b[k]))
                printf("  %s: %g, %g\n", pairs[i][0], a[k], b[k]);
    }
}

static void test_studio(void)
{
    struct error err = {0};
    check_case("built-in studio");
    struct sky_map *a = sky_open("builtin:studio", &err);
    struct sky_map *b = sky_builtin("studio", &err);
    if (CHECK(a && b)) {
        CHECK(a->width == 2 * a->height);
        CHECK(memcmp(a->sha256, b->sha256, 32) == 0);
        CHECK_STR(a->name, "builtin:studio");
        float most = 0, least = 1;
        for (int i = 0; i < 3 * a->width * a->height; i++) {
            most = fmaxf(most, a->rgb[i]);
            least = fminf(least, a->rgb[i]);
        }
        CHECK(most > 10 && least > 0 && least < 0.1f);
        CHECK(a->cleaned.negative + a->cleaned.nan + a->cleaned.infinite == 0);
    }
    sky_map_destroy(a);
    sky_map_destroy(b);
    CHECK(sky_builtin("beach", &err) == NULL);
    CHECK(strstr(err.text, "'beach'") && strstr(err.text, "studio"));
}

int main(int argc, char **argv)
{
    sky_helper_main(argc, argv);
    test_exr_channels();
    test_exr_windows();
    test_exr_refusals();
    test_exr_primaries();
    test_cleaning();
    test_orientation();
    test_pairs();
    test_studio();
    return check_end();
}
