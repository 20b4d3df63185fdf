// shoot_threads.c - see the header.
#include "renderer/shoot_threads.h"

#include <pthread.h>
#include <stdatomic.h>

#include "renderer/crew.h"

enum { THREADS_MAX = 64 };

struct crew {
    void (*work)(void *context, size_t i);
    void *context;
    size_t count;
    atomic_size_t next;
};

static void *toil(void *arg)
{
    struct crew *c = arg;
    for (;;) {
        size_t i = atomic_fetch_add_explicit(&c->next, 1, memory_order_relaxed);
        if (i >= c->count)
            return NULL;
        c->work(c->context, i);
    }
}

void shoot_threads(size_t count, void (*work)(void *context, size_t i),
                   void *context)
{
    struct crew c = {.work = work, .context = context, .count = count};
    pthread_t thread[THREADS_MAX];
    size_t wanted = (size_t)crew_cores(), started = 0;
    if (wanted > count)
        wanted = count;
    // A thread that cannot be had only makes it slower.
    while (started + 1 < wanted &&
           pthread_create(&thread[started], NULL, toil, &c) == 0)
        started++;
    toil(&c);
    while (started > 0)
        pthread_join(thread[--started], NULL);
}
