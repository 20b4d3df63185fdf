// chart_labels.c - places labels one after the other, those of the front
// first: beside the point where nothing is covered, else in the column at the
// right, which has a line for each.
#include "server/chart_private.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

struct box {
    double x0, y0, x1, y1;
};

struct layout {
    const struct chart_spot *spot;
    int n;
    struct box label[CHART_POINTS_MAX];
    bool beside[CHART_POINTS_MAX]; // placed beside its point
    bool away[CHART_POINTS_MAX];   // belongs into the column
};

static bool overlap(const struct box *a, const struct box *b)
{
    return a->x0 < b->x1 && b->x0 < a->x1 && a->y0 < b->y1 && b->y0 < a->y1;
}

static double width_of(const char *label)
{
    size_t n = 0; // characters, not bytes
    for (; *label; label++)
        n += ((unsigned char)*label & 0xc0) != 0x80;
    return CHART_CHARACTER * (double)n;
}

static bool is_free(const struct layout *l, const struct box *b)
{
    if (b->x0 < CHART_LEFT + 2 || b->x1 > CHART_RIGHT - 2 ||
        b->y0 < CHART_TOP + 2 || b->y1 > CHART_BOTTOM - 2)
        return false;
    for (int i = 0; i < l->n; i++) {
        const struct chart_spot *s = &l->spot[i];
        const struct box point = {s->x - 6, s->y - 6, s->x + 6, s->y + 6};
        if (overlap(b, &point) || (l->beside[i] && overlap(b, &l->label[i])))
            return false;
    }
    return true;
}

// Right, left, above, below, then the corners.
static bool put_beside(struct layout *l, int i)
{
    static const double way[][2] = {{1, 0},  {-1, 0},  {0, -1}, {0, 1},
                                    {1, -1}, {-1, -1}, {1, 1},  {-1, 1}};
    const struct chart_spot *s = &l->spot[i];
    const double w = width_of(s->of->label), h = CHART_LINE;
    for (size_t k = 0; k < sizeof way / sizeof way[0]; k++) {
        const double dx = way[k][0], dy = way[k][1];
        const double gap = dy != 0 && dx != 0 ? 5 : 8;
        const double x = s->x + dx * (gap + w / 2);
        const double y = s->y + dy * ((dx != 0 ? 2 : 8) + h / 2);
        const struct box b = {x - w / 2, y - h / 2, x + w / 2, y + h / 2};
        if (!is_free(l, &b))
            continue;
        l->label[i] = b;
        l->beside[i] = true;
        return true;
    }
    return false;
}

static void write_label(struct buf *out, const struct chart_spot *s, double x,
                        double y)
{
    buf_printf(out,
               "<text class=\"label\" x=\"%.1f\" y=\"%.1f\"%s "
               "stroke=\"#ffffff\" stroke-width=\"2.5\" "
               "paint-order=\"stroke\">",
               x, y, s->of->front ? " font-weight=\"bold\"" : "");
    chart_escape(out, s->of->label);
    buf_text(out, "</text>\n");
}

static int by_height(const void *a, const void *b)
{
    const struct chart_spot *x = *(const struct chart_spot *const *)a;
    const struct chart_spot *y = *(const struct chart_spot *const *)b;
    if (x->y != y->y)
        return x->y < y->y ? -1 : 1;
    return (x->x > y->x) - (x->x < y->x);
}

// One under the other in the order of the points' heights, each as near to its
// point's height as those above and those still to come allow.
static void column(const struct layout *l, struct buf *out)
{
    const struct chart_spot *away[CHART_POINTS_MAX];
    int n = 0;
    for (int i = 0; i < l->n; i++)
        if (l->away[i])
            away[n++] = &l->spot[i];
    qsort(away, (size_t)n, sizeof *away, by_height);
    const double room = CHART_BOTTOM - CHART_TOP;
    const double step = fmin(CHART_LINE, room / (n > 0 ? n : 1));
    double y = CHART_TOP;
    for (int i = 0; i < n; i++) {
        const double last = CHART_BOTTOM - step * (n - i);
        y = fmin(fmax(y, away[i]->y - step / 2), last);
        buf_printf(out,
                   "<path fill=\"none\" stroke=\"#b4b4b4\" "
                   "stroke-width=\"0.7\" d=\"M%.1f %.1fL%d %.1fh8\"/>\n",
                   away[i]->x, away[i]->y, CHART_RIGHT + 2, y + step / 2);
        write_label(out, away[i], CHART_RIGHT + 13, y + step / 2 + 3.5);
        y += step;
    }
}

void chart_labels(const struct chart_spot *spot, int n, struct buf *out)
{
    struct layout *l = bytes_zalloc(1, sizeof *l);
    l->spot = spot;
    l->n = n;
    for (int pass = 0; pass < 2; pass++)
        for (int i = 0; i < n; i++)
            if (spot[i].of->front == (pass == 0) && spot[i].of->label[0])
                l->away[i] = !put_beside(l, i);
    column(l, out);
    for (int i = 0; i < n; i++)
        if (l->beside[i])
            write_label(out, &spot[i], l->label[i].x0, l->label[i].y1 - 2.5);
    free(l);
}
