// conn.c - the socket, its buffers and its deadlines.  What the bytes mean is
// in conn_line.c, conn_http.c and conn_ws.c.
#include "server/conn.h"

#include <errno.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <stdlib.h>
#include <sys/socket.h>
#include <unistd.h>

#include "protocol/line.h"
#include "server/clock.h"
#include "server/conn_private.h"

#define SECONDS(n) ((int64_t)(n)*1000000)

static void work(struct conn *c);
static void flush(struct conn *c);

// --- the session's carrier --------------------------------------------------
static struct conn *of_session(const struct session *s)
{
    return (struct conn *)((char *)(uintptr_t)s -
                           offsetof(struct conn, session));
}

static void carry_line(struct session *s, struct span line)
{
    struct conn *c = of_session(s);
    if (c->speech == CONN_WS)
        conn_ws_send_line(c, line);
    else
        outbox_bytes(&c->out, line.data, line.size);
    flush(c);
}

static void carry_frame(struct session *s, struct span header, struct blob *b)
{
    struct conn *c = of_session(s);
    if (c->speech == CONN_WS) {
        conn_ws_send_frame(c, header, b);
    } else {
        outbox_bytes(&c->out, header.data, header.size);
        outbox_blob(&c->out, b);
    }
    flush(c);
}

static bool carry_ready(const struct session *s)
{
    const struct conn *c = of_session(s);
    return !c->dead && !c->closing && c->out.blobs == 0;
}

static void carry_resume(struct session *s)
{
    work(of_session(s));
}

static const struct session_out carrier = {carry_line, carry_frame, carry_ready,
                                           carry_resume};

void conn_begin_session(struct conn *c)
{
    session_open(&c->session, c->service->hub, &carrier,
                 c->trusted || !c->service->hub->token);
    c->open_session = true;
}

// --- deadlines --------------------------------------------------------------
static void earlier(int64_t *at, int64_t other)
{
    if (other < *at)
        *at = other;
}

static int64_t speech_deadline(const struct conn *c)
{
    switch (c->speech) {
    case CONN_UNKNOWN:
        return c->in.size > 0 ? c->first_byte + SECONDS(CONN_HEAD_S)
                              : c->opened + SECONDS(CONN_SILENT_S);
    case CONN_HTTP:
        if (!outbox_empty(&c->out))
            return INT64_MAX; // it is busy reading; see CONN_STALLED_S
        return c->in.size > 0 ? c->first_byte + SECONDS(CONN_HEAD_S)
                              : c->last_read + SECONDS(CONN_IDLE_S);
    case CONN_WS:
        if (c->ws_close_sent)
            return c->closed_at + SECONDS(CONN_CLOSE_S);
        if (conn_paused(c))
            return INT64_MAX; // we do not listen, so silence says nothing
        return c->last_read + SECONDS(c->ws_pinged ? CONN_DEAD_S : CONN_PING_S);
    case CONN_LINE:
        break;
    }
    return INT64_MAX;
}

static void rearm(struct conn *c)
{
    int64_t at = INT64_MAX;
    if (c->dead)
        at = 0;
    else if (c->lingering)
        at = c->closed_at + (int64_t)CONN_LINGER_MS * 1000;
    else if (!outbox_empty(&c->out))
        at = c->progress + SECONDS(CONN_STALLED_S);
    if (!c->dead && !c->lingering && !c->closing)
        earlier(&at, speech_deadline(c));
    if (at == INT64_MAX)
        loop_timer_clear(c->service->loop, &c->timer);
    else
        loop_timer_set(c->service->loop, &c->timer, at);
}

static void kill_soon(struct conn *c)
{
    if (c->dead)
        return;
    c->dead = true;
    loop_unwatch(c->service->loop, &c->source);
    rearm(c);
}

static void speech_late(struct conn *c)
{
    if (c->speech == CONN_WS && !c->ws_pinged && !c->ws_close_sent)
        conn_ws_ping(c);
    else if (c->speech != CONN_WS && c->in.size > 0)
        conn_http_late(c);
    else
        kill_soon(c);
}

static void timer_fire(struct loop_timer *t)
{
    struct conn *c = (struct conn *)((char *)t - offsetof(struct conn, timer));
    int64_t now = clock_us();
    if (c->dead || c->lingering) {
        conn_destroy(c);
        return;
    }
    if (!outbox_empty(&c->out) && now >= c->progress + SECONDS(CONN_STALLED_S))
        kill_soon(c);
    else if (!c->closing && now >= speech_deadline(c))
        speech_late(c);
    flush(c);
}

// --- writing ----------------------------------------------------------------
static void watch(struct conn *c)
{
    uint32_t events = 0;
    bool room = c->lingering || (!c->closing && c->in.size < CONN_IN_MAX);
    if (!c->read_ended && room)
        events |= EPOLLIN;
    if (!outbox_empty(&c->out))
        events |= EPOLLOUT;
    loop_change(c->service->loop, &c->source, events);
}

static void linger(struct conn *c)
{
    // Closing with unread bytes would reset the connection and might destroy
    // what the peer has not read yet.
    c->lingering = true;
    c->closed_at = clock_us();
    shutdown(c->source.fd, SHUT_WR);
    if (c->read_ended)
        kill_soon(c);
}

static void flush(struct conn *c)
{
    if (c->corked || c->dead)
        return;
    size_t wrote = 0;
    enum outbox_result result = outbox_write(&c->out, c->source.fd, &wrote);
    if (wrote > 0)
        c->progress = clock_us();
    if (result == OUTBOX_BROKEN)
        kill_soon(c);
    else if (result == OUTBOX_DONE && c->closing && !c->lingering)
        linger(c);
    if (c->dead)
        return;
    watch(c);
    rearm(c);
}

void conn_finish(struct conn *c)
{
    c->closing = true;
    c->closed_at = clock_us();
    buf_finish(&c->in);
}

bool conn_paused(const struct conn *c)
{
    return c->closing || c->dead || c->out.replies >= CONN_REPLIES_MAX ||
           (c->open_session && session_busy(&c->session));
}

// --- reading ----------------------------------------------------------------
static void tell(struct conn *c)
{
    struct span first = {c->in.data, c->in.size};
    switch (line_looks_http(first)) {
    case LINE_MORE:
        return;
    case LINE_ONE:
        c->speech = CONN_HTTP;
        return;
    case LINE_BAD:
        c->speech = CONN_LINE;
        if (!c->over)
            conn_begin_session(c);
        return;
    }
}

// Takes requests until there is none, or the connection pauses.
static void take_requests(struct conn *c)
{
    c->corked = true;
    if (c->speech == CONN_UNKNOWN && c->in.size > 0)
        tell(c);
    if (c->speech == CONN_HTTP)
        conn_http_work(c);
    if (c->speech == CONN_LINE)
        conn_line_work(c);
    if (c->speech == CONN_WS)
        conn_ws_work(c);
    if (c->in.size == 0)
        buf_finish(&c->in); // an idle client keeps no buffer
    if (c->read_ended && !conn_paused(c))
        conn_finish(c);
    c->corked = false;
}

static void work(struct conn *c)
{
    bool again = !c->corked && !c->dead;
    while (again) {
        take_requests(c);
        // Paused by its replies, and those could be written at once?
        bool full = c->out.replies >= CONN_REPLIES_MAX;
        flush(c);
        again = full && !conn_paused(c);
    }
}

static void drop_input(struct conn *c)
{
    unsigned char scrap[CONN_READ];
    ssize_t n = recv(c->source.fd, scrap, sizeof scrap, MSG_DONTWAIT);
    if (n > 0)
        c->dropped += (size_t)n;
    bool again = n < 0 && (errno == EAGAIN || errno == EINTR);
    if (!again && (n <= 0 || c->dropped > CONN_LINGER_MAX))
        kill_soon(c);
}

static void read_some(struct conn *c)
{
    size_t room = CONN_IN_MAX - c->in.size;
    if (room == 0)
        return;
    buf_reserve(&c->in, CONN_READ);
    ssize_t n = recv(c->source.fd, c->in.data + c->in.size,
                     room < CONN_READ ? room : CONN_READ, MSG_DONTWAIT);
    if (n > 0) {
        if (c->in.size == 0)
            c->first_byte = clock_us();
        c->in.size += (size_t)n;
        c->last_read = clock_us();
        c->ws_pinged = false;
    } else if (n == 0) {
        c->read_ended = true;
    } else if (errno != EAGAIN && errno != EINTR) {
        kill_soon(c);
    }
}

static void ready(struct loop_source *source, uint32_t events)
{
    struct conn *c =
        (struct conn *)((char *)source - offsetof(struct conn, source));
    bool had_blobs = c->out.blobs > 0;
    if (events & EPOLLIN) {
        if (c->lingering)
            drop_input(c);
        else
            read_some(c);
    } else if (events & (EPOLLERR | EPOLLHUP)) {
        kill_soon(c);
    }
    flush(c);
    work(c);
    // A frame went out: there may be room for the next.
    if (had_blobs && c->out.blobs == 0 && c->open_session &&
        c->session.streaming)
        hub_serve(c->service->hub);
}

// --- life -------------------------------------------------------------------
void conn_open(struct service *s, int fd, bool trusted)
{
    struct conn *c = bytes_zalloc(1, sizeof *c);
    int one = 1, unsent = 128 << 10;
    // Both fail on a Unix socket, where they are not needed.
    setsockopt(fd, IPPROTO_TCP, TCP_NODELAY, &one, sizeof one);
    setsockopt(fd, IPPROTO_TCP, TCP_NOTSENT_LOWAT, &unsent, sizeof unsent);
    setsockopt(fd, SOL_SOCKET, SO_KEEPALIVE, &one, sizeof one);
    c->service = s;
    c->trusted = trusted;
    c->over = s->connections >= s->connections_max;
    c->source = (struct loop_source){.fd = fd, .ready = ready};
    c->timer.fire = timer_fire;
    c->opened = c->last_read = c->progress = clock_us();
    c->next = s->conns;
    if (s->conns)
        s->conns->previous = c;
    s->conns = c;
    s->connections++;
    s->hub->connections = s->connections;
    if (loop_watch(s->loop, &c->source, EPOLLIN))
        rearm(c);
    else
        kill_soon(c);
}

struct conn *conn_next(const struct conn *c)
{
    return c->next;
}

void conn_good_bye(struct conn *c)
{
    if (c->dead || c->closing)
        return;
    if (c->speech == CONN_WS)
        conn_ws_close(c, WEBSOCKET_GOING_AWAY, "the server ends");
    else
        conn_finish(c);
    flush(c);
}

void conn_destroy(struct conn *c)
{
    struct service *s = c->service;
    c->dead = true;
    c->corked = true; // what closing the session sends goes nowhere
    loop_unwatch(s->loop, &c->source);
    loop_timer_clear(s->loop, &c->timer);
    if (c->open_session)
        session_close(&c->session);
    conn_ws_finish(c);
    outbox_finish(&c->out);
    buf_finish(&c->in);
    buf_finish(&c->held);
    buf_finish(&c->pong);
    close(c->source.fd);
    if (c->previous)
        c->previous->next = c->next;
    else
        s->conns = c->next;
    if (c->next)
        c->next->previous = c->previous;
    s->connections--;
    s->hub->connections = s->connections;
    free(c);
    if (s->stopping && !s->conns)
        loop_stop(s->loop);
}
