// scale.c - exponents, tables, plots.
#include "tests/bench/scale.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "protocol/json.h"
#include "server/chart.h"

const char *const scale_edits[SCALE_EDITS] = {"fibre", "light colour",
                                              "camera"};

uint64_t scale_memory(const struct scale_row *r)
{
    return r->strands + r->shadow + r->cache + r->targets + r->tables;
}

static double value(const struct scale_row *r, int column)
{
    return column < SCALE_EDITS ? r->cpu[column] : (double)scale_memory(r);
}

// Slope of log y over log x by least squares, of the rows from `from` on; NaN
// of fewer than two.
static double exponent(const struct scale_sweep *s, int column, int from)
{
    double n = 0, sx = 0, sy = 0, sxx = 0, sxy = 0;
    for (int i = from; i < s->rows; i++) {
        const struct scale_row *r = &s->row[i];
        if (r->refused[0])
            continue;
        const double x = log(r->x), y = log(value(r, column));
        n++;
        sx += x;
        sy += y;
        sxx += x * x;
        sxy += x * y;
    }
    return n < 2 ? NAN : (n * sxy - sx * sy) / (n * sxx - sx * sx);
}

static int measured(const struct scale_sweep *s)
{
    int n = 0;
    for (int i = 0; i < s->rows; i++)
        n += !s->row[i].refused[0];
    return n;
}

void scale_json(const struct scale_sweep *s, const struct scale_row *r,
                struct buf *out)
{
    struct json j = json_begin(out);
    json_open_object(&j);
    json_put_string(&j, "sweep", s->name);
    json_put_number(&j, "x", r->x);
    if (r->refused[0]) {
        json_put_string(&j, "refused", r->refused);
    } else {
        for (int i = 0; i < SCALE_EDITS; i++) {
            char key[32];
            snprintf(key, sizeof key, "%s_ms",
                     i == 1 ? "colour" : scale_edits[i]);
            json_put_number(&j, key, r->ms[i]);
            snprintf(key, sizeof key, "%s_cpu_ms",
                     i == 1 ? "colour" : scale_edits[i]);
            json_put_number(&j, key, r->cpu[i]);
        }
        json_put_int(&j, "visible", r->points);
        json_put_int(&j, "strand_points", r->strand_points);
        json_put_int(&j, "lights", r->lights);
        json_put_int(&j, "tables", r->light_tables);
        json_put_int(&j, "tables_missing", r->missing);
        json_put_string(&j, "path", r->path);
        json_put_int(&j, "memory", (int64_t)scale_memory(r));
        json_put_int(&j, "memory_strands", (int64_t)r->strands);
        json_put_int(&j, "memory_shadow", (int64_t)r->shadow);
        json_put_int(&j, "memory_cache", (int64_t)r->cache);
        json_put_int(&j, "memory_targets", (int64_t)r->targets);
        json_put_int(&j, "memory_tables", (int64_t)r->tables);
    }
    json_close_object(&j);
    buf_byte(out, '\n');
}

void scale_summary(const struct scale_sweep *s, struct buf *out)
{
    const int first = measured(s) / 2; // what is refused comes last
    double low = INFINITY, high = 0;
    for (int i = 0; i < s->rows; i++)
        if (!s->row[i].refused[0]) {
            low = fmin(low, s->row[i].x);
            high = fmax(high, s->row[i].x);
        }
    buf_printf(out, "| [%s](#%s) | %.4g to %.4g (x%.3g) |", s->name, s->id, low,
               high, high / low);
    for (int i = 0; i <= SCALE_EDITS; i++) {
        const double upper = exponent(s, i, first);
        buf_printf(out, isnan(upper) ? " %.2f |" : " %.2f (%.2f) |",
                   exponent(s, i, 0), upper);
    }
    buf_text(out, "\n");
}

static double megabytes(uint64_t bytes)
{
    return (double)bytes / 1e6;
}

void scale_section(const struct scale_sweep *s, const char *plot,
                   struct buf *out)
{
    buf_printf(out, "\n## %s\n\n%s\n\n", s->name, s->about);
    if (plot)
        buf_printf(out, "![edit time over %s](%s)\n\n", s->x, plot);
    buf_printf(
        out,
        "| %s | fibre ms | light colour ms | camera ms | visible places "
        "| lights | without a table | their tables | path | MB | of that "
        "strands "
        "| shadow | cache | targets | tables |\n"
        "|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|\n",
        s->x);
    for (int i = 0; i < s->rows; i++) {
        const struct scale_row *r = &s->row[i];
        if (r->label[0])
            buf_printf(out, "| %s |", r->label);
        else
            buf_printf(out, "| %.0f |", r->x);
        if (r->refused[0]) {
            buf_printf(out, " refused: %s | | | | | | | | | | | | | |\n",
                       r->refused);
            continue;
        }
        for (int e = 0; e < SCALE_EDITS; e++)
            buf_printf(out, " %.4g (%.4g) |", r->ms[e], r->cpu[e]);
        buf_printf(out, " %u | %d | %d | %d | %s |", r->points, r->lights,
                   r->missing, r->light_tables, r->path);
        buf_printf(out, " %.4g | %.4g | %.4g | %.4g | %.4g | %.4g |\n",
                   megabytes(scale_memory(r)), megabytes(r->strands),
                   megabytes(r->shadow), megabytes(r->cache),
                   megabytes(r->targets), megabytes(r->tables));
    }
}

void scale_plot(const struct scale_sweep *s, const char *device,
                struct buf *out)
{
    struct chart_point *p = bytes_zalloc(CHART_POINTS_MAX, sizeof *p);
    char title[120], names[SCALE_EDITS][64];
    struct chart c = {.title = title,
                      .note = device,
                      .x_title = s->x,
                      .y_title = "ms of all processors for an edit, median",
                      .point = p,
                      .series = true};
    snprintf(title, sizeof title, "an edit's time over %s", s->x);
    for (int e = 0; e < SCALE_EDITS; e++) {
        snprintf(names[e], sizeof names[e], "%s: x^%.2f", scale_edits[e],
                 exponent(s, e, 0));
        c.groups[e] = names[e];
        for (int i = 0; i < s->rows; i++)
            if (!s->row[i].refused[0])
                p[c.count++] = (struct chart_point){
                    .x = s->row[i].x,
                    .y = s->row[i].cpu[e],
                    .low = NAN,
                    .high = NAN,
                    .label = "",
                    .group = e,
                };
    }
    chart_svg(&c, out);
    free(p);
}
