// judge.h - says how wrong the resting picture is: a thread of low
// priority traces paths at random visible places and compares.
//
// The figure is against all of the truth that reference.h has: the sky's
// texels, rays against the strands, light scattered by any number of fibres.
// Thread: render, for every function but judge_halt, judge_stop and judge_ended
// (any); `done` is called on the judge's own thread.
#ifndef SERVER_JUDGE_H
#define SERVER_JUDGE_H

#include <stdbool.h>
#include <stdint.h>

#include "protocol/error.h"
#include "renderer/metric.h"
#include "renderer/reference.h"

enum { JUDGE_PATHS = 128 }; // a place, of a case's last verdict

struct judge_case {
    uint64_t revision;
    struct reference_scene scene; // groom and map: borrowed until judge_settle;
                                  // params: copied
    struct places_item *places;   // taken: freed by the judge
    size_t count;
};

struct judge_verdict {
    uint64_t revision; // 0: none
    double value;      // relative RMSE over the places
    double low, high;  // 95 % interval
    double bias;       // mean signed error, relative
    double noise;      // of the paths, already taken off `value`
    double seconds;    // what it took
    int places, paths; // paths a place
    uint64_t memory;   // bytes that the truth keeps for the next case
};

struct judge;

// NULL when there is no thread to be had.
struct judge *judge_create(void (*done)(void *ctx,
                                        const struct judge_verdict *v),
                           void *ctx, struct error *err);
// Hears this case instead of any other.  `done` follows twice: after few paths
// and after all, unless it is halted.
void judge_hear(struct judge *j, struct judge_case *c);
// Lets the present case go; does not wait.
void judge_halt(struct judge *j);
// Halts and returns when groom and map of any case may go: putting the strands
// in order is left where it is.
void judge_settle(struct judge *j);
// Halts and hears no more; does not wait.
void judge_stop(struct judge *j);
// Has its thread come to its end?  On a busy machine that may take long.
bool judge_ended(struct judge *j);
void judge_destroy(struct judge *j); // waits for that; NULL is allowed

#endif
