// test_websocket.c - frames of a client: messages, control frames, every
// refusal with its close code, and streams cut at every byte.
#include <stdlib.h>
#include <string.h>

#include "protocol/websocket.h"
#include "tests/check.h"

// One frame as a client sends it.  `first` is FIN, reserved bits and opcode.
static void frame_n(struct buf *out, int first, const void *data, size_t size)
{
    static const unsigned char mask[4] = {0x12, 0xe4, 0x00, 0x7f};
    buf_byte(out, (unsigned char)first);
    int bytes = size < 126 ? 0 : size < 65536 ? 2 : 8;
    buf_byte(out, (unsigned char)(0x80 | (bytes == 0   ? (int)size
                                          : bytes == 2 ? 126
                                                       : 127)));
    for (int i = bytes - 1; i >= 0; i--)
        buf_byte(out, (unsigned char)(size >> (8 * i)));
    buf_append(out, mask, 4);
    for (size_t i = 0; i < size; i++)
        buf_byte(out, ((const unsigned char *)data)[i] ^ mask[i & 3]);
}

static void frame(struct buf *out, int first, const char *text)
{
    frame_n(out, first, text, strlen(text));
}

static const char letters[] = "-TBiocX"; // by enum websocket_event

// Reads `in` in pieces of at most `piece` bytes; what happened as text:
// "T(hello)" a text, B binary, i ping, o pong, c(code,reason), X(code).
static void run(struct span in, size_t piece, bool binary, struct buf *out)
{
    struct websocket w;
    websocket_init(&w);
    w.allow_binary = binary;
    buf_clear(out);
    size_t at = 0;
    while (at < in.size) {
        size_t size = in.size - at < piece ? in.size - at : piece, used = 0;
        // A copy, so that reading beyond the piece shows.
        unsigned char *copy = bytes_alloc(size);
        memcpy(copy, in.data + at, size);
        enum websocket_event e =
            websocket_read(&w, (struct span){copy, size}, &used);
        free(copy);
        at += used;
        if (used > size || (e == WEBSOCKET_MORE && used != size))
            buf_text(out, "?used");
        if (e == WEBSOCKET_MORE)
            continue;
        buf_printf(out, "%c(", letters[e]);
        if (e == WEBSOCKET_CLOSE || e == WEBSOCKET_BAD)
            buf_printf(out, "%d,", w.code);
        buf_append(out, w.payload.data, w.payload.size);
        buf_byte(out, ')');
        if (e == WEBSOCKET_CLOSE || e == WEBSOCKET_BAD)
            break;
    }
    buf_byte(out, 0);
    websocket_finish(&w);
}

// Whole, in halves, and byte by byte: the same story.
static void expect_with(struct buf *in, bool binary, const char *want)
{
    struct buf out = {0};
    struct span all = {in->data, in->size};
    size_t step = in->size > 4096 ? 1000 : 1;
    for (size_t piece = 1; piece <= in->size; piece += step) {
        run(all, piece, binary, &out);
        if (strcmp((char *)out.data, want) != 0) {
            CHECK_STR((char *)out.data, want);
            break;
        }
    }
    run(all, in->size, binary, &out);
    CHECK_STR((char *)out.data, want);
    buf_finish(&out);
    buf_clear(in);
}

static void expect(struct buf *in, const char *want)
{
    expect_with(in, false, want);
}

enum { FIN = 0x80 };

static void test_messages(void)
{
    struct buf b = {0};
    check_case("websocket: messages, whole and in fragments");
    frame(&b, FIN | 1, "hello");
    frame(&b, FIN | 1, "");
    frame(&b, 1, "a");
    frame(&b, 0, "");
    frame(&b, 0, "b");
    frame(&b, FIN | 0, "c");
    frame(&b, FIN | 1, "\xe2\x82\xac");
    expect(&b, "T(hello)T()T(abc)T(\xe2\x82\xac)");
    check_case("websocket: control frames between fragments");
    frame(&b, 1, "a");
    frame(&b, FIN | 9, "p");
    frame(&b, FIN | 10, "");
    frame(&b, FIN | 0, "b");
    frame(&b, FIN | 9, "");
    expect(&b, "i(p)o()T(ab)i()");
    check_case("websocket: a character may be cut by a fragment");
    frame(&b, 1, "\xe2");
    frame(&b, FIN | 0, "\x82\xac");
    expect(&b, "T(\xe2\x82\xac)");
    check_case("websocket: binary only where it is allowed");
    frame(&b, FIN | 2, "\x80\xff");
    expect_with(&b, true, "B(\x80\xff)");
    frame(&b, FIN | 2, "x");
    expect(&b, "X(1003,)");
    buf_finish(&b);
}

static void test_refused(void)
{
    static const struct {
        int first;
        const char *want;
    } cases[] = {
        {FIN | 0x41, "X(1002,)"}, {FIN | 0x21, "X(1002,)"},
        {FIN | 0x11, "X(1002,)"}, {FIN | 3, "X(1002,)"},
        {FIN | 7, "X(1002,)"},    {FIN | 11, "X(1002,)"},
        {FIN | 15, "X(1002,)"},   {9, "X(1002,)"}, // fragmented control
        {8, "X(1002,)"},          {10, "X(1002,)"},
        {FIN | 0, "X(1002,)"},    {0, "X(1002,)"}, // nothing to continue
    };
    struct buf b = {0};
    check_case("websocket: reserved bits, opcodes, fragments of nothing");
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        frame(&b, cases[i].first, "x");
        expect(&b, cases[i].want);
    }
    check_case("websocket: a message inside a message");
    frame(&b, 1, "a");
    frame(&b, FIN | 1, "b");
    expect(&b, "X(1002,)");
    check_case("websocket: an unmasked frame");
    buf_append(&b, "\x81\x01x", 3);
    expect(&b, "X(1002,)");
    check_case("websocket: bad UTF-8, also when a message ends too early");
    frame(&b, FIN | 1, "a\x80");
    expect(&b, "X(1007,)");
    frame(&b, 1, "\xe2");
    frame(&b, FIN | 0, "\x82");
    expect(&b, "X(1007,)");
    check_case("websocket: lengths not in their shortest form");
    buf_append(&b, "\x81\xfe\x00\x7d\x00\x00\x00\x00", 8);
    expect(&b, "X(1002,)");
    buf_append(&b, "\x81\xff\x00\x00\x00\x00\x00\x00\xff\xff\x00\x00\x00\x00",
               14);
    expect(&b, "X(1002,)");
    buf_append(&b, "\x81\xff\x80\x00\x00\x00\x00\x00\x00\x01\x00\x00\x00\x00",
               14);
    expect(&b, "X(1002,)");
    check_case("websocket: what follows a refusal is not looked at");
    frame(&b, FIN | 3, "x");
    frame(&b, FIN | 1, "y");
    expect(&b, "X(1002,)");
    buf_finish(&b);
}

static void test_control(void)
{
    char data[126];
    struct buf b = {0};
    memset(data, 'p', sizeof data);
    check_case("websocket: control frames at and above 125 bytes");
    frame_n(&b, FIN | 9, data, 125);
    struct buf want = {0};
    buf_text(&want, "i(");
    buf_append(&want, data, 125);
    buf_append(&want, ")", 2);
    expect(&b, (char *)want.data);
    frame_n(&b, FIN | 9, data, 126);
    expect(&b, "X(1002,)");
    buf_finish(&want);
    buf_finish(&b);
}

static void test_close(void)
{
    static const struct {
        int code;
        bool legal;
    } codes[] = {{999, false},  {1000, true},  {1003, true},   {1004, false},
                 {1005, false}, {1006, false}, {1007, true},   {1014, true},
                 {1015, false}, {1016, false}, {2999, false},  {3000, true},
                 {4999, true},  {5000, false}, {65535, false}, {0, false}};
    struct buf b = {0};
    check_case("websocket: close frames");
    frame(&b, FIN | 8, "");
    expect(&b, "c(1005,)");
    frame_n(&b, FIN | 8, "\x03\xe9gone", 6);
    expect(&b, "c(1001,gone)");
    frame(&b, FIN | 8, "\x03");
    expect(&b, "X(1002,)");
    frame_n(&b, FIN | 8, "\x03\xe9\x80", 3);
    expect(&b, "X(1007,)");
    frame(&b, FIN | 8, "");
    frame(&b, FIN | 1, "late");
    expect(&b, "c(1005,)");
    for (size_t i = 0; i < sizeof codes / sizeof *codes; i++) {
        unsigned char code[2] = {(unsigned char)(codes[i].code >> 8),
                                 (unsigned char)codes[i].code};
        char want[32];
        frame_n(&b, FIN | 8, code, 2);
        snprintf(want, sizeof want, codes[i].legal ? "c(%d,)" : "X(1002,)",
                 codes[i].code);
        expect(&b, want);
    }
    buf_finish(&b);
}

static void test_limits(void)
{
    struct websocket w;
    size_t used = 0;
    struct buf b = {0}, all = {0};
    memset(buf_grow(&all, WEBSOCKET_MESSAGE_MAX), 'm', WEBSOCKET_MESSAGE_MAX);
    check_case("websocket: the largest message, whole and in two pieces");
    websocket_init(&w);
    frame_n(&b, FIN | 1, all.data, WEBSOCKET_MESSAGE_MAX);
    frame_n(&b, 1, all.data, 65535);
    frame_n(&b, FIN | 0, all.data, 1);
    size_t at = 0;
    for (int i = 0; i < 2; i++) {
        CHECK(websocket_read(&w, (struct span){b.data + at, b.size - at},
                             &used) == WEBSOCKET_TEXT);
        CHECK(w.payload.size == WEBSOCKET_MESSAGE_MAX);
        at += used;
    }
    CHECK(at == b.size);
    // What a large message took is given back with the next call.
    CHECK(websocket_read(&w, (struct span){NULL, 0}, &used) == WEBSOCKET_MORE);
    CHECK(w.message.cap <= WEBSOCKET_KEEP);
    websocket_finish(&w);
    check_case("websocket: one byte more is refused from the header alone");
    buf_clear(&b);
    buf_append(&b, "\x81\xff\x00\x00\x00\x00\x00\x01\x00\x01mask", 14);
    expect(&b, "X(1009,)");
    buf_append(&b, "\x81\xff\x7f\xff\xff\xff\xff\xff\xff\xffmask", 14);
    expect(&b, "X(1009,)");
    frame_n(&b, 1, all.data, 65535);
    buf_append(&b, "\x80\x82mask", 6);
    expect(&b, "X(1009,)");
    buf_finish(&all);
    check_case("websocket: fragments at and above their number");
    for (int extra = 0; extra < 2; extra++) {
        frame(&b, 1, "");
        for (int i = 2; i < WEBSOCKET_FRAGMENTS_MAX + extra; i++)
            frame(&b, 0, "");
        frame(&b, FIN | 0, "e");
        expect(&b, extra ? "X(1008,)" : "T(e)");
    }
    buf_finish(&b);
}

static void test_frames(void)
{
    static const struct {
        uint64_t size;
        const char *head;
        size_t bytes;
    } cases[] = {
        {0, "\x82\x00", 2},
        {125, "\x82\x7d", 2},
        {126, "\x82\x7e\x00\x7e", 4},
        {65535, "\x82\x7e\xff\xff", 4},
        {65536, "\x82\x7f\x00\x00\x00\x00\x00\x01\x00\x00", 10},
        {UINT64_C(0x123456789a), "\x82\x7f\x00\x00\x00\x12\x34\x56\x78\x9a",
         10},
    };
    unsigned char head[WEBSOCKET_HEAD_MAX];
    struct buf b = {0};
    check_case("websocket: frames of the server");
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        size_t n = websocket_head(head, WEBSOCKET_OP_BINARY, cases[i].size);
        CHECK(n == cases[i].bytes && memcmp(head, cases[i].head, n) == 0);
    }
    websocket_frame(&b, WEBSOCKET_OP_PONG, (struct span){head, 0});
    websocket_frame(&b, WEBSOCKET_OP_TEXT,
                    (struct span){(const unsigned char *)"hi", 2});
    websocket_frame_close(&b, 0, "unsaid");
    websocket_frame_close(&b, WEBSOCKET_NO_CODE, NULL);
    websocket_frame_close(&b, 1001, NULL);
    websocket_frame_close(&b, 1008, "slow");
    static const char want[] = "\x8a\x00\x81\x02hi\x88\x00\x88\x00"
                               "\x88\x02\x03\xe9\x88\x06\x03\xf0slow";
    CHECK(b.size == sizeof want - 1 && memcmp(b.data, want, b.size) == 0);
    buf_clear(&b);
    char reason[200];
    memset(reason, 'r', sizeof reason);
    memcpy(reason + 122, "\xe2\x82\xac", 4); // would be cut in its middle
    websocket_frame_close(&b, 1011, reason);
    CHECK(b.size == 2 + 2 + 122 && b.data[1] == 124);
    buf_finish(&b);
}

int main(void)
{
    test_messages();
    test_refused();
    test_control();
    test_close();
    test_limits();
    test_frames();
    return check_end();
}
