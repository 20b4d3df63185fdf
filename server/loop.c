// loop.c - epoll, a binary heap of timers, an eventfd.  What the events mean is
// not known here.
#include "server/loop.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include "protocol/bytes.h"
#include "server/clock.h"

enum { BATCH = 64 };

struct loop {
    int epoll;
    bool stopped;
    struct loop_source wake;
    void (*woken)(void *ctx);
    void *woken_ctx;
    struct epoll_event batch[BATCH]; // the events being handed out
    int batch_size;
    struct loop_timer **heap;
    int heap_size, heap_cap;
};

static void wake_ready(struct loop_source *s, uint32_t events)
{
    (void)events;
    struct loop *l = (struct loop *)((char *)s - offsetof(struct loop, wake));
    uint64_t count;
    if (read(s->fd, &count, sizeof count) > 0 && l->woken)
        l->woken(l->woken_ctx);
}

struct loop *loop_create(struct error *err)
{
    struct loop *l = bytes_zalloc(1, sizeof *l);
    l->wake.fd = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
    l->wake.ready = wake_ready;
    l->epoll = epoll_create1(EPOLL_CLOEXEC);
    if (l->epoll >= 0 && l->wake.fd >= 0 && loop_watch(l, &l->wake, EPOLLIN))
        return l;
    error_set(err, "system", "", "no event loop: %s", strerror(errno));
    loop_destroy(l);
    return NULL;
}

void loop_destroy(struct loop *l)
{
    if (!l)
        return;
    if (l->epoll >= 0)
        close(l->epoll);
    if (l->wake.fd >= 0)
        close(l->wake.fd);
    free(l->heap);
    free(l);
}

bool loop_watch(struct loop *l, struct loop_source *s, uint32_t events)
{
    struct epoll_event e = {.events = events, .data.ptr = s};
    if (epoll_ctl(l->epoll, EPOLL_CTL_ADD, s->fd, &e) != 0)
        return false;
    s->events = events;
    s->watched = true;
    return true;
}

void loop_change(struct loop *l, struct loop_source *s, uint32_t events)
{
    if (!s->watched || s->events == events)
        return;
    struct epoll_event e = {.events = events, .data.ptr = s};
    if (epoll_ctl(l->epoll, EPOLL_CTL_MOD, s->fd, &e) == 0)
        s->events = events;
}

void loop_unwatch(struct loop *l, struct loop_source *s)
{
    if (!s->watched)
        return;
    epoll_ctl(l->epoll, EPOLL_CTL_DEL, s->fd, NULL);
    s->watched = false;
    // What was already fetched for it must not reach freed memory.
    for (int i = 0; i < l->batch_size; i++)
        if (l->batch[i].data.ptr == s)
            l->batch[i].data.ptr = NULL;
}

// --- timers -----------------------------------------------------------------
static void put(struct loop *l, int i, struct loop_timer *t)
{
    l->heap[i] = t;
    t->place = i + 1;
}

static void sift(struct loop *l, int i)
{
    struct loop_timer *t = l->heap[i];
    while (i > 0 && t->at < l->heap[(i - 1) / 2]->at) {
        put(l, i, l->heap[(i - 1) / 2]);
        i = (i - 1) / 2;
    }
    for (;;) {
        int c = 2 * i + 1;
        if (c + 1 < l->heap_size && l->heap[c + 1]->at < l->heap[c]->at)
            c++;
        if (c >= l->heap_size || t->at <= l->heap[c]->at)
            break;
        put(l, i, l->heap[c]);
        i = c;
    }
    put(l, i, t);
}

void loop_timer_set(struct loop *l, struct loop_timer *t, int64_t at)
{
    t->at = at;
    if (!t->place) {
        if (l->heap_size == l->heap_cap) {
            l->heap_cap = l->heap_cap ? 2 * l->heap_cap : 64;
            l->heap = bytes_realloc(l->heap, (size_t)l->heap_cap *
                                                 sizeof(struct loop_timer *));
        }
        put(l, l->heap_size++, t);
    }
    sift(l, t->place - 1);
}

void loop_timer_clear(struct loop *l, struct loop_timer *t)
{
    if (!t->place)
        return;
    int i = t->place - 1;
    t->place = 0;
    struct loop_timer *last = l->heap[--l->heap_size];
    if (last == t)
        return;
    put(l, i, last);
    sift(l, i);
}

static void fire_due(struct loop *l)
{
    int64_t now = clock_us();
    // A timer set again by its own call waits for the next turn.
    for (int n = l->heap_size; n > 0 && l->heap_size > 0; n--) {
        struct loop_timer *t = l->heap[0];
        if (t->at > now)
            return;
        loop_timer_clear(l, t);
        t->fire(t);
    }
}

static int wait_ms(const struct loop *l)
{
    if (l->heap_size == 0)
        return -1;
    int64_t us = l->heap[0]->at - clock_us();
    if (us <= 0)
        return 0;
    return us > 60000000 ? 60000 : (int)(us / 1000 + 1);
}

// --- the loop ---------------------------------------------------------------
bool loop_run(struct loop *l, struct error *err)
{
    while (!l->stopped) {
        int n = epoll_wait(l->epoll, l->batch, BATCH, wait_ms(l));
        if (n < 0 && errno != EINTR)
            return error_set(err, "system", "", "epoll_wait: %s",
                             strerror(errno));
        l->batch_size = n > 0 ? n : 0;
        for (int i = 0; i < l->batch_size; i++) {
            struct loop_source *s = l->batch[i].data.ptr;
            if (s)
                s->ready(s, l->batch[i].events);
        }
        l->batch_size = 0;
        fire_due(l);
    }
    return true;
}

void loop_stop(struct loop *l)
{
    l->stopped = true;
}

void loop_on_wake(struct loop *l, void (*woken)(void *ctx), void *ctx)
{
    l->woken = woken;
    l->woken_ctx = ctx;
}

void loop_wake(struct loop *l)
{
    uint64_t one = 1;
    if (write(l->wake.fd, &one, sizeof one) < 0)
        return; // the counter is full: it is awake
}
