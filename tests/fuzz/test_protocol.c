// test_protocol.c - the parsers of the ground floor and of the client under
// mutated input.  Each case has a corpus of good and nearly good inputs,
// damages them by a seeded generator, and holds the parser to laws that need no
// second parser: the outcome does not depend on how a stream was cut, spans lie
// inside what was given, refused edits change nothing, printed values read
// back.
//
// The same inputs on every run; GLINT_LONG=1 goes on with 40 times as many.  On
// a crash the input at hand is printed in hexadecimal.
#include <math.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "protocol/edit.h"
#include "protocol/http.h"
#include "protocol/json.h"
#include "protocol/line.h"
#include "protocol/number.h"
#include "protocol/utf8.h"
#include "protocol/websocket.h"
#include "tests/check.h"
// The client is not among the objects that tests are linked with.
#include "protocol/client/find.c"

// --- generator, corpus and crash report -------------------------------------

static uint64_t state;

// xorshift* (Vigna 2016), uniform below n up to a bias that does not matter.
static size_t below(size_t n)
{
    state ^= state >> 12;
    state ^= state << 25;
    state ^= state >> 27;
    return (size_t)((state * 0x2545f4914f6cdd1du) >> 33) % n;
}

static unsigned char *input; // exactly input_size bytes, for the sanitizer
static size_t input_size;

static void dump(void)
{
    static const char hex[] = "0123456789abcdef";
    char text[2];
    if (write(STDERR_FILENO, "input: ", 7) < 0)
        return;
    for (size_t i = 0; i < input_size; i++) {
        text[0] = hex[input[i] >> 4];
        text[1] = hex[input[i] & 15];
        if (write(STDERR_FILENO, text, 2) < 0)
            return;
    }
    if (write(STDERR_FILENO, "\n", 1) < 0)
        return;
}

static void crashed(int signal_number)
{
    dump();
    signal(signal_number, SIG_DFL);
    raise(signal_number);
}

void __asan_on_error(void); // called by the sanitizer where there is one
void __asan_on_error(void)
{
    dump();
}

static void use(const struct buf *b)
{
    free(input);
    input_size = b->size;
    input = bytes_alloc(b->size + (b->size == 0));
    if (b->size > 0)
        memcpy(input, b->data, b->size);
}

struct corpus {
    const char *const *texts;
    size_t count;
    const char *const *words; // pieces that mean something to the parser
    size_t word_count;
};

static void insert(struct buf *b, size_t at, const void *data, size_t size)
{
    if (size == 0)
        return;
    buf_append(b, data, size);
    memmove(b->data + at + size, b->data + at, b->size - size - at);
    memcpy(b->data + at, data, size);
}

static void damage(struct buf *b, const struct corpus *c)
{
    size_t at = below(b->size + 1), n = b->size - at;
    unsigned char byte = (unsigned char)below(256);
    const char *word = c->words[below(c->word_count)];
    switch (below(7)) {
    case 0:
        if (n > 0)
            b->data[at] = byte;
        break;
    case 1:
        if (n > 0)
            b->data[at] ^= (unsigned char)(1u << below(8));
        break;
    case 2:
        insert(b, at, &byte, 1);
        break;
    case 3: // a piece goes
        n = below(n + 1);
        memmove(b->data + at, b->data + at + n, b->size - at - n);
        b->size -= n;
        break;
    case 4: { // a piece comes twice
        struct buf piece = {0};
        buf_append(&piece, b->data + at, below((n < 64 ? n : 64) + 1));
        insert(b, below(b->size + 1), piece.data, piece.size);
        buf_finish(&piece);
        break;
    }
    default:
        insert(b, at, word, strlen(word));
    }
}

static void make(struct buf *b, const struct corpus *c)
{
    buf_clear(b);
    buf_byte(b, 0); // so that it has memory even when nothing follows
    buf_clear(b);
    buf_text(b, c->texts[below(c->count)]);
    for (size_t n = below(6); n > 0; n--)
        damage(b, c);
    use(b);
}

static size_t rounds(size_t n)
{
    return getenv("GLINT_LONG") ? n * 40 : n;
}

static bool within(struct span part, struct span all)
{
    return part.size == 0 ||
           (part.data >= all.data && part.size <= all.size &&
            (size_t)(part.data - all.data) <= all.size - part.size);
}

static struct span given(void)
{
    return (struct span){input, input_size};
}

// One failure is enough: it is shown with its input, and the case ends.
#define LAW(x) \
    do { \
        if (!CHECK(x)) { \
            fflush(stdout); \
            dump(); \
            return false; \
        } \
    } while (0)

#define COUNT(a) (sizeof(a) / sizeof *(a))
#define CORPUS(t, w) \
    { \
        t, COUNT(t), w, COUNT(w) \
    }

static void run(const char *name, const struct corpus *c, size_t n,
                bool (*law)(void))
{
    struct buf b = {0};
    check_case(name);
    state = 0x9e3779b97f4a7c15u;
    bool ok = true;
    for (size_t i = 0; ok && i < rounds(n); i++) {
        make(&b, c);
        ok = law();
    }
    buf_finish(&b);
}

// --- lines and edits --------------------------------------------------------

static const char *const line_texts[] = {
    "ping",
    "#7 get fibre.eta light.yaw",
    "#a-B_1.2:3 stream on window=2 format=jpeg",
    "set fibre.sigma_a=0.2,0.3,0.5 light.yaw=30 seq=5 echo=\"a b\"",
    "set camera.eye=1e2,-3,auto output.format=exr view.head=off",
    "hair name=\"\\u00e9\\n\\\\\\\"\\ud83d\\ude00\"",
    "capture format=exr size=720x480 revision=12",
    "set image.width=8192 image.height=8192",
};
static const char *const line_words[] = {" ",
                                         "=",
                                         "\"",
                                         "#",
                                         "\\",
                                         "\\u",
                                         "\\u0000",
                                         "\\ud83d",
                                         "\\ude00",
                                         "\n",
                                         "\xe2\x82\xac",
                                         "\x80",
                                         "auto",
                                         "nan",
                                         "1e308",
                                         "-0",
                                         "1e-40",
                                         ",",
                                         "0x1",
                                         "fibre.eta=",
                                         "image.width=1 ",
                                         "output.format=jpeg ",
                                         "a=1 ",
                                         "\r\n",
                                         "GET ",
                                         "Host:",
                                         "camera.up=0,0,1 ",
                                         "hair.scale=3 ",
                                         "tint.colour=2 "};

static bool law_line(void)
{
    static struct line line;
    struct error err = {0};
    struct span text = given();
    if (!line_parse(&line, text, &err)) {
        LAW(strcmp(err.code, "syntax") == 0 || strcmp(err.code, "limit") == 0);
        LAW(err.text[0] != 0);
        LAW(within(line.tag, text));
        return true;
    }
    struct span store = {line.store.data, line.store.size};
    LAW(utf8_valid(text) && within(line.verb, text) && line.verb.size > 0);
    for (int i = 0; i < line.word_count; i++)
        LAW(within(line.words[i], text) && line.words[i].size > 0);
    for (int i = 0; i < line.pair_count; i++) {
        struct line_pair *p = &line.pairs[i];
        LAW(within(p->name, text) && utf8_valid(p->value));
        LAW(within(p->value, p->quoted ? store : text));
        for (int k = 0; k < i; k++)
            LAW(p->name.size != line.pairs[k].name.size ||
                memcmp(p->name.data, line.pairs[k].name.data, p->name.size));
    }
    return true;
}

// Every value lies within its row's range, and reads back from its own text.
static bool legal_values(const struct params *p)
{
    struct params again;
    struct error err = {0};
    params_defaults(&again);
    again.image.width = again.image.height = 1; // both together are limited
    for (int r = 0; r < params_row_count; r++) {
        const struct params_row *row = &params_rows[r];
        struct buf text = {0};
        buf_printf(&text, "%s.%s=", row->group_name, row->name);
        edit_print(&text, p, row);
        buf_byte(&text, 0);
        bool ok = edit_apply_text(&again, (char *)text.data, &err);
        buf_finish(&text);
        LAW(ok);
        for (int i = 0; i < row->count; i++) {
            double v = params_get(p, row, i);
            if (row->type == PARAMS_CHOICE)
                LAW(edit_choice(row, (int)v).size > 0);
            else
                LAW((isnan(v) && row->has_auto) ||
                    (v >= (double)(float)row->min &&
                     v <= (double)(float)row->max));
        }
    }
    LAW(params_changed(p, &again) == 0);
    LAW((int64_t)p->image.width * p->image.height <= EDIT_PIXELS_MAX);
    return true;
}

static bool law_edit(void)
{
    static struct line line;
    static struct params p;
    struct error err = {0};
    struct line_pair pairs[LINE_PAIRS_MAX];
    int count = 0;
    if (p.image.width == 0)
        params_defaults(&p);
    if (!line_parse(&line, given(), &err))
        return true;
    for (int i = 0; i < line.pair_count; i++)
        if (memchr(line.pairs[i].name.data, '.', line.pairs[i].name.size))
            pairs[count++] = line.pairs[i];
    struct params before = p;
    if (edit_apply(&p, pairs, count, &err))
        return count == 0 || params_changed(&p, &before) == 0 ||
               legal_values(&p);
    LAW(memcmp(&p, &before, sizeof p) == 0);
    LAW(err.code[0] && err.text[0]);
    return true;
}

// What a stream of lines is, cut into pieces of `step` bytes (0: whole).
static void lines_of(struct buf *out, size_t step)
{
    size_t have = step && step < input_size ? step : input_size;
    size_t from = 0, scanned = 0;
    buf_clear(out);
    for (;;) {
        struct span line;
        struct error err;
        size_t used = 0;
        struct span in = {input + from, have - from};
        enum line_result r = line_cut(in, &scanned, &line, &used, &err);
        if (r == LINE_BAD) {
            buf_printf(out, "!%s", err.code);
            return;
        }
        if (r == LINE_ONE) {
            buf_append(out, line.data, line.size);
            buf_byte(out, '\n');
            from += used;
        } else if (have == input_size) {
            return;
        } else {
            have = input_size - have < step ? input_size : have + step;
        }
    }
}

static bool same(const struct buf *a, const struct buf *b)
{
    return a->size == b->size &&
           (a->size == 0 || memcmp(a->data, b->data, a->size) == 0);
}

static bool law_stream(void)
{
    static struct buf whole, pieces;
    lines_of(&whole, 0);
    for (size_t step = 1; step < 6; step++) {
        lines_of(&pieces, step);
        LAW(same(&whole, &pieces));
    }
    return true;
}

static const char *const stream_texts[] = {
    "ping\n#7 get a\r\nset a=1\n\n",
    "ping\nGET / HTTP/1.1\r\nHost: x\r\n\r\n",
    "\r\n\r\nhost: x\nping\n",
};

// --- numbers ----------------------------------------------------------------

static const char *const number_texts[] = {
    "0",        "-1.5",
    "1e3",      "123456789.987654321e-10",
    "4.9e-324", "1.7976931348623157e308",
    "0.1",      "+7",
    "inf",      "nan",
    "0x1p3",    "1e999"};
static const char *const number_words[] = {
    "0", "9", "e", ".", "-", "+", "1e", "99999999", "e-3", "00", ",", " "};

static bool law_number(void)
{
    double got = 0, back = 0;
    char copy[NUMBER_TEXT_MAX + 1], out[NUMBER_BUFFER], *end;
    if (!number_parse(given(), &got))
        return true;
    LAW(input_size <= NUMBER_TEXT_MAX);
    memcpy(copy, input, input_size);
    copy[input_size] = 0;
    LAW(strtod(copy, &end) == got && *end == 0 && isfinite(got));
    LAW(strspn(copy, "0123456789.eE+-") == input_size);
    size_t n = number_print(out, got);
    LAW(number_parse((struct span){(unsigned char *)out, n}, &back));
    LAW(back == got && signbit(back) == signbit(got));
    return true;
}

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

// --- JSON -------------------------------------------------------------------

static const char *const json_texts[] = {
    "{\"ok\":true,\"tag\":\"7\",\"frame\":{\"id\":5,\"bytes\":99,\"stages\":"
    "{\"shade\":1.5},\"list\":[1,[2],{}]}}",
    "{\"ok\":false,\"error\":{\"code\":\"range\",\"text\":\"a \\\"b\\\" \\u20ac"
    "\\ud83d\\ude00\"}}",
    "[1,2,3]", "\"text\\n\"", "{}"};
static const char *const json_words[] = {
    "{",          "}",       "[",    "]",       "\"",   ",",
    ":",          "\\",      "\\u",  "\\ud83d", "null", "1e9",
    "\"frame\":", "{\"a\":", "[[[[", "}}}}",    "\x80"};

static bool law_find(void)
{
    static struct buf text;
    struct span all = given(), key, value, inner;
    size_t at = 0, steps = 0;
    uint64_t number;
    while (find_member(all, &at, &key, &value)) {
        LAW(within(key, all) && within(value, all) && ++steps <= input_size);
        buf_clear(&text);
        if (find_text(value, &text))
            for (size_t i = 0; i < text.size; i++)
                LAW(text.data[i] >= 0x20 && text.data[i] != 0x7f);
    }
    for (at = 0, steps = 0; find_item(all, &at, &value);)
        LAW(within(value, all) && ++steps <= input_size);
    if (find_key(all, "frame", &value))
        LAW(within(value, all) &&
            (!find_key(value, "stages", &inner) || within(inner, value)));
    (void)find_u64(all, "id", &number);
    (void)find_text(all, &text);
    return true;
}

// What json_span writes, find_text reads: where the text is valid and holds no
// control characters they are the same.
static bool law_json(void)
{
    static struct buf out, back;
    buf_clear(&out);
    buf_clear(&back);
    struct json j = json_begin(&out);
    json_span(&j, given());
    LAW(utf8_valid((struct span){out.data, out.size}));
    LAW(find_text((struct span){out.data, out.size}, &back));
    bool plain = utf8_valid(given());
    for (size_t i = 0; i < input_size; i++)
        plain = plain && input[i] >= 0x20 && input[i] != 0x7f;
    LAW(!plain ||
        (back.size == input_size &&
         (input_size == 0 || memcmp(back.data, input, input_size) == 0)));
    return true;
}

int main(void)
{
    const struct corpus lines = CORPUS(line_texts, line_words);
    const struct corpus streams = CORPUS(stream_texts, line_words);
    const struct corpus numbers = CORPUS(number_texts, number_words);
    const struct corpus heads = CORPUS(http_texts, http_words);
    const struct corpus frames = CORPUS(ws_texts, ws_words);
    const struct corpus json = CORPUS(json_texts, json_words);
    signal(SIGSEGV, crashed);
    signal(SIGABRT, crashed);
    run("fuzz: request lines", &lines, 300000, law_line);
    run("fuzz: edits", &lines, 60000, law_edit);
    run("fuzz: streams of lines, cut anywhere", &streams, 150000, law_stream);
    run("fuzz: numbers", &numbers, 150000, law_number);
    run("fuzz: request heads, cut anywhere", &heads, 20000, law_http);
    run("fuzz: damaged frames, cut anywhere", &frames, 150000, law_websocket);
    run_frames(8000);
    run("fuzz: looking values up in JSON", &json, 200000, law_find);
    run("fuzz: JSON texts written and read", &json, 100000, law_json);
    free(input);
    return check_end();
}
