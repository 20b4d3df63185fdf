// params.c - the table made from params.def, and plain access to it.  Text is
// parsed and printed in edit.c; nothing is checked here.
#include "protocol/params.h"

#include <math.h>
#include <string.h>

#define AT(g, n) offsetof(struct params, g.n)
#define GROUP(g, title)
// clang-format off
#define FLOAT(g, n, def, lo, hi, unit, doc)                                    \
    {GROUP_##g, #g, #n, PARAMS_FLOAT, false, {def}, lo, hi, unit, NULL, doc,   \
     AT(g, n), 1},
#define AUTO(g, n, lo, hi, unit, doc)                                          \
    {GROUP_##g, #g, #n, PARAMS_FLOAT, true, {NAN}, lo, hi, unit, NULL, doc,    \
     AT(g, n), 1},
#define INT(g, n, def, lo, hi, unit, doc)                                      \
    {GROUP_##g, #g, #n, PARAMS_INT, false, {def}, lo, hi, unit, NULL, doc,     \
     AT(g, n), 1},
#define BOOL(g, n, def, doc)                                                   \
    {GROUP_##g, #g, #n, PARAMS_BOOL, false, {def}, 0, 1, "", NULL, doc,        \
     AT(g, n), 1},
#define CHOICE(g, n, def, words, doc)                                          \
    {GROUP_##g, #g, #n, PARAMS_CHOICE, false, {def}, 0, 0, "", words, doc,     \
     AT(g, n), 1},
#define RGB(g, n, r, gr, b, lo, hi, unit, doc)                                 \
    {GROUP_##g, #g, #n, PARAMS_RGB, false, {r, gr, b}, lo, hi, unit, NULL,     \
     doc, AT(g, n), 3},
#define VEC3(g, n, lo, hi, unit, doc)                                          \
    {GROUP_##g, #g, #n, PARAMS_VEC3, true, {NAN, NAN, NAN}, lo, hi, unit,      \
     NULL, doc, AT(g, n), 3},
// clang-format on
#define END(g)
const struct params_row params_rows[] = {
#include "protocol/params.def"
};
const int params_row_count = sizeof params_rows / sizeof params_rows[0];
#undef GROUP
#undef FLOAT
#undef AUTO
#undef INT
#undef BOOL
#undef CHOICE
#undef RGB
#undef VEC3

#define FLOAT(g, n, def, lo, hi, unit, doc)
#define AUTO(g, n, lo, hi, unit, doc)
#define INT(g, n, def, lo, hi, unit, doc)
#define BOOL(g, n, def, doc)
#define CHOICE(g, n, def, words, doc)
#define RGB(g, n, r, gr, b, lo, hi, unit, doc)
#define VEC3(g, n, lo, hi, unit, doc)
#define GROUP(g, title) #g,
const char *const params_group_names[PARAMS_GROUPS] = {
#include "protocol/params.def"
};
#undef GROUP
#define GROUP(g, title) title,
const char *const params_group_titles[PARAMS_GROUPS] = {
#include "protocol/params.def"
};
#undef GROUP

#define GROUP(g, title)
#define NEEDS(g, n, what) {AT(g, n), what},
static const struct {
    size_t offset;
    const char *what;
} needs[] = {
#include "protocol/params.def"
};

const char *params_needs(const struct params_row *row)
{
    for (size_t i = 0; i < sizeof needs / sizeof needs[0]; i++)
        if (needs[i].offset == row->offset)
            return needs[i].what;
    return NULL;
}

static bool is_integer(const struct params_row *row)
{
    return row->type == PARAMS_INT || row->type == PARAMS_BOOL ||
           row->type == PARAMS_CHOICE;
}

double params_get(const struct params *p, const struct params_row *row, int i)
{
    const char *at = (const char *)p + row->offset + (size_t)i * 4;
    if (is_integer(row)) {
        int32_t v;
        memcpy(&v, at, sizeof v);
        return v;
    }
    float v;
    memcpy(&v, at, sizeof v);
    return (double)v;
}

void params_put(struct params *p, const struct params_row *row, int i,
                double value)
{
    char *at = (char *)p + row->offset + (size_t)i * 4;
    if (is_integer(row)) {
        int32_t v = (int32_t)lround(value);
        memcpy(at, &v, sizeof v);
    } else {
        float v = (float)value;
        memcpy(at, &v, sizeof v);
    }
}

void params_defaults(struct params *p)
{
    memset(p, 0, sizeof *p);
    for (int r = 0; r < params_row_count; r++)
        for (int i = 0; i < params_rows[r].count; i++)
            params_put(p, &params_rows[r], i, params_rows[r].def[i]);
}

const struct params_row *params_find(const char *name, size_t length)
{
    const char *dot = memchr(name, '.', length);
    if (!dot)
        return NULL;
    size_t group = (size_t)(dot - name), rest = length - group - 1;
    for (int r = 0; r < params_row_count; r++) {
        const struct params_row *row = &params_rows[r];
        if (strlen(row->group_name) == group &&
            memcmp(row->group_name, name, group) == 0 &&
            strlen(row->name) == rest && memcmp(row->name, dot + 1, rest) == 0)
            return row;
    }
    return NULL;
}

uint32_t params_changed(const struct params *a, const struct params *b)
{
    uint32_t changed = 0;
    for (int r = 0; r < params_row_count; r++)
        for (int i = 0; i < params_rows[r].count; i++) {
            double x = params_get(a, &params_rows[r], i);
            double y = params_get(b, &params_rows[r], i);
            if (x != y && !(isnan(x) && isnan(y)))
                changed |= 1u << params_rows[r].group;
        }
    return changed;
}

void params_fibre_resolve(struct params *p)
{
    if (isnan(p->fibre.alpha_tt))
        p->fibre.alpha_tt = -p->fibre.alpha_r / 2;
    if (isnan(p->fibre.alpha_trt))
        p->fibre.alpha_trt = -3 * p->fibre.alpha_r / 2;
    if (isnan(p->fibre.beta_tt))
        p->fibre.beta_tt = fmaxf(0.1f, p->fibre.beta_r / 2);
    if (isnan(p->fibre.beta_trt))
        p->fibre.beta_trt = fminf(60, 2 * p->fibre.beta_r);
}
