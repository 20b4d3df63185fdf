// request.c - request lines.  Whether names and values are good is the daemon's
// to say; only what would not be a line at all is refused here.
#include "protocol/client/request.h"

#include <string.h>

#include "protocol/line.h"

void request_begin(struct buf *out, const char *verb)
{
    buf_clear(out);
    buf_text(out, verb);
}

void request_word(struct buf *out, const char *word)
{
    buf_byte(out, ' ');
    buf_text(out, word);
}

static bool plain(const char *value)
{
    for (const char *c = value; *c; c++)
        if ((unsigned char)*c <= ' ' || *c == '"' || *c == 0x7f)
            return false;
    return *value != 0;
}

void request_value(struct buf *out, const char *name, const char *value)
{
    buf_printf(out, " %s=", name);
    if (plain(value)) {
        buf_text(out, value);
        return;
    }
    buf_byte(out, '"');
    for (const char *c = value; *c; c++) {
        if (*c == '\n')
            buf_text(out, "\\n");
        else if ((unsigned char)*c < ' ' || *c == 0x7f)
            buf_printf(out, "\\u%04x", (unsigned char)*c);
        else if (*c == '"' || *c == '\\')
            buf_printf(out, "\\%c", *c);
        else
            buf_byte(out, (unsigned char)*c);
    }
    buf_byte(out, '"');
}

bool request_pair(struct buf *out, const char *assignment, struct error *err)
{
    const char *sign = strchr(assignment, '=');
    if (!sign || sign == assignment)
        return error_set(err, "usage", "",
                         "\"%.60s\" is not of the form NAME=VALUE", assignment);
    struct buf name = {0};
    buf_append(&name, assignment, (size_t)(sign - assignment));
    buf_byte(&name, 0);
    request_value(out, (const char *)name.data, sign + 1);
    buf_finish(&name);
    return true;
}

bool request_end(struct buf *out, struct error *err)
{
    struct line line = {0};
    bool ok = line_parse(&line, (struct span){out->data, out->size}, err);
    line_finish(&line);
    if (!ok) {
        struct error why = *err;
        return error_set(err, "usage", "", "%s", why.text);
    }
    buf_byte(out, '\n');
    return true;
}

bool request_is_parameter(const char *assignment)
{
    return memchr(assignment, '.', strcspn(assignment, "=")) != NULL;
}
