// timer.h - milliseconds of each stage of one step, by GPU timestamps.
// Thread: render.
#ifndef RENDERER_TIMER_H
#define RENDERER_TIMER_H

#include <stdbool.h>

enum { TIMER_SLOTS = 16 };

struct timer {
    unsigned query[2 * TIMER_SLOTS];
    bool used[TIMER_SLOTS];
};

void timer_init(struct timer *t);
void timer_finish(struct timer *t);
// A debug group too.
void timer_begin(struct timer *t, int slot, const char *name);
void timer_end(struct timer *t, int slot);
// After the work is known to be done: adds what was measured since the last
// call to ms[slot] (a negative ms[slot] counts as 0) and forgets it.
void timer_collect(struct timer *t, double *ms, int slots);
double timer_now(void); // seconds, monotonic

#endif
