// chart_rows.c - one line of pixels after the other.
#include "server/chart_rows.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "server/chart_private.h"

enum { LEFT = 250, RIGHT = 970, TOP = 76, ROW = 13, GAP = 7 };

struct sheet {
    const struct chart_rows *c;
    struct buf *out;
    struct chart_axis x;
    double y[CHART_ROWS_MAX], bottom;
};

static void place(struct sheet *s)
{
    double y = TOP;
    s->x = (struct chart_axis){INFINITY, -INFINITY, LEFT, RIGHT};
    for (int i = 0; i < s->c->count; i++) {
        const struct chart_row *r = &s->c->row[i];
        y += i > 0 && r->label ? ROW + GAP : ROW;
        s->y[i] = y;
        chart_widen(&s->x, r->least);
        chart_widen(&s->x, r->p95);
        chart_widen(&s->x, r->target);
        chart_widen(&s->x, r->other);
    }
    s->bottom = y + ROW;
    chart_settle(&s->x);
}

static void ticks(const struct sheet *s)
{
    static const double steps[] = {1, 2, 5};
    for (int d = (int)floor(s->x.low); d <= (int)ceil(s->x.high); d++)
        for (int i = 0; i < 3; i++) {
            const double v = steps[i] * pow(10, d);
            if (log10(v) < s->x.low || log10(v) > s->x.high)
                continue;
            const double x = chart_put(&s->x, v);
            buf_printf(s->out,
                       "<path d=\"M%.1f %dV%.1f\" stroke=\"#e4e4e4\"/>\n"
                       "<text x=\"%.1f\" y=\"%.1f\" "
                       "text-anchor=\"middle\">%g</text>\n",
                       x, TOP, s->bottom, x, s->bottom + 14, v);
        }
}

static void diamond(struct buf *out, double x, double y, const char *colour)
{
    buf_printf(out,
               "<path d=\"M%.1f %.1fl4 4l-4 4l-4 -4z\" fill=\"#ffffff\" "
               "stroke=\"%s\"/>\n",
               x, y - 4, colour);
}

static void target(struct buf *out, double x, double y, const char *colour)
{
    buf_printf(out,
               "<path d=\"M%.1f %.1fv10\" stroke=\"%s\" "
               "stroke-width=\"3\"/>\n",
               x, y - 5, colour);
}

static void row(const struct sheet *s, int i)
{
    const struct chart_row *r = &s->c->row[i];
    const char *colour = chart_colours[r->group % CHART_GROUPS_MAX];
    char at[96];
    snprintf(at, sizeof at, "x=\"%d\" y=\"%.1f\" text-anchor=\"end\"", LEFT - 8,
             s->y[i] + 3.5);
    if (r->label)
        chart_text(s->out, at, r->label);
    if (isfinite(r->target) && r->target > 0)
        target(s->out, chart_put(&s->x, r->target), s->y[i], colour);
    if (isfinite(r->other) && r->other > 0)
        diamond(s->out, chart_put(&s->x, r->other), s->y[i], colour);
    if (!(r->least > 0 && r->median > 0 && isfinite(r->p95)))
        return;
    buf_printf(s->out,
               "<path d=\"M%.1f %.1fH%.1f\" stroke=\"%s\" "
               "stroke-opacity=\"0.5\" stroke-width=\"3\"/>\n"
               "<circle cx=\"%.1f\" cy=\"%.1f\" r=\"3.5\" fill=\"%s\"/>\n",
               chart_put(&s->x, r->least), s->y[i], chart_put(&s->x, r->p95),
               colour, chart_put(&s->x, r->median), s->y[i], colour);
}

static void legend(const struct sheet *s)
{
    double x = LEFT;
    char at[80];
    for (int g = 0; g < CHART_GROUPS_MAX && s->c->groups[g]; g++) {
        buf_printf(s->out,
                   "<circle cx=\"%.1f\" cy=\"56\" r=\"3.5\" fill=\"%s\"/>\n", x,
                   chart_colours[g]);
        snprintf(at, sizeof at, "x=\"%.1f\" y=\"60\"", x + 9);
        chart_text(s->out, at, s->c->groups[g]);
        x += 26 + CHART_CHARACTER * (double)strlen(s->c->groups[g]);
    }
    target(s->out, x, 56, "#444444");
    snprintf(at, sizeof at, "x=\"%.1f\" y=\"60\"", x + 9);
    chart_text(s->out, at, s->c->target);
    x += 26 + CHART_CHARACTER * (double)strlen(s->c->target);
    diamond(s->out, x, 56, "#444444");
    snprintf(at, sizeof at, "x=\"%.1f\" y=\"60\"", x + 9);
    chart_text(s->out, at, s->c->other);
}

void chart_rows_svg(const struct chart_rows *c, struct buf *out)
{
    struct sheet s = {.c = c, .out = out};
    char at[96];
    place(&s);
    chart_begin(out, RIGHT + 30, (int)s.bottom + 44);
    chart_text(out, "x=\"16\" y=\"22\" font-size=\"14\"", c->title);
    chart_text(out, "x=\"16\" y=\"38\" fill=\"#555555\"", c->note);
    snprintf(at, sizeof at, "x=\"%d\" y=\"%.1f\" text-anchor=\"middle\"",
             (LEFT + RIGHT) / 2, s.bottom + 32);
    chart_text(out, at, c->x_title);
    ticks(&s);
    buf_printf(out,
               "<rect x=\"%d\" y=\"%d\" width=\"%d\" height=\"%.1f\" "
               "fill=\"none\" stroke=\"#444444\"/>\n",
               LEFT, TOP, RIGHT - LEFT, s.bottom - TOP);
    legend(&s);
    for (int i = 0; i < c->count; i++)
        row(&s, i);
    buf_text(out, "</svg>\n");
}
