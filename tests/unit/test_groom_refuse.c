// test_groom_refuse.c - every way in which a .hair file can be wrong is refused
// with one error that says what is wrong, the value and what would be right.
#include "tests/check.h"

#include "renderer/groom.h"
#include "tests/unit/groom_files.h"

// The file must be refused with this code and with all these words.
static void refuse(const char *what, struct buf *b, const char *code,
                   const char *words[3])
{
    check_case(what);
    struct error err;
    struct groom *g = parse(b, &err);
    CHECK(g == NULL);
    groom_destroy(g);
    CHECK_STR(err.code, code);
    CHECK_STR(err.name, "x.hair");
    for (int i = 0; i < 3 && words[i]; i++)
        if (!CHECK(strstr(err.text, words[i]) != NULL))
            printf("  \"%s\" lacks \"%s\"\n", err.text, words[i]);
}
#define REFUSE(what, b, code, ...) \
    refuse("groom file refused: " what, b, code, (const char *[3]){__VA_ARGS__})

static void test_refuse_header(void)
{
    struct buf b = {0};
    REFUSE("empty", &b, "file", "0 bytes", "128");
    buf_append(&b, "HAIR", 4);
    REFUSE("cut off in the header", &b, "file", "4 bytes");
    buf_finish(&b);
    b = three_strands(all_arrays);
    b.data[3] = 'r';
    REFUSE("another magic", &b, "file", "48 41 49 72", "HAIR");
    b.data[3] = 'R';
    set_u32(&b, 12, 63);
    REFUSE("an unknown array", &b, "file", "0x3f", "0x1f");
    set_u32(&b, 12, all_arrays & ~(uint32_t)POINTS);
    REFUSE("no points", &b, "file", "0x1d", "no points");
    set_u32(&b, 12, all_arrays);
    set_u32(&b, 8, 1);
    REFUSE("one point", &b, "file", "1 points", "[2, 8000000]");
    set_u32(&b, 8, 8000001);
    REFUSE("too many points", &b, "limit", "8000001", "[2, 8000000]");
    set_u32(&b, 8, 0xffffffffu);
    REFUSE("4 G points", &b, "limit", "4294967295");
    set_u32(&b, 8, 9);
    set_u32(&b, 4, 0);
    REFUSE("no strand", &b, "file", "0 strands", "[1, 9]");
    set_u32(&b, 4, 10);
    REFUSE("more strands than points", &b, "file", "10 strands", "[1, 9]");
    set_u32(&b, 4, 0xffffffffu);
    REFUSE("4 G strands", &b, "file", "4294967295");
    buf_finish(&b);
    b = three_strands(POINTS);
    set_u32(&b, 16, 3);
    REFUSE("default segments that miss the count", &b, "file", "12 points",
           "counts 9");
    // 3 x (0xffffffff + 1) is 0 and 3 x (0x55555557 + 1) is 8 in 32 bits.
    set_u32(&b, 16, 0xffffffffu);
    REFUSE("default segments that overflow", &b, "file", "12884901888");
    set_u32(&b, 16, 0x55555558u);
    REFUSE("default segments that wrap", &b, "file", "4294967307");
    buf_finish(&b);
}

static void test_refuse_lengths(void)
{
    struct buf b = three_strands(all_arrays);
    b.size--;
    REFUSE("a byte short", &b, "file", "422 bytes", "421");
    b.size++;
    buf_byte(&b, 0);
    REFUSE("a byte long", &b, "file", "422 bytes", "423");
    b.size = 128;
    REFUSE("a header alone", &b, "file", "422 bytes", "128");
    buf_finish(&b);
    b = three_strands(all_arrays);
    b.data[AT_SEGMENTS] = 3;
    REFUSE("segments that make more points", &b, "file", "10 points",
           "counts 9");
    b.data[AT_SEGMENTS] = 1;
    REFUSE("segments that make fewer points", &b, "file", "8 points",
           "counts 9");
    memset(b.data + AT_SEGMENTS, 0xff, 6);
    REFUSE("segments of 65535", &b, "file", "196608 points");
    buf_finish(&b);
    put_header(&b, 2, 2, SEGMENTS | POINTS);
    put_u32(&b, 0); // two strands of no segment
    for (int i = 0; i < 6; i++)
        put_f32(&b, 1);
    REFUSE("strands of one point only", &b, "file", "none of its 2 strands");
    buf_finish(&b);
}

static void refuse_value(size_t at, float v, const char *what,
                         const char *range)
{
    struct buf b = three_strands(all_arrays);
    set_f32(&b, at, v);
    char title[96];
    snprintf(title, sizeof title, "groom file refused: %s of %g", what,
             (double)v);
    refuse(title, &b, "file", (const char *[3]){what, range});
    buf_finish(&b);
}

static void test_refuse_values(void)
{
    const char *far = "[-1e+09, 1e+09]", *thick = "[0, 1e+09]";
    refuse_value(AT_POINTS, NAN, "position of point 0", far);
    refuse_value(AT_POINTS + 4 * 13, INFINITY, "position of point 4", far);
    refuse_value(AT_POINTS + 4 * 26, -2e9f, "position of point 8", far);
    refuse_value(AT_THICKNESS + 8, -0.5f, "thickness of point 2", thick);
    refuse_value(AT_THICKNESS + 8, NAN, "thickness of point 2", thick);
    refuse_value(AT_THICKNESS + 32, INFINITY, "thickness of point 8", thick);
    refuse_value(AT_TRANSPARENCY, 1.001f, "transparency of point 0", "[0, 1]");
    refuse_value(AT_TRANSPARENCY, -0.001f, "transparency of point 0", "[0, 1]");
    refuse_value(AT_TRANSPARENCY + 4, NAN, "transparency of point 1", "[0, 1]");
    refuse_value(AT_COLOURS + 4 * 5, -1, "colour of point 1", "[0, 1000]");
    refuse_value(AT_COLOURS + 4 * 5, 1001, "colour of point 1", "[0, 1000]");
    refuse_value(AT_COLOURS + 4 * 26, NAN, "colour of point 8", "[0, 1000]");
}

static void refuse_default(size_t at, float v, const char *what)
{
    struct buf b = three_strands(POINTS);
    set_f32(&b, at, v);
    char title[96];
    snprintf(title, sizeof title, "groom file refused: %s of %g", what,
             (double)v);
    refuse(title, &b, "file", (const char *[3]){what, "not within [0,"});
    buf_finish(&b);
}

static void test_refuse_defaults(void)
{
    refuse_default(20, -1, "default thickness");
    refuse_default(20, NAN, "default thickness");
    refuse_default(20, INFINITY, "default thickness");
    refuse_default(24, 1.5f, "default transparency");
    refuse_default(24, NAN, "default transparency");
    refuse_default(28, -0.25f, "default colour");
    refuse_default(36, NAN, "default colour");
}

int main(void)
{
    test_refuse_header();
    test_refuse_lengths();
    test_refuse_values();
    test_refuse_defaults();
    return check_end();
}
