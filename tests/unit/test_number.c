// test_number.c - numbers and UTF-8: what is read, what is refused, and that
// what is printed reads back as the same bits.
#include <float.h>
#include <locale.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "protocol/number.h"
#include "protocol/utf8.h"
#include "tests/check.h"

static struct span text(const char *s)
{
    return (struct span){(const unsigned char *)s, strlen(s)};
}

static void test_accepts(void)
{
    static const struct {
        const char *text;
        double want;
    } good[] = {
        {"0", 0},
        {"-0", -0.0},
        {"1", 1},
        {"+1", 1},
        {"007", 7},
        {"1.55", 1.55},
        {"-7.5", -7.5},
        {"1e3", 1000},
        {"1E3", 1000},
        {"1e+3", 1000},
        {"25e-2", 0.25},
        {"0.1", 0.1},
        {"1e-400", 0},
        {"4.9e-324", 0x1p-1074},
        {"0.0001", 0.0001},
        {"1.7976931348623157e308", DBL_MAX},
        {"9007199254740993", 9007199254740992.0}, // halfway: to even
        {"0.500000000000000166533453693773481063544750213623046875",
         0x1.0000000000002p-1}, // halfway too
    };
    check_case("number: accepts, correctly rounded");
    for (size_t i = 0; i < sizeof good / sizeof *good; i++) {
        double got = NAN;
        if (!CHECK(number_parse(text(good[i].text), &got)) ||
            !CHECK(got == good[i].want &&
                   signbit(got) == signbit(good[i].want)))
            printf("  %s: got %.17g\n", good[i].text, got);
    }
}

static void test_refuses(void)
{
    static const char *const bad[] = {
        "",         " ",   " 1",    "1 ",    "+",      "-",        ".",
        ".5",       "5.",  "1.e3",  "e3",    "1e",     "1e+",      "1e1.5",
        "--1",      "+-1", "0x10",  "0x1p3", "inf",    "-inf",     "nan",
        "NAN",      "1,5", "1_000", "1e309", "-1e400", "1d3",      "1f",
        "infinity", "1\n", "\t1",   "1.2.3", "1e3e3",  "\xd9\xa1",
    };
    char longest[NUMBER_TEXT_MAX + 2];
    double got = 42;
    check_case("number: refuses and leaves the result alone");
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++)
        if (!CHECK(!number_parse(text(bad[i]), &got)))
            printf("  accepted \"%s\"\n", bad[i]);
    CHECK(!number_parse((struct span){(const unsigned char *)"1\0", 2}, &got));
    memset(longest, '1', sizeof longest);
    longest[NUMBER_TEXT_MAX + 1] = 0;
    CHECK(!number_parse(text(longest), &got));
    CHECK(got == 42);
    longest[NUMBER_TEXT_MAX] = 0;
    CHECK(number_parse(text(longest), &got));
    // A span need not end with a NUL.
    CHECK(number_parse((struct span){(const unsigned char *)"12345", 2}, &got));
    CHECK(got == 12);
}

static void test_u64(void)
{
    uint64_t got = 7;
    check_case("number: whole numbers up to a limit");
    CHECK(number_parse_u64(text("0"), 0, &got) && got == 0);
    CHECK(number_parse_u64(text("65535"), 65535, &got) && got == 65535);
    CHECK(!number_parse_u64(text("65536"), 65535, &got));
    CHECK(!number_parse_u64(text("9"), 8, &got));
    CHECK(!number_parse_u64(text("99"), 8, &got));
    CHECK(number_parse_u64(text("18446744073709551615"), UINT64_MAX, &got));
    CHECK(got == UINT64_MAX);
    CHECK(!number_parse_u64(text("18446744073709551616"), UINT64_MAX, &got));
    CHECK(!number_parse_u64(text("99999999999999999999999"), UINT64_MAX, &got));
    CHECK(!number_parse_u64(text(""), 10, &got));
    CHECK(!number_parse_u64(text("-1"), 10, &got));
    CHECK(!number_parse_u64(text("+1"), 10, &got));
    CHECK(!number_parse_u64(text("1.0"), 10, &got));
    CHECK(got == UINT64_MAX);
}

static void printed(double value, const char *want)
{
    char got[NUMBER_BUFFER];
    size_t n = number_print(got, value);
    CHECK_STR(got, want);
    CHECK(n == strlen(got));
}

static void printed_float(float value, const char *want)
{
    char got[NUMBER_BUFFER];
    size_t n = number_print_float(got, value);
    CHECK_STR(got, want);
    CHECK(n == strlen(got));
}

static void test_prints(void)
{
    check_case("number: prints what a person would write");
    printed(0, "0");
    printed(-0.0, "-0");
    printed(1, "1");
    printed(1000, "1000");
    printed(1e6, "1000000");
    printed(0.1, "0.1");
    printed(0.1 + 0.2, "0.30000000000000004");
    printed(1e15, "1000000000000000");
    printed(1e20, "100000000000000000000");
    printed(1e21, "1e21");
    printed(123456.789, "123456.789");
    printed(1e-4, "0.0001");
    printed(1e-6, "0.000001");
    printed(1.25e-7, "1.25e-7");
    printed(-0.0000012345678901234567, "-0.0000012345678901234567");
    printed(-1.5e-10, "-1.5e-10");
    printed(1e300, "1e300");
    printed(DBL_MAX, "1.7976931348623157e308");
    printed(0x1p-1074, "5e-324");
    printed_float(0.1f, "0.1");
    printed_float(1.55f, "1.55");
    printed_float(16777216.f, "16777216");
    printed_float(1.f / 3, "0.33333334");
    printed_float(FLT_MAX, "3.4028235e38");
    printed_float(0x1p-149f, "1e-45");
    printed_float(720, "720");
}

// xorshift (Marsaglia 2003): the cases are the same on every run.
static uint64_t random_bits(uint64_t *state)
{
    *state ^= *state << 13;
    *state ^= *state >> 7;
    *state ^= *state << 17;
    return *state;
}

static void test_round_trip(void)
{
    uint64_t seed = 0x9e3779b97f4a7c15u;
    int bad = 0, longer = 0;
    check_case("number: random bits survive printing and reading");
    for (int i = 0; i < 40000; i++) {
        char out[NUMBER_BUFFER];
        uint64_t bits = random_bits(&seed);
        uint32_t half = (uint32_t)(bits >> 32);
        double d, back = 0;
        float f;
        memcpy(&d, &bits, sizeof d);
        memcpy(&f, &half, sizeof f);
        if (isfinite(d)) {
            longer += number_print(out, d) >= NUMBER_BUFFER;
            bad += !number_parse(text(out), &back) ||
                   memcmp(&back, &d, sizeof d) != 0;
        }
        if (isfinite(f)) {
            longer += number_print_float(out, f) >= NUMBER_BUFFER;
            bad += !number_parse(text(out), &back) || (float)back != f;
        }
    }
    CHECK(bad == 0);
    CHECK(longer == 0);
}

// Sets a locale with a decimal comma, one that is made for the test where none
// is installed.  False when there is no way to have one.
static bool comma_locale(void)
{
    static const char *const names[] = {"de_DE.UTF-8", "de_DE", "fr_FR.UTF-8"};
    char dir[] = "/tmp/glint-locale-XXXXXX", command[256];
    for (size_t i = 0; i < sizeof names / sizeof *names; i++)
        if (setlocale(LC_ALL, names[i]))
            return true;
    if (!mkdtemp(dir))
        return false;
    snprintf(command, sizeof command,
             "localedef -i de_DE -f UTF-8 %s/glint >/dev/null 2>&1", dir);
    bool made = system(command) >= 0; // its status says little: see below
    setenv("LOCPATH", dir, 1);
    made = made && setlocale(LC_ALL, "glint");
    unsetenv("LOCPATH");
    snprintf(command, sizeof command, "rm -rf %s", dir);
    return system(command) == 0 && made;
}

static void test_locale(void)
{
    double got = 0;
    check_case("number: a locale with a decimal comma changes nothing");
    if (!comma_locale()) {
        check_skip("no locale with a decimal comma, and none can be made");
        return;
    }
    CHECK(strcmp(localeconv()->decimal_point, ".") != 0);
    CHECK(number_parse(text("1.5"), &got) && got == 1.5);
    CHECK(!number_parse(text("1,5"), &got));
    printed(1.5e-7, "1.5e-7");
    printed_float(0.25f, "0.25");
    setlocale(LC_ALL, "C");
}

static void test_utf8(void)
{
    static const char *const good[] = {"",
                                       "a",
                                       "\xc3\xa9",
                                       "\xe2\x82\xac",
                                       "\xf0\x9f\x98\x80",
                                       "\xed\x9f\xbf",
                                       "\xee\x80\x80",
                                       "\xf4\x8f\xbf\xbf",
                                       "\xc2\x80",
                                       "\xe0\xa0\x80"};
    static const char *const bad[] = {"\x80",
                                      "\xbf",
                                      "\xc0\x80",
                                      "\xc1\xbf",
                                      "\xc3",
                                      "\xc3(",
                                      "\xe2\x82",
                                      "\xe0\x80\x80",
                                      "\xe0\x9f\xbf",
                                      "\xed\xa0\x80",
                                      "\xed\xbf\xbf",
                                      "\xf0\x80\x80\x80",
                                      "\xf0\x8f\xbf\xbf",
                                      "\xf4\x90\x80\x80",
                                      "\xf5\x80\x80\x80",
                                      "\xff",
                                      "\xfe",
                                      "a\x80",
                                      "\xe2(\xa1",
                                      "\xf0\x9f\x98"};
    check_case("utf8: valid and invalid sequences");
    for (size_t i = 0; i < sizeof good / sizeof *good; i++)
        CHECK(utf8_valid(text(good[i])));
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++)
        if (!CHECK(!utf8_valid(text(bad[i]))))
            printf("  case %zu\n", i);
    check_case("utf8: every code point is written as it is read");
    int wrong = 0;
    for (uint32_t c = 1; c < 0x110000; c++) {
        unsigned char out[4];
        size_t n = utf8_put(out, c);
        bool surrogate = c >= 0xd800 && c <= 0xdfff;
        wrong += utf8_next((struct span){out, n}) != (surrogate ? 0 : n);
    }
    CHECK(wrong == 0);
    check_case("utf8: a cut falls between characters");
    CHECK(utf8_cut(text("ab"), 5) == 2);
    CHECK(utf8_cut(text("a\xe2\x82\xac"), 3) == 1);
    CHECK(utf8_cut(text("a\xe2\x82\xac"), 4) == 4);
    CHECK(utf8_cut(text("\xe2\x82\xac"), 0) == 0);
}

int main(void)
{
    test_accepts();
    test_refuses();
    test_u64();
    test_prints();
    test_round_trip();
    test_utf8();
    test_locale();
    return check_end();
}
