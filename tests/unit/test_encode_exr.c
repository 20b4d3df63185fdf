// test_encode_exr.c - EXR files read back by OpenEXR's two libraries: by
// OpenEXRCore channel by channel and bit by bit, by OpenEXR as a painter's
// program would.
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <ImfCRgbaFile.h>
#include <openexr.h>

#include "renderer/encode.h"
#include "tests/check.h"
#include "tests/unit/encode_picture.h"

// --- reading -----------------------------------------------------------------

enum { CHANNELS_MAX = 128 };

struct reader {
    struct span in;
    exr_context_t file;
    const exr_attr_chlist_t *list;
    int width, height, size; // size: bytes of a value
    unsigned char *plane[CHANNELS_MAX];
};

static int64_t read_bytes(exr_const_context_t context, void *user, void *to,
                          uint64_t size, uint64_t at,
                          exr_stream_error_func_ptr_t report)
{
    (void)context, (void)report;
    const struct reader *r = user;
    if (at >= r->in.size)
        return 0;
    uint64_t left = r->in.size - at, n = size < left ? size : left;
    memcpy(to, r->in.data + at, (size_t)n);
    return (int64_t)n;
}

static int64_t size_of(exr_const_context_t context, void *user)
{
    (void)context;
    return (int64_t)((const struct reader *)user)->in.size;
}

static bool good(exr_result_t result)
{
    return result == EXR_ERR_SUCCESS;
}

static void aim(struct reader *r, exr_decode_pipeline_t *pipe, int y)
{
    const int line = r->width * r->size;
    for (int c = 0; c < r->list->num_channels; c++) {
        exr_coding_channel_info_t *to = &pipe->channels[c];
        to->user_pixel_stride = r->size;
        to->user_line_stride = line;
        to->user_bytes_per_element = (int16_t)r->size;
        to->user_data_type = (uint16_t)r->list->entries[c].pixel_type;
        to->decode_to_ptr = r->plane[c] + (size_t)line * (size_t)y;
    }
}

static bool read_chunks(struct reader *r)
{
    exr_decode_pipeline_t pipe = EXR_DECODE_PIPELINE_INITIALIZER;
    int step = 0;
    bool ok = good(exr_get_scanlines_per_chunk(r->file, 0, &step));
    for (int y = 0; ok && y < r->height; y += step) {
        exr_chunk_info_t info;
        ok = good(exr_read_scanline_chunk_info(r->file, 0, y, &info)) &&
             good(y ? exr_decoding_update(r->file, 0, &info, &pipe)
                    : exr_decoding_initialize(r->file, 0, &info, &pipe));
        if (!ok)
            break;
        aim(r, &pipe, y);
        ok = y || good(exr_decoding_choose_default_routines(r->file, 0, &pipe));
        ok = ok && good(exr_decoding_run(r->file, 0, &pipe));
    }
    exr_decoding_destroy(r->file, &pipe);
    return ok;
}

// The whole file as planes.
static bool read_exr(struct reader *r, struct span in)
{
    *r = (struct reader){.in = in};
    exr_context_initializer_t how = EXR_DEFAULT_CONTEXT_INITIALIZER;
    how.user_data = r;
    how.read_fn = read_bytes;
    how.size_fn = size_of;
    exr_attr_box2i_t data;
    if (!good(exr_start_read(&r->file, "test", &how)) ||
        !good(exr_get_channels(r->file, 0, &r->list)) ||
        !good(exr_get_data_window(r->file, 0, &data)) ||
        r->list->num_channels > CHANNELS_MAX)
        return false;
    r->width = data.max.x - data.min.x + 1;
    r->height = data.max.y - data.min.y + 1;
    r->size = r->list->entries[0].pixel_type == EXR_PIXEL_HALF ? 2 : 4;
    for (int c = 0; c < r->list->num_channels; c++)
        r->plane[c] =
            bytes_alloc((size_t)r->size * (size_t)r->width * (size_t)r->height);
    return read_chunks(r);
}

static void reader_finish(struct reader *r)
{
    for (int c = 0; c < CHANNELS_MAX; c++)
        free(r->plane[c]);
    exr_finish(&r->file);
}

// The plane of that name, NULL: there is none.
static const unsigned char *plane(const struct reader *r, const char *name)
{
    for (int c = 0; c < r->list->num_channels; c++)
        if (strcmp(r->list->entries[c].name.str, name) == 0)
            return r->plane[c];
    return NULL;
}

// --- values ------------------------------------------------------------------

// Every pattern of bits, so that NaN of any kind, infinities and values too
// small or too large for a half are among them.
static float *random_bits(size_t n, uint64_t seed)
{
    static const uint32_t special[] = {
        0,          0x80000000, 0x7f800000, 0xff800000, 0x7fc00000, 0xffc12345,
        0x7f800001, 0x477fe000, 0x477fe001, 0x477fefff, 0x477ff000, 0xc7800000,
        0x33000000, 0x33000001, 0x32ffffff, 0x387fc000, 0x387fffff, 0x38800000,
        0x3f801000, 0x3f803000, 0x3f800fff, 0x3f801001, 0x00000001, 0x7f7fffff};
    enum { SPECIALS = sizeof special / sizeof *special };
    uint64_t random = seed;
    uint32_t *bits = bytes_alloc(n * sizeof *bits);
    for (size_t i = 0; i < n; i++) {
        uint32_t r = picture_random(&random);
        if (i % 3 == 0) // most of the rest are far out of a half's range
            r = (r & 0x80ffffff) | (0x66 + (r >> 24 & 31)) << 23;
        if (i % 7 == 6) // half-way between two halves, or one bit beside it
            r = (r & 0x807fe000) | (100 + (r >> 24) % 45) << 23 |
                (0x1000 + r % 3 - 1);
        bits[i] = i % 5 == 4 ? special[r % SPECIALS] : r;
    }
    return (float *)(void *)bits;
}

static double half_value(uint16_t h)
{
    int exponent = h >> 10 & 31, fraction = h & 1023;
    double v =
        exponent ? ldexp(1024 + fraction, exponent - 25) : ldexp(fraction, -24);
    if (exponent == 31)
        v = fraction ? (double)NAN : (double)INFINITY;
    return h & 0x8000 ? -v : v;
}

// Is h what encode.h promises for v: the nearest, clamped, NaN kept?
static bool half_right(uint16_t h, float v)
{
    double got = half_value(h), want = (double)v;
    if (isnan(want))
        return isnan(got);
    want = fmax(-65504, fmin(65504, want));
    int exponent = want == 0 ? -14 : ilogb(want);
    double unit = ldexp(1, (exponent < -14 ? -14 : exponent) - 10);
    return fabs(got - want) <= unit / 2 && !signbit(got) == !signbit(want);
}

static bool plane_right(const struct reader *r, const char *name,
                        const float *rgba, int component)
{
    const unsigned char *p = plane(r, name);
    size_t n = (size_t)r->width * (size_t)r->height;
    for (size_t i = 0; p && i < n; i++) {
        const float *want = &rgba[4 * i + (size_t)component];
        uint16_t h;
        memcpy(&h, p + (size_t)r->size * i, 2);
        if (r->size == 4 ? memcmp(p + 4 * i, want, 4) != 0
                         : !half_right(h, *want)) {
            printf("  %s, value %zu of %zu: %g\n", name, i, n, (double)*want);
            return false;
        }
    }
    return p != NULL;
}

// --- tests -------------------------------------------------------------------

static bool encode(struct buf *out, const struct encode_exr *e)
{
    struct error err = {0};
    bool ok = encode_exr(out, e, &err);
    if (!ok)
        printf("  %s: %s\n", err.code, err.text);
    return ok && !err.text[0];
}

static void test_bits(bool half)
{
    // below, at and above the 16 rows of a chunk
    static const int sizes[][2] = {{1, 1},   {7, 5},   {16, 16},
                                   {3, 15},  {5, 17},  {33, 50},
                                   {900, 3}, {2, 200}, {8192, 2}};
    check_case(half ? "exr: halves are nearest, clamped; NaN stays"
                    : "exr: floats are bit for bit");
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++)
        for (int alpha = 0; alpha < 2; alpha++) {
            int w = sizes[i][0], h = sizes[i][1];
            float *rgba = random_bits(4 * (size_t)w * (size_t)h, 3 + i);
            struct encode_layer layer = {"", rgba, alpha};
            struct encode_exr e = {w, h, half, &layer, 1, NULL};
            struct buf out = {0};
            struct reader r;
            buf_text(&out, "before");
            CHECK(encode(&out, &e) && memcmp(out.data, "before", 6) == 0);
            CHECK(read_exr(&r, (struct span){out.data + 6, out.size - 6}));
            CHECK(r.width == w && r.height == h && r.size == (half ? 2 : 4));
            CHECK(r.list->num_channels == 3 + alpha);
            CHECK(plane_right(&r, "R", rgba, 0));
            CHECK(plane_right(&r, "G", rgba, 1));
            CHECK(plane_right(&r, "B", rgba, 2));
            CHECK(alpha ? plane_right(&r, "A", rgba, 3) : !plane(&r, "A"));
            reader_finish(&r);
            buf_finish(&out);
            free(rgba);
        }
}

// Somewhere among these zlib makes a chunk exactly as long as it was, which
// OpenEXRCore by itself writes so that it is read as garbage.
static void test_equal_lengths(void)
{
    enum { W = 3, H = 15 };
    int wrong = 0;
    check_case("exr: small pictures at the edge of what zlib can shorten");
    for (uint64_t seed = 1; seed <= 600; seed++) {
        float *rgba = random_bits(4 * W * H, seed);
        struct encode_layer layer = {"", rgba, true};
        struct encode_exr e = {W, H, true, &layer, 1, NULL};
        struct buf out = {0};
        struct reader r;
        bool ok =
            encode(&out, &e) && read_exr(&r, (struct span){out.data, out.size});
        for (int c = 0; ok && c < 4; c++)
            ok = plane_right(&r, (const char[2]){"RGBA"[c], 0}, rgba, c);
        wrong += !ok;
        reader_finish(&r);
        buf_finish(&out);
        free(rgba);
    }
    CHECK(wrong == 0);
}

static void test_layers(void)
{
    enum { W = 20, H = 19 };
    static const char *const names[] = {"", "single_TRT", "a", "global",
                                        "Z.sub"};
    struct encode_layer layers[5];
    struct encode_exr e = {W, H, false, layers, 5, NULL};
    struct buf out = {0};
    struct reader r;
    check_case("exr: layers by name, each with its own pixels");
    for (int l = 0; l < 5; l++)
        layers[l] = (struct encode_layer){
            names[l], random_bits(4 * W * H, 50 + (uint64_t)l), l % 2 == 0};
    CHECK(encode(&out, &e));
    CHECK(read_exr(&r, (struct span){out.data, out.size}));
    CHECK(r.list->num_channels == 3 * 4 + 2 * 3);
    for (int c = 0; c + 1 < r.list->num_channels; c++) // the format's order
        CHECK(strcmp(r.list->entries[c].name.str,
                     r.list->entries[c + 1].name.str) < 0);
    for (int l = 0; l < 5; l++)
        for (int c = 0; c < (layers[l].alpha ? 4 : 3); c++) {
            char name[64];
            snprintf(name, sizeof name, "%s%s%c", names[l], l ? "." : "",
                     "RGBA"[c]);
            CHECK(plane_right(&r, name, layers[l].rgba, c));
        }
    reader_finish(&r);
    buf_finish(&out);
    for (int l = 0; l < 5; l++)
        free((void *)layers[l].rgba);
}

static void test_many_layers(void)
{
    float rgba[32][4];
    char names[32][8];
    struct encode_layer layers[33];
    struct encode_exr e = {1, 1, true, layers, 32, NULL};
    struct buf out = {0};
    struct reader r;
    check_case("exr: 32 layers");
    for (int l = 0; l < 32; l++) {
        snprintf(names[l], sizeof names[l], "l%d", 31 - l);
        for (int c = 0; c < 4; c++)
            rgba[l][c] = (float)(10 * l + c);
        layers[l] = (struct encode_layer){names[l], rgba[l], true};
    }
    CHECK(encode(&out, &e));
    CHECK(read_exr(&r, (struct span){out.data, out.size}));
    CHECK(r.list->num_channels == 128);
    for (int l = 0; l < 32; l++) {
        char name[64];
        snprintf(name, sizeof name, "%s.B", names[l]);
        CHECK(plane_right(&r, name, rgba[l], 2));
    }
    reader_finish(&r);
    buf_finish(&out);
}

static const char *const text[] = {
    "camera.fov", "30", "empty", "", "hair", "tr\xc3\xa4ne, \"x\"\n",
    "twice",      "b",  NULL};

static void test_header(void)
{
    enum { W = 9, H = 33 };
    float *rgba = random_bits(4 * W * H, 8);
    struct encode_layer layer = {"", rgba, true};
    const char *more[12] = {"twice", "a"}; // the later one counts
    memcpy(more + 2, text, sizeof text);
    struct encode_exr e = {W, H, true, &layer, 1, more};
    struct buf out = {0}, again = {0};
    struct reader r;
    check_case("exr: header, attributes; same bytes each time");
    CHECK(encode(&out, &e) && encode(&again, &e));
    CHECK(out.size == again.size &&
          memcmp(out.data, again.data, out.size) == 0);
    CHECK(read_exr(&r, (struct span){out.data, out.size}));
    int parts = 0;
    exr_storage_t storage;
    exr_compression_t compression;
    exr_lineorder_t order;
    exr_attr_box2i_t d;
    float aspect = 0;
    CHECK(good(exr_get_pixel_aspect_ratio(r.file, 0, &aspect)));
    CHECK_NEAR(aspect, 1, 0); // stored, not computed
    CHECK(good(exr_get_count(r.file, &parts)) && parts == 1);
    CHECK(good(exr_get_storage(r.file, 0, &storage)) &&
          storage == EXR_STORAGE_SCANLINE);
    CHECK(good(exr_get_compression(r.file, 0, &compression)) &&
          compression == EXR_COMPRESSION_ZIP);
    CHECK(good(exr_get_lineorder(r.file, 0, &order)) &&
          order == EXR_LINEORDER_INCREASING_Y);
    CHECK(good(exr_get_display_window(r.file, 0, &d)) && d.min.x == 0 &&
          d.min.y == 0 && d.max.x == W - 1 && d.max.y == H - 1);
    for (int c = 0; c < r.list->num_channels; c++)
        CHECK(r.list->entries[c].p_linear == 0 &&
              r.list->entries[c].x_sampling == 1 &&
              r.list->entries[c].y_sampling == 1);
    for (int i = 0; text[i]; i += 2) {
        int32_t n = -1;
        const char *value = NULL;
        CHECK(good(exr_attr_get_string(r.file, 0, text[i], &n, &value)));
        CHECK(n == (int)strlen(text[i + 1]));
        CHECK_STR(value, text[i + 1]);
    }
    reader_finish(&r);
    buf_finish(&out);
    buf_finish(&again);
    free(rgba);
}

static bool library_reads(const char *path, ImfRgba *pixels, int w, int h)
{
    ImfInputFile *in = ImfOpenInputFile(path);
    if (!in)
        return false;
    int x0, y0, x1, y1;
    const char *value = NULL;
    const ImfHeader *header = ImfInputHeader(in);
    ImfHeaderDataWindow(header, &x0, &y0, &x1, &y1);
    bool ok = x0 == 0 && y0 == 0 && x1 == w - 1 && y1 == h - 1 &&
              ImfInputChannels(in) == IMF_WRITE_RGBA &&
              ImfHeaderStringAttribute(header, text[0], &value) &&
              strcmp(value, text[1]) == 0 &&
              ImfInputSetFrameBuffer(in, pixels, 1, (size_t)w) &&
              ImfInputReadPixels(in, 0, h - 1);
    ImfCloseInputFile(in);
    return ok;
}

static void test_library(void)
{
    enum { W = 240, H = 161 };
    char path[] = "/tmp/glint_test_exr_XXXXXX";
    float *rgba = bytes_alloc(4 * W * H * sizeof *rgba);
    ImfRgba *pixels = bytes_alloc(W * H * sizeof *pixels);
    struct encode_layer layer = {"", rgba, true};
    picture_hair(rgba, W, H);
    for (int half = 0; half < 2; half++) {
        struct encode_exr e = {W, H, half, &layer, 1, text};
        struct buf out = {0};
        check_case(half ? "exr: OpenEXR reads the hair picture's halves"
                        : "exr: OpenEXR reads the hair picture's floats");
        CHECK(encode(&out, &e));
        strcpy(path + sizeof path - 7, "XXXXXX");
        int file = mkstemp(path);
        CHECK(write(file, out.data, out.size) == (ssize_t)out.size);
        close(file);
        bool ok = library_reads(path, pixels, W, H);
        if (!CHECK(ok))
            printf("  %s\n", ImfErrorMessage());
        unlink(path);
        bool same = ok;
        for (int i = 0; same && i < W * H; i++) {
            const ImfHalf got[4] = {pixels[i].r, pixels[i].g, pixels[i].b,
                                    pixels[i].a};
            for (int c = 0; c < 4; c++)
                same = same && half_right(got[c], rgba[4 * i + c]);
        }
        CHECK(same);
        buf_finish(&out);
    }
    free(pixels);
    free(rgba);
}

// --- refusals ----------------------------------------------------------------

static void refuse(const char *what, const struct encode_exr *e,
                   const char *word)
{
    struct buf out = {0};
    struct error err = {0};
    buf_text(&out, "before");
    bool ok = encode_exr(&out, e, &err);
    CHECK_STR(err.name, "exr");
    if (!CHECK(!ok && strstr(err.text, word) && err.code[0] &&
               !strchr(err.text, '\n')))
        printf("  %s: %s \"%s\"\n", what, err.code, err.text);
    CHECK(out.size == 6 && memcmp(out.data, "before", 6) == 0);
    CHECK(!encode_exr(&out, e, NULL) && out.size == 6);
    buf_finish(&out);
}

static void test_errors(void)
{
    static const float rgba[4] = {1, 2, 3, 4};
    struct encode_layer layers[33], *one = layers;
    for (int l = 0; l < 33; l++)
        layers[l] = (struct encode_layer){"same", rgba, true};
    const struct encode_exr fine = {1, 1, true, one, 1, NULL};
    struct encode_exr e;
    check_case("exr: refusals leave the output alone and tell why");
    static const int counts[] = {0, -1, 33, 2147483647};
    for (int i = 0; i < 4; i++)
        refuse("layers", (e = fine, e.layer_count = counts[i], &e), "[1, 32]");
    static const int sides[] = {0, -1, 16385, 2147483647, -2147483647 - 1};
    for (int i = 0; i < 5; i++) {
        refuse("width", (e = fine, e.width = sides[i], &e), "[1, 16384]");
        refuse("height", (e = fine, e.height = sides[i], &e), "[1, 16384]");
    }
    refuse("two of a name", (e = fine, e.layer_count = 2, &e), "same");
    layers[0].name = "a_name_of_thirty_characters_xx"; // and ".R"
    refuse("long layer", &fine, "a_name_of_thirty");
    layers[0].name = "an_endless_name_that_goes_on_and_on_and_on_until_it_is_"
                     "longer_than_any_buffer_that_might_be_made_for_it";
    refuse("endless layer", &fine, "an_endless_name");
    layers[0].name = "a_name_of_29_characters_xxxxx";
    struct buf out = {0};
    CHECK(encode(&out, &fine));
    buf_finish(&out);
    static const char *const bad[][3] = {
        {"", "x", NULL},
        {"a_key_of_more_than_31_characters", "x", NULL},
        {"channels", "x", NULL},
        {"compression", "x", NULL},
    };
    for (int i = 0; i < 4; i++)
        refuse(bad[i][0], (e = fine, e.text = bad[i], &e), i ? bad[i][0] : "");
    check_case("exr: after refusals a picture is written as ever");
    struct reader r;
    CHECK(encode(&out, &fine));
    CHECK(read_exr(&r, (struct span){out.data, out.size}));
    reader_finish(&r);
    buf_finish(&out);
}

int main(void)
{
    test_bits(false);
    test_bits(true);
    test_equal_lengths();
    test_layers();
    test_many_layers();
    test_header();
    test_library();
    test_errors();
    return check_end();
}
