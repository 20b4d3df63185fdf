// verb_get.c - `glint get`: values as lines that `glint set` takes, and help on
// parameters without a daemon.
#include <stdio.h>
#include <string.h>

#include "protocol/client/find.h"
#include "protocol/client/reply.h"
#include "protocol/client/request.h"
#include "protocol/client/verbs.h"
#include "protocol/edit.h"
#include "protocol/schema.h"

#define PATIENCE 30 // seconds

static void print(const struct buf *b)
{
    fwrite(b->data, 1, b->size, stdout);
}

static bool help(const struct verbs_options *o, struct error *err)
{
    struct buf out = {0};
    bool ok = true;
    if (o->markdown)
        schema_markdown(&out);
    else if (o->arg_count == 0)
        schema_help_all(&out);
    for (int i = 0; ok && !o->markdown && i < o->arg_count; i++) {
        const char *name = o->args[i];
        const struct params_row *row = edit_find(
            (struct span){(const unsigned char *)name, strlen(name)}, err);
        ok = row != NULL;
        if (row)
            schema_help(&out, row);
    }
    if (ok)
        print(&out);
    buf_finish(&out);
    return ok;
}

// A JSON value as `set` takes it: 1.5, 1,2,3, a word, on or off.
static void put_value(struct buf *out, struct span value)
{
    struct span item;
    size_t at = 0;
    int count = 0;
    if (find_text(value, out))
        return;
    if (value.size == 4 && memcmp(value.data, "true", 4) == 0) {
        buf_text(out, "on");
    } else if (value.size == 5 && memcmp(value.data, "false", 5) == 0) {
        buf_text(out, "off");
    } else if (value.size > 0 && value.data[0] == '[') {
        while (find_item(value, &at, &item)) {
            buf_text(out, count++ ? "," : "");
            buf_append(out, item.data, item.size);
        }
    } else {
        buf_append(out, value.data, value.size);
    }
}

static bool put_reply(const struct reply *r, struct error *err)
{
    struct span values, key, value;
    struct buf out = {0};
    size_t at = 0;
    if (!find_key(r->line, "values", &values))
        return error_set(err, "wire", "", "the reply has no values");
    while (find_member(values, &at, &key, &value)) {
        buf_append(&out, key.data, key.size);
        buf_byte(&out, '=');
        put_value(&out, value);
        buf_byte(&out, '\n');
    }
    print(&out);
    buf_finish(&out);
    return true;
}

bool verb_get_run(const struct verbs_options *o, struct error *err)
{
    struct buf line = {0};
    struct wire w = {0};
    struct reply r;
    if (o->help || o->markdown)
        return help(o, err);
    request_begin(&line, "get");
    for (int i = 0; i < o->arg_count; i++)
        request_word(&line, o->args[i]);
    bool ok = request_end(&line, err) && verbs_connect(&w, o, PATIENCE, err) &&
              reply_ask(&w, &line, &r, err);
    if (ok && o->json)
        printf("%.*s\n", (int)r.line.size, (const char *)r.line.data);
    else if (ok)
        ok = put_reply(&r, err);
    wire_close(&w);
    buf_finish(&line);
    return ok;
}
