// test_groom_file.c - .hair files: every array, every default, up axes,
// loading, and the real files when they are at hand.  Refusals:
// test_groom_refuse.c.
#include "tests/check.h"

#include <dirent.h>
#include <fcntl.h>
#include <stdint.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#include "renderer/groom.h"
#include "tests/unit/groom_files.h"

static void check_three_first(const struct groom *g)
{
    CHECK(g->strands == 3);
    CHECK(g->points == 9);
    CHECK(g->first[0] == 0 && g->first[1] == 3 && g->first[2] == 5);
    CHECK(g->first[3] == 9);
}

static void test_all_arrays(void)
{
    check_case("groom file: every array, floats off by two bytes");
    struct buf b = three_strands(all_arrays);
    CHECK(b.size == AT_END);
    struct error err;
    struct groom *g = parse(&b, &err);
    if (CHECK(g != NULL)) {
        check_three_first(g);
        CHECK_STR(g->name, "x.hair");
        for (int i = 0; i < 27; i++) {
            CHECK(g->position[i] == (float)i * 0.5f - 3);
            CHECK(g->colour[i] == (float)i / 26);
        }
        for (int i = 0; i < 9; i++) {
            CHECK(g->diameter[i] == 0.01f * (float)(i + 1));
            CHECK(g->opacity[i] == 1 - (float)i / 8);
        }
        CHECK(g->box_min[0] == -3 && g->box_max[0] == 9);
        CHECK(g->box_min[2] == -2 && g->box_max[2] == 10);
        CHECK(!g->head.present);
    }
    groom_destroy(g);
    buf_finish(&b);
}

static void test_unaligned_bytes(void)
{
    check_case("groom file: bytes at any address");
    struct buf b = three_strands(all_arrays);
    struct error err;
    struct groom *want = parse(&b, &err);
    for (size_t shift = 1; shift < 4; shift++) {
        unsigned char *copy = malloc(b.size + shift);
        memcpy(copy + shift, b.data, b.size);
        struct span file = {copy + shift, b.size};
        struct groom *g = groom_parse(file, "x.hair", &err);
        if (CHECK(g != NULL) && CHECK(want != NULL))
            CHECK(memcmp(g->colour, want->colour, 27 * sizeof(float)) == 0);
        groom_destroy(g);
        free(copy);
    }
    groom_destroy(want);
    buf_finish(&b);
}

static void test_defaults(void)
{
    check_case("groom file: defaults where arrays are absent");
    struct buf b = three_strands(POINTS);
    struct error err;
    struct groom *g = parse(&b, &err);
    if (CHECK(g != NULL)) {
        CHECK(g->strands == 3 && g->first[1] == 3 && g->first[3] == 9);
        CHECK(!g->diameter && !g->opacity && !g->colour);
        CHECK(g->default_diameter == 0.25f);
        CHECK(g->default_opacity == 0.875f);
        CHECK(g->default_colour[1] == 0.25f);
        CHECK(g->default_colour[2] == 0.75f);
    }
    groom_destroy(g);
    check_case("groom file: a default thickness of 1 means unknown");
    set_f32(&b, 20, 1);
    g = parse(&b, &err);
    CHECK(g && g->default_diameter == 0);
    groom_destroy(g);
    buf_finish(&b);
    check_case("groom file: defaults that arrays replace are not looked at");
    b = three_strands(all_arrays);
    for (size_t at = 16; at < 40; at += 4)
        set_u32(&b, at, 0xffffffffu); // a NaN as a float
    g = parse(&b, &err);
    if (CHECK(g != NULL)) {
        CHECK(g->default_diameter == 0 && g->default_opacity == 1);
        CHECK(g->default_colour[0] == 1);
    }
    groom_destroy(g);
    check_case("groom file: thickness that is zero everywhere is no thickness");
    for (size_t i = 0; i < 9; i++)
        set_f32(&b, AT_THICKNESS + 4 * i, 0);
    g = parse(&b, &err);
    CHECK(g && !g->diameter && g->default_diameter == 0);
    groom_destroy(g);
    buf_finish(&b);
}

static void test_single_points(void)
{
    check_case("groom file: strands of one point are dropped with their data");
    struct buf b = {0};
    put_header(&b, 4, 7, SEGMENTS | POINTS | THICKNESS);
    static const unsigned segments[4] = {0, 2, 0, 1};
    for (int s = 0; s < 4; s++)
        put_u16(&b, segments[s]);
    for (int i = 0; i < 21; i++)
        put_f32(&b, (float)(i / 3));
    for (int i = 0; i < 7; i++)
        put_f32(&b, (float)i);
    struct error err;
    struct groom *g = parse(&b, &err);
    static const float kept[5] = {1, 2, 3, 5, 6};
    if (CHECK(g != NULL) && CHECK(g->strands == 2 && g->points == 5)) {
        CHECK(g->first[1] == 3 && g->first[2] == 5);
        for (int i = 0; i < 5; i++) {
            CHECK(g->position[3 * i + 2] == kept[i]);
            CHECK(g->diameter[i] == kept[i]);
        }
        CHECK(g->box_min[0] == 1 && g->box_max[0] == 6);
    }
    groom_destroy(g);
    buf_finish(&b);
}

// A strand per direction, all roots in the origin.
static int up_of(const float (*tips)[3], uint32_t strands)
{
    struct buf b = {0};
    put_header(&b, strands, 2 * strands, SEGMENTS | POINTS);
    for (uint32_t s = 0; s < strands; s++)
        put_u16(&b, 1);
    for (uint32_t s = 0; s < strands; s++)
        for (int k = 0; k < 6; k++)
            put_f32(&b, k < 3 ? 0 : tips[s][k - 3]);
    struct error err;
    struct groom *g = parse(&b, &err);
    int up = g ? g->up : -1;
    groom_destroy(g);
    buf_finish(&b);
    return up;
}

static void test_up(void)
{
    check_case("groom file: up is the axis along which hair hangs");
    CHECK(up_of((const float[][3]){{0, 0, -5}, {1, 1, -4}}, 2) == 2);
    CHECK(up_of((const float[][3]){{0, -5, 1}, {1, -4, 0}}, 2) == 1);
    CHECK(up_of((const float[][3]){{-3, 0, 1}, {-3, -1, 0}}, 2) == 0);
    // Blown along +y further than it falls: z is still up.
    CHECK(up_of((const float[][3]){{0, 9, -5}, {1, 8, -4}}, 2) == 2);
    // Standing on end along +y, and along +x.
    CHECK(up_of((const float[][3]){{0, 9, -1}, {1, 8, 1}}, 2) == 1);
    CHECK(up_of((const float[][3]){{6, 0, 1}, {7, 1, -1}}, 2) == 0);
    // All around: z.
    CHECK(
        up_of((const float[][3]){{0, 5, 0}, {0, -5, 0}, {5, 0, 0}, {-5, 0, 0}},
              4) == 2);
}

static void test_bounds_accepted(void)
{
    check_case("groom file: values at their bounds are read");
    struct buf b = three_strands(all_arrays);
    set_f32(&b, AT_POINTS, 1e9f);
    set_f32(&b, AT_POINTS + 4, -1e9f);
    set_f32(&b, AT_THICKNESS, 0);
    set_f32(&b, AT_THICKNESS + 4, 1e9f);
    set_f32(&b, AT_TRANSPARENCY, 0);
    set_f32(&b, AT_TRANSPARENCY + 4, 1);
    set_f32(&b, AT_COLOURS, 0);
    set_f32(&b, AT_COLOURS + 4, 1000);
    struct error err;
    struct groom *g = parse(&b, &err);
    if (CHECK(g != NULL)) {
        CHECK(g->opacity[0] == 1 && g->opacity[1] == 0);
        CHECK(isfinite(groom_auto_diameter(g)));
    }
    groom_destroy(g);
    buf_finish(&b);
}

static void refuse_path(const char *path, const char *code, const char *word)
{
    struct error err = {0};
    struct groom *g = groom_load(path, &err);
    CHECK(g == NULL);
    groom_destroy(g);
    CHECK_STR(err.code, code);
    if (!CHECK(strstr(err.text, word) != NULL))
        printf("  \"%s\" lacks \"%s\"\n", err.text, word);
}

static void test_load(void)
{
    char dir[] = "/tmp/glint_groom_XXXXXX", path[64];
    if (!CHECK(mkdtemp(dir) != NULL))
        return;
    snprintf(path, sizeof path, "%s/a.hair", dir);
    check_case("groom load: a file");
    struct buf b = three_strands(all_arrays);
    FILE *f = fopen(path, "wb");
    CHECK(f && fwrite(b.data, 1, b.size, f) == b.size);
    if (f)
        fclose(f);
    struct error err = {0};
    struct groom *g = groom_open(path, &err);
    if (CHECK(g != NULL)) {
        check_three_first(g);
        CHECK_STR(g->name, "a.hair");
    }
    groom_destroy(g);
    buf_finish(&b);
    check_case("groom load: no such file");
    refuse_path("/nowhere/b.hair", "file", "/nowhere/b.hair");
    check_case("groom load: a folder, a pipe, a device");
    refuse_path(dir, "file", "not a regular file");
    refuse_path("/dev/zero", "file", "not a regular file");
    unlink(path);
    CHECK(mkfifo(path, 0600) == 0);
    refuse_path(path, "file", "not a regular file"); // and does not wait
    unlink(path);
    check_case("groom load: more than 512 MB");
    int fd = open(path, O_CREAT | O_WRONLY, 0600);
    CHECK(fd >= 0 && ftruncate(fd, (512L << 20) + 1) == 0); // a sparse file
    close(fd);
    refuse_path(path, "limit", "536870913 bytes");
    unlink(path);
    rmdir(dir);
}

static void test_auto_diameter(void)
{
    check_case("groom: automatic diameter");
    struct buf b = three_strands(POINTS);
    struct error err;
    struct groom *g = parse(&b, &err);
    // The box of the nine points is 12 long along each axis.
    if (CHECK(g != NULL))
        CHECK_NEAR(groom_auto_diameter(g),
                   0.0004 * 12 * sqrt(3) * sqrt(100000.0 / 3), 1e-6);
    groom_destroy(g);
    groom_destroy(NULL);
    buf_finish(&b);
}

static double seconds(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static void check_real(const char *folder, const char *name)
{
    char path[512], title[128];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    snprintf(title, sizeof title, "groom load: %s", name);
    check_case(title);
    struct error err = {0};
    double began = seconds();
    struct groom *g = groom_load(path, &err);
    double ms = 1e3 * (seconds() - began);
    if (!CHECK(g != NULL)) {
        printf("  %s\n", err.text);
        return;
    }
    CHECK(g->strands > 0 && g->points >= 2 * g->strands);
    CHECK(g->first[g->strands] == g->points);
    CHECK(g->up >= 0 && g->up <= 2);
    if (strcmp(name, "straight.hair") == 0) {
        CHECK(g->strands == 10000 && g->points == 160000 && g->up == 2);
        CHECK(g->colour && g->default_diameter == 0.1f);
    }
    if (strcmp(name, "amd_ponytail.hair") == 0)
        CHECK(g->up == 1);
    printf("  %u strands, %u points, up %c, box %.4g x %.4g x %.4g, "
           "diameter %.4g, %.1f ms\n",
           g->strands, g->points, "xyz"[g->up],
           (double)(g->box_max[0] - g->box_min[0]),
           (double)(g->box_max[1] - g->box_min[1]),
           (double)(g->box_max[2] - g->box_min[2]),
           (double)(g->default_diameter > 0 ? g->default_diameter
                                            : groom_auto_diameter(g)),
           ms);
    groom_destroy(g);
}

static void test_real_files(void)
{
    const char *data = getenv("GLINT_DATA");
    char folder[256];
    snprintf(folder, sizeof folder, "%s/hair", data ? data : "../shared/data");
    DIR *d = opendir(folder);
    check_case("groom load: real files");
    if (!d) {
        check_skip("no folder of .hair files (GLINT_DATA)");
        return;
    }
    int found = 0;
    for (struct dirent *e; (e = readdir(d));)
        if (strstr(e->d_name, ".hair")) {
            check_real(folder, e->d_name);
            found++;
        }
    closedir(d);
    check_case("groom load: real files are there");
    CHECK(found > 0);
}

// 1.5 M points, 30,000 strands, every array: the largest groom of the paper.
// The limit is a hundred times what the machine of the measurements needs.
static void test_speed(void)
{
    check_case("groom file: 1.5 M points in two seconds");
    const uint32_t strands = 30000, points = 1500000;
    struct buf b = {0};
    put_header(&b, strands, points, all_arrays);
    for (uint32_t s = 0; s < strands; s++)
        put_u16(&b, 49);
    size_t floats = (size_t)points * 8;
    memset(buf_grow(&b, 4 * floats), 0, 4 * floats);
    struct error err;
    double began = seconds();
    struct groom *g = parse(&b, &err);
    double took = seconds() - began;
    CHECK(g && g->points == points);
    printf("  %.0f ms\n", 1e3 * took);
    CHECK_ATMOST(took, 2);
    groom_destroy(g);
    buf_finish(&b);
}

int main(void)
{
    test_all_arrays();
    test_unaligned_bytes();
    test_defaults();
    test_single_points();
    test_up();
    test_bounds_accepted();
    test_load();
    test_auto_diameter();
    test_real_files();
    test_speed();
    return check_end();
}
