// warmer.c - one round at a time.  Which states a round has is the renderer's
// affair, when it begins, the engine's.
#include "server/warmer.h"

#include <limits.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <unistd.h>

struct warmer {
    pthread_t thread;
    warmer_done_fn *done;
    void *ctx;
    atomic_bool halted, ended;
    pthread_mutex_t lock;
    pthread_cond_t change;
    // Under the lock:
    bool stop, waiting;
    struct warm_scene scene; // of the round that waits; else without a sample
    // The thread's own:
    struct warm *warm;
};

static void report(struct warmer *w, struct buf *names)
{
    pthread_mutex_lock(&w->lock);
    const int left = w->waiting ? INT_MAX : warm_left(w->warm); // of the next
    pthread_mutex_unlock(&w->lock);
    w->done(w->ctx, names, left, warm_done(w->warm));
}

// Under the lock, let go of while it works.
static void round_of(struct warmer *w)
{
    const struct warm_scene scene = w->scene;
    struct buf none = {0};
    w->scene.sample = NULL;
    w->waiting = false;
    atomic_store(&w->halted, false);
    pthread_mutex_unlock(&w->lock);
    warm_begin(w->warm, &scene);
    report(w, &none);
    while (warm_left(w->warm) > 0 && !atomic_load(&w->halted)) {
        struct buf names = {0};
        warm_step(w->warm, &names, NULL);
        report(w, &names);
    }
    // A halted round goes on soon, and needs all of it again.
    if (warm_left(w->warm) == 0)
        warm_rest(w->warm);
    pthread_mutex_lock(&w->lock);
}

static void *warmer_main(void *arg)
{
    struct warmer *w = arg;
    pthread_setname_np(pthread_self(), "glint-warm");
    // As the judge, and less: about a tenth of a contended core between them.
    setpriority(PRIO_PROCESS, (id_t)gettid(), 15);
    w->warm = warm_create();
    pthread_mutex_lock(&w->lock);
    while (!w->stop)
        if (w->waiting)
            round_of(w);
        else
            pthread_cond_wait(&w->change, &w->lock);
    pthread_mutex_unlock(&w->lock);
    warm_rest(w->warm);
    warm_destroy(w->warm);
    atomic_store(&w->ended, true);
    return NULL;
}

struct warmer *warmer_create(warmer_done_fn *done, void *ctx, struct error *err)
{
    struct warmer *w = bytes_zalloc(1, sizeof *w);
    w->done = done;
    w->ctx = ctx;
    pthread_mutex_init(&w->lock, NULL);
    pthread_cond_init(&w->change, NULL);
    int bad = pthread_create(&w->thread, NULL, warmer_main, w);
    if (!bad)
        return w;
    error_set(err, "system", "", "no thread: %s", strerror(bad));
    pthread_cond_destroy(&w->change);
    pthread_mutex_destroy(&w->lock);
    free(w);
    return NULL;
}

void warmer_begin(struct warmer *w, const struct warm_scene *scene)
{
    pthread_mutex_lock(&w->lock);
    groom_destroy(w->scene.sample);
    w->scene = *scene;
    w->waiting = true;
    pthread_cond_signal(&w->change);
    pthread_mutex_unlock(&w->lock);
}

void warmer_halt(struct warmer *w)
{
    pthread_mutex_lock(&w->lock);
    w->waiting = false;
    atomic_store(&w->halted, true);
    pthread_mutex_unlock(&w->lock);
}

void warmer_stop(struct warmer *w)
{
    warmer_halt(w);
    pthread_mutex_lock(&w->lock);
    w->stop = true;
    pthread_cond_signal(&w->change);
    pthread_mutex_unlock(&w->lock);
}

bool warmer_ended(struct warmer *w)
{
    return atomic_load(&w->ended);
}

void warmer_destroy(struct warmer *w)
{
    if (!w)
        return;
    warmer_stop(w);
    pthread_join(w->thread, NULL);
    groom_destroy(w->scene.sample);
    pthread_cond_destroy(&w->change);
    pthread_mutex_destroy(&w->lock);
    free(w);
}
