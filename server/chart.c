// chart.c - axes, marks and front.  Where labels go is chart_labels.c's.
#include "server/chart.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "server/chart_private.h"

const char *const chart_colours[CHART_GROUPS_MAX] = {
    "#1b6ca8", "#c2410c", "#2e7d32", "#7b3fa0", "#b8860b", "#00838f",
    "#ad1457", "#5d4037", "#455a64", "#6a8f00", "#d81b60", "#3949ab"};

static bool usable(const struct chart_point *p)
{
    return isfinite(p->x) && isfinite(p->y) && p->x > 0 && p->y > 0;
}

void chart_front(struct chart_point *p, int count)
{
    for (int i = 0; i < count; i++) {
        p[i].front = usable(&p[i]);
        for (int k = 0; k < count && p[i].front; k++)
            if (usable(&p[k]) && p[k].x <= p[i].x && p[k].y <= p[i].y &&
                (p[k].x < p[i].x || p[k].y < p[i].y))
                p[i].front = false;
    }
}

void chart_escape(struct buf *out, const char *text)
{
    for (; *text; text++)
        switch (*text) {
        case '&':
            buf_text(out, "&amp;");
            break;
        case '<':
            buf_text(out, "&lt;");
            break;
        case '>':
            buf_text(out, "&gt;");
            break;
        case '"':
            buf_text(out, "&quot;");
            break;
        default:
            buf_byte(out, (unsigned char)*text);
        }
}

// --- axes --------------------------------------------------------------------

double chart_put(const struct chart_axis *a, double v)
{
    return a->from +
           (log10(v) - a->low) / (a->high - a->low) * (a->to - a->from);
}

void chart_widen(struct chart_axis *a, double v)
{
    if (!(isfinite(v) && v > 0))
        return;
    a->low = fmin(a->low, log10(v));
    a->high = fmax(a->high, log10(v));
}

void chart_settle(struct chart_axis *a)
{
    const double least = log10(4), middle = 0.5 * (a->low + a->high);
    const double half = fmax(0.5 * least, 0.54 * (a->high - a->low) + 0.02);
    if (!(a->high >= a->low)) // no point at all
        *a = (struct chart_axis){-1, 1, a->from, a->to};
    else
        a->low = middle - half, a->high = middle + half;
}

static void tick(struct buf *out, const struct chart_axis *a, double v,
                 bool across)
{
    const double at = chart_put(a, v);
    if (across)
        buf_printf(out,
                   "<line x1=\"%.1f\" y1=\"%d\" x2=\"%.1f\" y2=\"%d\" "
                   "stroke=\"#e4e4e4\"/>\n<text x=\"%.1f\" y=\"%d\" "
                   "text-anchor=\"middle\">%g</text>\n",
                   at, CHART_TOP, at, CHART_BOTTOM, at, CHART_BOTTOM + 16, v);
    else
        buf_printf(out,
                   "<line x1=\"%d\" y1=\"%.1f\" x2=\"%d\" y2=\"%.1f\" "
                   "stroke=\"#e4e4e4\"/>\n<text x=\"%d\" y=\"%.1f\" "
                   "text-anchor=\"end\">%g</text>\n",
                   CHART_LEFT, at, CHART_RIGHT, at, CHART_LEFT - 6, at + 3.5,
                   v);
}

// At 1, 2 and 5 of every decade; on long axes at 1 alone.
static void ticks(struct buf *out, const struct chart_axis *a, bool across)
{
    static const double steps[] = {1, 2, 5};
    const int n = a->high - a->low > 2.5 ? 1 : 3;
    for (int d = (int)floor(a->low); d <= (int)ceil(a->high); d++)
        for (int i = 0; i < n; i++) {
            const double v = steps[i] * pow(10, d);
            if (log10(v) >= a->low && log10(v) <= a->high)
                tick(out, a, v, across);
        }
}

// --- marks -------------------------------------------------------------------

static void mark(struct buf *out, int group, bool front, double x, double y)
{
    const char *colour = chart_colours[group % CHART_GROUPS_MAX];
    const double r = 4;
    buf_printf(out, "<path d=\"");
    switch (group % 4) {
    case 0: // circle
        buf_printf(out, "M%.1f %.1fa%g %g 0 1 0 %g 0a%g %g 0 1 0 %g 0z", x - r,
                   y, r, r, 2 * r, r, r, -2 * r);
        break;
    case 1: // square
        buf_printf(out, "M%.1f %.1fh7v7h-7z", x - 3.5, y - 3.5);
        break;
    case 2: // diamond
        buf_printf(out, "M%.1f %.1fl5 5l-5 5l-5 -5z", x, y - 5);
        break;
    default: // triangle
        buf_printf(out, "M%.1f %.1fl4.6 8h-9.2z", x, y - 5);
    }
    buf_printf(out, "\" fill=\"%s\" stroke=\"%s\" stroke-width=\"1.3\"/>\n",
               front ? colour : "#ffffff", colour);
}

static void bar(struct buf *out, const struct chart_axis *y, double x,
                const struct chart_point *p)
{
    if (!(p->low > 0 && p->high >= p->low && isfinite(p->high)))
        return;
    const double low = fmin(chart_put(y, p->low), CHART_BOTTOM);
    const double high = fmax(chart_put(y, p->high), CHART_TOP);
    buf_printf(out,
               "<path d=\"M%.1f %.1fV%.1f\" stroke=\"%s\" "
               "stroke-opacity=\"0.45\" fill=\"none\"/>\n",
               x, low, high, chart_colours[p->group % CHART_GROUPS_MAX]);
}

// The border of what is reached: down a step at each point of the front.
static void front_line(struct buf *out, const struct chart *c,
                       const struct chart_axis *ax, const struct chart_axis *ay)
{
    double x = 0, y = 0;
    bool any = false;
    buf_text(out, "<path fill=\"none\" stroke=\"#888888\" "
                  "stroke-dasharray=\"5 3\" d=\"");
    for (;;) { // by rising x; the next one right of the last
        const struct chart_point *next = NULL;
        for (int i = 0; i < c->count; i++) {
            const struct chart_point *p = &c->point[i];
            if (p->front && (!any || p->x > x) && (!next || p->x < next->x))
                next = p;
        }
        if (!next)
            break;
        const double px = chart_put(ax, next->x), py = chart_put(ay, next->y);
        if (any)
            buf_printf(out, "H%.1fV%.1f", px, py);
        else
            buf_printf(out, "M%.1f %dV%.1f", px, CHART_TOP, py);
        x = next->x;
        y = py;
        any = true;
    }
    if (any)
        buf_printf(out, "V%.1fH%d", y, CHART_RIGHT);
    else
        buf_text(out, "M0 0");
    buf_text(out, "\"/>\n");
}

void chart_text(struct buf *out, const char *attributes, const char *text)
{
    buf_printf(out, "<text %s>", attributes);
    chart_escape(out, text ? text : "");
    buf_text(out, "</text>\n");
}

// Points of a group joined in their order.
static void lines(struct buf *out, const struct chart *c,
                  const struct chart_axis *ax, const struct chart_axis *ay)
{
    for (int g = 0; g < CHART_GROUPS_MAX; g++) {
        bool any = false;
        for (int i = 0; i < c->count; i++) {
            const struct chart_point *p = &c->point[i];
            if (p->group != g || !usable(p))
                continue;
            buf_printf(out, any ? "L%.1f %.1f" : "<path d=\"M%.1f %.1f",
                       chart_put(ax, p->x), chart_put(ay, p->y));
            any = true;
        }
        if (any)
            buf_printf(out, "\" fill=\"none\" stroke=\"%s\"/>\n",
                       chart_colours[g]);
    }
}

static void frame(struct buf *out, const struct chart *c)
{
    char at[160];
    snprintf(at, sizeof at, "x=\"%d\" y=\"22\" font-size=\"14\"", CHART_LEFT);
    chart_text(out, at, c->title);
    snprintf(at, sizeof at, "x=\"%d\" y=\"38\" fill=\"#555555\"", CHART_LEFT);
    chart_text(out, at, c->note);
    snprintf(at, sizeof at, "x=\"%d\" y=\"%d\" text-anchor=\"middle\"",
             (CHART_LEFT + CHART_RIGHT) / 2, CHART_BOTTOM + 34);
    chart_text(out, at, c->x_title);
    snprintf(at, sizeof at,
             "transform=\"translate(16 %d) rotate(-90)\" "
             "text-anchor=\"middle\"",
             (CHART_TOP + CHART_BOTTOM) / 2);
    chart_text(out, at, c->y_title);
    buf_printf(out,
               "<rect x=\"%d\" y=\"%d\" width=\"%d\" height=\"%d\" "
               "fill=\"none\" stroke=\"#444444\"/>\n",
               CHART_LEFT, CHART_TOP, CHART_RIGHT - CHART_LEFT,
               CHART_BOTTOM - CHART_TOP);
}

static void legend(struct buf *out, const struct chart *c)
{
    double x = CHART_LEFT;
    for (int g = 0; g < CHART_GROUPS_MAX; g++) {
        bool used = false;
        for (int i = 0; i < c->count; i++)
            used |= c->point[i].group == g && usable(&c->point[i]);
        if (!used || !c->groups[g])
            continue;
        char at[80];
        mark(out, g, true, x + 5, CHART_BOTTOM + 51);
        snprintf(at, sizeof at, "x=\"%.1f\" y=\"%d\"", x + 14,
                 CHART_BOTTOM + 55);
        chart_text(out, at, c->groups[g]);
        x += 30 + CHART_CHARACTER * (double)strlen(c->groups[g]);
    }
    buf_printf(out,
               "<text x=\"%d\" y=\"%d\" text-anchor=\"end\" "
               "fill=\"#555555\">%s</text>\n",
               CHART_WIDTH - 8, CHART_BOTTOM + 34,
               c->series ? "" : "filled and dashed: Pareto front; bars: 95 %");
}

void chart_begin(struct buf *out, int width, int height)
{
    buf_printf(out,
               "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"%d\" "
               "height=\"%d\" viewBox=\"0 0 %d %d\" "
               "font-family=\"DejaVu Sans Mono,monospace\" "
               "font-size=\"10\" fill=\"#111111\">\n<rect width=\"%d\" "
               "height=\"%d\" fill=\"#ffffff\"/>\n",
               width, height, width, height, width, height);
}

void chart_svg(struct chart *c, struct buf *out)
{
    struct chart_spot *spot = bytes_alloc(CHART_POINTS_MAX * sizeof *spot);
    struct chart_axis ax = {INFINITY, -INFINITY, CHART_LEFT, CHART_RIGHT};
    struct chart_axis ay = {INFINITY, -INFINITY, CHART_BOTTOM, CHART_TOP};
    int n = 0;
    chart_front(c->point, c->count);
    for (int i = 0; i < c->count; i++)
        c->point[i].front |= c->series && usable(&c->point[i]);
    for (int i = 0; i < c->count; i++)
        if (usable(&c->point[i])) {
            chart_widen(&ax, c->point[i].x);
            chart_widen(&ay, c->point[i].y);
        }
    chart_settle(&ax);
    chart_settle(&ay);
    chart_begin(out, CHART_WIDTH, CHART_HEIGHT);
    ticks(out, &ax, true);
    ticks(out, &ay, false);
    frame(out, c);
    (c->series ? lines : front_line)(out, c, &ax, &ay);
    for (int i = 0; i < c->count && n < CHART_POINTS_MAX; i++)
        if (usable(&c->point[i])) {
            spot[n] = (struct chart_spot){.of = &c->point[i],
                                          .x = chart_put(&ax, c->point[i].x),
                                          .y = chart_put(&ay, c->point[i].y)};
            bar(out, &ay, spot[n].x, &c->point[i]);
            n++;
        }
    chart_labels(spot, n, out);
    for (int i = 0; i < n; i++)
        mark(out, spot[i].of->group, spot[i].of->front, spot[i].x, spot[i].y);
    legend(out, c);
    buf_text(out, "</svg>\n");
    free(spot);
}
