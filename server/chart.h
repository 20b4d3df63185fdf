// chart.h - a scatter plot with logarithmic axes as SVG: error over time, the
// Pareto front marked, every point named without labels on each other.
//
// Plain SVG 1.1 without scripts, styles from outside or links.  Labels are set
// in a monospaced face, so their boxes are known here: a label goes beside its
// point where there is room, else into a column at the right, with a line to
// the point.
// Thread: any (no state).
#ifndef SERVER_CHART_H
#define SERVER_CHART_H

#include <stdbool.h>

#include "protocol/bytes.h"

enum { CHART_POINTS_MAX = 128, CHART_GROUPS_MAX = 12 };

struct chart_point {
    double x, y;       // > 0
    double low, high;  // interval of y; NaN: none is drawn
    const char *label; // UTF-8; escaped here; "": none
    int group;         // 0..CHART_GROUPS_MAX-1: shape and colour
    bool front;        // out: no other point is both faster and better
};

struct chart {
    const char *title, *note, *x_title, *y_title; // texts are escaped here
    const char *groups[CHART_GROUPS_MAX];         // names; NULL: not shown
    struct chart_point *point;
    int count;   // at most CHART_POINTS_MAX
    bool series; // points of a group are joined in their order and there is no
                 // front: growth
};

// Appends one SVG document.  Points that are not finite and positive are left
// out.  Sets every point's `front`.
void chart_svg(struct chart *c, struct buf *out);

// Marks the front alone: points that no other one is at least as good as in
// both and better in one.
void chart_front(struct chart_point *p, int count);

#endif
