// conn_http.c - the page's files and the door to WebSocket.
#include <stdio.h>
#include <string.h>

#include "protocol/http.h"
#include "server/clock.h"
#include "server/conn_private.h"
#include "server/pages.h"

static void refuse(struct conn *c, int status, const char *text, bool head_only)
{
    struct buf out = {0};
    http_respond_error(&out, status, text, head_only);
    outbox_bytes(&c->out, out.data, out.size);
    buf_finish(&out);
    conn_finish(c);
}

void conn_http_late(struct conn *c)
{
    refuse(c, 408, "the request did not end in time", false);
}

static void answer_page(struct conn *c, const struct http_request *r,
                        bool head_only)
{
    char path[256];
    struct span body;
    const char *type;
    bool keep = r->keep_alive && c->requests < CONN_REQUESTS_MAX;
    bool fits =
        r->path.size < sizeof path && !memchr(r->path.data, 0, r->path.size);
    if (fits) {
        memcpy(path, r->path.data, r->path.size);
        path[r->path.size] = 0;
    }
    if (!fits || !pages_find(path, &body, &type)) {
        refuse(c, 404, "there is no such page", head_only);
        return;
    }
    struct buf out = {0};
    struct http_response answer = {
        .status = 200, .type = type, .length = body.size, .keep_alive = keep};
    http_respond(&out, &answer);
    outbox_bytes(&c->out, out.data, out.size);
    if (!head_only)
        outbox_bytes(&c->out, body.data, body.size);
    buf_finish(&out);
    if (!keep)
        conn_finish(c);
}

static bool origin_allowed(const struct conn *c, const struct http_request *r)
{
    bool absent;
    return http_origin_allowed(r, (const char *const *)c->service->origins,
                               &absent) ||
           absent;
}

static void answer_socket(struct conn *c, const struct http_request *r)
{
    struct span key;
    int status = http_upgrade(r, &key);
    if (status == 0)
        refuse(c, 426, "this path is for WebSocket", false);
    else if (status != 101)
        refuse(c, status, "not a good WebSocket upgrade", false);
    else {
        struct buf out = {0};
        http_respond_upgrade(&out, key);
        outbox_bytes(&c->out, out.data, out.size);
        buf_finish(&out);
        conn_ws_begin(c);
    }
}

static void answer(struct conn *c, const struct http_request *r)
{
    bool head_only = http_is(r->method, "HEAD");
    int status = http_refuse(r);
    c->requests++;
    if (c->over)
        refuse(c, 503, "too many connections", head_only);
    else if (!http_host_allowed(r, (const char *const *)c->service->hosts))
        refuse(c, 421, "this host is not served here (--allow-host)",
               head_only);
    else if (status)
        refuse(c, status, status == 405 ? "only GET and HEAD" : "no body",
               head_only);
    else if (!origin_allowed(c, r))
        refuse(c, 403, "this origin may not speak here (--allow-host)",
               head_only);
    else if (http_is(r->path, "/ws"))
        answer_socket(c, r);
    else
        answer_page(c, r, head_only);
}

void conn_http_work(struct conn *c)
{
    struct http_request r;
    while (c->speech == CONN_HTTP && c->in.size > 0 && !conn_paused(c)) {
        enum http_result result =
            http_parse(&r, (struct span){c->in.data, c->in.size});
        if (result == HTTP_MORE)
            return;
        if (result == HTTP_BAD) {
            refuse(c, r.status, r.why, false);
            return;
        }
        answer(c, &r);
        if (c->closing)
            return;
        buf_drop(&c->in, r.size);
        c->first_byte = clock_us(); // of what was sent behind it
    }
}
