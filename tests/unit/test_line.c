// test_line.c - the request line, and cutting lines out of a stream.
#include <string.h>

#include "protocol/line.h"
#include "tests/check.h"

static struct span text(const char *s)
{
    return (struct span){(const unsigned char *)s, strlen(s)};
}

static bool is(struct span s, const char *want)
{
    return s.size == strlen(want) && memcmp(s.data, want, s.size) == 0;
}

static void test_good(void)
{
    struct line l = {0};
    struct error err = {0};
    check_case("line: tag, verb, words, pairs");
    CHECK(line_parse(&l, text("ping"), &err));
    CHECK(is(l.verb, "ping") && l.tag.size == 0 && l.word_count == 0);
    CHECK(line_parse(&l, text("#7 get fibre.eta light.yaw"), &err));
    CHECK(is(l.tag, "7") && is(l.verb, "get") && l.word_count == 2);
    CHECK(is(l.words[0], "fibre.eta") && is(l.words[1], "light.yaw"));
    CHECK(line_parse(&l, text("#a-B_1.2:3 stream on window=2"), &err));
    CHECK(is(l.tag, "a-B_1.2:3") && l.word_count == 1 && l.pair_count == 1);
    CHECK(is(l.pairs[0].name, "window") && is(l.pairs[0].value, "2"));
    CHECK(!l.pairs[0].quoted);
    CHECK(line_parse(&l, text("set fibre.sigma_a=0.2,0.3,0.5 a=-1e3"), &err));
    CHECK(l.pair_count == 2 && is(l.pairs[0].value, "0.2,0.3,0.5"));
    CHECK(line_pair(&l, "a") == &l.pairs[1] && !line_pair(&l, "b"));
    CHECK(line_parse(&l, text("hair file=/a\\b=c.hair"), &err));
    CHECK(is(l.pairs[0].value, "/a\\b=c.hair"));
    CHECK(line_parse(&l, text("hair builtin:ponytail"), &err));
    CHECK(is(l.words[0], "builtin:ponytail"));
    CHECK(line_parse(&l, text("get \xc3\xa9"), &err));
    CHECK(line_is(l.verb, "get") && !line_is(l.verb, "ge"));
    CHECK(!line_is(l.verb, "gett"));
    line_finish(&l);
}

static void test_quoted(void)
{
    static const struct {
        const char *text, *want;
    } good[] = {
        {"v x=\"\"", ""},
        {"v x=\"a b\"", "a b"},
        {"v x=\"a=b\"", "a=b"},
        {"v x=\"\\\\\\\"\\n\"", "\\\"\n"},
        {"v x=\"\\u0041\\u00e9\\u20ac\"", "A\xc3\xa9\xe2\x82\xac"},
        {"v x=\"\\uD83D\\uDE00\"", "\xf0\x9f\x98\x80"},
        {"v x=\"\\u0001\"", "\x01"},
        {"v x=\"\xe2\x82\xac\"", "\xe2\x82\xac"},
        {"v x=\"#1 set\"", "#1 set"},
    };
    struct line l = {0};
    struct error err = {0};
    check_case("line: quoted values");
    for (size_t i = 0; i < sizeof good / sizeof *good; i++) {
        if (!CHECK(line_parse(&l, text(good[i].text), &err)) ||
            !CHECK(is(l.pairs[0].value, good[i].want) && l.pairs[0].quoted))
            printf("  %s: %s\n", good[i].text, err.text);
    }
    // Earlier values stay where they are while later ones are unquoted.
    CHECK(
        line_parse(&l, text("v a=\"\" b=\"bbbb\" c=c d=\"\\u0064ddd\""), &err));
    CHECK(is(l.pairs[0].value, "") && is(l.pairs[1].value, "bbbb"));
    CHECK(is(l.pairs[2].value, "c") && is(l.pairs[3].value, "dddd"));
    // Also when they are longer than any first guess at their room.
    struct buf b = {0};
    buf_text(&b, "v");
    for (int i = 0; i < 100; i++)
        buf_printf(&b, " n%d=\"%0300d\"", i, i);
    CHECK(line_parse(&l, (struct span){b.data, b.size}, &err));
    for (int i = 0; i < 100; i++) {
        char want[301];
        snprintf(want, sizeof want, "%0300d", i);
        CHECK(l.pairs[i].value.data == l.store.data + 300 * i);
        CHECK(is(l.pairs[i].value, want));
    }
    buf_finish(&b);
    line_finish(&l);
}

static void test_refused(void)
{
    static const char *const bad[] = {
        "",
        " ",
        " ping",
        "ping ",
        "ping  x",
        "#",
        "#7",
        "#7 ",
        "#7  ping",
        "# ping",
        "#a#b ping",
        "#\xc3\xa9 ping",
        "Ping",
        "PING",
        "1ping",
        "_ping",
        "pi-ng",
        "a=1",
        "set =1",
        "set a=",
        "set a= b=1",
        "set A=1",
        "set 1a=1",
        "set a-b=1",
        "set a=1 b",
        "set a=1 a=2",
        "set a=\"",
        "set a=\"x",
        "set a=\"x\"y",
        "set a=\"x\"b=1",
        "set a=x\"y\"",
        "set a=\"\\x\"",
        "set a=\"\\t\"",
        "set a=\"\\u12\"",
        "set a=\"\\u12g4\"",
        "set a=\"\\u0000\"",
        "set a=\"\\ud800\"",
        "set a=\"\\ud800x\"",
        "set a=\"\\ud800\\n\"",
        "set a=\"\\ud800\\u0041\"",
        "set a=\"\\udc00\"",
        "set a=\"\\",
        "set a=\"\\u",
        "get \"x\"",
        "get a\"b",
        "ping\tx",
        "ping\r",
        "ping \x7f",
        "ping \x80",
        "set a=\"\xc3\"",
        "set a=\"x\ny\"",
    };
    struct line l = {0};
    check_case("line: what is not in the grammar is refused");
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        struct error err = {0};
        if (!CHECK(!line_parse(&l, text(bad[i]), &err)) ||
            !CHECK(strcmp(err.code, "syntax") == 0 && err.text[0]))
            printf("  \"%s\": code %s\n", bad[i], err.code);
    }
    CHECK(!line_parse(&l, (struct span){NULL, 0}, NULL));
    CHECK(
        !line_parse(&l, (struct span){(const unsigned char *)"p\0q", 3}, NULL));
    check_case("line: the tag survives a bad rest");
    struct error err = {0};
    CHECK(!line_parse(&l, text("#9 Bad"), &err) && is(l.tag, "9"));
    CHECK(!line_parse(&l, text("#9 set a=\x80"), &err) && is(l.tag, "9"));
    CHECK(is(l.verb, "set"));
    CHECK(strstr(err.text, "not UTF-8") != NULL);
    CHECK(!line_parse(&l, text("#9 set x=\"a"), &err) && is(l.tag, "9"));
    CHECK(!line_parse(&l, text("#\x80 set"), &err) && l.tag.size == 0);
    line_finish(&l);
}

// `count` items "name0=1 name1=1 ..." or "w0 w1 ...".
static struct buf many(const char *start, const char *item, int count)
{
    struct buf b = {0};
    buf_text(&b, start);
    for (int i = 0; i < count; i++) {
        buf_printf(&b, " %c%d%s", 'n', i, item);
    }
    return b;
}

static bool parses(struct buf *b, const char *code)
{
    struct line l = {0};
    struct error err = {0};
    bool ok = line_parse(&l, (struct span){b->data, b->size}, &err);
    line_finish(&l);
    buf_finish(b);
    return ok ? code == NULL : code && strcmp(err.code, code) == 0;
}

static void test_limits(void)
{
    struct buf b;
    check_case("line: counts and lengths at and above their limits");
    b = many("get", "", LINE_WORDS_MAX);
    CHECK(parses(&b, NULL));
    b = many("get", "", LINE_WORDS_MAX + 1);
    CHECK(parses(&b, "limit"));
    b = many("set", "=1", LINE_PAIRS_MAX);
    CHECK(parses(&b, NULL));
    b = many("set", "=1", LINE_PAIRS_MAX + 1);
    CHECK(parses(&b, "limit"));
    for (int extra = 0; extra < 2; extra++) {
        const char *want = extra ? "limit" : NULL;
        b = (struct buf){0};
        buf_byte(&b, '#');
        memset(buf_grow(&b, LINE_TAG_MAX + (size_t)extra), 't',
               LINE_TAG_MAX + (size_t)extra);
        buf_text(&b, " ping");
        CHECK(parses(&b, want));
        memset(buf_grow(&b, LINE_NAME_MAX + (size_t)extra), 'v',
               LINE_NAME_MAX + (size_t)extra);
        CHECK(parses(&b, want));
        buf_text(&b, "set ");
        memset(buf_grow(&b, LINE_NAME_MAX + (size_t)extra), 'n',
               LINE_NAME_MAX + (size_t)extra);
        buf_text(&b, "=1");
        CHECK(parses(&b, want));
        buf_text(&b, "set a=");
        size_t rest = LINE_BYTES_MAX - b.size + (size_t)extra;
        memset(buf_grow(&b, rest), '1', rest);
        CHECK(parses(&b, want));
    }
    check_case("line: a quoted value may fill the whole line");
    b = (struct buf){0};
    buf_text(&b, "set a=\"");
    size_t rest = LINE_BYTES_MAX - b.size - 1;
    memset(buf_grow(&b, rest), 'q', rest);
    buf_byte(&b, '"');
    CHECK(parses(&b, NULL));
}

// Feeds `all` in two pieces cut at `cut`, the way a connection would, and
// appends each line and a bar to `out`; "!" and the code where it is bad.
static void cut_stream(const char *all, size_t cut, struct buf *out)
{
    size_t total = strlen(all), have = cut, from = 0, scanned = 0;
    struct error err;
    buf_clear(out);
    for (;;) {
        struct span line;
        size_t used = 0;
        struct span in = {(const unsigned char *)all + from, have - from};
        switch (line_cut(in, &scanned, &line, &used, &err)) {
        case LINE_ONE:
            buf_append(out, line.data, line.size);
            buf_byte(out, '|');
            from += used;
            break;
        case LINE_BAD:
            buf_printf(out, "!%s", err.code);
            buf_byte(out, 0);
            return;
        case LINE_MORE:
            if (have == total) {
                buf_byte(out, 0);
                return;
            }
            have = total;
        }
    }
}

static void test_cut(void)
{
    static const struct {
        const char *in, *want;
    } cases[] = {
        {"", ""},
        {"ping", ""},
        {"ping\n", "ping|"},
        {"ping\r\nset a=1\n\nx", "ping|set a=1||"},
        {"\r\n", "|"},
        {"a\r\r\n", "a\r|"},
        {"ping\nGET / HTTP/1.1\r\n", "ping|!http"},
        {"ping\nPOST ", "ping|!http"},
        {"ping\nHost: x\n", "ping|!http"},
        {"ping\nhOsT:", "ping|!http"},
        {"ping\nHOSTS\n", "ping|HOSTS|"},
        {"GET\n", "GET|"},
        {"get /\n", "get /|"},
        {"hos\nhost \n", "hos|host |"},
        {"Get / HTTP/1.1\n", "Get / HTTP/1.1|"},
    };
    struct buf out = {0};
    check_case("line: a stream cut at every byte gives the same lines");
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
        for (size_t cut = 0; cut <= strlen(cases[i].in); cut++) {
            cut_stream(cases[i].in, cut, &out);
            CHECK_STR((char *)out.data, cases[i].want);
        }
    check_case("line: the longest line passes, a longer one is fatal");
    struct buf b = {0};
    struct span line;
    struct error err;
    size_t used = 0, scanned = 0;
    memset(buf_grow(&b, LINE_BYTES_MAX), 'a', LINE_BYTES_MAX);
    CHECK(line_cut((struct span){b.data, b.size}, &scanned, &line, &used,
                   &err) == LINE_MORE);
    buf_byte(&b, '\n');
    CHECK(line_cut((struct span){b.data, b.size}, &scanned, &line, &used,
                   &err) == LINE_ONE);
    CHECK(line.size == LINE_BYTES_MAX && used == LINE_BYTES_MAX + 1);
    b.data[LINE_BYTES_MAX] = 'a';
    CHECK(line_cut((struct span){b.data, b.size}, &scanned, &line, &used,
                   &err) == LINE_BAD);
    CHECK_STR(err.code, "limit");
    buf_byte(&b, '\n');
    scanned = 0;
    CHECK(line_cut((struct span){b.data, b.size}, &scanned, &line, &used,
                   &err) == LINE_BAD);
    buf_finish(&b);
    buf_finish(&out);
}

static void test_sniff(void)
{
    check_case("line: first bytes tell HTTP from lines");
    CHECK(line_looks_http(text("")) == LINE_MORE);
    CHECK(line_looks_http(text("G")) == LINE_MORE);
    CHECK(line_looks_http(text("GET")) == LINE_MORE);
    CHECK(line_looks_http(text("GET ")) == LINE_ONE);
    CHECK(line_looks_http(text("X y")) == LINE_ONE);
    CHECK(line_looks_http(text("GET\n")) == LINE_BAD);
    CHECK(line_looks_http(text(" GET ")) == LINE_BAD);
    CHECK(line_looks_http(text("get ")) == LINE_BAD);
    CHECK(line_looks_http(text("#1 GET ")) == LINE_BAD);
    char word[] = "AAAAAAAABBBBBBBBCCCCCCCCDDDDDDDDE ";
    CHECK(line_looks_http(text(word)) == LINE_BAD); // 33 letters
    CHECK(line_looks_http(text(word + 1)) == LINE_ONE);
    word[33] = 0;
    CHECK(line_looks_http(text(word)) == LINE_BAD);
    CHECK(line_looks_http(text(word + 1)) == LINE_MORE);
}

int main(void)
{
    test_good();
    test_quoted();
    test_refused();
    test_limits();
    test_cut();
    test_sniff();
    return check_end();
}
