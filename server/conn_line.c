// conn_line.c - the raw line protocol: cuts lines out of the stream.
#include <stdio.h>

#include "protocol/line.h"
#include "protocol/message.h"
#include "server/conn_private.h"

// The stream cannot be trusted any more: one error, then the end.
static void refuse_stream(struct conn *c, const struct error *err)
{
    struct buf out = {0};
    message_error(&out, (struct span){0}, err);
    outbox_bytes(&c->out, out.data, out.size);
    buf_finish(&out);
    conn_finish(c);
}

void conn_line_work(struct conn *c)
{
    struct error err = {0};
    if (c->over) {
        error_set(&err, "limit", "", "the server has %d connections already",
                  c->service->connections_max);
        refuse_stream(c, &err);
        return;
    }
    size_t done = 0;
    while (!conn_paused(c)) {
        struct span in = {c->in.data + done, c->in.size - done}, line;
        size_t used = 0;
        enum line_result r = line_cut(in, &c->scanned, &line, &used, &err);
        if (r == LINE_MORE)
            break;
        if (r == LINE_BAD) {
            refuse_stream(c, &err);
            return;
        }
        done += used;
        session_request(&c->session, line);
        if (c->session.quit)
            conn_finish(c);
    }
    if (!c->closing)
        buf_drop(&c->in, done);
}
