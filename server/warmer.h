// warmer.h - the thread that has programs compiled which the next edit may need
// (renderer/warm.h), while nobody waits for anything.
//
// It has a small renderer and a GL context of its own, so an edit that comes
// meanwhile waits for nothing; between two states it looks whether it is
// halted. Thread: render, but for what says otherwise.
#ifndef SERVER_WARMER_H
#define SERVER_WARMER_H

#include <stdbool.h>

#include "protocol/bytes.h"
#include "protocol/error.h"
#include "renderer/warm.h"

struct warmer;

// done: on the warmer's thread, after each state: the names of programs that
// it needed and none before (taken: the caller frees), what is left of this
// round (INT_MAX: of the next, not known yet), and how many states were made in
// all.
typedef void warmer_done_fn(void *ctx, struct buf *names, int left, int made);

// NULL when there is no thread to be had.
struct warmer *warmer_create(warmer_done_fn *done, void *ctx,
                             struct error *err);
// What is one edit away from this scene (its sample is taken), instead of
// anything before.
void warmer_begin(struct warmer *w, const struct warm_scene *scene);
void warmer_halt(struct warmer *w); // after the state at hand.  Thread: any
void warmer_stop(struct warmer *w); // for good; does not wait.  Thread: any
bool warmer_ended(struct warmer *w);
void warmer_destroy(struct warmer *w); // waits; NULL is allowed

#endif
