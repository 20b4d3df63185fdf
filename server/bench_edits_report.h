// bench_edits_report.h - what edits cost, as JSON lines, Markdown and a plot.
// Thread: any (no state).
#ifndef SERVER_BENCH_EDITS_REPORT_H
#define SERVER_BENCH_EDITS_REPORT_H

#include "protocol/bytes.h"
#include "server/bench_edits.h"

// One line with its end.
void bench_edits_json(const struct bench_edits_scene *s,
                      const struct bench_edits_row *row, struct buf *out);

struct bench_edits_head {
    const char *command, *device;
    const char *plot;    // as the report names it; NULL: none
    const char *skipped; // what was not measured and why; NULL: nothing
    int cores, runs, forward_runs, cold;
    int places, exact, paths;
    double seconds, load[2]; // of the whole run; load average before and after
    const struct params *base;
};
// The page: a short table between two marks, which the README shows too, the
// plot, and all rows of `count` scenes.
void bench_edits_page(const struct bench_edits_head *h,
                      const struct bench_edits_scene *scene, int count,
                      struct buf *out);
// Rows that have a target or are of Table 2.
void bench_edits_plot(const struct bench_edits_head *h,
                      const struct bench_edits_scene *scene, int count,
                      struct buf *out);

#endif
