// message.c - the frame of a reply.  The keys of a good one are the caller's.
#include "protocol/message.h"

static struct json begin(struct buf *out, bool ok, struct span tag)
{
    struct json j = json_begin(out);
    json_open_object(&j);
    json_put_bool(&j, "ok", ok);
    if (tag.size > 0) {
        json_key(&j, "tag");
        json_span(&j, tag);
    }
    return j;
}

struct json message_ok(struct buf *out, struct span tag)
{
    return begin(out, true, tag);
}

void message_end(struct json *j)
{
    json_close_object(j);
    buf_byte(j->out, '\n');
}

void message_error(struct buf *out, struct span tag, const struct error *err)
{
    struct json j = begin(out, false, tag);
    json_key(&j, "error");
    json_open_object(&j);
    json_put_string(&j, "code", err->code);
    json_put_string(&j, "name", err->name);
    json_put_string(&j, "text", err->text);
    json_close_object(&j);
    message_end(&j);
}
