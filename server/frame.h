// frame.h - the header line of a frame.  Its keys: protocol/PROTOCOL.md.
// Thread: loop.
#ifndef SERVER_FRAME_H
#define SERVER_FRAME_H

#include "protocol/bytes.h"
#include "protocol/json.h"
#include "server/session.h"
#include "server/studio.h"

struct frame_about { // what differs from client to client
    uint64_t id;
    int64_t queued_us;
    const struct session_mark *shown; // newest edit of this client in it
};

// Adds the key "frame" with its object.
void frame_put(struct json *j, const struct studio_frame *f,
               const struct frame_about *about);
// How wrong a picture is: an object, or null where that is not known.
void frame_put_error(struct json *j, const struct judge_verdict *v);
// Milliseconds with three decimals.
void frame_put_ms(struct json *j, const char *key, double ms);
// {"stage":ms,...} of those that ran.
void frame_put_stages(struct json *j, const double ms[RENDERER_STAGES]);

#endif
