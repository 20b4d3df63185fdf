// main.c - glint, the thin client of glintd.  It links libc and libm only: what
// it does any language with sockets can do in ten lines.
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "protocol/client/verbs.h"

static const struct verb {
    const char *name;
    bool (*run)(const struct verbs_options *o, struct error *err);
    const char *takes; // options beyond those that every verb has
    const char *usage;
} verbs[] = {
    {"set", verb_set_run, "json",
     "set GROUP.NAME=VALUE... [--json]\n"
     "    Changes parameters, all or none; prints the new revision.\n"},
    {"get", verb_get_run, "json markdown",
     "get [NAME...] [--json]\n"
     "    Prints values as `set` takes them: of all, of a group, of one.\n"
     "get --help [NAME...], get --markdown\n"
     "    Prints what the parameters are; needs no daemon.\n"},
    {"load", verb_load_run, "json",
     "load [hair=FILE] [env=FILE] [--json]\n"
     "    Loads a groom or a sky by the daemon's name for it, or "
     "builtin:NAME.\n"},
    {"capture", verb_capture_run, "json out",
     "capture [format=exr|png|jpeg] [size=WxH] [revision=N] "
     "[depth=half|float]\n"
     "        [layers=on|off] [quality=N] [GROUP.NAME=VALUE...] --out FILE "
     "[--json]\n"
     "    Makes the edits, waits for the final picture and writes it, whole "
     "or\n"
     "    not at all.  The format is that of the file's name; - is the "
     "standard\n"
     "    output.\n"},
    {"watch", verb_watch_run, "json out count",
     "watch [--count N] [--out DIR] [window=N] [format=...] [--json]\n"
     "    Prints one line per frame of the stream; --out keeps the frames.\n"},
    {"send", verb_send_run, "out",
     "send [--out DIR]\n"
     "    Sends request lines from the standard input, prints the replies.\n"},
};

static const char common[] =
    "Every verb takes:\n"
    "  --connect HOST:PORT  where the daemon listens (" WIRE_ADDRESS ")\n"
    "  --unix PATH          the same, a Unix socket\n"
    "  --token-file FILE    the daemon's token; else GLINT_TOKEN is used\n"
    "  --timeout SECONDS    longest silence while an answer is awaited\n"
    "Exit status: 0 done, 1 failed, 2 wrong usage.\n";

static void usage(FILE *to, const struct verb *only)
{
    fputs("usage: glint VERB [options]\n\n", to);
    for (size_t v = 0; v < sizeof verbs / sizeof *verbs; v++)
        if (!only || only == &verbs[v])
            fprintf(to, "%s\n", verbs[v].usage);
    fputs(common, to);
}

static const struct verb *find_verb(const char *name)
{
    for (size_t v = 0; v < sizeof verbs / sizeof *verbs; v++)
        if (strcmp(verbs[v].name, name) == 0)
            return &verbs[v];
    return NULL;
}

struct option {
    const char *name;
    const char **value; // or
    bool *flag;
    bool common;
};

static bool listed(const char *list, const char *name)
{
    size_t size = strlen(name);
    for (const char *at = list; (at = strstr(at, name)); at++)
        if ((at == list || at[-1] == ' ') && (at[size] == 0 || at[size] == ' '))
            return true;
    return false;
}

// argv[*i] is "--name", "--name=value" or "--name value".
static bool take_option(const struct verb *v, const struct option *table,
                        char **argv, int *i, struct error *err)
{
    const char *text = argv[*i] + 2;
    size_t size = strcspn(text, "=");
    for (const struct option *o = table; o->name; o++) {
        if (strlen(o->name) != size || memcmp(o->name, text, size) != 0 ||
            !(o->common || listed(v->takes, o->name)))
            continue;
        bool joined = text[size] == '=';
        if (o->flag && joined)
            return error_set(err, "usage", "", "--%s takes no value", o->name);
        if (o->flag) {
            *o->flag = true;
            return true;
        }
        *o->value = joined ? text + size + 1 : argv[*i + 1];
        if (!*o->value)
            return error_set(err, "usage", "", "--%s wants a value", o->name);
        *i += !joined;
        return true;
    }
    return error_set(err, "usage", "",
                     "%s has no option --%.*s; see glint "
                     "--help",
                     v->name, (int)(size > 40 ? 40 : size), text);
}

static bool parse(const struct verb *v, int argc, char **argv,
                  struct verbs_options *o, struct error *err)
{
    const struct option table[] = {
        {"connect", &o->connect, NULL, true},
        {"unix", &o->unix_path, NULL, true},
        {"token-file", &o->token_file, NULL, true},
        {"timeout", &o->timeout, NULL, true},
        {"help", NULL, &o->help, true},
        {"out", &o->out, NULL, false},
        {"count", &o->count, NULL, false},
        {"json", NULL, &o->json, false},
        {"markdown", NULL, &o->markdown, false},
        {NULL, NULL, NULL, false},
    };
    bool options = true;
    for (int i = 2; i < argc; i++) {
        if (options && strcmp(argv[i], "--") == 0)
            options = false;
        else if (options && strcmp(argv[i], "-h") == 0)
            o->help = true;
        else if (options && strncmp(argv[i], "--", 2) == 0) {
            if (!take_option(v, table, argv, &i, err))
                return false;
        } else
            o->args[o->arg_count++] = argv[i];
    }
    return true;
}

static int report(bool ok, const struct error *err)
{
    // What is still in the buffer may have nowhere to go: a full disk.
    if (ok && (fflush(stdout) != 0 || ferror(stdout))) {
        fputs("glint: cannot write to the standard output\n", stderr);
        return 1;
    }
    if (ok)
        return 0;
    fprintf(stderr, "glint: %s\n", err->text);
    return strcmp(err->code, "usage") == 0 ? 2 : 1;
}

int main(int argc, char **argv)
{
    struct error err = {0};
    struct verbs_options o = {0};
    if (argc < 2) {
        usage(stderr, NULL);
        return 2;
    }
    if (strcmp(argv[1], "--help") == 0 || strcmp(argv[1], "-h") == 0 ||
        strcmp(argv[1], "help") == 0) {
        usage(stdout, NULL);
        return report(true, &err);
    }
    const struct verb *v = find_verb(argv[1]);
    if (!v) {
        error_set(&err, "usage", "",
                  "unknown verb \"%.40s\"; there are set get load capture "
                  "watch send",
                  argv[1]);
        return report(false, &err);
    }
    o.args = bytes_zalloc((size_t)argc, sizeof *o.args);
    bool ok = parse(v, argc, argv, &o, &err);
    if (ok && o.help && v->run != verb_get_run)
        usage(stdout, v);
    else
        ok = ok && v->run(&o, &err);
    free(o.args);
    return report(ok, &err);
}
