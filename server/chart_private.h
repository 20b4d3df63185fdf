// chart_private.h - what chart.c, chart_labels.c and chart_rows.c share: the
// sheet and the points on it, in pixels, y down; logarithmic axes.
// Thread: any.
#ifndef SERVER_CHART_PRIVATE_H
#define SERVER_CHART_PRIVATE_H

#include "server/chart.h"

enum {
    CHART_WIDTH = 1000,
    CHART_HEIGHT = 640,
    CHART_LEFT = 64, // of the axes' rectangle
    CHART_TOP = 48,
    CHART_RIGHT = 740,
    CHART_BOTTOM = 572
};
// Advance of a character and height of a line at font size 10: DejaVu Sans
// Mono is 0.602 em wide, other monospaced faces 0.60.
#define CHART_CHARACTER 6.05
#define CHART_LINE 11.5

struct chart_spot {
    const struct chart_point *of;
    double x, y;
};

struct chart_axis {
    double low, high; // decimal logarithms
    double from, to;  // pixels
};
double chart_put(const struct chart_axis *a, double v);
void chart_widen(struct chart_axis *a, double v); // not finite, <= 0: nothing
// A margin around what is shown, and never less than a factor of four: small
// differences shall look small.
void chart_settle(struct chart_axis *a);
extern const char *const chart_colours[CHART_GROUPS_MAX];
// One <text> element; attributes as they are, the text escaped.
void chart_text(struct buf *out, const char *attributes, const char *text);
void chart_begin(struct buf *out, int width, int height);

// Appends the labels of n points, with lines to those that stand away.
void chart_labels(const struct chart_spot *spot, int n, struct buf *out);
void chart_escape(struct buf *out, const char *text);

#endif
