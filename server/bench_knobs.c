// bench_knobs.c - the table of knobs, and how it becomes a list of settings.
#include "server/bench_knobs.h"

#include <stdio.h>
#include <string.h>

#include "protocol/edit.h"

enum { Q = BENCH_KNOBS_QUICK, I = BENCH_KNOBS_INTEGRAL, S = BENCH_KNOBS_SKY };

const char *const bench_knobs_groups[] = {
    "default", "scheme",   "segments", "path",    "lights", "shadow",
    "rays",    "multiple", "rest",     "samples", NULL};

#define PAPER "render.path=direct render.scheme=paper"

// A new knob is one row: assignments that hold for the whole row (or ""), the
// parameter, its values.
static const struct knob {
    const char *group, *with, *name, *values;
    unsigned flags;
} knobs[] = {
    // scheme, tables and segments bear upon what is lit directly
    {"scheme", "render.path=direct", "render.scheme", "paper best", Q | I},
    {"scheme", PAPER, "render.tables", "1 4", I},
    {"segments", PAPER " render.nodes=paper", "render.m", "2 4 6 8 16", I},
    {"segments", PAPER " render.nodes=paper", "render.m", "200",
     I | BENCH_KNOBS_DEAR},
    {"segments", PAPER " render.nodes=fine", "render.m", "2 6 8 16", I},
    {"segments", PAPER " render.nodes=fine", "render.m", "200",
     I | BENCH_KNOBS_DEAR},
    {"path", "render.scheme=best", "render.path", "direct table forward",
     Q | I},
    {"path", "render.scheme=paper", "render.path", "direct forward", Q | I},
    {"lights", "", "sky.lights", "5 80", Q | S},
    {"lights", "", "sky.lights", "10 20 200", S},
    {"lights", "", "sky.fit", "plain", 0},
    {"lights", "", "quality.light_bound", "0 0.02 0.1", 0},
    {"shadow", "", "shadow.method", "off", Q | S},
    {"shadow", "", "shadow.resolution", "32 64 128 192", S},
    {"shadow", "", "shadow.directions", "coarse fine", S},
    {"rays", "", "shadow.rays", "1", Q},
    {"rays", "", "shadow.rays", "4 16", 0},
    {"multiple", "", "render.multiple", "off paper best", Q},
    // the picture at rest, in which no other error drowns in the field's
    {"rest", "shadow.rays=4 render.path=direct", "render.scheme", "paper best",
     0},
    {"rest", "shadow.rays=4", "render.multiple", "off paper best", 0},
    {"rest", "shadow.rays=4", "sky.lights", "5 10 20 80", 0},
    {"samples", "", "quality.samples", "4 16 64", BENCH_KNOBS_PICTURE},
};

int bench_knobs_group(const char *name)
{
    for (int i = 0; bench_knobs_groups[i]; i++)
        if (strcmp(bench_knobs_groups[i], name) == 0)
            return i;
    return 0;
}

// The next word of *at into out; false at the end.
static bool next_word(const char **at, char *out, size_t room)
{
    *at += strspn(*at, " ");
    const size_t n = strcspn(*at, " ");
    snprintf(out, room, "%.*s", (int)n, *at);
    *at += n;
    return n > 0;
}

// The word of a choice, or "" where there is no such parameter.
static struct span word_of(const struct params *p, const char *name)
{
    const struct params_row *row = params_find(name, strlen(name));
    if (!row || row->type != PARAMS_CHOICE)
        return (struct span){0};
    return edit_choice(row, (int)params_get(p, row, 0));
}

bool bench_knobs_forward(const struct params *p)
{
    static const char forward[] = "forward";
    const struct span path = word_of(p, "render.path");
    return path.size == sizeof forward - 1 &&
           memcmp(path.data, forward, path.size) == 0;
}

static void name_method(struct bench_setting *s)
{
    const struct span scheme = word_of(&s->params, "render.scheme");
    const struct span path = word_of(&s->params, "render.path");
    snprintf(s->method, sizeof s->method, "%.*s%s%.*s", (int)scheme.size,
             (const char *)scheme.data, path.size > 0 ? "-" : "",
             (int)path.size, (const char *)path.data);
}

// Applies assignments; what changed nothing is not mentioned in the text.
static bool apply(struct bench_setting *s, const char *assignments)
{
    char word[80];
    while (next_word(&assignments, word, sizeof word)) {
        const struct params before = s->params;
        struct error err = {0};
        if (!edit_apply_text(&s->params, word, &err))
            return false;
        if (params_changed(&before, &s->params) == 0)
            continue;
        const size_t n = strlen(s->text);
        snprintf(s->text + n, sizeof s->text - n, "%s%s", n > 0 ? " " : "",
                 word);
    }
    return true;
}

bool bench_knobs_wanted(const struct bench_setting *s, const char *only)
{
    char word[80];
    while (only && *only) {
        const size_t n = strcspn(only, ",");
        snprintf(word, sizeof word, "%.*s", (int)n, only);
        if (strstr(s->text, word) || strcmp(s->group, word) == 0)
            return true;
        only += n + (only[n] == ',');
    }
    return false;
}

static bool repeats(const struct bench_setting *list, int n,
                    const struct bench_setting *s)
{
    for (int i = 0; i < n; i++)
        if (params_changed(&list[i].params, &s->params) == 0)
            return true;
    return false;
}

int bench_knobs_list(const struct params *base, struct bench_choice *choice,
                     struct bench_setting *out)
{
    int n = 1;
    out[0] = (struct bench_setting){
        .group = "default", .params = *base, .text = "default"};
    out[0].flags = Q | I | S;
    name_method(&out[0]);
    choice->left_out = 0;
    for (size_t k = 0; k < sizeof knobs / sizeof knobs[0]; k++) {
        const struct knob *knob = &knobs[k];
        const char *values = knob->values;
        char value[40], assignment[96];
        if ((choice->quick && !(knob->flags & Q)) ||
            (!choice->first && (knob->flags & BENCH_KNOBS_DEAR)))
            continue;
        while (n < BENCH_KNOBS_MAX && next_word(&values, value, sizeof value)) {
            struct bench_setting s = {
                .group = knob->group, .params = *base, .flags = knob->flags};
            snprintf(assignment, sizeof assignment, "%s=%s", knob->name, value);
            if (!apply(&s, knob->with) || !apply(&s, assignment)) {
                choice->left_out++;
                continue;
            }
            name_method(&s);
            if (!repeats(out, n, &s) &&
                (!choice->only || bench_knobs_wanted(&s, choice->only)))
                out[n++] = s;
        }
    }
    return n;
}
