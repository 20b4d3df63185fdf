// conn_private.h - shared by conn.c and the speeches conn_line.c, conn_http.c
// and conn_ws.c.
// Thread: loop.
#ifndef SERVER_CONN_PRIVATE_H
#define SERVER_CONN_PRIVATE_H

#include <stdbool.h>
#include <stdint.h>

#include "protocol/bytes.h"
#include "protocol/websocket.h"
#include "server/conn.h"
#include "server/outbox.h"
#include "server/service.h"
#include "server/session.h"

enum {
    CONN_READ = 16384,           // bytes of one read
    CONN_IN_MAX = 65536 + 16384, // unread requests, bytes
    CONN_REPLIES_MAX = 65536,    // beyond it no further request is taken
    CONN_SILENT_S = 60,          // before a first byte
    CONN_HEAD_S = 10,            // from a head's first byte to its last
    CONN_IDLE_S = 15,            // between two HTTP requests
    CONN_REQUESTS_MAX = 100,     // HTTP requests of one connection
    CONN_PING_S = 30,
    CONN_DEAD_S = 60,
    CONN_CLOSE_S = 2,    // for the peer's close frame
    CONN_STALLED_S = 10, // data waits and the socket takes none
    CONN_LINGER_MS = 1000,
    CONN_LINGER_MAX = 65536 // bytes thrown away
};

enum conn_speech { CONN_UNKNOWN, CONN_LINE, CONN_HTTP, CONN_WS };

struct conn {
    struct service *service;
    struct conn *next, *previous;
    struct loop_source source;
    struct loop_timer timer;
    bool trusted;
    bool over;       // beyond the limit of connections: refused politely
    bool dead;       // to be destroyed by its timer
    bool closing;    // takes no more requests; closes once all is written
    bool lingering;  // all written and shut; what still comes is dropped
    bool read_ended; // the peer sends no more
    bool corked;     // requests are being worked through; flush comes after
    enum conn_speech speech;
    struct buf in;
    size_t scanned; // line_cut's memory
    size_t dropped; // while lingering
    struct outbox out;
    int64_t opened, first_byte, last_read, progress, closed_at; // microseconds
    int requests;                                               // HTTP
    bool open_session;
    struct session session;
    struct websocket *ws; // CONN_WS only
    struct buf held;      // a message that waits for the session
    bool has_held, ws_close_sent, ws_pinged;
    bool pong_waits; // the newest ping, not yet answered
    struct buf pong;
};

// Each works on c->in until it needs more bytes, or the connection pauses.
void conn_line_work(struct conn *c);
void conn_http_work(struct conn *c);
void conn_ws_work(struct conn *c);

// The head asked for an upgrade that was granted.
void conn_ws_begin(struct conn *c);
void conn_ws_finish(struct conn *c);
void conn_ws_close(struct conn *c, int code, const char *why);
void conn_ws_ping(struct conn *c);
// The carrier's part of a session over WebSocket.
void conn_ws_send_line(struct conn *c, struct span line);
void conn_ws_send_frame(struct conn *c, struct span header, struct blob *b);
// 408, for a head that does not end.
void conn_http_late(struct conn *c);

void conn_begin_session(struct conn *c);
// No further request: close once everything is written.
void conn_finish(struct conn *c);
// Requests wait until replies were written or the session is free.
bool conn_paused(const struct conn *c);

#endif
