// websocket.h - the server's side of WebSocket framing (RFC 6455): bytes of a
// client in, messages out; frame heads for what the server sends.
//
// One message is at most 64 KiB and 1024 fragments, refused from the header
// that exceeds it before a byte of its payload is kept.  No extensions.
// Thread: any; an object belongs to one thread at a time.
#ifndef PROTOCOL_WEBSOCKET_H
#define PROTOCOL_WEBSOCKET_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "protocol/bytes.h"

#define WEBSOCKET_MESSAGE_MAX 65536
#define WEBSOCKET_FRAGMENTS_MAX 1024
#define WEBSOCKET_HEAD_MAX 10 // of a frame that the server sends
#define WEBSOCKET_KEEP 4096   // buffer kept between messages, bytes

enum websocket_opcode {
    WEBSOCKET_OP_CONTINUE = 0,
    WEBSOCKET_OP_TEXT = 1,
    WEBSOCKET_OP_BINARY = 2,
    WEBSOCKET_OP_CLOSE = 8,
    WEBSOCKET_OP_PING = 9,
    WEBSOCKET_OP_PONG = 10
};

enum websocket_close { // codes sent or understood
    WEBSOCKET_NORMAL = 1000,
    WEBSOCKET_GOING_AWAY = 1001,
    WEBSOCKET_PROTOCOL = 1002,    // framing, mask, reserved bits, opcode
    WEBSOCKET_UNSUPPORTED = 1003, // binary while none is allowed
    WEBSOCKET_NO_CODE = 1005,     // never sent: a Close without a code came
    WEBSOCKET_BAD_TEXT = 1007,    // not UTF-8
    WEBSOCKET_POLICY = 1008,      // fragments, host, slowness
    WEBSOCKET_TOO_BIG = 1009,
    WEBSOCKET_FAILED = 1011,
    WEBSOCKET_TRY_LATER = 1013
};

enum websocket_event {
    WEBSOCKET_MORE,
    WEBSOCKET_TEXT,   // payload is a whole message, valid UTF-8
    WEBSOCKET_BINARY, // payload is a whole message
    WEBSOCKET_PING,   // answer with a pong of the same payload
    WEBSOCKET_PONG,
    WEBSOCKET_CLOSE, // payload is the reason, `code` the code: echo it, close
    WEBSOCKET_BAD    // send a close frame with `code`, then drop
};

struct websocket {       // set allow_binary at any time, read payload/code/why
    bool allow_binary;   // a binary message is welcome (an upload is open)
    struct span payload; // of the last event; valid until the next call
    int code;            // CLOSE and BAD: see enum websocket_close
    const char *why;     // BAD: a constant text

    // private
    int phase;
    unsigned char head[14], control[125];
    size_t head_have, head_need;
    unsigned char opcode, mask[4];
    bool fin, open, clear;
    unsigned char kind; // opcode of the open message
    int fragments;
    uint64_t left, at; // of the current frame's payload
    size_t control_have;
    struct buf message;
};

void websocket_init(struct websocket *w);
void websocket_finish(struct websocket *w);

// Takes bytes from `in` until an event; *used says how many.  Call again with
// the rest until WEBSOCKET_MORE, which has used all.  After WEBSOCKET_CLOSE and
// WEBSOCKET_BAD nothing more is to be read.
enum websocket_event websocket_read(struct websocket *w, struct span in,
                                    size_t *used);

// A frame head, unmasked, FIN set; returns its size.  The payload of `size`
// bytes follows, from wherever the caller has it.
size_t websocket_head(unsigned char out[WEBSOCKET_HEAD_MAX],
                      enum websocket_opcode opcode, uint64_t size);
// A whole frame.
void websocket_frame(struct buf *out, enum websocket_opcode opcode,
                     struct span payload);
// A close frame.  Code 0 or WEBSOCKET_NO_CODE: an empty one.  The reason (NULL:
// none) is cut to what a control frame holds.
void websocket_frame_close(struct buf *out, int code, const char *reason);

#endif
