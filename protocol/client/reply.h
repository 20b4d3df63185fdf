// reply.h - what a line of the daemon is, and the exchange of one request.
// Thread: main.
#ifndef PROTOCOL_CLIENT_REPLY_H
#define PROTOCOL_CLIENT_REPLY_H

#include <stdbool.h>
#include <stdint.h>

#include "protocol/bytes.h"
#include "protocol/client/wire.h"
#include "protocol/error.h"

struct reply_frame { // of a frame's header; spans point into the line
    struct span all; // the whole object
    char format[8];  // "jpeg", "png", "exr"
    char level[8];   // "draft", "full", "final"
    uint64_t id, revision, bytes, width, height, samples;
    double render_ms, encode_ms;
};

struct reply {
    struct span line;
    bool answers; // it is the reply to a request (has "ok")
    bool ok;
    bool has_frame; // frame.bytes bytes follow the line
    struct reply_frame frame;
    bool is_event; // a notice that answers no request
};

// Takes a line apart; the reply points into it.  False: it is none of these.
bool reply_read(struct reply *r, struct span line, struct error *err);

// What a refusing reply, or a notice of a failure, says.  Always false.
bool reply_refusal(const struct reply *r, struct error *err);

// Sends a request that request_end closed and waits for its reply.  Frames and
// notices that come before it are dropped.  False when it was refused too.
bool reply_ask(struct wire *w, const struct buf *request, struct reply *r,
               struct error *err);

// "exr", "png", "jpg" for the end of a file's name.
const char *reply_extension(const struct reply_frame *f);

#endif
