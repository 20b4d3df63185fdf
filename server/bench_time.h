// bench_time.h - how long an edit takes until its picture is there, stage by
// stage.
// Thread: the renderer's.
#ifndef SERVER_BENCH_TIME_H
#define SERVER_BENCH_TIME_H

#include <stdbool.h>

#include "protocol/error.h"
#include "protocol/params.h"
#include "renderer/metric.h"
#include "renderer/renderer.h"

enum { BENCH_RUNS_MAX = 200, BENCH_RUNS_LEAST = 3 };

enum bench_edit {      // what is changed
    BENCH_EDIT_FIBRE,  // fibre.sigma_a
    BENCH_EDIT_COLOUR, // tint.colour
    BENCH_EDIT_SKY,    // light.yaw
    BENCH_EDIT_CAMERA, // camera.fov
    BENCH_EDITS
};
extern const char *const bench_edit_names[BENCH_EDITS];

struct bench_times {
    int runs;                      // 0: not measured
    struct metric_value median;    // ms, wall clock, with its 95 % interval
    double least, p95;             // ms
    double cpu;                    // ms of all processors, the least
    double crowd;                  // processors at work, the most of any run
    double processor;              // ms of all threads, median
    double encode;                 // ms of JPEG afterwards, median; 0: none
    double stage[RENDERER_STAGES]; // ms, medians; < 0: did not run
    struct gl_counts work;         // of the last of them: exact numbers
};

struct bench_effort {
    int runs;       // that are wanted
    double seconds; // after so many no more than BENCH_RUNS_LEAST are made;
                    // 0: no limit
};

enum { // columns of a log, after the stages'
    BENCH_WHOLE = RENDERER_STAGES,
    BENCH_PROCESSOR,
    BENCH_ENCODE,
    BENCH_COLUMNS
};
struct bench_log { // ms
    double ms[BENCH_COLUMNS][BENCH_RUNS_MAX];
    size_t n;
    struct gl_counts work;
};
// One edit as it is done: *p until it is done (a draft, where `how` is one) and
// read as displayed into *pixels, ms[BENCH_COLUMNS]; encoded besides where that
// is asked for.
struct bench_frame {
    const struct params *params;
    struct renderer_draft *how; // NULL: the full frame
    bool encode;
    struct buf pixels;     // the caller's
    struct gl_counts work; // out
};
bool bench_time_frame(struct renderer *r, struct bench_frame *f, double *ms,
                      struct error *err);
void bench_time_note(struct bench_log *log, const struct bench_frame *f,
                     const double *ms);
void bench_time_take(const struct bench_log *log, struct bench_times *out);

// Edit number k >= 0 of a series, on a fresh copy of the base.
typedef void bench_edit_fn(const void *self, struct params *p, int k);
struct bench_series {
    bench_edit_fn *edit;
    const void *self;
    bool encode;  // as a frame is sent: JPEG 85, 4:2:0; not in the time
    double *each; // [BENCH_RUNS_MAX + 2] ms of edit k, NaN: not counted; or
                  // NULL
};

// As bench_time, of any edits.
bool bench_time_series(struct renderer *r, const struct params *p,
                       const struct bench_series *series,
                       const struct bench_effort *effort,
                       struct bench_times *out, struct error *err);

// Makes edits of one kind around *p, each different from the one before, after
// two that are not counted (one, where it takes a quarter of the time), and
// waits for each until the picture is done and read as it is displayed.  With
// quality.samples = 1 and shadow.rays = 0 that is the first full frame.
// Afterwards the picture is that of *p itself.
bool bench_time(struct renderer *r, const struct params *p,
                enum bench_edit edit, const struct bench_effort *effort,
                struct bench_times *out, struct error *err);

// The picture of *p, until it is done; stage_ms[RENDERER_STAGES] are sums, or
// NULL.
bool bench_time_finish(struct renderer *r, const struct params *p,
                       double *stage_ms, struct error *err);

#endif
