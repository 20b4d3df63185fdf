// session.c - order, waiting and credit of one client.  What a verb means is
// in commands.c; how bytes travel, in conn.c.
#include "server/session.h"

#include <stdlib.h>
#include <string.h>

#include "protocol/line.h"
#include "protocol/message.h"
#include "protocol/utf8.h"
#include "server/clock.h"
#include "server/commands.h"
#include "server/frame.h"
#include "server/hub.h"

static void out_of_patience(struct loop_timer *t);

void session_open(struct session *s, struct hub *h,
                  const struct session_out *out, bool allowed)
{
    s->hub = h;
    s->out = out;
    s->allowed = allowed;
    s->patience.fire = out_of_patience;
    hub_add(h, s);
}

static void end_wait(struct session *s)
{
    if (s->wait == SESSION_CAPTURE || s->wait == SESSION_REVISION)
        s->hub->captures--;
    s->wait = SESSION_FREE;
    loop_timer_clear(s->hub->loop, &s->patience);
    free(s->tag);
    s->tag = NULL;
}

void session_close(struct session *s)
{
    if (s->wait == SESSION_CAPTURE || s->wait == SESSION_LOAD)
        engine_cancel(s->hub->engine, s->job);
    end_wait(s);
    hub_remove(s->hub, s);
    free(s->marks);
    if (s->streaming) {
        s->streaming = false;
        s->hub->viewers--;
        hub_serve(s->hub);
    }
}

bool session_busy(const struct session *s)
{
    return s->wait != SESSION_FREE;
}

static void send_line(struct session *s, struct buf *line)
{
    s->out->line(s, (struct span){line->data, line->size});
    buf_finish(line);
}

void session_refuse(struct session *s, struct span tag, const struct error *err)
{
    struct buf line = {0};
    s->hub->refused++;
    message_error(&line, tag, err);
    send_line(s, &line);
}

void session_request(struct session *s, struct span text)
{
    struct error err = {0};
    struct line line = {0};
    s->hub->requests++;
    bool ok = utf8_valid(text)
                  ? line_parse(&line, text, &err)
                  : error_set(&err, "syntax", "", "a line must be UTF-8");
    if (!ok || !commands_run(s, &line, &err))
        session_refuse(s, line.tag, &err);
    line_finish(&line);
}

// --- waiting ----------------------------------------------------------------
void session_begin_wait(struct session *s, struct span tag,
                        enum session_wait wait)
{
    s->wait = wait;
    s->tag = NULL;
    if (tag.size > 0) {
        s->tag = bytes_alloc(tag.size + 1);
        memcpy(s->tag, tag.data, tag.size);
        s->tag[tag.size] = 0;
    }
    if (wait == SESSION_REVISION)
        loop_timer_set(s->hub->loop, &s->patience,
                       clock_us() + HUB_PATIENCE_S * INT64_C(1000000));
}

static struct span tag_of(const struct session *s)
{
    return s->tag ? (struct span){(const unsigned char *)s->tag, strlen(s->tag)}
                  : (struct span){0};
}

void session_start_capture(struct session *s)
{
    struct engine_capture c = {.id = ++s->hub->next_job,
                               .how = s->capture_how,
                               .width = s->capture_width,
                               .height = s->capture_height};
    s->job = c.id;
    s->wait = SESSION_CAPTURE;
    loop_timer_clear(s->hub->loop, &s->patience);
    engine_capture(s->hub->engine, &c);
}

void session_revision(struct session *s)
{
    if (s->wait == SESSION_REVISION && s->wanted_revision <= s->hub->revision)
        session_start_capture(s);
}

static void out_of_patience(struct loop_timer *t)
{
    struct session *s =
        (struct session *)((char *)t - offsetof(struct session, patience));
    struct error err;
    error_set(&err, "timeout", "revision",
              "revision: %llu was not made within %d s; the newest is %llu",
              (unsigned long long)s->wanted_revision, HUB_PATIENCE_S,
              (unsigned long long)s->hub->revision);
    session_refuse(s, tag_of(s), &err);
    end_wait(s);
    s->out->resume(s);
}

static void send_capture(struct session *s, const struct studio_frame *f)
{
    struct buf header = {0};
    struct json j = message_ok(&header, tag_of(s));
    struct frame_about about = {.id = ++s->hub->next_frame,
                                .queued_us = clock_us()};
    frame_put(&j, f, &about);
    message_end(&j);
    s->out->frame(s, (struct span){header.data, header.size}, f->bytes);
    buf_finish(&header);
}

static void send_loaded(struct session *s, const struct engine_event *event)
{
    struct buf line = {0};
    struct json j = message_ok(&line, tag_of(s));
    json_put_int(&j, "revision", (int64_t)s->hub->revision);
    commands_put_asset(&j, event->which, &event->asset);
    message_end(&j);
    send_line(s, &line);
}

// A notice among the frames: it answers no request.
static void send_failure(struct session *s, const struct engine_event *event)
{
    struct buf line = {0};
    struct json j = json_begin(&line);
    json_open_object(&j);
    json_put_string(&j, "event", "failed");
    json_put_int(&j, "revision", (int64_t)event->frame.revision);
    json_key(&j, "error");
    json_open_object(&j);
    json_put_string(&j, "code", event->error.code);
    json_put_string(&j, "name", event->error.name);
    json_put_string(&j, "text", event->error.text);
    json_close_object(&j);
    json_close_object(&j);
    buf_byte(&line, '\n');
    send_line(s, &line);
}

void session_event(struct session *s, const struct engine_event *event)
{
    if (event->type == ENGINE_FAILED) {
        send_failure(s, event);
        return;
    }
    if (!event->ok)
        session_refuse(s, tag_of(s), &event->error);
    else if (event->type == ENGINE_CAPTURED)
        send_capture(s, &event->frame);
    else
        send_loaded(s, event);
    end_wait(s);
    s->out->resume(s);
}

// --- streaming --------------------------------------------------------------
bool session_has_credit(const struct session *s)
{
    return s->streaming && s->unacked < s->window && s->out->ready(s);
}

struct still_encoding session_encoding(const struct session *s)
{
    struct still_encoding how = s->how;
    if (!s->own_format)
        how.format = s->hub->params.output.format;
    return how;
}

void session_remember_edit(struct session *s, const struct session_mark *m)
{
    if (!s->marks)
        s->marks = bytes_alloc(SESSION_MARKS * sizeof *s->marks);
    // When full the newest is replaced: then frames between may name an older
    // edit than they show, but the newest edit is named by the first frame
    // that shows it.
    if (s->mark_count == SESSION_MARKS)
        s->mark_count--;
    s->marks[s->mark_count++] = *m;
}

static void take_marks(struct session *s, uint64_t revision)
{
    int shown = 0;
    while (shown < s->mark_count && s->marks[shown].revision <= revision)
        shown++;
    if (shown == 0)
        return;
    s->shown = s->marks[shown - 1];
    s->mark_count -= shown;
    memmove(s->marks, s->marks + shown,
            (size_t)s->mark_count * sizeof *s->marks);
    if (s->mark_count == 0) { // an idle client keeps no such memory
        free(s->marks);
        s->marks = NULL;
    }
}

void session_send_frame(struct session *s, const struct studio_frame *f,
                        uint64_t serial)
{
    take_marks(s, f->revision);
    struct frame_about about = {.id = ++s->hub->next_frame,
                                .queued_us = clock_us(),
                                .shown = &s->shown};
    struct buf header = {0};
    struct json j = json_begin(&header);
    json_open_object(&j);
    frame_put(&j, f, &about);
    json_close_object(&j);
    buf_byte(&header, '\n');
    s->sent_serial = serial;
    s->unacked_id[s->unacked++] = about.id;
    s->newest_id = about.id;
    s->hub->frames_sent++;
    s->hub->bytes_sent += f->bytes->size;
    s->out->frame(s, (struct span){header.data, header.size}, f->bytes);
    buf_finish(&header);
}

bool session_ack(struct session *s, uint64_t id, struct error *err)
{
    if (id > s->newest_id)
        return error_set(err, "range", "id",
                         "id: %llu was not sent; the newest frame is %llu",
                         (unsigned long long)id,
                         (unsigned long long)s->newest_id);
    int count = 0;
    while (count < s->unacked && s->unacked_id[count] <= id)
        count++;
    s->unacked -= count;
    memmove(s->unacked_id, s->unacked_id + count,
            (size_t)s->unacked * sizeof *s->unacked_id);
    return true;
}
