// test_framing.c - request heads of HTTP and frames of WebSocket under damaged
// input.  The law: however the stream is cut, the same story is told, and what
// it tells of lies inside what was given.
#include <stdint.h>

#include "protocol/http.h"
#include "protocol/utf8.h"
#include "protocol/websocket.h"
#include "tests/fuzz/mutate.h"

// --- HTTP -------------------------------------------------------------------

static const char *const http_texts[] = {
    "GET / HTTP/1.1\r\nHost: 127.0.0.1:8177\r\nAccept: */*\r\n\r\n",
    "GET /ws?x=1 HTTP/1.1\r\nHost: a\r\nUpgrade: websocket\r\nConnection: "
    "keep-alive, Upgrade\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n"
    "Sec-WebSocket-Version: 13\r\nOrigin: http://a\r\n\r\n",
    "POST /x HTTP/1.0\r\nContent-Length: 12\r\n\r\nhello=world!",
};
static const char *const http_words[] = {
    "\r\n",
    "\r\n\r\n",
    "\n",
    "\r",
    " ",
    ":",
    "Host: b\r\n",
    "HTTP/1.1",
    "HTTP/2.0",
    "Content-Length: 0\r\n",
    ",",
    "\t",
    "\r\n folded",
    "/",
    "GET ",
    "Transfer-Encoding: chunked\r\n",
    "xxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxx"};

// 0 while more is wanted, 200 or the refusal; at the first size that decides.
static int head_status(size_t step, struct http_request *r)
{
    for (size_t n = step ? 0 : input_size;; n += step) {
        n = n > input_size ? input_size : n;
        enum http_result result = http_parse(r, (struct span){input, n});
        if (result == HTTP_ONE)
            return 200;
        if (result == HTTP_BAD)
            return r->status;
        if (n == input_size)
            return 0;
    }
}

static bool law_http(void)
{
    static struct http_request r, pieces;
    struct span key;
    bool absent;
    const char *const list[] = {"a", "http://a", NULL};
    int status = head_status(0, &r);
    for (size_t step = 1; step < 12; step += 5)
        LAW(head_status(step, &pieces) == status);
    if (status != 200)
        return true;
    LAW(r.size == pieces.size && r.header_count == pieces.header_count);
    LAW(r.size <= input_size && r.header_count <= HTTP_HEADERS_MAX);
    LAW(within(r.target, given()) && within(r.path, r.target) &&
        within(r.query, r.target) && r.path.size > 0);
    for (int i = 0; i < r.header_count; i++)
        LAW(within(r.headers[i].name, given()) &&
            within(r.headers[i].value, given()) && r.headers[i].name.size > 0);
    int upgrade = http_upgrade(&r, &key);
    LAW(upgrade != 101 || key.size == 24);
    (void)http_host_allowed(&r, list);
    (void)http_origin_allowed(&r, list, &absent);
    return true;
}

// --- WebSocket --------------------------------------------------------------

// Everything that happened, with its payloads.
static bool events_of(struct buf *out, size_t step)
{
    struct websocket w;
    size_t at = 0;
    bool ok = true;
    websocket_init(&w);
    w.allow_binary = true;
    buf_clear(out);
    while (ok && at < input_size) {
        size_t left = input_size - at, used = 0;
        struct span in = {input + at, step && step < left ? step : left};
        enum websocket_event e = websocket_read(&w, in, &used);
        ok = used <= in.size && (e != WEBSOCKET_MORE || used == in.size) &&
             w.message.size <= WEBSOCKET_MESSAGE_MAX;
        at += used;
        if (e == WEBSOCKET_MORE)
            continue;
        ok = ok && (e != WEBSOCKET_TEXT || utf8_valid(w.payload));
        bool over = e == WEBSOCKET_CLOSE || e == WEBSOCKET_BAD;
        buf_printf(out, "%d %d %zu:", (int)e, over ? w.code : 0,
                   w.payload.size);
        buf_append(out, w.payload.data, w.payload.size);
        if (over)
            break;
    }
    websocket_finish(&w);
    return ok;
}

static bool law_websocket(void)
{
    static struct buf whole, pieces;
    LAW(events_of(&whole, 0));
    for (size_t step = 1; step < 8; step += 3) {
        LAW(events_of(&pieces, step));
        LAW(same(&whole, &pieces));
    }
    return true;
}

// Random frames, mostly good ones, rather than damaged texts: a damaged length
// would end almost every story at its first frame.
static void make_frames(struct buf *b)
{
    static const unsigned char opcodes[] = {0, 0, 0, 1, 1, 2, 9, 10, 8, 3, 11};
    buf_clear(b);
    for (size_t n = below(8) + 1; n > 0; n--) {
        unsigned char mask[4];
        unsigned fin = below(3) ? 0x80 : 0;
        unsigned op = opcodes[below(COUNT(opcodes) - (below(4) ? 2 : 0))];
        size_t size = below(20) ? below(140) : below(70000);
        buf_byte(b, (unsigned char)(fin | op | (below(60) ? 0 : 0x40)));
        unsigned masked = below(60) ? 0x80 : 0;
        if (size < 126)
            buf_byte(b, (unsigned char)(masked | size));
        else if (size < 65536)
            buf_append(b,
                       (unsigned char[]){(unsigned char)(masked | 126),
                                         (unsigned char)(size >> 8),
                                         (unsigned char)size},
                       3);
        else
            buf_append(b,
                       (unsigned char[]){(unsigned char)(masked | 127), 0, 0, 0,
                                         0, 0, (unsigned char)(size >> 16),
                                         (unsigned char)(size >> 8),
                                         (unsigned char)size},
                       9);
        for (int i = 0; i < 4; i++)
            mask[i] = (unsigned char)below(256);
        buf_append(b, mask, 4);
        bool dirty = below(30) == 0;
        size_t keep = below(40) ? size : below(size + 1);
        for (size_t i = 0; i < keep; i++)
            buf_byte(b, (unsigned char)((dirty ? below(256) : 'a' + i % 26) ^
                                        mask[i & 3]));
    }
    use(b);
}

static void run_frames(size_t n)
{
    struct buf b = {0};
    bool ok = true;
    check_case("fuzz: random frames, cut anywhere, tell the same story");
    state = 0x2545f4914f6cdd1du;
    for (size_t i = 0; ok && i < rounds(n); i++) {
        make_frames(&b);
        ok = law_websocket();
    }
    buf_finish(&b);
}

static const char *const ws_texts[] = {"\x81\x85maskhello\x81\x80mask",
                                       "\x01\x81mask.\x89\x80mask\x80\x81mask.",
                                       "\x88\x82mask\x6e\x89", "\x82\xfemask"};
static const char *const ws_words[] = {"\x81",        "\x80", "\x89\x80mask",
                                       "\xfe",        "\xff", "\x01\x80mask",
                                       "\x88\x80mask"};

int main(void)
{
    const struct corpus heads = CORPUS(http_texts, http_words);
    const struct corpus frames = CORPUS(ws_texts, ws_words);
    catch_crashes();
    run("fuzz: request heads, cut anywhere", &heads, 20000, law_http);
    run("fuzz: damaged frames, cut anywhere", &frames, 150000, law_websocket);
    run_frames(8000);
    free(input);
    return check_end();
}
