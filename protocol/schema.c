// schema.c - the table as JSON, Markdown and plain text.
#include "protocol/schema.h"

#include <math.h>
#include <string.h>

#include "protocol/edit.h"
#include "protocol/number.h"

#define COLUMNS 80
#define LEGAL_COLUMN 42 // after the name and the default

static const char *const type_names[] = {
    [PARAMS_FLOAT] = "float",   [PARAMS_INT] = "int", [PARAMS_BOOL] = "bool",
    [PARAMS_CHOICE] = "choice", [PARAMS_RGB] = "rgb", [PARAMS_VEC3] = "vec3",
};

static bool has_range(const struct params_row *row)
{
    return row->type != PARAMS_BOOL && row->type != PARAMS_CHOICE;
}

// --- JSON -------------------------------------------------------------------

void schema_value(struct json *j, const struct params *p,
                  const struct params_row *row)
{
    double first = params_get(p, row, 0);
    if (isnan(first)) {
        json_string(j, "auto");
    } else if (row->type == PARAMS_BOOL) {
        json_bool(j, first != 0);
    } else if (row->type == PARAMS_CHOICE) {
        json_span(j, edit_choice(row, (int)first));
    } else if (row->count == 1) {
        json_float(j, (float)first);
    } else {
        json_open_array(j);
        for (int i = 0; i < row->count; i++)
            json_float(j, (float)params_get(p, row, i));
        json_close_array(j);
    }
}

// The row's doc, and what it needs.
static void put_doc(struct buf *out, const struct params_row *row)
{
    const char *needs = params_needs(row);
    buf_text(out, row->doc);
    if (needs)
        buf_printf(out, ". Only with %s", needs);
}

// [["render.scheme","paper"],["sun1.strength"]]: any of them.
static void needs_json(struct json *j, const struct params_row *row)
{
    const char *at = params_needs(row);
    json_open_array(j);
    while (at && *at) {
        const size_t name = strcspn(at, "= ");
        const struct span key = {(const unsigned char *)at, name};
        at += name;
        do {
            json_open_array(j);
            json_span(j, key);
            if (*at == '=' || *at == '|') {
                const size_t word = strcspn(++at, "| ");
                json_span(j, (struct span){(const unsigned char *)at, word});
                at += word;
            }
            json_close_array(j);
        } while (*at == '|');
        at += strncmp(at, " or ", 4) == 0 ? 4 : strlen(at);
    }
    json_close_array(j);
}

static void row_json(struct json *j, const struct params *defaults,
                     const struct params_row *row)
{
    struct buf name = {0}, doc = {0};
    buf_printf(&name, "%s.%s", row->group_name, row->name);
    json_open_object(j);
    json_key(j, "name");
    json_span(j, (struct span){name.data, name.size});
    json_put_string(j, "group", row->group_name);
    json_put_string(j, "title", params_group_titles[row->group]);
    json_put_string(j, "type", type_names[row->type]);
    json_put_string(j, "unit", row->unit);
    json_key(j, "default");
    schema_value(j, defaults, row);
    json_put_number(j, "min", has_range(row) ? row->min : (double)NAN);
    json_put_number(j, "max", has_range(row) ? row->max : (double)NAN);
    json_key(j, "choices");
    json_open_array(j);
    for (int i = 0; edit_choice(row, i).size > 0; i++)
        json_span(j, edit_choice(row, i));
    json_close_array(j);
    json_put_bool(j, "auto", row->has_auto);
    json_key(j, "needs");
    needs_json(j, row);
    put_doc(&doc, row);
    json_key(j, "doc");
    json_span(j, (struct span){doc.data, doc.size});
    json_close_object(j);
    buf_finish(&name);
    buf_finish(&doc);
}

void schema_params(struct json *j)
{
    struct params defaults;
    params_defaults(&defaults);
    json_open_array(j);
    for (int r = 0; r < params_row_count; r++)
        row_json(j, &defaults, &params_rows[r]);
    json_close_array(j);
}

// --- text -------------------------------------------------------------------

// What may be written there: "0.1 .. 60", "jpeg, png, exr", "on, off".
static void legal(struct buf *out, const struct params_row *row,
                  const char *unit)
{
    char lo[NUMBER_BUFFER], hi[NUMBER_BUFFER];
    if (row->type == PARAMS_BOOL)
        buf_text(out, "on, off");
    for (int i = 0; edit_choice(row, i).size > 0; i++)
        buf_printf(out, "%s%.*s", i ? ", " : "", (int)edit_choice(row, i).size,
                   (const char *)edit_choice(row, i).data);
    if (has_range(row)) {
        number_print(lo, row->min);
        number_print(hi, row->max);
        buf_printf(out, "%s .. %s%s%s", lo, hi, unit[0] ? " " : "", unit);
    }
    if (row->has_auto)
        buf_text(out, " or auto");
}

static void table_row(struct buf *out, const struct params *defaults,
                      const struct params_row *row)
{
    buf_printf(out, "| `%s.%s` | %s | `", row->group_name, row->name,
               type_names[row->type]);
    edit_print(out, defaults, row);
    buf_text(out, "` | ");
    legal(out, row, "");
    buf_printf(out, " | %s | ", row->unit);
    struct buf doc = {0};
    put_doc(&doc, row);
    for (size_t i = 0; i < doc.size; i++) {
        if (doc.data[i] == '|')
            buf_byte(out, '\\');
        buf_byte(out, doc.data[i]);
    }
    buf_finish(&doc);
    buf_text(out, " |\n");
}

void schema_markdown(struct buf *out)
{
    struct params defaults;
    params_defaults(&defaults);
    for (int r = 0; r < params_row_count; r++) {
        const struct params_row *row = &params_rows[r];
        if (r == 0 || row->group != row[-1].group)
            buf_printf(out,
                       "%s### %s (`%s`)\n\n"
                       "| name | type | default | legal values | unit | what "
                       "it is |\n|---|---|---|---|---|---|\n",
                       r ? "\n" : "", params_group_titles[row->group],
                       row->group_name);
        table_row(out, &defaults, row);
    }
}

// Words of `text`, broken before column COLUMNS; `column` are written already,
// lines after the first are indented.
static void wrapped_from(struct buf *out, const char *text, size_t column,
                         size_t indent)
{
    bool first = column > 0; // what is written ends with its own blank
    while (*text) {
        size_t word = strcspn(text, " ");
        if (column > 0 && column + 1 + word > COLUMNS) {
            buf_byte(out, '\n');
            column = 0;
        }
        size_t blanks = column == 0 ? indent : first ? 0 : 1;
        first = false;
        buf_printf(out, "%*s%.*s", (int)blanks, "", (int)word, text);
        column += blanks + word;
        text += word;
        text += strspn(text, " ");
    }
    buf_byte(out, '\n');
}

static void wrapped(struct buf *out, const char *text, size_t indent)
{
    wrapped_from(out, text, 0, indent);
}

// "fibre.eta   1.55   1.05 .. 3", and the unit.
static void summary(struct buf *out, const struct params_row *row)
{
    struct params defaults;
    struct buf name = {0}, value = {0};
    params_defaults(&defaults);
    buf_printf(&name, "%s.%s", row->group_name, row->name);
    edit_print(&value, &defaults, row);
    buf_printf(out, "%-22.*s %-18.*s ", (int)name.size, (char *)name.data,
               (int)value.size, (char *)value.data);
    struct buf values = {0};
    legal(&values, row, row->unit);
    buf_byte(&values, 0);
    wrapped_from(out, (char *)values.data, LEGAL_COLUMN, LEGAL_COLUMN);
    buf_finish(&values);
    buf_finish(&name);
    buf_finish(&value);
}

static void heading(struct buf *out, const char *title)
{
    buf_printf(out, "%-22s %-18s %s\n", title, "default", "legal values");
}

void schema_help(struct buf *out, const struct params_row *row)
{
    heading(out, params_group_titles[row->group]);
    struct buf doc = {0};
    summary(out, row);
    put_doc(&doc, row);
    buf_byte(&doc, 0);
    wrapped(out, (char *)doc.data, 4);
    buf_finish(&doc);
}

void schema_help_all(struct buf *out)
{
    for (int r = 0; r < params_row_count; r++) {
        const struct params_row *row = &params_rows[r];
        if (r == 0 || row->group != row[-1].group) {
            buf_text(out, r ? "\n" : "");
            heading(out, params_group_titles[row->group]);
        }
        summary(out, row);
    }
}
