// verb_capture.c - `glint capture`: the final picture of a state as a file.
#include <stdio.h>
#include <string.h>
#include <strings.h>

#include "protocol/client/find.h"
#include "protocol/client/reply.h"
#include "protocol/client/request.h"
#include "protocol/client/verbs.h"

#define PATIENCE 3600 // seconds: a final picture may take its time

// By the name's end, or NULL.
static const char *format_of(const char *path)
{
    static const char *const ends[][2] = {
        {".exr", "exr"}, {".png", "png"}, {".jpg", "jpeg"}, {".jpeg", "jpeg"}};
    size_t size = strlen(path);
    for (size_t i = 0; i < sizeof ends / sizeof *ends; i++) {
        size_t end = strlen(ends[i][0]);
        if (size > end && strcasecmp(path + size - end, ends[i][0]) == 0)
            return ends[i][1];
    }
    return NULL;
}

// The format to ask for: what was said, else what the file's name says.
static const char *choose_format(const struct verbs_options *o,
                                 struct error *err)
{
    const char *named = format_of(o->out), *said = NULL;
    for (int i = 0; i < o->arg_count; i++)
        if (strncmp(o->args[i], "format=", 7) == 0)
            said = o->args[i] + 7;
    if (!said && !named)
        error_set(err, "usage", "--out",
                  "--out: the name \"%.80s\" tells no format; add format=exr, "
                  "png or jpeg",
                  o->out);
    else if (said && named && strcmp(said, named) != 0)
        error_set(err, "usage", "--out",
                  "--out: the name \"%.80s\" says %s, but format=%.20s was "
                  "given",
                  o->out, named, said);
    else
        return said ? said : named;
    return NULL;
}

struct lines { // what is asked, one after the other
    struct buf set, capture;
    bool edits, revision;
    const char *format;
};

// Parameters go to a `set` before, everything else is the capture's.
static bool build(struct lines *l, const struct verbs_options *o,
                  struct error *err)
{
    request_begin(&l->set, "set");
    request_begin(&l->capture, "capture");
    if (!o->out)
        return error_set(err, "usage", "--out", "capture wants --out FILE");
    l->format = choose_format(o, err);
    if (!l->format)
        return false;
    request_value(&l->capture, "format", l->format);
    for (int i = 0; i < o->arg_count; i++) {
        const char *arg = o->args[i];
        bool edit = request_is_parameter(arg);
        l->edits = l->edits || edit;
        l->revision = l->revision || strncmp(arg, "revision=", 9) == 0;
        if (strncmp(arg, "format=", 7) != 0 &&
            !request_pair(edit ? &l->set : &l->capture, arg, err))
            return false;
    }
    return true;
}

static bool edit(struct lines *l, struct wire *w, struct error *err)
{
    struct reply r;
    uint64_t revision;
    char text[32];
    if (!reply_ask(w, &l->set, &r, err))
        return false;
    if (!find_u64(r.line, "revision", &revision))
        return error_set(err, "wire", "", "the reply names no revision");
    snprintf(text, sizeof text, "%llu", (unsigned long long)revision);
    if (!l->revision)
        request_value(&l->capture, "revision", text);
    return true;
}

// The header is printed before the bytes come: they overwrite it.
static void print(const struct verbs_options *o, const struct reply *r,
                  struct buf *out)
{
    const struct reply_frame *f = &r->frame;
    if (o->json)
        buf_printf(out, "%.*s\n", (int)r->line.size,
                   (const char *)r->line.data);
    else
        buf_printf(out,
                   "%s: revision %llu, %llux%llu %s, %llu samples, %llu "
                   "bytes\n",
                   o->out, (unsigned long long)f->revision,
                   (unsigned long long)f->width, (unsigned long long)f->height,
                   f->format, (unsigned long long)f->samples,
                   (unsigned long long)f->bytes);
}

static bool fetch(const struct verbs_options *o, struct lines *l,
                  struct wire *w, struct error *err)
{
    struct reply r;
    struct save file = {.fd = -1};
    struct buf summary = {0};
    if (!reply_ask(w, &l->capture, &r, err))
        return false;
    if (!r.has_frame || strcmp(r.frame.format, l->format) != 0)
        return error_set(err, "wire", "",
                         "the daemon answered a capture of %s without one",
                         l->format);
    print(o, &r, &summary);
    bool ok = save_begin(&file, o->out, err) &&
              wire_bytes(w, r.frame.bytes, &file, err) &&
              save_commit(&file, err);
    if (!ok)
        save_abort(&file);
    // With the picture on the standard output the summary goes elsewhere.
    else
        fwrite(summary.data, 1, summary.size,
               strcmp(o->out, "-") == 0 ? stderr : stdout);
    buf_finish(&summary);
    return ok;
}

bool verb_capture_run(const struct verbs_options *o, struct error *err)
{
    struct lines l = {0};
    struct wire w = {0};
    bool ok = build(&l, o, err) && (!l.edits || request_end(&l.set, err)) &&
              verbs_connect(&w, o, PATIENCE, err) &&
              (!l.edits || edit(&l, &w, err)) && request_end(&l.capture, err) &&
              fetch(o, &l, &w, err);
    wire_close(&w);
    buf_finish(&l.set);
    buf_finish(&l.capture);
    return ok;
}
