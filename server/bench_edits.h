// bench_edits.h - what an edit costs, kind by kind, in one scene: times, the
// same by the paper's way of drawing, and the error of what was shown.
// Thread: the renderer's.
#ifndef SERVER_BENCH_EDITS_H
#define SERVER_BENCH_EDITS_H

#include "renderer/metric.h"
#include "server/bench_drag.h"
#include "server/bench_kinds.h"
#include "server/bench_scene.h"

struct bench_edits_ask {
    const char *hair, *env; // as options have them
    const struct params *base;
    struct bench_effort effort;  // of edits
    struct bench_effort slow;    // of those that take long
    struct bench_effort forward; // of paper-forward's
    int cold;                    // starts of a daemon
    int places, exact, paths;    // of the reference
    const char *cache;           // directory, or NULL
    bool brief;                  // Table 2's rows alone
    bool few;                    // paper-forward by plain fibre edits alone
};

struct bench_edits_error { // of one state; NaN: not known
    // RMSE / mean of the reference: texels, rays and paths, at visible places;
    // by the path that ran, and by direct evaluation (scheme best)
    struct metric_value path, direct;
    double difference; // of the two, relative to the direct one's mean
    // once-scattered light of the same lights without shadows, against exact
    // integrals: what the path itself is off by
    double integral, integral_direct;
};

struct bench_edits_row {
    char edit[64];
    struct bench_times time;
    double each[BENCH_KINDS_FIBRE]; // ms by fibre parameter, medians; NaN
    double first, blocks;           // of drags (bench_drag.h); else NaN
    struct renderer_draft how;      // of drags
    bool drag, chief;
    double target; // ms; NaN: none
    const char *path;
    int lights, lights_asked;    // in use; sky.lights
    int tables, tables_missing;  // of renderer_stats
    uint32_t points;             // visible
    double forward, forward_cpu; // ms by paper-forward; NaN: does not compare
    int forward_runs;
    double paper_fps; // Xu 2011, Table 2; else NaN
    // Of drags `path` is the draft's error against the full frame.
    struct bench_edits_error error;
};

enum { BENCH_EDITS_ROWS_MAX = 40 };
struct bench_edits_scene { // zero-initialised is empty
    struct bench_loaded loaded;
    char device[160];
    struct bench_edits_row row[BENCH_EDITS_ROWS_MAX];
    int rows;
};

bool bench_edits_run(struct bench_edits_scene *s,
                     const struct bench_edits_ask *ask, struct error *err);

#endif
