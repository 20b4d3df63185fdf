// conn_ws.c - WebSocket: messages to requests, replies to messages, and the
// manners of opening, pinging and closing.
#include <stdlib.h>

#include "server/clock.h"
#include "server/conn_private.h"

void conn_ws_begin(struct conn *c)
{
    c->speech = CONN_WS;
    c->ws = bytes_zalloc(1, sizeof *c->ws);
    websocket_init(c->ws);
    conn_begin_session(c);
}

void conn_ws_finish(struct conn *c)
{
    if (c->ws)
        websocket_finish(c->ws);
    free(c->ws);
    c->ws = NULL;
}

static void send_control(struct conn *c, enum websocket_opcode op,
                         struct span payload)
{
    struct buf out = {0};
    websocket_frame(&out, op, payload);
    outbox_bytes(&c->out, out.data, out.size);
    buf_finish(&out);
}

static void send_close(struct conn *c, int code, const char *why)
{
    struct buf out = {0};
    websocket_frame_close(&out, code, why);
    outbox_bytes(&c->out, out.data, out.size);
    buf_finish(&out);
    c->ws_close_sent = true;
    c->closed_at = clock_us();
}

void conn_ws_close(struct conn *c, int code, const char *why)
{
    if (!c->ws_close_sent)
        send_close(c, code, why);
}

void conn_ws_ping(struct conn *c)
{
    c->ws_pinged = true;
    send_control(c, WEBSOCKET_OP_PING, (struct span){0});
}

void conn_ws_send_line(struct conn *c, struct span line)
{
    unsigned char head[WEBSOCKET_HEAD_MAX];
    if (c->ws_close_sent)
        return;
    size_t size = line.size - 1; // a message needs no line end
    outbox_bytes(&c->out, head, websocket_head(head, WEBSOCKET_OP_TEXT, size));
    outbox_bytes(&c->out, line.data, size);
}

void conn_ws_send_frame(struct conn *c, struct span header, struct blob *b)
{
    unsigned char head[WEBSOCKET_HEAD_MAX];
    if (c->ws_close_sent)
        return;
    outbox_bytes(
        &c->out, head,
        websocket_head(head, WEBSOCKET_OP_BINARY, header.size + b->size));
    outbox_bytes(&c->out, header.data, header.size);
    outbox_blob(&c->out, b);
}

static void request(struct conn *c, struct span text)
{
    session_request(&c->session, text);
    bool expelled = c->session.expelled;
    if (c->session.quit)
        conn_ws_close(c, expelled ? WEBSOCKET_POLICY : WEBSOCKET_NORMAL, NULL);
}

// At most one pong waits: a peer that does not read cannot fill our memory
// with pings.
static void answer_ping(struct conn *c, struct span payload)
{
    if (c->out.replies < CONN_REPLIES_MAX) {
        send_control(c, WEBSOCKET_OP_PONG, payload);
        return;
    }
    buf_clear(&c->pong);
    buf_append(&c->pong, payload.data, payload.size);
    c->pong_waits = true;
}

static void event(struct conn *c, enum websocket_event e)
{
    struct websocket *w = c->ws;
    switch (e) {
    case WEBSOCKET_TEXT:
        if (c->ws_close_sent)
            return;
        if (conn_paused(c)) {
            buf_append(&c->held, w->payload.data, w->payload.size);
            c->has_held = true;
        } else {
            request(c, w->payload);
        }
        return;
    case WEBSOCKET_PING:
        if (!c->ws_close_sent)
            answer_ping(c, w->payload);
        return;
    case WEBSOCKET_CLOSE:
        conn_ws_close(c, w->code, NULL);
        conn_finish(c);
        return;
    case WEBSOCKET_BINARY: // none is allowed: reported as BAD
    case WEBSOCKET_BAD:
        conn_ws_close(c, e == WEBSOCKET_BAD ? w->code : WEBSOCKET_UNSUPPORTED,
                      w->why);
        conn_finish(c);
        return;
    case WEBSOCKET_PONG:
    case WEBSOCKET_MORE:
        return;
    }
}

static void release_held(struct conn *c)
{
    struct buf text = c->held;
    c->held = (struct buf){0};
    c->has_held = false;
    request(c, (struct span){text.data, text.size});
    buf_finish(&text);
}

void conn_ws_work(struct conn *c)
{
    size_t done = 0;
    if (c->pong_waits && c->out.replies < CONN_REPLIES_MAX) {
        send_control(c, WEBSOCKET_OP_PONG,
                     (struct span){c->pong.data, c->pong.size});
        c->pong_waits = false;
    }
    while (!c->closing && !c->dead) {
        if (c->has_held) {
            if (conn_paused(c))
                break;
            release_held(c);
            continue;
        }
        size_t used = 0;
        struct span in = {c->in.data + done, c->in.size - done};
        enum websocket_event e = websocket_read(c->ws, in, &used);
        done += used;
        event(c, e);
        if (e == WEBSOCKET_MORE)
            break;
    }
    if (!c->closing)
        buf_drop(&c->in, done);
}
