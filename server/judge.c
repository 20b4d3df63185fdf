// judge.c - one thread, one case at a time.  What is compared, and when, is
// for studio.c to say.
#include "server/judge.h"

#include <math.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <unistd.h>

#include "protocol/bytes.h"
#include "server/clock.h"

// Paths a place, first and in all: after the first a figure can be shown.  They
// say what was scattered several times; light scattered once is summed over the
// sky, with far less noise.
static const int rounds[] = {16, JUDGE_PATHS};
enum { BATCH = 16 }; // places summed between two looks at `halted`

struct judge {
    pthread_t thread;
    void (*done)(void *ctx, const struct judge_verdict *v);
    void *ctx;
    atomic_bool halted; // the case at hand is not wanted any more
    atomic_bool ended;
    pthread_mutex_t lock;
    pthread_cond_t change;
    // Under the lock:
    bool stop, waiting, reading; // reading: groom and map are being read
    struct judge_case next;      // where waiting
    struct params params;        // of next
    // The judge's own thread only: kept from case to case, since most edits
    // leave the hair as it is.
    struct reference *truth;
};

static bool go_on(void *self, const struct reference_progress *p)
{
    struct judge *j = self;
    (void)p;
    return !atomic_load(&j->halted);
}

static void compare(const struct judge_case *c,
                    const struct reference_single *once,
                    const struct reference_estimate *paths,
                    struct judge_verdict *v)
{
    double *x = bytes_alloc(9 * c->count * sizeof *x);
    double *r = x + 3 * c->count, *variance = r + 3 * c->count;
    for (size_t i = 0; i < c->count; i++)
        for (size_t k = 0; k < 3; k++) {
            x[3 * i + k] = (double)c->places[i].radiance[k];
            r[3 * i + k] = once[i].sum[k] + paths[i].multiple[k];
            variance[3 * i + k] = paths[i].multiple_variance[k];
        }
    struct metric_errors e;
    metric_errors(&(struct metric_pairs){c->count, x, r, variance}, &e);
    v->value = e.rel_rmse.value;
    v->low = e.rel_rmse.low;
    v->high = e.rel_rmse.high;
    v->bias = e.mean_signed.value;
    v->noise = e.noise;
    free(x);
}

static bool sum_once(struct judge *j, const struct judge_case *c,
                     struct reference_single *once)
{
    for (size_t i = 0; i < c->count && !atomic_load(&j->halted); i += BATCH) {
        const size_t left = c->count - i;
        reference_single(j->truth, c->places + i, left < BATCH ? left : BATCH,
                         0, c->revision + i, once + i);
    }
    return !atomic_load(&j->halted);
}

static void weigh(struct judge *j, const struct judge_case *c, int64_t began)
{
    struct reference_estimate *e = bytes_alloc(c->count * sizeof *e);
    struct reference_single *once = bytes_alloc(c->count * sizeof *once);
    const size_t count =
        sum_once(j, c, once) ? sizeof rounds / sizeof *rounds : 0;
    for (size_t i = 0; i < count; i++) {
        const struct reference_paths how = {.samples = rounds[i],
                                            .seed = c->revision,
                                            .progress = go_on,
                                            .self = j};
        if (!reference_path(j->truth, c->places, c->count, &how, e))
            break;
        struct judge_verdict v = {.revision = c->revision,
                                  .places = (int)c->count,
                                  .paths = rounds[i],
                                  .memory = reference_bytes(j->truth)};
        compare(c, once, e, &v);
        v.seconds = (double)(clock_us() - began) / 1e6;
        // A black truth has no relative error.
        if (isfinite(v.value) && !atomic_load(&j->halted))
            j->done(j->ctx, &v);
    }
    free(once);
    free(e);
}

static bool is_halted(void *self)
{
    return atomic_load(&((struct judge *)self)->halted);
}

// Under the lock, let go of while it works.
static void hear_next(struct judge *j)
{
    struct judge_case c = j->next;
    struct params params = j->params;
    struct error err = {0};
    const int64_t began = clock_us();
    struct watch watch = {.newer = is_halted, .ctx = j};
    c.scene.params = &params;
    c.scene.watch = &watch;
    j->waiting = false;
    j->reading = true;
    atomic_store(&j->halted, false);
    pthread_mutex_unlock(&j->lock);
    bool ok = true;
    if (j->truth)
        ok = reference_update(j->truth, &c.scene, &err);
    else
        j->truth = reference_create(&c.scene, &err);
    pthread_mutex_lock(&j->lock);
    j->reading = false;
    pthread_cond_broadcast(&j->change);
    pthread_mutex_unlock(&j->lock);
    // A groom too large for the truth has no verdict; that is no fault.
    if (ok && j->truth && !atomic_load(&j->halted))
        weigh(j, &c, began);
    free(c.places);
    pthread_mutex_lock(&j->lock);
}

static void *judge_main(void *arg)
{
    struct judge *j = arg;
    // About a tenth of a contended core; the threads it makes inherit this.
    // Not the idle class: who waits in judge_settle would wait for ever on a
    // machine that others keep busy.
    setpriority(PRIO_PROCESS, (id_t)gettid(), 10);
    pthread_mutex_lock(&j->lock);
    while (!j->stop)
        if (j->waiting)
            hear_next(j);
        else
            pthread_cond_wait(&j->change, &j->lock);
    pthread_mutex_unlock(&j->lock);
    atomic_store(&j->ended, true);
    return NULL;
}

struct judge *judge_create(void (*done)(void *ctx,
                                        const struct judge_verdict *v),
                           void *ctx, struct error *err)
{
    struct judge *j = bytes_zalloc(1, sizeof *j);
    j->done = done;
    j->ctx = ctx;
    pthread_mutex_init(&j->lock, NULL);
    pthread_cond_init(&j->change, NULL);
    int bad = pthread_create(&j->thread, NULL, judge_main, j);
    if (!bad)
        return j;
    error_set(err, "system", "", "no thread: %s", strerror(bad));
    pthread_cond_destroy(&j->change);
    pthread_mutex_destroy(&j->lock);
    free(j);
    return NULL;
}

// Under the lock.
static void drop_waiting(struct judge *j)
{
    if (j->waiting)
        free(j->next.places);
    j->waiting = false;
}

void judge_hear(struct judge *j, struct judge_case *c)
{
    pthread_mutex_lock(&j->lock);
    drop_waiting(j);
    atomic_store(&j->halted, true);
    j->next = *c;
    j->params = *c->scene.params;
    j->waiting = true;
    pthread_cond_broadcast(&j->change);
    pthread_mutex_unlock(&j->lock);
    *c = (struct judge_case){0};
}

void judge_halt(struct judge *j)
{
    pthread_mutex_lock(&j->lock);
    drop_waiting(j);
    atomic_store(&j->halted, true);
    pthread_mutex_unlock(&j->lock);
}

void judge_settle(struct judge *j)
{
    judge_halt(j);
    pthread_mutex_lock(&j->lock);
    while (j->reading)
        pthread_cond_wait(&j->change, &j->lock);
    pthread_mutex_unlock(&j->lock);
}

void judge_stop(struct judge *j)
{
    pthread_mutex_lock(&j->lock);
    drop_waiting(j);
    j->stop = true;
    atomic_store(&j->halted, true);
    pthread_cond_broadcast(&j->change);
    pthread_mutex_unlock(&j->lock);
}

bool judge_ended(struct judge *j)
{
    return atomic_load(&j->ended);
}

void judge_destroy(struct judge *j)
{
    if (!j)
        return;
    judge_stop(j); // drops as well what came in after an earlier one
    pthread_join(j->thread, NULL);
    reference_destroy(j->truth);
    pthread_cond_destroy(&j->change);
    pthread_mutex_destroy(&j->lock);
    free(j);
}
