// loop.h - waits for file descriptors and times, and calls who asked.
//
// Sources and timers are embedded in what owns them and stay in place while
// they are watched.  A callback may unwatch or free anything, itself included.
// Thread: loop, except loop_wake, which any thread may call.
#ifndef SERVER_LOOP_H
#define SERVER_LOOP_H

#include <stdbool.h>
#include <stdint.h>
#include <sys/epoll.h>

#include "protocol/error.h"

struct loop_source {
    int fd; // set before loop_watch; who owns it closes it
    void (*ready)(struct loop_source *s, uint32_t events); // EPOLLIN ...
    uint32_t events; // private: what is watched
    bool watched;    // private
};

struct loop_timer { // zero-initialised, then .fire set: at rest
    void (*fire)(struct loop_timer *t);
    int64_t at; // private: microseconds of clock_us
    int place;  // private: 1 + place in the heap; 0 at rest
};

struct loop;

struct loop *loop_create(struct error *err);
void loop_destroy(struct loop *l); // NULL is allowed

bool loop_watch(struct loop *l, struct loop_source *s, uint32_t events);
void loop_change(struct loop *l, struct loop_source *s, uint32_t events);
void loop_unwatch(struct loop *l, struct loop_source *s);

void loop_timer_set(struct loop *l, struct loop_timer *t, int64_t at);
void loop_timer_clear(struct loop *l, struct loop_timer *t);

// Runs until loop_stop.  False when the kernel refuses to wait.
bool loop_run(struct loop *l, struct error *err);
void loop_stop(struct loop *l);

// From any thread: `woken` is called soon on the loop thread.
void loop_on_wake(struct loop *l, void (*woken)(void *ctx), void *ctx);
void loop_wake(struct loop *l);

#endif
