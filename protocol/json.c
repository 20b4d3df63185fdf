// json.c - the JSON writer.  It keeps the commas and the nesting; what is
// written is the caller's.
#include "protocol/json.h"

#include <assert.h>
#include <math.h>
#include <string.h>

#include "protocol/number.h"
#include "protocol/utf8.h"

struct json json_begin(struct buf *out)
{
    return (struct json){.out = out};
}

// Before every value: a comma where one is due.
static void item(struct json *j)
{
    assert(!j->object[j->depth] || j->key);
    if (!j->key && j->filled[j->depth])
        buf_byte(j->out, ',');
    j->filled[j->depth] = true;
    j->key = false;
}

static void open(struct json *j, bool object)
{
    item(j);
    assert(j->depth < JSON_DEPTH_MAX);
    j->depth++;
    j->object[j->depth] = object;
    j->filled[j->depth] = false;
    buf_byte(j->out, object ? '{' : '[');
}

static void close_level(struct json *j, bool object)
{
    assert(j->depth > 0 && j->object[j->depth] == object && !j->key);
    j->depth--;
    buf_byte(j->out, object ? '}' : ']');
}

void json_open_object(struct json *j)
{
    open(j, true);
}

void json_close_object(struct json *j)
{
    close_level(j, true);
}

void json_open_array(struct json *j)
{
    open(j, false);
}

void json_close_array(struct json *j)
{
    close_level(j, false);
}

static void escaped(struct buf *out, unsigned char c)
{
    switch (c) {
    case '"':
        buf_text(out, "\\\"");
        break;
    case '\\':
        buf_text(out, "\\\\");
        break;
    case '\n':
        buf_text(out, "\\n");
        break;
    case '\r':
        buf_text(out, "\\r");
        break;
    case '\t':
        buf_text(out, "\\t");
        break;
    default:
        buf_printf(out, "\\u%04x", c);
    }
}

static void quoted(struct buf *out, struct span text)
{
    buf_byte(out, '"');
    while (text.size > 0) {
        size_t n = utf8_next(text);
        unsigned char c = text.data[0];
        if (n == 0)
            buf_text(out, "\xef\xbf\xbd"); // U+FFFD
        else if (n == 1 && (c < 0x20 || c == '"' || c == '\\' || c == 0x7f))
            escaped(out, c);
        else
            buf_append(out, text.data, n);
        n += n == 0;
        text.data += n;
        text.size -= n;
    }
    buf_byte(out, '"');
}

void json_key(struct json *j, const char *key)
{
    assert(j->object[j->depth] && !j->key);
    if (j->filled[j->depth])
        buf_byte(j->out, ',');
    quoted(j->out, (struct span){(const unsigned char *)key, strlen(key)});
    buf_byte(j->out, ':');
    j->key = true;
}

void json_span(struct json *j, struct span text)
{
    item(j);
    quoted(j->out, text);
}

void json_string(struct json *j, const char *text)
{
    if (text)
        json_span(j, (struct span){(const unsigned char *)text, strlen(text)});
    else
        json_null(j);
}

void json_raw(struct json *j, struct span text)
{
    item(j);
    buf_append(j->out, text.data, text.size);
}

static void literal(struct json *j, const char *text)
{
    item(j);
    buf_text(j->out, text);
}

void json_number(struct json *j, double value)
{
    char text[NUMBER_BUFFER] = "null";
    if (isfinite(value))
        number_print(text, value);
    literal(j, text);
}

void json_float(struct json *j, float value)
{
    char text[NUMBER_BUFFER] = "null";
    if (isfinite(value))
        number_print_float(text, value);
    literal(j, text);
}

void json_int(struct json *j, int64_t value)
{
    item(j);
    buf_printf(j->out, "%lld", (long long)value);
}

void json_uint(struct json *j, uint64_t value)
{
    item(j);
    buf_printf(j->out, "%llu", (unsigned long long)value);
}

void json_bool(struct json *j, bool value)
{
    literal(j, value ? "true" : "false");
}

void json_null(struct json *j)
{
    literal(j, "null");
}

void json_put_string(struct json *j, const char *key, const char *text)
{
    json_key(j, key);
    json_string(j, text);
}

void json_put_number(struct json *j, const char *key, double value)
{
    json_key(j, key);
    json_number(j, value);
}

void json_put_int(struct json *j, const char *key, int64_t value)
{
    json_key(j, key);
    json_int(j, value);
}

void json_put_bool(struct json *j, const char *key, bool value)
{
    json_key(j, key);
    json_bool(j, value);
}
