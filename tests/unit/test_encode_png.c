// test_encode_png.c - PNG files taken apart again: chunks, checksums, filters,
// pixels.  With arguments it is a tool for test_encode_png.py:
//   --deflate            standard input deflated to standard output
//   --hair rgba|rgb      the hair picture as PNG to standard output
#include <pthread.h>
#include <stdlib.h>
#include <string.h>

#include "renderer/encode.h"
#include "tests/check.h"
#include "tests/unit/encode_inflate.h"
#include "tests/unit/encode_picture.h"

struct png { // as read
    int width, height, step;
    int chunks[6]; // how many of each kind, in this order
    struct buf idat;
    struct buf text; // type, key, 0, rest, 0x01 of each text chunk
};

static const char kinds[6][5] = {"IHDR", "sRGB", "tEXt",
                                 "iTXt", "IDAT", "IEND"};

static uint32_t get32(const unsigned char *p)
{
    return (uint32_t)p[0] << 24 | (uint32_t)p[1] << 16 | (uint32_t)p[2] << 8 |
           p[3];
}

// ISO/IEC 15948, annex D, one bit at a time.
static uint32_t slow_crc(const unsigned char *p, size_t n)
{
    uint32_t c = 0xffffffffu;
    for (size_t i = 0; i < n; i++) {
        c ^= p[i];
        for (int bit = 0; bit < 8; bit++)
            c = c >> 1 ^ (c & 1 ? 0xedb88320u : 0);
    }
    return ~c;
}

static bool read_header(struct png *png, const unsigned char *p, size_t n)
{
    if (n != 13 || p[8] != 8 || (p[9] != 2 && p[9] != 6) || p[10] || p[11] ||
        p[12])
        return false;
    png->width = (int)get32(p);
    png->height = (int)get32(p + 4);
    png->step = p[9] == 6 ? 4 : 3;
    return true;
}

// One chunk; false when it is not as it must be.
static bool read_chunk(struct png *png, const unsigned char *p, size_t n)
{
    int kind = 0;
    while (kind < 6 && memcmp(kinds[kind], p + 4, 4) != 0)
        kind++;
    if (kind == 6 || get32(p + 8 + n) != slow_crc(p + 4, n + 4))
        return false;
    for (int later = kind + 1; later < 6; later++)
        if (png->chunks[later] > 0 && !(kind == 2 && later == 3))
            return false;
    png->chunks[kind]++;
    if (kind == 4)
        buf_append(&png->idat, p + 8, n);
    if (kind == 2 || kind == 3) {
        buf_append(&png->text, p + 4, 4 + n);
        buf_byte(&png->text, 1);
    }
    return kind > 0 || read_header(png, p + 8, n);
}

static bool read_png(struct png *png, struct span in)
{
    *png = (struct png){0};
    if (in.size < 8 || memcmp(in.data, "\x89PNG\r\n\x1a\n", 8) != 0)
        return false;
    for (size_t at = 8; at < in.size;) {
        size_t left = in.size - at, n = get32(in.data + at);
        if (left < 12 || n > left - 12 || !read_chunk(png, in.data + at, n))
            return false;
        at += n + 12;
    }
    return png->chunks[0] == 1 && png->chunks[1] == 1 && png->chunks[4] == 1 &&
           png->chunks[5] == 1;
}

// ISO/IEC 15948, 9.4, as it is written there.
static int predict(int kind, int a, int b, int c)
{
    int p = a + b - c, pa = abs(p - a), pb = abs(p - b), pc = abs(p - c);
    switch (kind) {
    case 1:
        return a;
    case 2:
        return b;
    case 3:
        return (a + b) / 2;
    case 4:
        return pa <= pb && pa <= pc ? a : pb <= pc ? b : c;
    default:
        return 0;
    }
}

// Undoes one row in place; returns the sum by which each filter is judged, for
// all five, of the row as it was.
static void undo_row(unsigned char *row, const unsigned char *up, int n,
                     int step, unsigned sum[5])
{
    int kind = row[-1];
    memset(sum, 0, 5 * sizeof *sum);
    for (int i = 0; i < n; i++) {
        int a = i < step ? 0 : row[i - step], b = up ? up[i] : 0;
        int c = i < step || !up ? 0 : up[i - step];
        row[i] = (unsigned char)(row[i] + predict(kind, a, b, c));
        for (int k = 0; k < 5; k++) {
            int d = (row[i] - predict(k, a, b, c)) & 255;
            sum[k] += (unsigned)(d < 128 ? d : 256 - d);
        }
    }
}

// Checks rows against the picture; counts which filters were used.
static void check_rows(const struct png *png, struct buf *rows,
                       const unsigned char *rgba, int seen[5])
{
    const int n = png->width * png->step;
    if (!CHECK(rows->size == (size_t)png->height * (size_t)(n + 1)))
        return;
    bool same = true, cheapest = true;
    for (int y = 0; y < png->height; y++) {
        unsigned char *row = rows->data + (size_t)y * (size_t)(n + 1) + 1;
        unsigned sum[5];
        int kind = row[-1];
        if (!CHECK(kind < 5))
            return;
        undo_row(row, y ? row - n - 1 : NULL, n, png->step, sum);
        seen[kind]++;
        for (int k = 0; k < 5; k++)
            cheapest = cheapest && sum[kind] <= sum[k];
        for (int x = 0; x < png->width; x++)
            same =
                same &&
                memcmp(row + x * png->step,
                       rgba + 4 * ((size_t)y * (size_t)png->width + (size_t)x),
                       (size_t)png->step) == 0;
    }
    CHECK(same);
    CHECK(cheapest);
}

static void check_picture(const unsigned char *rgba, int width, int height,
                          int seen[5])
{
    for (int step = 3; step <= 4; step++) {
        struct buf out = {0};
        struct png png;
        struct inflate z = {0};
        buf_text(&out, "before");
        encode_png(&out, rgba, width, height, step == 4, NULL);
        bool ok = read_png(&png, (struct span){out.data + 6, out.size - 6});
        CHECK(ok && memcmp(out.data, "before", 6) == 0);
        CHECK(png.width == width && png.height == height && png.step == step);
        CHECK(png.chunks[2] == 0 && png.chunks[3] == 0);
        ok = ok && inflate(&z, (struct span){png.idat.data, png.idat.size});
        if (!CHECK(ok))
            printf("  %d x %d x %d: %s\n", width, height, step,
                   z.bad ? z.bad : "chunks");
        if (ok)
            check_rows(&png, &z.out, rgba, seen);
        buf_finish(&z.out);
        buf_finish(&png.idat);
        buf_finish(&png.text);
        buf_finish(&out);
    }
}

enum { KINDS = 6 };

// Each kind of picture favours other filters.
static void fill(unsigned char *rgba, int width, int height, int kind)
{
    uint64_t random = 17;
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++)
            for (int c = 0; c < 4; c++) {
                unsigned r = picture_random(&random) >> 8;
                int edge = x * 3 > y * 5 ? 90 : 7; // planes with an edge
                int v[KINDS] = {(int)(r & 255),
                                x * 2 + y * 3 + c * 40,
                                edge + (int)(r & 3) + x,
                                (int)(r & 1) * 255,
                                (x * 7 + (int)(r & 31)) ^ (y << 3),
                                98 + (int)(r % 61)}; // large sums
                rgba[4 * ((size_t)y * (size_t)width + (size_t)x) + (size_t)c] =
                    (unsigned char)v[kind];
            }
}

static void test_pictures(void)
{
    static const int sizes[][2] = {
        {1, 1},   {1, 7},    {2, 1},    {3, 5},    {4, 4},     {5, 3},
        {7, 5},   {15, 17},  {16, 16},  {17, 3},   {33, 20},   {64, 64},
        {99, 31}, {8192, 1}, {1, 8192}, {3001, 3}, {16384, 2}, {333, 77}};
    int seen[5] = {0};
    unsigned char *rgba = bytes_alloc(4 * 720 * 480);
    check_case("png: sizes and kinds of pictures, RGB and RGBA");
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++)
        for (int kind = 0; kind < KINDS; kind++) {
            // at the end of its block: what lies beyond must not be read
            int w = sizes[i][0], h = sizes[i][1];
            unsigned char *exact = bytes_alloc(4 * (size_t)w * (size_t)h);
            fill(exact, w, h, kind);
            check_picture(exact, w, h, seen);
            free(exact);
        }
    for (int k = 0; k < 5; k++)
        if (!CHECK(seen[k] > 0)) // else a filter was not tested
            printf("  filter %d\n", k);
    check_case("png: the hair picture");
    picture_hair8(rgba, 720, 480);
    check_picture(rgba, 720, 480, seen);
    free(rgba);
}

static void test_text(void)
{
    static const unsigned char rgba[4] = {1, 2, 3, 4};
    static const char *const text[] = {
        "camera.fov", "30", "hair", "tr\xc3\xa4ne.hair", "empty", "", NULL};
    static const char want[] = "tEXtcamera.fov\0"
                               "30\1iTXthair\0\0\0\0\0tr\xc3\xa4ne.hair\1"
                               "tEXtempty\0\1";
    struct buf out = {0};
    struct png png;
    check_case("png: text, and what is not ASCII as UTF-8");
    encode_png(&out, rgba, 1, 1, true, text);
    CHECK(read_png(&png, (struct span){out.data, out.size}));
    CHECK(png.chunks[2] == 2 && png.chunks[3] == 1);
    CHECK(png.text.size == sizeof want - 1 &&
          memcmp(png.text.data, want, sizeof want - 1) == 0);
    buf_finish(&png.idat);
    buf_finish(&png.text);
    buf_finish(&out);
}

enum { THREADS = 4 };

struct worker {
    pthread_t thread;
    const unsigned char *rgba;
    struct buf out;
};

static void *work(void *user)
{
    struct worker *w = user;
    encode_png(&w->out, w->rgba, 64, 64, true, NULL);
    return NULL;
}

static void test_threads(void)
{
    unsigned char rgba[4 * 64 * 64];
    struct worker worker[THREADS];
    check_case("png: several threads at once, same bytes");
    fill(rgba, 64, 64, 4);
    for (int i = 0; i < THREADS; i++) {
        worker[i] = (struct worker){.rgba = rgba};
        CHECK(pthread_create(&worker[i].thread, NULL, work, &worker[i]) == 0);
    }
    for (int i = 0; i < THREADS; i++)
        pthread_join(worker[i].thread, NULL);
    for (int i = 1; i < THREADS; i++)
        CHECK(worker[i].out.size == worker[0].out.size &&
              memcmp(worker[i].out.data, worker[0].out.data,
                     worker[0].out.size) == 0);
    for (int i = 0; i < THREADS; i++)
        buf_finish(&worker[i].out);
}

// --- the tool ----------------------------------------------------------------

static int tool(int argc, char **argv)
{
    struct buf in = {0}, out = {0};
    if (strcmp(argv[1], "--deflate") == 0) {
        size_t n;
        do {
            n = fread(buf_grow(&in, 65536), 1, 65536, stdin);
            in.size -= 65536 - n;
        } while (n > 0);
        encode_deflate(&out, (struct span){in.data, in.size});
    } else if (argc == 3 && strcmp(argv[1], "--hair") == 0) {
        picture_hair8(buf_grow(&in, 4 * 720 * 480), 720, 480);
        encode_png(&out, in.data, 720, 480, strcmp(argv[2], "rgba") == 0, NULL);
    } else {
        return 2;
    }
    bool ok = fwrite(out.data, 1, out.size, stdout) == out.size;
    ok = fflush(stdout) == 0 && ok;
    buf_finish(&in);
    buf_finish(&out);
    return ok ? 0 : 1;
}

int main(int argc, char **argv)
{
    if (argc > 1)
        return tool(argc, argv);
    test_pictures();
    test_text();
    test_threads();
    return check_end();
}
