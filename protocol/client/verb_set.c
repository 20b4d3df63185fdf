// verb_set.c - `glint set` and `glint load`: change the daemon's state.
#include <stdio.h>

#include "protocol/client/find.h"
#include "protocol/client/reply.h"
#include "protocol/client/request.h"
#include "protocol/client/verbs.h"

#define PATIENCE 30       // seconds
#define PATIENCE_LOAD 600 // a large sky is fitted before the reply comes

static bool ask_and_print(const struct verbs_options *o, struct wire *w,
                          const struct buf *line, struct error *err)
{
    struct reply r;
    uint64_t revision;
    if (!reply_ask(w, line, &r, err))
        return false;
    if (o->json)
        printf("%.*s\n", (int)r.line.size, (const char *)r.line.data);
    else if (find_u64(r.line, "revision", &revision))
        printf("%llu\n", (unsigned long long)revision);
    else
        return error_set(err, "wire", "", "the reply names no revision");
    return true;
}

bool verb_set_run(const struct verbs_options *o, struct error *err)
{
    struct buf line = {0};
    struct wire w = {0};
    bool ok = o->arg_count > 0 ||
              error_set(err, "usage", "",
                        "set wants GROUP.NAME=VALUE, as in `glint set "
                        "fibre.eta=1.6`");
    request_begin(&line, "set");
    for (int i = 0; ok && i < o->arg_count; i++)
        ok = request_pair(&line, o->args[i], err);
    ok = ok && request_end(&line, err) && verbs_connect(&w, o, PATIENCE, err) &&
         ask_and_print(o, &w, &line, err);
    wire_close(&w);
    buf_finish(&line);
    return ok;
}

// "hair=NAME" or "env=NAME", one request each.
static bool load(const struct verbs_options *o, struct wire *w, const char *arg,
                 struct error *err)
{
    static const char *const verbs[] = {"hair", "env"};
    struct buf line = {0};
    for (int i = 0; i < 2; i++) {
        const char *at = arg;
        for (const char *v = verbs[i]; *v && *at == *v; v++)
            at++;
        if (at != arg + (i == 0 ? 4 : 3) || *at != '=')
            continue;
        request_begin(&line, verbs[i]);
        request_value(&line, "name", at + 1);
        // Without a connection this only checks the words.
        bool ok =
            request_end(&line, err) && (!w || ask_and_print(o, w, &line, err));
        buf_finish(&line);
        return ok;
    }
    return error_set(err, "usage", "",
                     "load wants hair=NAME or env=NAME, not \"%.60s\"", arg);
}

bool verb_load_run(const struct verbs_options *o, struct error *err)
{
    struct wire w = {0};
    bool ok = o->arg_count > 0 ||
              error_set(err, "usage", "", "load wants hair=NAME or env=NAME");
    for (int i = 0; ok && i < o->arg_count; i++)
        ok = load(o, NULL, o->args[i], err);
    ok = ok && verbs_connect(&w, o, PATIENCE_LOAD, err);
    for (int i = 0; ok && i < o->arg_count; i++)
        ok = load(o, &w, o->args[i], err);
    wire_close(&w);
    return ok;
}
