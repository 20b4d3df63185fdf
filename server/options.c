// options.c - reads the command line into plain values.  No file is opened
// here; a name that does not exist is found out by who opens it.
#include "server/options.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "protocol/bytes.h"
#include "protocol/edit.h"

struct shared {
    unsigned bit;
    const char *name, *value, *doc;
};

static const struct shared shared[] = {
    {OPTIONS_HAIR, "hair", "FILE|builtin:NAME", "strands of hair"},
    {OPTIONS_ENV, "env", "FILE|builtin:NAME", "sky: a lat-long EXR or HDR"},
    {OPTIONS_SET, "set", "GROUP.NAME=VALUE", "a parameter; repeatable"},
    {OPTIONS_SIZE, "size", "WxH", "size of the picture"},
    {OPTIONS_OUT, "out", "FILE", "where the result goes"},
};
enum { SHARED = sizeof shared / sizeof shared[0] };

// One option with its value, as found in argv.
struct found {
    const char *name;
    size_t name_size;
    const char *value; // NULL until known
};

void options_list_finish(struct options_list *l)
{
    free(l->item);
    *l = (struct options_list){0};
}

static void list_add(struct options_list *l, const char *text)
{
    if ((l->count & (l->count - 1)) == 0)
        l->item = bytes_realloc(
            l->item, sizeof *l->item * (l->count ? 2 * (size_t)l->count : 1));
    l->item[l->count++] = text;
}

static bool number(const char *text, double *value)
{
    char *end;
    errno = 0;
    *value = strtod(text, &end);
    return end != text && *end == 0 && isfinite(*value);
}

// --size is checked by edit_size; sides that --set gave one by one, here.
static bool pixels_fit(const struct params *p, struct error *err)
{
    long pixels = (long)p->image.width * p->image.height;
    if (pixels <= EDIT_PIXELS_MAX)
        return true;
    return error_set(err, "range", "size",
                     "size: %dx%d is more than %d pixels in all",
                     p->image.width, p->image.height, EDIT_PIXELS_MAX);
}

static bool take_shared(struct options *o, unsigned bit, const char *value,
                        struct error *err)
{
    switch (bit) {
    case OPTIONS_HAIR:
        o->hair = value;
        o->hair_given = true;
        return true;
    case OPTIONS_ENV:
        o->env = value;
        o->env_given = true;
        return true;
    case OPTIONS_SET:
        return edit_apply_text(&o->params, value, err);
    case OPTIONS_SIZE:
        return edit_size(
            (struct span){(const unsigned char *)value, strlen(value)},
            "--size", &o->params.image.width, &o->params.image.height, err);
    default:
        o->out = value;
        return true;
    }
}

static bool take_own(const struct options_row *row, const char *value,
                     struct error *err)
{
    double v = 0;
    switch (row->type) {
    case OPTIONS_FLAG:
        *(bool *)row->to = true;
        return true;
    case OPTIONS_TEXT:
        *(const char **)row->to = value;
        return true;
    case OPTIONS_LIST:
        list_add(row->to, value);
        return true;
    case OPTIONS_INT:
    case OPTIONS_REAL:
        break;
    }
    bool whole = row->type == OPTIONS_INT;
    if (!number(value, &v) || (whole && v != floor(v)))
        return error_set(err, "syntax", row->name,
                         "--%s: '%.60s' is not %s number", row->name, value,
                         whole ? "a whole" : "a");
    if (!(v >= row->min && v <= row->max))
        return error_set(err, "range", row->name,
                         "--%s: %.60s is not within [%g, %g]", row->name, value,
                         row->min, row->max);
    if (whole)
        *(int *)row->to = (int)v;
    else
        *(double *)row->to = v;
    return true;
}

static bool is(const struct found *f, const char *name)
{
    return strlen(name) == f->name_size &&
           memcmp(name, f->name, f->name_size) == 0;
}

// The value of an option that wants one: behind '=' or the next word.
static bool want_value(struct found *f, int argc, char **argv, int *i,
                       struct error *err)
{
    if (f->value)
        return true;
    if (*i + 1 >= argc)
        return error_set(err, "syntax", "", "%s wants a value", argv[*i]);
    f->value = argv[++*i];
    return true;
}

static bool take(struct options *o, const struct options_verb *verb, int argc,
                 char **argv, int *i, struct error *err)
{
    const char *word = argv[*i] + 2, *equals = strchr(word, '=');
    struct found f = {word, equals ? (size_t)(equals - word) : strlen(word),
                      equals ? equals + 1 : NULL};
    for (const struct options_row *r = verb->rows; r && r->name; r++) {
        if (!is(&f, r->name))
            continue;
        if (r->type == OPTIONS_FLAG && f.value)
            return error_set(err, "syntax", r->name, "--%s takes no value",
                             r->name);
        if (r->type != OPTIONS_FLAG && !want_value(&f, argc, argv, i, err))
            return false;
        return take_own(r, f.value, err);
    }
    for (int s = 0; s < SHARED; s++) {
        if (!(verb->takes & shared[s].bit) || !is(&f, shared[s].name))
            continue;
        return want_value(&f, argc, argv, i, err) &&
               take_shared(o, shared[s].bit, f.value, err);
    }
    return error_set(err, "unknown", "",
                     "unknown option --%.*s; glintd %s --help lists them",
                     (int)f.name_size, word, verb->name);
}

static void help_row(const char *name, const char *value, const char *doc)
{
    char left[80];
    snprintf(left, sizeof left, "--%s%s%s", name, value ? " " : "",
             value ? value : "");
    printf("  %-32s %s\n", left, doc);
}

static void help(const struct options_verb *verb)
{
    printf("usage: glintd %s [OPTION ...]%s%s\n\n%s\n\n", verb->name,
           verb->args ? " " : "", verb->args ? verb->args : "", verb->about);
    for (int s = 0; s < SHARED; s++)
        if (verb->takes & shared[s].bit)
            help_row(shared[s].name, shared[s].value, shared[s].doc);
    for (const struct options_row *r = verb->rows; r && r->name; r++)
        help_row(r->name, r->value, r->doc);
    if (verb->takes & OPTIONS_SET)
        printf("\n`glintd info --params` lists the parameters.\n");
}

static bool parse(struct options *o, const struct options_verb *verb, int argc,
                  char **argv, struct error *err)
{
    bool ended = false;
    for (int i = 1; i < argc; i++) {
        if (!ended && strcmp(argv[i], "--") == 0) {
            ended = true;
        } else if (!ended && strncmp(argv[i], "--", 2) == 0) {
            if (!take(o, verb, argc, argv, &i, err))
                return false;
        } else if (verb->args) {
            list_add(&o->args, argv[i]);
        } else {
            return error_set(err, "syntax", "",
                             "unexpected word '%.60s'; glintd %s --help "
                             "lists the options",
                             argv[i], verb->name);
        }
    }
    return pixels_fit(&o->params, err);
}

int options_parse(struct options *o, const struct options_verb *verb, int argc,
                  char **argv)
{
    *o = (struct options){.hair = "builtin:ponytail", .env = "builtin:studio"};
    params_defaults(&o->params);
    for (int i = 1; i < argc && strcmp(argv[i], "--") != 0; i++)
        if (strcmp(argv[i], "--help") == 0 || strcmp(argv[i], "-h") == 0) {
            help(verb);
            return 0;
        }
    struct error err = {0};
    if (parse(o, verb, argc, argv, &err))
        return -1;
    options_fail(&err);
    return 2;
}

void options_finish(struct options *o)
{
    options_list_finish(&o->args);
}

int options_fail(const struct error *err)
{
    fprintf(stderr, "glintd: %s\n", err->text);
    return 1;
}
