// verbs.c - what several verbs need: connecting and options' values.
#include "protocol/client/verbs.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "protocol/client/request.h"
#include "protocol/number.h"

bool verbs_whole(const char *option, const char *text, uint64_t max,
                 uint64_t *out, struct error *err)
{
    struct span all = {(const unsigned char *)text, strlen(text)};
    if (number_parse_u64(all, max, out) && *out >= 1)
        return true;
    return error_set(err, "usage", option,
                     "%s: \"%.40s\" is not a whole number within [1, %llu]",
                     option, text, (unsigned long long)max);
}

static bool read_token(const char *path, char token[256], struct error *err)
{
    FILE *f = fopen(path, "r");
    if (!f || !fgets(token, 256, f)) {
        error_set(err, "file", path, "--token-file: cannot read %s: %s", path,
                  f && !ferror(f) ? "it is empty" : strerror(errno));
        if (f)
            fclose(f);
        return false;
    }
    fclose(f);
    token[strcspn(token, "\r\n")] = 0;
    return true;
}

static bool hello(struct wire *w, const char *token, struct error *err)
{
    struct buf line = {0};
    struct reply r;
    request_begin(&line, "hello");
    request_value(&line, "token", token);
    bool ok = request_end(&line, err) && reply_ask(w, &line, &r, err);
    buf_finish(&line);
    return ok;
}

bool verbs_connect(struct wire *w, const struct verbs_options *o, int patience,
                   struct error *err)
{
    char from_file[256];
    const char *token = getenv("GLINT_TOKEN");
    uint64_t seconds = (uint64_t)patience;
    if (o->connect && o->unix_path)
        return error_set(err, "usage", "--unix",
                         "--connect and --unix exclude each other");
    if (o->timeout &&
        !verbs_whole("--timeout", o->timeout, 1000000, &seconds, err))
        return false;
    if (o->token_file) {
        if (!read_token(o->token_file, from_file, err))
            return false;
        token = from_file;
    }
    if (!wire_open(w, o->connect ? o->connect : WIRE_ADDRESS, o->unix_path,
                   err))
        return false;
    w->timeout_ms = seconds ? (int)(seconds * 1000) : -1;
    return !token || hello(w, token, err);
}

bool verbs_make_folder(const struct verbs_options *o, struct error *err)
{
    return !o->out || mkdir(o->out, 0777) == 0 || errno == EEXIST ||
           error_set(err, "file", o->out, "--out: cannot make %s: %s", o->out,
                     strerror(errno));
}

bool verbs_keep(const struct verbs_options *o, struct wire *w,
                const struct reply_frame *f, struct error *err)
{
    struct save file = {.fd = -1};
    struct buf path = {0};
    if (!o->out)
        return wire_bytes(w, f->bytes, NULL, err);
    buf_printf(&path, "%s/%06llu.%s", o->out, (unsigned long long)f->id,
               reply_extension(f));
    buf_byte(&path, 0);
    bool ok = save_begin(&file, (const char *)path.data, err) &&
              wire_bytes(w, f->bytes, &file, err) && save_commit(&file, err);
    if (!ok)
        save_abort(&file);
    buf_finish(&path);
    return ok;
}
