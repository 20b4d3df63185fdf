// session.h - one client that speaks the protocol, whatever carries its bytes:
// requests in, replies and frames out, in order.
//
// While a request waits for the render thread (capture, hair, env) the session
// is busy and takes no further one: so replies come in order, and a request
// sees what those before it did.
// Thread: loop.
#ifndef SERVER_SESSION_H
#define SERVER_SESSION_H

#include <stdbool.h>
#include <stdint.h>

#include "protocol/bytes.h"
#include "protocol/error.h"
#include "server/loop.h"
#include "server/still.h"
#include "server/studio.h"

enum { SESSION_WINDOW_MAX = 8, SESSION_MARKS = 256, SESSION_ECHO_MAX = 64 };

struct session;
struct hub;

struct session_out { // what carries the bytes
    // One reply or notice, JSON with its "\n".
    void (*line)(struct session *s, struct span line);
    // A header line with its "\n", then the blob.
    void (*frame)(struct session *s, struct span header, struct blob *b);
    // Can it take a stream's frame without queueing it behind another?
    bool (*ready)(const struct session *s);
    // Not busy any more: the next request may come (not called from within
    // session_request).
    void (*resume)(struct session *s);
};

struct session_mark { // an edit of this client that no frame showed yet
    uint64_t revision, seq;
    bool has_seq;
    char echo[SESSION_ECHO_MAX + 1]; // "" none
};

enum session_wait {
    SESSION_FREE,
    SESSION_REVISION, // a capture waits for a revision to be made
    SESSION_CAPTURE,
    SESSION_LOAD
};

struct session {
    struct hub *hub;
    const struct session_out *out;
    struct session *next, *previous; // in the hub
    bool allowed;                    // no token needed, or it was given
    bool quit;     // the carrier closes once the replies are out
    bool expelled; // and not because it asked for it
    // Streaming
    bool streaming;
    bool own_format;           // else output.format of the state
    struct still_encoding how; // quality 0: automatic
    int window, unacked;
    uint64_t unacked_id[SESSION_WINDOW_MAX]; // oldest first
    uint64_t newest_id;                      // of the frames sent
    uint64_t sent_serial;                    // newest frame sent (hub)
    struct session_mark *marks;              // SESSION_MARKS, or NULL
    int mark_count;
    struct session_mark shown; // newest edit that was shown
    // Waiting
    enum session_wait wait;
    uint64_t job;
    uint64_t wanted_revision;
    struct loop_timer patience;
    struct still_encoding capture_how;
    int capture_width, capture_height;
    char *tag; // of the waiting request; NULL: none
};

// s: zero-initialised.  allowed: no token is asked for.
void session_open(struct session *s, struct hub *h,
                  const struct session_out *out, bool allowed);
void session_close(struct session *s); // what it waits for is cancelled

// One request line, without its end.  Not while it is busy.
void session_request(struct session *s, struct span line);
bool session_busy(const struct session *s);

// From the hub:
bool session_has_credit(const struct session *s);
struct still_encoding session_encoding(const struct session *s);
void session_send_frame(struct session *s, const struct studio_frame *f,
                        uint64_t serial);
// The revision that the session waits for may have come.
void session_revision(struct session *s);
struct engine_event;
void session_event(struct session *s, const struct engine_event *event);

// For commands.c and its kin: replies, and the end of waiting.
void session_refuse(struct session *s, struct span tag,
                    const struct error *err);
void session_begin_wait(struct session *s, struct span tag,
                        enum session_wait wait);
void session_remember_edit(struct session *s, const struct session_mark *m);
// All frames up to `id` were received.
bool session_ack(struct session *s, uint64_t id, struct error *err);
void session_start_capture(struct session *s);

#endif
