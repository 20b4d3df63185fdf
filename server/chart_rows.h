// chart_rows.h - times of many things under each other as SVG: a bar from the
// least to the 95th percentile, a dot at the median, a mark where the target
// is, a hollow one for what it is compared with; time is logarithmic.
// Thread: any (no state).
#ifndef SERVER_CHART_ROWS_H
#define SERVER_CHART_ROWS_H

#include "server/chart.h"

enum { CHART_ROWS_MAX = 128 };

struct chart_row {
    const char *label;         // NULL: belongs to the row above
    int group;                 // colour
    double least, median, p95; // > 0
    double target, other;      // NaN: none
};

struct chart_rows {
    const char *title, *note, *x_title;
    const char *groups[CHART_GROUPS_MAX]; // NULL: not shown
    const char *target, *other;           // what the marks mean
    const struct chart_row *row;
    int count; // at most CHART_ROWS_MAX
};

void chart_rows_svg(const struct chart_rows *c, struct buf *out);

#endif
