// bench_front.h - `glintd bench --front`: the settings that a governor may
// choose among (front.h), each timed and compared with the reference.
// Thread: the renderer's.
#ifndef SERVER_BENCH_FRONT_H
#define SERVER_BENCH_FRONT_H

#include <stdbool.h>

#include "protocol/error.h"
#include "server/bench_measure.h"
#include "server/bench_report.h"
#include "server/front.h"

// Fills out[BENCH_KNOBS_MAX] with *base at each setting; returns how many.
// Those with rays follow that without, whose shadows are else the same.  The
// default is there with and without rays, of the others those that `only` lets
// in (NULL: all).
int bench_front_list(const struct params *base, const char *only,
                     struct bench_setting *out);

// Times of edits, with rays only those of the fibre; the error as `whole`.
bool bench_front_row(const struct bench_view *v, const struct bench_setting *s,
                     struct bench_row *out, struct error *err);

// One JSON line: kind scene setting edits (least_ms cpu_ms crowd) error
// error_ci95.
void bench_front_json(const struct bench_result *b, const struct bench_row *row,
                      struct buf *out);

struct bench_front_scene { // what the result does not say of itself
    const char *hair_sha, *env_sha;
    int cores;
};
// The rows of a scene as a front.
void bench_front_make(const struct bench_result *b,
                      const struct bench_front_scene *scene, struct front *out);

#endif
