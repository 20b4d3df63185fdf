// test_find.c - what the client finds in a header line, and what it does not
// mistake for it.
#include <string.h>

#include "tests/check.h"
// The client is not among the objects that tests are linked with.
#include "protocol/client/find.c"

static struct span text(const char *s)
{
    return (struct span){(const unsigned char *)s, strlen(s)};
}

static bool is(struct span s, const char *want)
{
    return s.size == strlen(want) && memcmp(s.data, want, s.size) == 0;
}

static void test_keys(void)
{
    struct span all = text("{\"a\":{\"bytes\":1,\"ok\":false},\"t\":\"x\\\","
                           "\\\"bytes\\\":2\",\"l\":[{\"bytes\":3},[]],"
                           "\"bytes\":99,\"ok\":true,\"n\":null,\"e\":{}}");
    struct span value;
    uint64_t n = 0;
    bool ok = false;
    check_case("find: a key of the object itself, not of what is inside it");
    CHECK(find_u64(all, "bytes", &n) && n == 99);
    CHECK(find_bool(all, "ok", &ok) && ok);
    CHECK(find_key(all, "a", &value) && find_u64(value, "bytes", &n) && n == 1);
    CHECK(find_bool(value, "ok", &ok) && !ok);
    CHECK(find_key(all, "l", &value) && is(value, "[{\"bytes\":3},[]]"));
    CHECK(find_key(all, "n", &value) && is(value, "null"));
    CHECK(find_key(all, "e", &value) && is(value, "{}"));
    CHECK(!find_key(all, "byte", &value) && !find_key(all, "bytes2", &value));
    CHECK(!find_u64(all, "t", &n) && !find_u64(all, "ok", &n));
    CHECK(!find_bool(all, "bytes", &ok) && !find_u64(all, "none", &n));
    check_case("find: what is no object or array has nothing in it");
    static const char *const bad[] = {"",      "{",        "{}",     "[]",
                                      "x",     "{\"",      "{\"a",   "{\"a\"",
                                      "{a:1}", "{\"a\"1}", "\"a\":1"};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        size_t at = 0;
        CHECK(!find_key(text(bad[i]), "a", &value));
        CHECK(bad[i][0] == '[' || !find_item(text(bad[i]), &at, &value));
    }
}

static void test_items(void)
{
    struct span value, list = text("[1,\"a,]\",[2,3],{\"x\":[]},-4.5]");
    static const char *const want[] = {"1", "\"a,]\"", "[2,3]", "{\"x\":[]}",
                                       "-4.5"};
    size_t at = 0, i = 0;
    double d = 0;
    check_case("find: items of an array in order");
    for (; find_item(list, &at, &value); i++)
        CHECK(i < 5 && is(value, want[i]));
    CHECK(i == 5);
    CHECK(find_number(text("{\"x\":-4.5e1}"), "x", &d) && d == -45);
}

static void test_text(void)
{
    static const struct {
        const char *json, *want; // NULL: no string
    } cases[] = {
        {"\"\"", ""},
        {"\"a\\\"b\\\\c\\/\"", "a\"b\\c/"},
        {"\"a\\nb\\tc\\u0007d\\u001b[31m\"", "a b c d [31m"},
        {"\"\\u00e9\\u20AC\\ud83d\\ude00\"",
         "\xc3\xa9\xe2\x82\xac\xf0\x9f\x98\x80"},
        {"\"\xe2\x82\xac\"", "\xe2\x82\xac"},
        {"\"\\ud83d\"", "\xef\xbf\xbd"},
        {"\"\\ud83dx\"", "\xef\xbf\xbdx"},
        {"\"\\ud83d\\u0041\"", "\xef\xbf\xbd"
                               "A"},
        {"\"\\u12\"", "\xef\xbf\xbd"
                      "12"},
        {"\"", NULL},
        {"a", NULL},
        {"\"a", NULL},
        {"", NULL},
        {"5", NULL},
    };
    check_case("find: a string as text that a terminal may have");
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        struct buf out = {0};
        bool ok = find_text(text(cases[i].json), &out);
        buf_byte(&out, 0);
        CHECK(ok == (cases[i].want != NULL));
        if (ok && cases[i].want)
            CHECK_STR((char *)out.data, cases[i].want);
        buf_finish(&out);
    }
}

int main(void)
{
    test_keys();
    test_items();
    test_text();
    return check_end();
}
