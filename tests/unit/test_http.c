// test_http.c - request heads: what passes, what is refused with which status,
// every limit, and that the answer does not depend on how the bytes come in.
#include <stdlib.h>
#include <string.h>

#include "protocol/http.h"
#include "tests/check.h"

static struct span text(const char *s)
{
    return (struct span){(const unsigned char *)s, strlen(s)};
}

static bool is(struct span s, const char *want)
{
    return http_is(s, want);
}

#define HOST "Host: 127.0.0.1:8177\r\n"

static void test_good(void)
{
    static const char head[] = "GET /a/b?x=1?y HTTP/1.1\r\n" HOST "X-Empty:\r\n"
                               "Accept:  text/html \t\r\n"
                               "Connection: Upgrade, Keep-Alive\r\n"
                               "\r\nrest";
    struct http_request r;
    check_case("http: a request head taken apart");
    CHECK(http_parse(&r, text(head)) == HTTP_ONE);
    CHECK(r.size == strlen(head) - 4 && r.minor == 1 && r.header_count == 4);
    CHECK(is(r.method, "GET") && is(r.target, "/a/b?x=1?y"));
    CHECK(is(r.path, "/a/b") && is(r.query, "x=1?y"));
    CHECK(is(*http_header(&r, "hOST"), "127.0.0.1:8177"));
    CHECK(is(*http_header(&r, "accept"), "text/html"));
    CHECK(is(*http_header(&r, "x-empty"), ""));
    CHECK(!http_header(&r, "x-none"));
    CHECK(http_has_token(&r, "connection", "upgrade"));
    CHECK(http_has_token(&r, "connection", "keep-alive"));
    CHECK(!http_has_token(&r, "connection", "keep"));
    CHECK(r.keep_alive && !r.has_body && http_refuse(&r) == 0);
    CHECK(http_parse(&r, text("HEAD / HTTP/1.0\r\n\r\n")) == HTTP_ONE);
    CHECK(r.minor == 0 && !r.keep_alive && is(r.query, ""));
    CHECK(http_refuse(&r) == 0);
    CHECK(http_parse(&r, text("GET / HTTP/1.0\r\nConnection: keep-alive\r\n"
                              "\r\n")) == HTTP_ONE);
    CHECK(r.keep_alive);
    CHECK(http_parse(&r, text("GET / HTTP/1.1\r\nConnection: close\r\n" HOST
                              "\r\n")) == HTTP_ONE);
    CHECK(!r.keep_alive);
}

static void test_refuse(void)
{
    static const struct {
        const char *head;
        int status;
    } cases[] = {
        {"POST / HTTP/1.1\r\n" HOST "\r\n", 405},
        {"POST / HTTP/1.1\r\n" HOST "Content-Length: 9\r\n\r\n", 405},
        {"OPTIONS / HTTP/1.1\r\n" HOST "\r\n", 405},
        {"get / HTTP/1.1\r\n" HOST "\r\n", 405},
        {"GET / HTTP/1.1\r\n" HOST "Content-Length: 9\r\n\r\n", 413},
        {"GET / HTTP/1.1\r\n" HOST "Content-Length: 0\r\n\r\n", 0},
        {"GET / HTTP/1.1\r\n" HOST "Transfer-Encoding: chunked\r\n\r\n", 413},
    };
    struct http_request r;
    check_case("http: methods and bodies that are not served");
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        CHECK(http_parse(&r, text(cases[i].head)) == HTTP_ONE);
        CHECK(http_refuse(&r) == cases[i].status);
    }
}

static void test_bad(void)
{
    static const struct {
        const char *head;
        int status;
    } cases[] = {
        {"\r\n", 400},
        {"GET\r\n", 400},
        {"GET /\r\n", 400},
        {"GET / HTTP/1.1\n", 400},
        {"GET / HTTP/1.1 \r\n", 400},
        {"GET  / HTTP/1.1\r\n", 400},
        {" GET / HTTP/1.1\r\n", 400},
        {"G(T / HTTP/1.1\r\n", 400},
        {"GET * HTTP/1.1\r\n", 400},
        {"GET http://x/ HTTP/1.1\r\n", 400},
        {"GET /\x80 HTTP/1.1\r\n", 400},
        {"GET /\x7f HTTP/1.1\r\n", 400},
        {"GET /\ta HTTP/1.1\r\n", 400},
        {"GET /a b HTTP/1.1\r\n", 400},
        {"GET / HTTP/11\r\n", 400},
        {"GET / http/1.1\r\n", 400},
        {"GET / HTTP/1.x\r\n", 400},
        {"GET / HTTP/2.0\r\n", 505},
        {"GET / HTTP/0.9\r\n", 505},
        {"GET / HTTP/1.1\r\n\r\n", 400},              // no Host
        {"GET / HTTP/1.1\r\n" HOST HOST "\r\n", 400}, // two
        {"GET / HTTP/1.1\r\n" HOST " folded\r\n", 400},
        {"GET / HTTP/1.1\r\n" HOST "\tfolded\r\n", 400},
        {"GET / HTTP/1.1\r\n" HOST "no colon\r\n", 400},
        {"GET / HTTP/1.1\r\n" HOST "nocolon\r\n", 400},
        {"GET / HTTP/1.1\r\n" HOST "a : b\r\n", 400},
        {"GET / HTTP/1.1\r\n" HOST ": b\r\n", 400},
        {"GET / HTTP/1.1\r\n" HOST "a: b\rc\r\n", 400},
        {"GET / HTTP/1.1\r\n" HOST "a: \x01\r\n", 400},
        {"GET / HTTP/1.1\r\n" HOST "a: b\n", 400},
        {"GET / HTTP/1.1\r\n" HOST "Content-Length: -1\r\n\r\n", 400},
        {"GET / HTTP/1.1\r\n" HOST "Content-Length: 1, 1\r\n\r\n", 400},
        {"GET / HTTP/1.1\r\n" HOST "Content-Length: 0\r\nContent-Length: 0\r\n"
         "\r\n",
         400},
        {"GET / HTTP/1.1\r\n" HOST
         "Content-Length: 99999999999999999999\r\n\r\n",
         400},
    };
    struct http_request r;
    check_case("http: what is malformed is refused, whatever comes after it");
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        enum http_result result = http_parse(&r, text(cases[i].head));
        if (!CHECK(result == HTTP_BAD && r.status == cases[i].status && r.why))
            printf("  case %zu: result %d, status %d\n", i, (int)result,
                   r.status);
    }
    CHECK(http_parse(&r, (struct span){NULL, 0}) == HTTP_MORE);
    CHECK(
        http_parse(&r, (struct span){
                           (const unsigned char *)"GET / HTTP/1.1\r\na: \0\r\n",
                           23}) == HTTP_BAD);
}

// "GET /xxx HTTP/1.1", Host, `headers` lines, padded to `size` bytes in all.
static struct buf make(size_t target, int headers, size_t size)
{
    struct buf b = {0};
    buf_text(&b, "GET /");
    memset(buf_grow(&b, target - 1), 'x', target - 1);
    buf_text(&b, " HTTP/1.1\r\n" HOST);
    for (int i = 1; i < headers; i++)
        buf_printf(&b, "h%d: v\r\n", i);
    if (size > b.size) {
        buf_text(&b, "pad: ");
        size_t pad = size - b.size - 4;
        memset(buf_grow(&b, pad), 'p', pad);
        buf_text(&b, "\r\n");
    }
    buf_text(&b, "\r\n");
    return b;
}

// The outcome with the first `n` bytes, then with one more each time; the
// status of the first answer that is not HTTP_MORE, 200 for HTTP_ONE.
static int dribble(struct buf *b, size_t from, size_t step)
{
    struct http_request r;
    for (size_t n = from; n <= b->size; n += step) {
        // A copy of exactly n bytes, so that reading beyond them shows.
        unsigned char *copy = bytes_alloc(n ? n : 1);
        if (n > 0)
            memcpy(copy, b->data, n);
        enum http_result result = http_parse(&r, (struct span){copy, n});
        free(copy);
        if (result != HTTP_MORE)
            return result == HTTP_ONE ? 200 : r.status;
        if (n < b->size && n + step > b->size)
            n = b->size - step;
    }
    return 0;
}

static void both_ways(struct buf b, int want)
{
    CHECK(dribble(&b, b.size, 1) == want);
    CHECK(dribble(&b, 0, b.size > 1000 ? 7 : 1) == want);
    buf_finish(&b);
}

static void test_limits(void)
{
    check_case("http: target, header lines and head at and above the limits");
    both_ways(make(HTTP_TARGET_MAX, 1, 0), 200);
    both_ways(make(HTTP_TARGET_MAX + 1, 1, 0), 414);
    both_ways(make(HTTP_HEAD_MAX * 2, 1, 0), 414);
    both_ways(make(1, HTTP_HEADERS_MAX, 0), 200);
    both_ways(make(1, HTTP_HEADERS_MAX + 1, 0), 431);
    both_ways(make(1, 2, HTTP_HEAD_MAX), 200);
    both_ways(make(1, 2, HTTP_HEAD_MAX + 1), 431);
    both_ways(make(1, 2, HTTP_HEAD_MAX * 2), 431);
    struct buf b = {0};
    memset(buf_grow(&b, HTTP_HEAD_MAX), 'G', HTTP_HEAD_MAX);
    both_ways(b, 431);
    check_case("http: a long target is refused as soon as it shows");
    struct http_request r;
    b = make(HTTP_TARGET_MAX + 1, 1, 0);
    CHECK(http_parse(&r, (struct span){b.data, 4 + HTTP_TARGET_MAX}) ==
          HTTP_MORE);
    CHECK(http_parse(&r, (struct span){b.data, 5 + HTTP_TARGET_MAX}) ==
          HTTP_BAD);
    buf_finish(&b);
}

static void test_split(void)
{
    static const char *const heads[] = {
        "GET /a HTTP/1.1\r\n" HOST "A: b\r\n\r\n",
        "GET /a\r\n\r\n",
        "GET /a HTTP/2.0\r\n\r\n",
        "GET /a HTTP/1.1\n\n",
        "GET /a HTTP/1.1\r\n" HOST "A b\r\n\r\n",
        "GET /a HTTP/1.1\r\n\r\n",
    };
    check_case("http: byte by byte gives the same answer");
    for (size_t i = 0; i < sizeof heads / sizeof *heads; i++) {
        struct buf b = {0};
        buf_text(&b, heads[i]);
        int whole = dribble(&b, b.size, 1);
        CHECK(whole != 0 && dribble(&b, 0, 1) == whole);
        buf_finish(&b);
    }
}

static void test_allowed(void)
{
    static const char *const hosts[] = {"127.0.0.1:8177", "localhost:8177",
                                        NULL};
    static const char *const origins[] = {"http://127.0.0.1:8177", NULL};
    static const struct {
        const char *line;
        bool host;
    } cases[] = {
        {"Host: 127.0.0.1:8177\r\n", true},
        {"Host: LocalHost:8177\r\n", true},
        {"Host: localhost\r\n", false},
        {"Host: localhost:81770\r\n", false},
        {"Host: evil.example\r\n", false},
        {"Host: \r\n", false},
        {"Host: 127.0.0.1:8177.evil\r\n", false},
    };
    struct http_request r;
    char head[256];
    bool absent;
    check_case("http: hosts are compared whole, with their port");
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        snprintf(head, sizeof head, "GET / HTTP/1.1\r\n%s\r\n", cases[i].line);
        CHECK(http_parse(&r, text(head)) == HTTP_ONE);
        CHECK(http_host_allowed(&r, hosts) == cases[i].host);
    }
    CHECK(http_parse(&r, text("GET / HTTP/1.0\r\n\r\n")) == HTTP_ONE);
    CHECK(!http_host_allowed(&r, hosts));
    check_case("http: origins are compared whole; null and two never pass");
    CHECK(!http_origin_allowed(&r, origins, &absent) && absent);
    static const char *const bad[] = {
        "Origin: null\r\n",
        "Origin: http://127.0.0.1\r\n",
        "Origin: https://127.0.0.1:8177\r\n",
        "Origin:\r\n",
        "Origin: http://127.0.0.1:8177\r\nOrigin: http://127.0.0.1:8177\r\n",
        "Origin: http://127.0.0.1:8177/\r\n"};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        snprintf(head, sizeof head, "GET / HTTP/1.1\r\n" HOST "%s\r\n", bad[i]);
        CHECK(http_parse(&r, text(head)) == HTTP_ONE);
        CHECK(!http_origin_allowed(&r, origins, &absent) && !absent);
    }
    CHECK(http_parse(&r, text("GET / HTTP/1.1\r\n" HOST
                              "Origin: http://127.0.0.1:8177\r\n\r\n")) ==
          HTTP_ONE);
    CHECK(http_origin_allowed(&r, origins, &absent) && !absent);
}

#define KEY "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n"
#define WS "Upgrade: websocket\r\nConnection: keep-alive, Upgrade\r\n"
#define V13 "Sec-WebSocket-Version: 13\r\n"

static void test_upgrade(void)
{
    static const struct {
        const char *head;
        int status;
    } cases[] = {
        {"GET /ws HTTP/1.1\r\n" HOST WS KEY V13 "\r\n", 101},
        {"GET /ws HTTP/1.1\r\n" HOST V13 KEY
         "upgrade: h2c, WebSocket\r\nconnection: upgrade\r\n\r\n",
         101},
        {"GET /ws HTTP/1.1\r\n" HOST KEY V13 "\r\n", 0},
        {"GET /ws HTTP/1.1\r\n" HOST "Upgrade: h2c\r\n" KEY V13 "\r\n", 0},
        {"HEAD /ws HTTP/1.1\r\n" HOST WS KEY V13 "\r\n", 405},
        {"GET /ws HTTP/1.0\r\n" HOST WS KEY V13 "\r\n", 400},
        {"GET /ws HTTP/1.1\r\n" HOST "Upgrade: websocket\r\n" KEY V13 "\r\n",
         400},
        {"GET /ws HTTP/1.1\r\n" HOST WS KEY "\r\n", 426},
        {"GET /ws HTTP/1.1\r\n" HOST WS KEY "Sec-WebSocket-Version: 8\r\n\r\n",
         426},
        {"GET /ws HTTP/1.1\r\n" HOST WS V13 "\r\n", 400},
        {"GET /ws HTTP/1.1\r\n" HOST WS V13 KEY KEY "\r\n", 400},
        {"GET /ws HTTP/1.1\r\n" HOST WS V13
         "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ=\r\n\r\n",
         400},
        {"GET /ws HTTP/1.1\r\n" HOST WS V13 "Sec-WebSocket-Key:\r\n\r\n", 400},
    };
    struct http_request r;
    struct span key;
    char accept[HTTP_ACCEPT_SIZE];
    check_case("http: a WebSocket upgrade is checked whole");
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        CHECK(http_parse(&r, text(cases[i].head)) == HTTP_ONE);
        int got = http_upgrade(&r, &key);
        if (!CHECK(got == cases[i].status))
            printf("  case %zu: %d\n", i, got);
        if (got == 101)
            CHECK(is(key, "dGhlIHNhbXBsZSBub25jZQ=="));
    }
    http_accept(text("dGhlIHNhbXBsZSBub25jZQ=="), accept); // RFC 6455, 1.3
    CHECK_STR(accept, "s3pPLMBiTxaQ9kYGzzhZRbK+xOo=");
}

static bool has(const struct buf *b, const char *line)
{
    return memmem(b->data, b->size, line, strlen(line)) != NULL;
}

static void test_respond(void)
{
    static const int statuses[] = {101, 200, 304, 400, 403, 404, 405, 408,
                                   413, 414, 421, 426, 431, 500, 503, 505};
    struct buf b = {0};
    check_case("http: every answer carries its guards");
    for (size_t i = 0; i < sizeof statuses / sizeof *statuses; i++) {
        buf_clear(&b);
        CHECK(http_reason(statuses[i])[0] != 0);
        http_respond(&b, &(struct http_response){.status = statuses[i],
                                                 .type = "text/html",
                                                 .length = 5,
                                                 .keep_alive = true,
                                                 .extra = "X: y\r\n"});
        CHECK(has(&b, "\r\nX-Content-Type-Options: nosniff\r\n"));
        CHECK(has(&b, "\r\nReferrer-Policy: no-referrer\r\n"));
        CHECK(has(&b, "\r\nCross-Origin-Resource-Policy: same-origin\r\n"));
        CHECK(has(&b, "Policy: default-src 'self'; img-src 'self' blob:; "
                      "connect-src 'self'; frame-ancestors 'none'\r\n"));
        CHECK(has(&b, "\r\nX: y\r\n\r\n"));
        bool length = statuses[i] != 101 && statuses[i] != 304;
        CHECK(has(&b, "\r\nContent-Length: 5\r\n") == length);
        CHECK(has(&b, "\r\nConnection: keep-alive\r\n") ==
              (statuses[i] != 101));
    }
    CHECK_STR(http_reason(299), "");
    check_case("http: errors say what to do next, and close");
    for (int head_only = 0; head_only < 2; head_only++) {
        buf_clear(&b);
        http_respond_error(&b, 405, "no", head_only);
        CHECK(has(&b, "HTTP/1.1 405 Method Not Allowed\r\n"));
        CHECK(has(&b, "\r\nAllow: GET, HEAD\r\n"));
        CHECK(has(&b, "\r\nContent-Length: 3\r\n"));
        CHECK(has(&b, "\r\nConnection: close\r\n"));
        CHECK(has(&b, "\r\n\r\nno\n") == !head_only);
    }
    buf_clear(&b);
    http_respond_error(&b, 426, "no", false);
    CHECK(has(&b, "\r\nSec-WebSocket-Version: 13\r\n"));
    http_respond_error(&b, 503, "no", false);
    CHECK(has(&b, "\r\nRetry-After: "));
    buf_clear(&b);
    http_respond_upgrade(&b, text("dGhlIHNhbXBsZSBub25jZQ=="));
    CHECK(has(&b, "HTTP/1.1 101 Switching Protocols\r\n"));
    CHECK(has(&b, "\r\nSec-WebSocket-Accept: s3pPLMBiTxaQ9kYGzzhZRbK+xOo=\r\n"
                  "\r\n"));
    CHECK(has(&b, "\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"));
    CHECK(!has(&b, "Content-Length"));
    buf_finish(&b);
}

int main(void)
{
    test_good();
    test_refuse();
    test_bad();
    test_limits();
    test_split();
    test_allowed();
    test_upgrade();
    test_respond();
    return check_end();
}
