// engine.c - one lock, one mailbox, one queue of events.  What is rendered when
// is studio.c's affair; who gets it, hub.c's.
#include "server/engine_private.h"

#include <errno.h>
#include <limits.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "server/clock.h"

// --- the loop's side --------------------------------------------------------
bool engine_take(struct engine *e, struct engine_event *out)
{
    pthread_mutex_lock(&e->lock);
    bool got = events_take(&e->events, out);
    if (got && out->type == ENGINE_LOADED && out->ok)
        e->installed = TAKEN;
    pthread_mutex_unlock(&e->lock);
    return got;
}

void engine_edit(struct engine *e, const struct params *p,
                 const struct governor_note *note, uint64_t revision,
                 int64_t received_us)
{
    pthread_mutex_lock(&e->lock);
    e->wish.params = *p;
    e->wish.note = *note;
    e->wish.revision = revision;
    e->wish.received_us = received_us;
    judge_halt(e->judge); // all cores to the edit
    if (e->warmer)
        warmer_halt(e->warmer);
    if (e->installed == TAKEN) // not: one that was made before it was known
        e->installed = SETTLED;
    pthread_cond_signal(&e->work);
    pthread_mutex_unlock(&e->lock);
}

void engine_demand(struct engine *e, int viewers,
                   const struct studio_demand *demand, int count)
{
    pthread_mutex_lock(&e->lock);
    e->wish.viewers = viewers;
    e->wish.demand_count = count < STUDIO_DEMANDS ? count : STUDIO_DEMANDS;
    for (int d = 0; d < e->wish.demand_count; d++) {
        e->wish.demand[d] = demand[d];
        events_serve(&e->events, &e->wish.demand[d]);
    }
    pthread_cond_signal(&e->work);
    pthread_mutex_unlock(&e->lock);
}

void engine_capture(struct engine *e, const struct engine_capture *c)
{
    struct capture_item *item = bytes_zalloc(1, sizeof *item);
    item->capture = *c;
    pthread_mutex_lock(&e->lock);
    struct capture_item **at = &e->captures;
    while (*at)
        at = &(*at)->next;
    *at = item;
    e->stats.captures_waiting++;
    pthread_cond_signal(&e->work);
    pthread_mutex_unlock(&e->lock);
}

void engine_load(struct engine *e, uint64_t id, enum loader_asset which,
                 const char *name)
{
    loader_add(e->loader, id, which, name);
}

static void loaded(void *ctx, struct loader_item *item)
{
    struct engine *e = ctx;
    pthread_mutex_lock(&e->lock);
    struct loader_item **at = &e->loaded;
    while (*at)
        at = &(*at)->next;
    *at = item;
    pthread_cond_signal(&e->work);
    // Nothing more is loaded before this is installed: a long capture would
    // else heap up as many grooms as there are clients.
    while (e->loaded && !e->stop)
        pthread_cond_wait(&e->change, &e->lock);
    pthread_mutex_unlock(&e->lock);
}

// On the warmer's thread.
static void warmed(void *ctx, struct buf *names, int left, int made)
{
    struct engine *e = ctx;
    pthread_mutex_lock(&e->lock);
    buf_append(&e->names, names->data, names->size);
    e->stats.warm_states = made;
    e->stats.warm_states_left = left;
    pthread_cond_signal(&e->work);
    pthread_mutex_unlock(&e->lock);
    buf_finish(names);
}

// On the judge's thread.
static void judged(void *ctx, const struct judge_verdict *v)
{
    struct engine *e = ctx;
    const struct engine_event event = {.type = ENGINE_JUDGED, .verdict = *v};
    pthread_mutex_lock(&e->lock);
    e->stats.verdict = *v;
    events_push(&e->events, &event);
    pthread_mutex_unlock(&e->lock);
    e->wake(e->ctx);
}

void engine_cancel(struct engine *e, uint64_t id)
{
    pthread_mutex_lock(&e->lock);
    for (struct capture_item **at = &e->captures; *at; at = &(*at)->next)
        if ((*at)->capture.id == id) {
            struct capture_item *item = *at;
            *at = item->next;
            free(item);
            e->stats.captures_waiting--;
            break;
        }
    if (e->capturing == id)
        e->capture_cancelled = true;
    for (struct loader_item *i = e->loaded; i; i = i->next)
        if (i->id == id)
            i->cancelled = true;
    pthread_mutex_unlock(&e->lock);
    loader_cancel(e->loader, id);
}

void engine_stats(struct engine *e, struct engine_stats *out)
{
    pthread_mutex_lock(&e->lock);
    *out = e->stats;
    out->progress_seconds = e->stats.progress[0]
                                ? (double)(clock_us() - e->progress_since) / 1e6
                                : 0;
    pthread_mutex_unlock(&e->lock);
}

// --- start and end ----------------------------------------------------------
static void init_locks(struct engine *e)
{
    pthread_condattr_t monotonic;
    pthread_condattr_init(&monotonic);
    pthread_condattr_setclock(&monotonic, CLOCK_MONOTONIC);
    pthread_mutex_init(&e->lock, NULL);
    pthread_cond_init(&e->work, &monotonic);
    pthread_cond_init(&e->change, &monotonic);
    pthread_condattr_destroy(&monotonic);
}

static bool start(struct engine *e, struct error *err)
{
    int bad = pthread_create(&e->render, NULL, engine_render_main, e);
    if (bad)
        return error_set(err, "system", "", "no thread: %s", strerror(bad));
    e->started = true;
    pthread_mutex_lock(&e->lock);
    while (!e->ready && !e->ended)
        pthread_cond_wait(&e->change, &e->lock);
    bool ok = e->ready;
    if (!ok)
        *err = e->start_error;
    pthread_mutex_unlock(&e->lock);
    return ok;
}

struct engine *engine_create(struct engine_setup *setup, struct error *err)
{
    struct engine *e = bytes_zalloc(1, sizeof *e);
    init_locks(e);
    e->setup = setup;
    e->wake = setup->wake;
    e->ctx = setup->ctx;
    e->wish.params = setup->params;
    e->wish.revision = 1;
    e->judge = judge_create(judged, e, err);
    bool ok = e->judge != NULL;
    const char *wanted = getenv("GLINT_WARM");
    if (ok && !(wanted && strcmp(wanted, "0") == 0))
        ok = (e->warmer = warmer_create(warmed, e, err)) != NULL;
    ok = ok && start(e, err);
    if (ok)
        e->loader = loader_create(setup->roots, loaded, e, err);
    opening_end(setup->opening);
    e->setup = NULL;
    if (e->loader)
        return e;
    engine_stop(e, INT_MAX);
    engine_destroy(e);
    return NULL;
}

static bool helpers_ended(const struct engine *e)
{
    return (!e->loader || loader_ended(e->loader)) &&
           (!e->judge || judge_ended(e->judge)) &&
           (!e->warmer || warmer_ended(e->warmer));
}

bool engine_stop(struct engine *e, int wait_ms)
{
    int64_t until = clock_us() + (int64_t)wait_ms * 1000;
    if (e->loader)
        loader_stop(e->loader);
    pthread_mutex_lock(&e->lock);
    e->stop = true;
    if (e->judge)
        judge_stop(e->judge);
    if (e->warmer)
        warmer_stop(e->warmer);
    pthread_cond_broadcast(&e->work);
    pthread_cond_broadcast(&e->change);
    while (e->started && !e->ended && engine_render_wait(e, &e->change, until))
        continue;
    bool ended = !e->started || e->ended;
    pthread_mutex_unlock(&e->lock);
    while (!helpers_ended(e) && clock_us() < until)
        usleep(10000);
    if (!ended || !helpers_ended(e))
        return false;
    if (e->started)
        pthread_join(e->render, NULL);
    e->started = false;
    return true;
}

void engine_destroy(struct engine *e)
{
    if (!e)
        return;
    judge_destroy(e->judge);
    warmer_destroy(e->warmer);
    buf_finish(&e->names);
    events_finish(&e->events);
    while (e->captures) {
        struct capture_item *next = e->captures->next;
        free(e->captures);
        e->captures = next;
    }
    loader_destroy(e->loader);
    while (e->loaded) {
        struct loader_item *next = e->loaded->next;
        loader_item_free(e->loaded);
        e->loaded = next;
    }
    pthread_cond_destroy(&e->change);
    pthread_cond_destroy(&e->work);
    pthread_mutex_destroy(&e->lock);
    free(e);
}
