// verb_watch.c - `glint watch`: one line for every frame of the stream.
#include <stdio.h>
#include <string.h>

#include "protocol/client/find.h"
#include "protocol/client/reply.h"
#include "protocol/client/request.h"
#include "protocol/client/verbs.h"

static bool start(const struct verbs_options *o, struct wire *w,
                  struct error *err)
{
    struct buf line = {0};
    bool window = false, ok = true;
    request_begin(&line, "stream");
    request_word(&line, "on");
    for (int i = 0; ok && i < o->arg_count; i++) {
        window = window || strncmp(o->args[i], "window=", 7) == 0;
        ok = request_pair(&line, o->args[i], err);
    }
    if (!window)
        request_value(&line, "window", "2");
    ok = ok && request_end(&line, err) && verbs_connect(w, o, 0, err) &&
         wire_send(w, (struct span){line.data, line.size}, err);
    buf_finish(&line);
    return ok;
}

static bool acknowledge(struct wire *w, uint64_t id, struct error *err)
{
    char line[64];
    int n =
        snprintf(line, sizeof line, "ack id=%llu\n", (unsigned long long)id);
    return wire_send(w, (struct span){(const unsigned char *)line, (size_t)n},
                     err);
}

// How far the picture still is from its limit, where the daemon knows.
static void put_error(const struct reply_frame *f, char out[64])
{
    struct span error, metric;
    double value;
    struct buf name = {0};
    snprintf(out, 64, "-");
    if (!find_key(f->all, "error", &error) ||
        !find_number(error, "value", &value))
        return;
    if (find_key(error, "metric", &metric))
        find_text(metric, &name);
    snprintf(out, 64, "%.*s:%.4g", (int)(name.size > 32 ? 32 : name.size),
             name.data ? (const char *)name.data : "", value);
    buf_finish(&name);
}

static void put_line(const struct verbs_options *o, const struct reply *r,
                     struct buf *out)
{
    const struct reply_frame *f = &r->frame;
    char error[64];
    put_error(f, error);
    buf_clear(out);
    if (o->json)
        buf_printf(out, "%.*s\n", (int)r->line.size,
                   (const char *)r->line.data);
    else
        buf_printf(out,
                   "id=%llu revision=%llu level=%s samples=%llu ms=%.1f "
                   "bytes=%llu error=%s\n",
                   (unsigned long long)f->id, (unsigned long long)f->revision,
                   f->level, (unsigned long long)f->samples,
                   f->render_ms + f->encode_ms, (unsigned long long)f->bytes,
                   error);
}

// A frame whose header was read.  It is told of once all of it is there.
static bool take(const struct verbs_options *o, struct wire *w,
                 const struct reply *r, struct error *err)
{
    struct buf text = {0};
    struct reply_frame frame = r->frame;
    put_line(o, r, &text); // the header is gone once the bytes are taken in
    bool ok = verbs_keep(o, w, &frame, err);
    if (ok) {
        fwrite(text.data, 1, text.size, stdout);
        fflush(stdout);
        ok = acknowledge(w, frame.id, err);
    }
    buf_finish(&text);
    return ok;
}

static bool follow(const struct verbs_options *o, struct wire *w,
                   uint64_t count, struct error *err)
{
    struct reply r;
    struct span line;
    for (uint64_t seen = 0; seen < count;) {
        if (!wire_line(w, &line, err) || !reply_read(&r, line, err))
            return false;
        if (r.answers && !r.ok)
            return reply_refusal(&r, err);
        if (r.is_event && !reply_refusal(&r, err))
            fprintf(stderr, "glint: %s\n", err->text);
        if (!r.has_frame)
            continue;
        if (!take(o, w, &r, err))
            return false;
        seen++;
    }
    return true;
}

bool verb_watch_run(const struct verbs_options *o, struct error *err)
{
    struct wire w = {0};
    uint64_t count = UINT64_MAX;
    if (o->count && !verbs_whole("--count", o->count, 1u << 30, &count, err))
        return false;
    if (!verbs_make_folder(o, err))
        return false;
    bool ok = start(o, &w, err) && follow(o, &w, count, err);
    wire_close(&w);
    return ok;
}
