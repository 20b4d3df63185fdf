// edit.c - values as text, checked against the table.  What a changed value
// makes stale is decided elsewhere (params_changed).
#include "protocol/edit.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "protocol/number.h"
#include "protocol/utf8.h"

#define FULL_NAME 160   // "group.name" with room to spare
#define SHOWN 40        // bytes of a refused value that an error repeats
#define NEAREST_MAX 64u // longest name for which a near one is looked for

static struct span text_span(const char *s)
{
    return (struct span){(const unsigned char *)s, strlen(s)};
}

static void full_name(const struct params_row *row, char out[FULL_NAME])
{
    snprintf(out, FULL_NAME, "%s.%s", row->group_name, row->name);
}

// --- errors -----------------------------------------------------------------

// The refused text, cut short, between quotes unless it is a plain number.
struct shown {
    char text[SHOWN + 8];
};

static struct shown show(struct span value)
{
    struct shown s;
    double ignored;
    int n = (int)utf8_cut(value, SHOWN);
    bool number = number_parse(value, &ignored);
    snprintf(s.text, sizeof s.text, "%s%.*s%s%s", number ? "" : "\"", n,
             (const char *)value.data, (size_t)n < value.size ? "..." : "",
             number ? "" : "\"");
    return s;
}

static bool bad_range(const struct params_row *row, struct span value,
                      struct error *err)
{
    char name[FULL_NAME], lo[NUMBER_BUFFER], hi[NUMBER_BUFFER];
    full_name(row, name);
    number_print(lo, row->min);
    number_print(hi, row->max);
    return error_set(err, "range", name, "%s: %s is not within [%s, %s]%s%s",
                     name, show(value).text, lo, hi, row->unit[0] ? " " : "",
                     row->unit);
}

static bool bad_type(const struct params_row *row, struct span value,
                     const char *wanted, struct error *err)
{
    char name[FULL_NAME];
    full_name(row, name);
    return error_set(err, "type", name, "%s: %s is not %s%s", name,
                     show(value).text, wanted, row->has_auto ? " or auto" : "");
}

// --- names ------------------------------------------------------------------

// Edit distance (Levenshtein): one row of the table at a time.
static int distance(struct span a, struct span b)
{
    int row[NEAREST_MAX + 1];
    if (a.size > NEAREST_MAX || b.size > NEAREST_MAX)
        return (int)NEAREST_MAX;
    for (size_t j = 0; j <= b.size; j++)
        row[j] = (int)j;
    for (size_t i = 0; i < a.size; i++) {
        int diagonal = row[0];
        row[0] = (int)i + 1;
        for (size_t j = 0; j < b.size; j++) {
            int best = diagonal + (a.data[i] != b.data[j]);
            diagonal = row[j + 1];
            if (row[j] + 1 < best)
                best = row[j] + 1;
            if (row[j + 1] + 1 < best)
                best = row[j + 1] + 1;
            row[j + 1] = best;
        }
    }
    return row[b.size];
}

// The row whose name is nearest, if it is near at all.  A name without its
// group ("sigma_a") is compared with names without theirs.
static const struct params_row *nearest(struct span name)
{
    const struct params_row *best = NULL;
    int least = 1 + (int)(name.size / 3);
    bool whole = name.size > 0 && memchr(name.data, '.', name.size) != NULL;
    for (int r = 0; r < params_row_count; r++) {
        const struct params_row *row = &params_rows[r];
        char full[FULL_NAME];
        full_name(row, full);
        int d = distance(name, text_span(whole ? full : row->name));
        if (d < least) {
            least = d;
            best = row;
        }
    }
    return best;
}

const struct params_row *edit_find(struct span name, struct error *err)
{
    const struct params_row *row =
        params_find((const char *)name.data, name.size);
    if (row)
        return row;
    char given[LINE_NAME_MAX], full[FULL_NAME];
    int shown = (int)utf8_cut(name, sizeof given - 1);
    snprintf(given, sizeof given, "%.*s", shown, (const char *)name.data);
    const struct params_row *near = nearest(name);
    if (near) {
        full_name(near, full);
        error_set(err, "unknown", given,
                  "%s: no such parameter; did you mean %s?", given, full);
    } else {
        error_set(err, "unknown", given,
                  "%s: no such parameter; `schema` lists them all", given);
    }
    return NULL;
}

struct span edit_choice(const struct params_row *row, int i)
{
    const char *at = row->choices;
    for (; at && i > 0; i--) {
        at = strchr(at, '|');
        if (at)
            at++;
    }
    if (!at || i < 0)
        return (struct span){NULL, 0};
    return (struct span){(const unsigned char *)at, strcspn(at, "|")};
}

// --- one value --------------------------------------------------------------

static bool equal(struct span a, const char *b)
{
    return line_is(a, b);
}

static bool put_choice(struct params *p, const struct params_row *row,
                       struct span value, struct error *err)
{
    struct buf words = {0};
    for (int i = 0;; i++) {
        struct span word = edit_choice(row, i);
        if (word.size == 0)
            break;
        if (word.size == value.size &&
            memcmp(word.data, value.data, word.size) == 0) {
            buf_finish(&words);
            params_put(p, row, 0, i);
            return true;
        }
        buf_printf(&words, "%s%.*s", i ? ", " : "one of ", (int)word.size,
                   (const char *)word.data);
    }
    buf_byte(&words, 0);
    bad_type(row, value, (const char *)words.data, err);
    buf_finish(&words);
    return false;
}

static bool put_bool(struct params *p, const struct params_row *row,
                     struct span value, struct error *err)
{
    bool on = equal(value, "on") || equal(value, "true") || equal(value, "1");
    bool off =
        equal(value, "off") || equal(value, "false") || equal(value, "0");
    if (!on && !off)
        return bad_type(row, value, "on or off", err);
    params_put(p, row, 0, on);
    return true;
}

static bool put_int(struct params *p, const struct params_row *row,
                    struct span value, struct error *err)
{
    double v;
    if (!number_parse(value, &v) || v != trunc(v))
        return bad_type(row, value, "a whole number", err);
    if (!(v >= row->min && v <= row->max))
        return bad_range(row, value, err);
    params_put(p, row, 0, v);
    return true;
}

static bool put_auto(struct params *p, const struct params_row *row)
{
    for (int i = 0; i < row->count; i++)
        params_put(p, row, i, (double)NAN);
    return true;
}

// Splits at commas; returns how many parts there are, at most 4.
static int split(struct span value, struct span part[4])
{
    int n = 0;
    while (n < 4) {
        const unsigned char *comma =
            value.size > 0 ? memchr(value.data, ',', value.size) : NULL;
        part[n] = value;
        if (!comma)
            return n + 1;
        part[n].size = (size_t)(comma - value.data);
        value.size -= part[n].size + 1;
        value.data = comma + 1;
        n++;
    }
    return n;
}

// A float, or a tuple of them.
static bool put_floats(struct params *p, const struct params_row *row,
                       struct span value, struct error *err)
{
    static const char *const wanted[] = {
        [PARAMS_FLOAT] = "a number",
        [PARAMS_RGB] = "a number, or three joined by commas,",
        [PARAMS_VEC3] = "three numbers joined by commas"};
    double v[4];
    struct span part[4];
    int n = split(value, part);
    bool count = n == row->count || (n == 1 && row->type == PARAMS_RGB);
    for (int i = 0; i < n; i++)
        if (!count || !number_parse(part[i], &v[i]))
            return bad_type(row, value, wanted[row->type], err);
    for (int i = 0; i < n; i++)
        if (!(v[i] >= row->min && v[i] <= row->max))
            return bad_range(row, part[i], err);
    for (int i = 0; i < row->count; i++)
        params_put(p, row, i, v[n == 1 ? 0 : i]);
    return true;
}

static bool put(struct params *p, struct span name, struct span value,
                struct error *err)
{
    const struct params_row *row = edit_find(name, err);
    if (!row)
        return false;
    if (row->has_auto && equal(value, "auto"))
        return put_auto(p, row);
    switch (row->type) {
    case PARAMS_CHOICE:
        return put_choice(p, row, value, err);
    case PARAMS_BOOL:
        return put_bool(p, row, value, err);
    case PARAMS_INT:
        return put_int(p, row, value, err);
    case PARAMS_FLOAT:
    case PARAMS_RGB:
    case PARAMS_VEC3:
        break;
    }
    return put_floats(p, row, value, err);
}

// --- edits ------------------------------------------------------------------

static bool check_pixels(const char *name, int64_t width, int64_t height,
                         struct error *err)
{
    if (width * height <= EDIT_PIXELS_MAX)
        return true;
    return error_set(err, "range", name,
                     "%s: %lld x %lld is %.1f megapixels, more than the %d "
                     "that a picture may have",
                     name, (long long)width, (long long)height,
                     (double)(width * height) / 1e6, EDIT_PIXELS_MAX / 1000000);
}

bool edit_apply(struct params *p, const struct line_pair *pairs, int count,
                struct error *err)
{
    struct params next = *p;
    for (int i = 0; i < count; i++)
        if (!put(&next, pairs[i].name, pairs[i].value, err))
            return false;
    if (!check_pixels("image", next.image.width, next.image.height, err))
        return false;
    *p = next;
    return true;
}

bool edit_apply_text(struct params *p, const char *assignment,
                     struct error *err)
{
    const char *sign = strchr(assignment, '=');
    struct span all = text_span(assignment);
    if (!utf8_valid(all))
        return error_set(err, "syntax", "", "an assignment is not UTF-8");
    if (!sign)
        return error_set(err, "syntax", "",
                         "\"%.*s\" is not of the form group.name=value",
                         (int)utf8_cut(all, SHOWN), assignment);
    struct line_pair pair = {
        .name = {all.data, (size_t)(sign - assignment)},
        .value = text_span(sign + 1),
    };
    return edit_apply(p, &pair, 1, err);
}

void edit_print(struct buf *out, const struct params *p,
                const struct params_row *row)
{
    char text[NUMBER_BUFFER];
    double first = params_get(p, row, 0);
    struct span word;
    switch (row->type) {
    case PARAMS_CHOICE:
        word = edit_choice(row, (int)first);
        buf_append(out, word.data, word.size);
        return;
    case PARAMS_BOOL:
        buf_text(out, first != 0 ? "on" : "off");
        return;
    case PARAMS_INT:
        buf_printf(out, "%d", (int)first);
        return;
    case PARAMS_FLOAT:
    case PARAMS_RGB:
    case PARAMS_VEC3:
        break;
    }
    if (isnan(first)) {
        buf_text(out, "auto");
        return;
    }
    for (int i = 0; i < row->count; i++) {
        number_print_float(text, (float)params_get(p, row, i));
        buf_printf(out, "%s%s", i ? "," : "", text);
    }
}

bool edit_size(struct span text, const char *name, int *width, int *height,
               struct error *err)
{
    const struct params_row *w = params_find("image.width", 11);
    const struct params_row *h = params_find("image.height", 12);
    uint64_t wide, high;
    const unsigned char *x =
        text.size > 0 ? memchr(text.data, 'x', text.size) : NULL;
    size_t left = x ? (size_t)(x - text.data) : 0;
    if (!x ||
        !number_parse_u64((struct span){text.data, left}, INT32_MAX, &wide) ||
        !number_parse_u64((struct span){x + 1, text.size - left - 1}, INT32_MAX,
                          &high))
        return error_set(err, "type", name,
                         "%s: %s is not of the form WIDTHxHEIGHT", name,
                         show(text).text);
    if ((double)wide < w->min || (double)wide > w->max ||
        (double)high < h->min || (double)high > h->max)
        return error_set(err, "range", name,
                         "%s: %s is not within [%.0f, %.0f] by [%.0f, %.0f] "
                         "pixels",
                         name, show(text).text, w->min, w->max, h->min, h->max);
    if (!check_pixels(name, (int64_t)wide, (int64_t)high, err))
        return false;
    *width = (int)wide;
    *height = (int)high;
    return true;
}
