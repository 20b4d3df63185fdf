// bench_encode.c - milliseconds and bytes of a picture in each format.
//   bench_encode [--runs N] [WIDTH HEIGHT FILE]   (make bench-encode ARGS=)
// The picture is the drawn hair of the unit tests at 720x480, or FILE: packed
// RGBA bytes.  One JSON line for each format: minimum and median over N runs
// (default 30) after two to warm up.  Compare ratios: machines differ.
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "renderer/encode.h"
#include "tests/unit/encode_picture.h"

enum { RUNS_MAX = 1000 };

struct input {
    int width, height;
    unsigned char *rgba;
    float *linear;
};

typedef void encode_fn(struct buf *out, const struct input *in);

static void jpeg_75(struct buf *out, const struct input *in)
{
    encode_jpeg(out, in->rgba, in->width, in->height, 75, ENCODE_420);
}
static void jpeg_90(struct buf *out, const struct input *in)
{
    encode_jpeg(out, in->rgba, in->width, in->height, 90, ENCODE_444);
}
static void png_rgba(struct buf *out, const struct input *in)
{
    encode_png(out, in->rgba, in->width, in->height, true, NULL);
}
static void png_rgb(struct buf *out, const struct input *in)
{
    encode_png(out, in->rgba, in->width, in->height, false, NULL);
}
static void deflate(struct buf *out, const struct input *in)
{
    size_t n = 4 * (size_t)in->width * (size_t)in->height;
    encode_deflate(out, (struct span){in->rgba, n});
}
static void exr(struct buf *out, const struct input *in, bool half)
{
    struct encode_layer layer = {"", in->linear, true};
    struct encode_exr e = {in->width, in->height, half, &layer, 1, NULL};
    struct error err = {0};
    if (encode_exr(out, &e, &err))
        return;
    fprintf(stderr, "bench_encode: %s\n", err.text);
    exit(1);
}
static void exr_half(struct buf *out, const struct input *in)
{
    exr(out, in, true);
}
static void exr_float(struct buf *out, const struct input *in)
{
    exr(out, in, false);
}

static const struct {
    const char *name;
    encode_fn *run;
} cases[] = {
    {"jpeg 75 420", jpeg_75},         {"jpeg 90 444", jpeg_90},
    {"png rgba", png_rgba},           {"png rgb", png_rgb},
    {"deflate, unfiltered", deflate}, {"exr half zip", exr_half},
    {"exr float zip", exr_float},
};

// Milliseconds of this thread's own work: what else the machine does matters
// less than to a clock on the wall.
static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return 1e3 * (double)t.tv_sec + 1e-6 * (double)t.tv_nsec;
}

static int compare(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static void measure(const char *name, encode_fn *run, const struct input *in,
                    int runs)
{
    static double ms[RUNS_MAX];
    struct buf out = {0};
    for (int i = -2; i < runs; i++) {
        buf_clear(&out);
        double began = now();
        run(&out, in);
        if (i >= 0)
            ms[i] = now() - began;
    }
    qsort(ms, (size_t)runs, sizeof *ms, compare);
    printf("{\"format\":\"%s\",\"width\":%d,\"height\":%d,\"min_ms\":%.3f,"
           "\"median_ms\":%.3f,\"bytes\":%zu}\n",
           name, in->width, in->height, ms[0], ms[runs / 2], out.size);
    fflush(stdout);
    buf_finish(&out);
}

static bool read_picture(struct input *in, char **argv)
{
    in->width = atoi(argv[0]);
    in->height = atoi(argv[1]);
    if (in->width < 1 || in->width > 8192 || in->height < 1 ||
        in->height > 8192)
        return false;
    size_t n = 4 * (size_t)in->width * (size_t)in->height;
    in->rgba = bytes_alloc(n);
    FILE *f = fopen(argv[2], "rb");
    bool ok = f && fread(in->rgba, 1, n, f) == n;
    if (f)
        fclose(f);
    return ok;
}

static void make_linear(struct input *in)
{
    size_t n = 4 * (size_t)in->width * (size_t)in->height;
    in->linear = bytes_alloc(n * sizeof *in->linear);
    for (size_t i = 0; i < n; i++) {
        float v = (float)in->rgba[i] / 255;
        in->linear[i] = i % 4 == 3 ? v : v * v; // about linear light
    }
}

int main(int argc, char **argv)
{
    int runs = 30, first = 1;
    struct input in = {720, 480, NULL, NULL};
    if (argc > 2 && strcmp(argv[1], "--runs") == 0) {
        runs = atoi(argv[2]);
        first = 3;
    }
    bool ok = runs >= 1 && runs <= RUNS_MAX;
    if (ok && argc == first + 3) {
        ok = read_picture(&in, argv + first);
    } else if (ok && argc == first) {
        in.rgba = bytes_alloc(4 * 720 * 480);
        picture_hair8(in.rgba, 720, 480);
    } else {
        ok = false;
    }
    if (!ok) {
        fprintf(stderr, "bench_encode: [--runs 1..%d] [WIDTH HEIGHT FILE]\n",
                RUNS_MAX);
        return 2;
    }
    make_linear(&in);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
        measure(cases[i].name, cases[i].run, &in, runs);
    free(in.rgba);
    free(in.linear);
    return 0;
}
