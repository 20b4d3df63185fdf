// reply.c - tells replies, frames and notices apart.
#include "protocol/client/reply.h"

#include <stdio.h>
#include <string.h>

#include "protocol/client/find.h"

// A short word of the header; what is not one of [a-z0-9] is refused, because
// it may become a part of a file's name.
static bool word(struct span object, const char *key, char *out, size_t room)
{
    struct span value;
    if (!find_key(object, key, &value) || value.size < 3 ||
        value.size - 2 >= room)
        return false;
    for (size_t i = 1; i < value.size - 1; i++) {
        unsigned char c = value.data[i];
        if (!((c >= 'a' && c <= 'z') || (c >= '0' && c <= '9')))
            return false;
    }
    snprintf(out, room, "%.*s", (int)value.size - 2,
             (const char *)value.data + 1);
    return true;
}

static bool read_frame(struct reply_frame *f, struct span object,
                       struct error *err)
{
    f->all = object;
    if (!find_u64(object, "bytes", &f->bytes))
        return error_set(err, "wire", "",
                         "the daemon sent a frame without its size");
    if (f->bytes == 0 || f->bytes > WIRE_BYTES_MAX)
        return error_set(err, "wire", "",
                         "the daemon announced a frame of %llu bytes; 1 to %u "
                         "are accepted",
                         (unsigned long long)f->bytes, WIRE_BYTES_MAX);
    if (!word(object, "format", f->format, sizeof f->format) ||
        !word(object, "level", f->level, sizeof f->level) ||
        !find_u64(object, "id", &f->id) ||
        !find_u64(object, "revision", &f->revision) ||
        !find_u64(object, "width", &f->width) ||
        !find_u64(object, "height", &f->height) ||
        !find_u64(object, "samples", &f->samples) ||
        !find_number(object, "render_ms", &f->render_ms) ||
        !find_number(object, "encode_ms", &f->encode_ms))
        return error_set(err, "wire", "",
                         "the daemon sent a frame with an incomplete header");
    return true;
}

bool reply_read(struct reply *r, struct span line, struct error *err)
{
    struct span object;
    *r = (struct reply){.line = line};
    r->answers = find_bool(line, "ok", &r->ok);
    r->is_event = !r->answers && find_key(line, "event", &object);
    r->has_frame = find_key(line, "frame", &object);
    if (r->has_frame)
        return read_frame(&r->frame, object, err);
    return r->answers || r->is_event ||
           error_set(err, "wire", "", "this is not a Glint daemon: \"%.*s\"",
                     (int)(line.size > 60 ? 60 : line.size),
                     (const char *)line.data);
}

bool reply_refusal(const struct reply *r, struct error *err)
{
    struct span error, value;
    struct buf text = {0};
    if (find_key(r->line, "error", &error) && find_key(error, "text", &value))
        find_text(value, &text);
    if (text.size == 0)
        buf_text(&text, "the daemon refused and did not say why");
    // A code of the daemon's does not become one of this program's own.
    error_set(err, "refused", "", "%.*s", (int)text.size,
              (const char *)text.data);
    buf_finish(&text);
    return false;
}

bool reply_ask(struct wire *w, const struct buf *request, struct reply *r,
               struct error *err)
{
    struct span line;
    if (!wire_send(w, (struct span){request->data, request->size}, err))
        return false;
    for (;;) {
        if (!wire_line(w, &line, err) || !reply_read(r, line, err))
            return false;
        if (r->answers)
            return r->ok || reply_refusal(r, err);
        if (r->has_frame && !wire_bytes(w, r->frame.bytes, NULL, err))
            return false;
    }
}

const char *reply_extension(const struct reply_frame *f)
{
    return strcmp(f->format, "jpeg") == 0 ? "jpg" : f->format;
}
