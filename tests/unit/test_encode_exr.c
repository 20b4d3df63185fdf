// test_encode_exr.c - what encode_exr writes, read back by both readers of
// OpenEXR: the core library from memory, the older one through a file.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <ImfCRgbaFile.h>
#include <openexr.h>

#include "renderer/encode.h"
#include "tests/check.h"

enum { CHANNELS_MAX = 64 };

// --- reading ---------------------------------------------------------------

struct file {
    exr_context_t context;
    struct span bytes;
    int width, height, channels;
    exr_pixel_type_t type;
    char name[CHANNELS_MAX][256];
    unsigned char *plane[CHANNELS_MAX]; // [height][width], in the file's type
};

static int64_t read_at(exr_const_context_t context, void *user, void *to,
                       uint64_t size, uint64_t offset,
                       exr_stream_error_func_ptr_t report)
{
    (void)context, (void)report;
    const struct span *in = user;
    if (offset > in->size)
        return -1;
    size_t n = in->size - offset < size ? in->size - offset : size;
    memcpy(to, in->data + offset, n);
    return (int64_t)n;
}

static int64_t size_of(exr_const_context_t context, void *user)
{
    (void)context;
    return (int64_t)((const struct span *)user)->size;
}

static size_t sample_size(const struct file *f)
{
    return f->type == EXR_PIXEL_HALF ? 2 : 4;
}

static bool good(exr_result_t result)
{
    return result == EXR_ERR_SUCCESS;
}

static bool read_chunk(struct file *f, exr_decode_pipeline_t *pipe, int y)
{
    exr_chunk_info_t info;
    const size_t size = sample_size(f), row = size * (size_t)f->width;
    bool ok = good(exr_read_scanline_chunk_info(f->context, 0, y, &info)) &&
              good(y == 0 ? exr_decoding_initialize(f->context, 0, &info, pipe)
                          : exr_decoding_update(f->context, 0, &info, pipe));
    if (!ok)
        return false;
    for (int c = 0; c < f->channels; c++) {
        exr_coding_channel_info_t *to = &pipe->channels[c];
        to->user_pixel_stride = (int32_t)size;
        to->user_line_stride = (int32_t)row;
        to->user_bytes_per_element = (int16_t)size;
        to->user_data_type = (uint16_t)f->type;
        to->decode_to_ptr = f->plane[c] + row * (size_t)y;
    }
    if (y == 0)
        ok = good(exr_decoding_choose_default_routines(f->context, 0, pipe));
    return ok && good(exr_decoding_run(f->context, 0, pipe));
}

static bool read_head(struct file *f)
{
    exr_attr_box2i_t window;
    const exr_attr_chlist_t *list;
    if (!good(exr_get_data_window(f->context, 0, &window)) ||
        !good(exr_get_channels(f->context, 0, &list)) ||
        list->num_channels > CHANNELS_MAX)
        return false;
    f->width = window.max.x - window.min.x + 1;
    f->height = window.max.y - window.min.y + 1;
    f->channels = list->num_channels;
    f->type = list->entries[0].pixel_type;
    for (int c = 0; c < f->channels; c++) {
        snprintf(f->name[c], sizeof f->name[c], "%s",
                 list->entries[c].name.str);
        if (list->entries[c].pixel_type != f->type)
            return false;
        f->plane[c] =
            bytes_zalloc((size_t)f->width * (size_t)f->height, sample_size(f));
    }
    return true;
}

static bool file_read(struct file *f, const struct buf *bytes)
{
    *f = (struct file){.bytes = {bytes->data, bytes->size}};
    exr_context_initializer_t how = EXR_DEFAULT_CONTEXT_INITIALIZER;
    how.user_data = &f->bytes;
    how.read_fn = read_at;
    how.size_fn = size_of;
    if (!good(exr_start_read(&f->context, "memory", &how)) || !read_head(f))
        return false;
    exr_decode_pipeline_t pipe = EXR_DECODE_PIPELINE_INITIALIZER;
    int32_t step = 0;
    bool ok = good(exr_get_scanlines_per_chunk(f->context, 0, &step));
    for (int y = 0; ok && y < f->height; y += step)
        ok = read_chunk(f, &pipe, y);
    exr_decoding_destroy(f->context, &pipe);
    return ok;
}

static void file_finish(struct file *f)
{
    for (int c = 0; c < f->channels; c++)
        free(f->plane[c]);
    if (f->context)
        exr_finish(&f->context);
}

static const unsigned char *sample(const struct file *f, const char *name,
                                   size_t pixel)
{
    for (int c = 0; c < f->channels; c++)
        if (strcmp(f->name[c], name) == 0)
            return f->plane[c] + pixel * sample_size(f);
    return NULL;
}

// --- pictures --------------------------------------------------------------

static uint32_t random_bits(uint32_t *state) // a linear congruence, its top
{
    *state = *state * 1664525u + 1013904223u;
    uint32_t high = *state >> 16;
    *state = *state * 1664525u + 1013904223u;
    return high << 16 | *state >> 16;
}

static float float_of(uint32_t bits)
{
    float f;
    memcpy(&f, &bits, sizeof f);
    return f;
}

static float *pixels_make(int width, int height, uint32_t seed)
{
    size_t n = 4 * (size_t)width * (size_t)height;
    float *p = bytes_alloc(n * sizeof *p);
    for (size_t i = 0; i < n; i++) // every bit pattern, NaN and infinity too
        p[i] = float_of(random_bits(&seed));
    return p;
}

static bool encode_one(struct buf *out, const float *rgba, int width,
                       int height, bool half)
{
    struct encode_layer layer = {"", rgba, true};
    struct encode_exr e = {width, height, half, &layer, 1, NULL};
    struct error err = {0};
    bool ok = encode_exr(out, &e, &err);
    if (!ok)
        printf("  %s\n", err.text);
    return ok;
}

static const int sizes[][2] = {{1, 1},  {1, 16},  {7, 17},   {16, 15},
                               {1, 99}, {333, 1}, {8192, 2}, {64, 64}};
static const char *const rgba_names[4] = {"R", "G", "B", "A"};

// --- cases -----------------------------------------------------------------

static void test_float(void)
{
    check_case("exr_floats_keep_every_bit");
    for (size_t s = 0; s < sizeof sizes / sizeof *sizes; s++) {
        int w = sizes[s][0], h = sizes[s][1];
        float *p = pixels_make(w, h, (uint32_t)s);
        struct buf out = {0};
        struct file f = {0};
        int wrong = 0;
        if (CHECK(encode_one(&out, p, w, h, false)) &&
            CHECK(file_read(&f, &out)) && CHECK(f.width == w) &&
            CHECK(f.height == h) && CHECK(f.channels == 4) &&
            CHECK(f.type == EXR_PIXEL_FLOAT))
            for (size_t i = 0; i < 4 * (size_t)w * (size_t)h; i++)
                wrong +=
                    memcmp(sample(&f, rgba_names[i % 4], i / 4), p + i, 4) != 0;
        CHECK_ATMOST(wrong, 0);
        file_finish(&f);
        buf_finish(&out);
        free(p);
    }
}

static double half_value(uint16_t h) // IEEE 754, binary16
{
    int e = h >> 10 & 31, m = h & 1023;
    double v = e == 31 ? (m ? (double)NAN : (double)INFINITY)
               : e     ? ldexp(1024 + m, e - 25)
                       : ldexp(m, -24);
    return h & 0x8000 ? -v : v;
}

// Nearest half: at most half of the spacing there; NaN stays, what a half does
// not hold becomes the largest that it holds.
static bool half_right(uint16_t h, float x)
{
    double got = half_value(h);
    if (isnan(x))
        return isnan(got);
    double want = fmin(fmax((double)x, -65504), 65504);
    int e = 0;
    frexp(want, &e); // |want| in [2^(e-1), 2^e)
    double spacing = ldexp(1, (e - 1 < -14 ? -14 : e - 1) - 10);
    return fabs(got - want) <= spacing / 2;
}

static void check_half(const float *p, int w, int h)
{
    struct buf out = {0};
    struct file f = {0};
    int wrong = 0;
    if (CHECK(encode_one(&out, p, w, h, true)) && CHECK(file_read(&f, &out)) &&
        CHECK(f.type == EXR_PIXEL_HALF))
        for (size_t i = 0; i < 4 * (size_t)w * (size_t)h; i++) {
            uint16_t got;
            memcpy(&got, sample(&f, rgba_names[i % 4], i / 4), 2);
            if (!half_right(got, p[i]) && wrong++ < 5)
                printf("  %.9g became %.9g\n", (double)p[i], half_value(got));
        }
    CHECK_ATMOST(wrong, 0);
    file_finish(&f);
    buf_finish(&out);
}

static void test_half(void)
{
    check_case("exr_halves_are_the_nearest");
    for (size_t s = 0; s < sizeof sizes / sizeof *sizes; s++) {
        float *p = pixels_make(sizes[s][0], sizes[s][1], 77 + (uint32_t)s);
        check_half(p, sizes[s][0], sizes[s][1]);
        free(p);
    }
    // exponents that halves have, at random and about every border
    float *p = bytes_alloc(sizeof *p * 4 * 256 * 64);
    uint32_t seed = 5;
    for (size_t i = 0; i < 4 * 256 * 64; i++) {
        uint32_t bits = random_bits(&seed);
        uint32_t exponent = 127 - 27 + (bits >> 8) % 45;
        p[i] = float_of((bits & 0x80000000) | exponent << 23 |
                        (i % 3 ? bits & 0x7fffff
                               : (bits & 0x7fe000) + 0x1000 + bits % 3 - 1));
    }
    check_half(p, 256, 64);
    free(p);

    check_case("exr_halves_that_do_not_fit");
    float odd[4 * 4] = {INFINITY, -INFINITY, NAN,     -NAN,   65504,    -65504,
                        65519,    65520,     1e30f,   -1e30f, 65504.5f, 0,
                        -0.0f,    5.9e-8f,   2.9e-8f, 6e-5f};
    check_half(odd, 4, 1);
}

static void test_layers(void)
{
    check_case("exr_layers");
    static const char *const names[] = {"", "single_TT", "global", "single_R"};
    static const char *const order[] = {
        "A",          "B",           "G",           "R",          "global.B",
        "global.G",   "global.R",    "single_R.A",  "single_R.B", "single_R.G",
        "single_R.R", "single_TT.B", "single_TT.G", "single_TT.R"};
    const int w = 37, h = 21;
    struct encode_layer layers[4];
    float *p[4];
    for (int l = 0; l < 4; l++) {
        p[l] = pixels_make(w, h, 100u + (uint32_t)l);
        layers[l] = (struct encode_layer){names[l], p[l], l == 0 || l == 3};
    }
    struct encode_exr e = {w, h, false, layers, 4, NULL};
    struct buf out = {0};
    struct error err = {0};
    struct file f = {0};
    CHECK(encode_exr(&out, &e, &err));
    if (CHECK(file_read(&f, &out)) && CHECK(f.channels == 14))
        for (int c = 0; c < 14; c++)
            CHECK_STR(f.name[c], order[c]);
    int wrong = 0;
    for (int l = 0; l < 4; l++)
        for (size_t i = 0; i < 4 * (size_t)w * (size_t)h; i++) {
            char name[64];
            snprintf(name, sizeof name, "%s%s%s", names[l], l ? "." : "",
                     rgba_names[i % 4]);
            const unsigned char *got = sample(&f, name, i / 4);
            bool there = i % 4 < 3 || layers[l].alpha;
            wrong += there != (got != NULL) ||
                     (got && memcmp(got, p[l] + i, 4) != 0);
        }
    CHECK_ATMOST(wrong, 0);
    file_finish(&f);
    buf_finish(&out);
    for (int l = 0; l < 4; l++)
        free(p[l]);
}

static void check_text(const struct file *f, const char *key, const char *want)
{
    int32_t length = 0;
    const char *got = NULL;
    CHECK(good(exr_attr_get_string(f->context, 0, key, &length, &got)));
    char copy[256];
    snprintf(copy, sizeof copy, "%.*s", (int)length, got ? got : "?");
    CHECK_STR(copy, want);
}

static void test_attributes(void)
{
    check_case("exr_attributes");
    float *p = pixels_make(5, 3, 1);
    const char *const text[] = {"fibre.eta",  "1.55", "comments",
                                "h\xc3\xa4r", "none", "",
                                "fibre.eta",  "1.6",  NULL};
    struct encode_layer layer = {"", p, true};
    struct encode_exr e = {5, 3, true, &layer, 1, text};
    struct buf out = {0};
    struct error err = {0};
    struct file f = {0};
    CHECK(encode_exr(&out, &e, &err));
    if (CHECK(file_read(&f, &out))) {
        check_text(&f, "fibre.eta", "1.6"); // the last one counts
        check_text(&f, "comments", "h\xc3\xa4r");
        check_text(&f, "none", "");
        exr_compression_t compression;
        exr_storage_t storage;
        exr_attr_box2i_t window;
        float aspect = 0;
        CHECK(good(exr_get_compression(f.context, 0, &compression)));
        CHECK(compression == EXR_COMPRESSION_ZIP);
        CHECK(good(exr_get_storage(f.context, 0, &storage)));
        CHECK(storage == EXR_STORAGE_SCANLINE);
        CHECK(good(exr_get_display_window(f.context, 0, &window)));
        CHECK(window.min.x == 0 && window.min.y == 0);
        CHECK(window.max.x == 4 && window.max.y == 2);
        CHECK(good(exr_get_pixel_aspect_ratio(f.context, 0, &aspect)));
        CHECK_NEAR(aspect, 1, 0); // stored, not computed
    }
    file_finish(&f);
    buf_finish(&out);
    free(p);
}

static void check_refused(struct encode_exr e, const char *what)
{
    struct buf out = {0};
    struct error err = {0};
    buf_text(&out, "before");
    CHECK(!encode_exr(&out, &e, &err));
    CHECK(out.size == 6 && memcmp(out.data, "before", 6) == 0);
    CHECK_STR(err.name, "exr");
    if (!CHECK(strstr(err.text, what) != NULL))
        printf("  \"%s\" does not say %s\n", err.text, what);
    CHECK(!encode_exr(&out, &e, NULL)); // the caller need not care why
    buf_finish(&out);
}

static void test_refused(void)
{
    check_case("exr_errors_name_the_cause");
    static float p[4 * 8 * 8];
    struct encode_layer one = {"", p, true};
    struct encode_layer twice[2] = {{"x", p, true}, {"x", p, false}};
    struct encode_layer longer = {"a_layer_of_thirty_letters_okay", p, true};
    struct encode_layer many[33];
    for (int i = 0; i < 33; i++)
        many[i] = one;
    const char *const taken[] = {"channels", "x", NULL};
    const char *const nameless[] = {"", "x", NULL};
    const char *const long_key[] = {"a_name_of_more_than_31_characters_", "x",
                                    NULL};
    check_refused((struct encode_exr){0, 8, true, &one, 1, NULL}, "0 x 8");
    check_refused((struct encode_exr){8, -1, true, &one, 1, NULL}, "8 x -1");
    check_refused((struct encode_exr){16385, 8, true, &one, 1, NULL}, "16385");
    check_refused((struct encode_exr){8, 8, true, &one, 0, NULL}, "0 layers");
    check_refused((struct encode_exr){8, 8, true, many, 33, NULL}, "33");
    check_refused((struct encode_exr){8, 8, true, twice, 2, NULL}, "x.B");
    check_refused((struct encode_exr){8, 8, true, &longer, 1, NULL},
                  "a_layer_of_thirty_letters_okay");
    check_refused((struct encode_exr){8, 8, true, &one, 1, taken}, "channels");
    check_refused((struct encode_exr){8, 8, true, &one, 1, nameless}, "name");
    check_refused((struct encode_exr){8, 8, true, &one, 1, long_key},
                  "a_name_of_more_than_31");
}

static void test_same_bytes(void)
{
    check_case("exr_appended_and_deterministic");
    float *p = pixels_make(50, 40, 3);
    struct buf a = {0}, b = {0};
    buf_text(&a, "before");
    CHECK(encode_one(&a, p, 50, 40, true));
    CHECK(encode_one(&b, p, 50, 40, true));
    CHECK(memcmp(a.data, "before", 6) == 0);
    CHECK(a.size == b.size + 6 && memcmp(a.data + 6, b.data, b.size) == 0);
    buf_finish(&a);
    buf_finish(&b);
    free(p);
}

// The older library is what most programs read with.
static void test_other_reader(void)
{
    check_case("exr_read_by_the_older_library");
    const int w = 67, h = 35;
    float *p = pixels_make(w, h, 8);
    struct buf out = {0};
    char path[] = "/tmp/glint_exr_XXXXXX";
    int fd = mkstemp(path);
    CHECK(encode_one(&out, p, w, h, true));
    CHECK(fd >= 0 && write(fd, out.data, out.size) == (ssize_t)out.size);
    ImfRgba *pixels = bytes_zalloc((size_t)(w * h), sizeof *pixels);
    ImfInputFile *in = ImfOpenInputFile(path);
    int wrong = 0;
    if (CHECK(in != NULL) &&
        CHECK(ImfInputSetFrameBuffer(in, pixels, 1, (size_t)w)) &&
        CHECK(ImfInputReadPixels(in, 0, h - 1)))
        for (size_t i = 0; i < (size_t)(w * h); i++)
            wrong += !half_right(pixels[i].r, p[4 * i]) ||
                     !half_right(pixels[i].g, p[4 * i + 1]) ||
                     !half_right(pixels[i].b, p[4 * i + 2]) ||
                     !half_right(pixels[i].a, p[4 * i + 3]);
    CHECK_ATMOST(wrong, 0);
    if (in)
        ImfCloseInputFile(in);
    close(fd);
    unlink(path);
    free(pixels);
    free(p);
    buf_finish(&out);
}

int main(void)
{
    test_float();
    test_half();
    test_layers();
    test_attributes();
    test_refused();
    test_same_bytes();
    test_other_reader();
    return check_end();
}
