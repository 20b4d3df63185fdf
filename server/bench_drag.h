// bench_drag.h - how long the frames of a drag take as the daemon makes them:
// drafts as coarse as quality.draft_ms needs, and what they are off by.
// Thread: the renderer's.
#ifndef SERVER_BENCH_DRAG_H
#define SERVER_BENCH_DRAG_H

#include "server/bench_time.h"

struct bench_drag {
    struct bench_times time;   // of all frames of the drags, first ones too
    double first;              // ms, median of the drags' first frames
    struct renderer_draft how; // of the newest; divisor 0: the full frame
                               // keeps to the time
    double error;              // root of the mean square over pixels that the
                               // full frame covers, of its display in linear
                               // light, relative to its mean
    double blocks;             // the same of means over 32 x 32 pixels: of the
                               // light without its detail
};

// Drags of eight edits each, until effort->runs are timed; before each of them
// a full frame and what is rehearsed then, as when the hand has rested.  The
// first drag is not counted: in it the drafts find their size.
bool bench_drag_run(struct renderer *r, const struct params *base,
                    const struct bench_series *series,
                    const struct bench_effort *effort, struct bench_drag *out,
                    struct error *err);

#endif
