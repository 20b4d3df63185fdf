// bench_report.h - what was measured, as JSON lines, Markdown and plots.
// Thread: any (no state).
#ifndef SERVER_BENCH_REPORT_H
#define SERVER_BENCH_REPORT_H

#include "protocol/bytes.h"
#include "server/bench_measure.h"

struct bench_result { // of one scene
    const char *name; // "ponytail, studio"
    const char *id;   // for file names: letters, digits, '_'
    const char *device;
    uint32_t strands, points;
    const struct bench_truth *truth;
    int paths, picture_paths, picture_samples;
    struct bench_row *row;
    int rows;
    struct bench_cause cause[BENCH_CAUSES];
    bool causes;
};

// One line each, with its end.
void bench_report_json_scene(const struct bench_result *b, struct buf *out);
void bench_report_json_row(const struct bench_result *b,
                           const struct bench_row *row, struct buf *out);
void bench_report_json_cause(const struct bench_result *b,
                             const struct bench_cause *c, struct buf *out);

enum bench_plot { BENCH_PLOT_WHOLE, BENCH_PLOT_INTEGRAL };

// Error over time of all settings; a point on the front sets front[row].
void bench_report_plot(const struct bench_result *b, enum bench_plot which,
                       bool *front, struct buf *out);

// The scene's section.  plot: files to show, or NULL.
void bench_report_scene(const struct bench_result *b, const char *const *plot,
                        const bool *front, struct buf *out);

// Heads a report of several scenes: what is measured and how to read it.
struct bench_head {
    const char *command; // that makes it
    const char *device;
    int cores, runs, scenes;
    double seconds, load; // of the whole run; load average at its end
};
void bench_report_head(const struct bench_head *h, const struct params *base,
                       struct buf *out);
// A line for each scene under the head.
void bench_report_overview(const struct bench_result *b, bool first,
                           struct buf *out);

#endif
