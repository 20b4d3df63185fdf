// engine.c - one lock, one mailbox, one queue of events.  What is rendered when
// is studio.c's affair; who gets it, hub.c's.
#include "server/engine.h"

#include <errno.h>
#include <limits.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "server/clock.h"
#include "server/events.h"

struct capture_item {
    struct capture_item *next;
    struct engine_capture capture;
};

// What was installed belongs to the revision that the loop makes of it: until
// that is known nothing is rendered, or a frame would name the one before.
enum installed { SETTLED, INSTALLED, TAKEN };

struct engine {
    pthread_t render;
    bool started; // the render thread runs
    struct loader *loader;
    pthread_mutex_t lock;
    pthread_cond_t work;   // for the render thread
    pthread_cond_t change; // start, end, for the loop; installed, the loader
    void (*wake)(void *ctx);
    void *ctx;
    struct engine_setup *setup; // during the start only

    // Under the lock:
    bool stop, ready, ended;
    struct error start_error;
    struct studio_wish wish;
    uint64_t taken_revision; // newest that was rendered
    bool viewers_next;       // after a capture viewers have their turn
    struct capture_item *captures;
    uint64_t capturing; // id of the running one; 0: none
    bool capture_cancelled;
    struct loader_item *loaded; // waiting to be installed
    enum installed installed;
    struct events events;
    struct engine_stats stats;
    int64_t progress_since;
    // Render thread only:
    struct studio studio;
};

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

void engine_edit(struct engine *e, const struct params *p, uint64_t revision,
                 int64_t received_us)
{
    pthread_mutex_lock(&e->lock);
    e->wish.params = *p;
    e->wish.revision = revision;
    e->wish.received_us = received_us;
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

// --- the render thread ------------------------------------------------------
// Under the lock.
static void progress(struct engine *e, const char *what)
{
    snprintf(e->stats.progress, sizeof e->stats.progress, "%s", what);
    e->progress_since = clock_us();
}

// Under the lock, after work outside of it.
static void note_stats(struct engine *e)
{
    if (e->studio.samples > 0)
        renderer_stats(e->studio.renderer, &e->stats.renderer);
    e->stats.steps = e->studio.steps;
}

static void note_frames(struct engine *e, const struct studio_frame *frames,
                        int count)
{
    for (int i = 0; i < count; i++) {
        struct engine_event event = {
            .type = ENGINE_FRAME, .ok = true, .frame = frames[i]};
        events_push(&e->events, &event);
        e->stats.frames++;
        for (int d = 0; d < e->wish.demand_count; d++)
            if (still_encoding_same(&e->wish.demand[d].how, &frames[i].asked))
                studio_served(&e->wish.demand[d], &frames[i]);
    }
}

static void note_taken(struct engine *e, uint64_t revision)
{
    if (revision > e->taken_revision + 1)
        e->stats.coalesced += revision - e->taken_revision - 1;
    if (revision > e->taken_revision)
        e->taken_revision = revision;
}

// Entered and left under the lock, as all of the following.
static void do_live(struct engine *e)
{
    struct studio_wish wish = e->wish;
    struct studio_frame frames[STUDIO_DEMANDS];
    int count = 0;
    struct error err = {0};
    note_taken(e, wish.revision);
    pthread_mutex_unlock(&e->lock);
    bool ok =
        studio_turn(&e->studio, &wish, &err) &&
        studio_publish(&e->studio, &wish, clock_us(), frames, &count, &err);
    pthread_mutex_lock(&e->lock);
    progress(e, "");
    note_stats(e);
    note_frames(e, frames, count);
    struct engine_event failed = {
        .type = ENGINE_FAILED, .error = err, .frame.revision = wish.revision};
    e->stats.failures += !ok;
    if (!ok)
        events_push(&e->events, &failed);
}

static bool capture_goes_on(struct engine *e)
{
    return !e->stop && !e->capture_cancelled;
}

// Steps to the end; viewers of the very state see them go by.
static bool capture_steps(struct engine *e, struct studio_wish *wish,
                          struct error *err)
{
    bool done = false, ok = true;
    while (ok && !done && capture_goes_on(e)) {
        struct studio_frame frames[STUDIO_DEMANDS];
        int count = 0;
        memcpy(wish->demand, e->wish.demand, sizeof wish->demand);
        wish->demand_count = e->wish.demand_count;
        pthread_mutex_unlock(&e->lock);
        ok = studio_step(&e->studio, &done, err) &&
             studio_publish(&e->studio, wish, clock_us(), frames, &count, err);
        pthread_mutex_lock(&e->lock);
        note_stats(e);
        note_frames(e, frames, count);
    }
    return ok;
}

static void do_capture(struct engine *e)
{
    struct capture_item *item = e->captures;
    struct engine_capture c = item->capture;
    e->captures = item->next;
    free(item);
    struct studio_wish wish = e->wish;
    struct params p = wish.params;
    struct engine_event event = {.type = ENGINE_CAPTURED, .id = c.id};
    if (c.width > 0) {
        p.image.width = c.width;
        p.image.height = c.height;
    }
    e->capturing = c.id;
    e->capture_cancelled = false;
    progress(e, "capture");
    note_taken(e, wish.revision);
    studio_capture_begin(&e->studio, &p, &wish);
    event.ok =
        (!c.how.layers || studio_capture_layers(&e->studio, &event.error)) &&
        capture_steps(e, &wish, &event.error);
    if (event.ok && capture_goes_on(e)) {
        pthread_mutex_unlock(&e->lock);
        event.ok = studio_capture_end(&e->studio, &c.how, wish.revision,
                                      &event.frame, &event.error);
        event.frame.received_us = wish.received_us;
        pthread_mutex_lock(&e->lock);
    }
    studio_capture_leave(&e->studio);
    if (capture_goes_on(e))
        events_push(&e->events, &event);
    else
        blob_unref(event.frame.bytes);
    e->capturing = 0;
    e->stats.captures++;
    e->stats.captures_waiting--;
    progress(e, "");
}

static void do_install(struct engine *e)
{
    struct loader_item *item = e->loaded;
    e->loaded = item->next;
    pthread_cond_broadcast(&e->change);
    struct engine_event event = {.type = ENGINE_LOADED,
                                 .id = item->id,
                                 .which = item->which,
                                 .error = item->error};
    bool hair = item->which == LOADER_HAIR;
    struct engine_asset_info info = {.source = hair ? item->hair.source
                                                    : item->sky.source,
                                     .strands = item->hair.strands,
                                     .points = item->hair.points,
                                     .width = item->sky.width,
                                     .height = item->sky.height};
    if (item->ok && !item->cancelled) {
        pthread_mutex_unlock(&e->lock);
        event.ok = hair ? studio_set_hair(&e->studio, &item->hair, &event.error)
                        : studio_set_sky(&e->studio, &item->sky, &event.error);
        pthread_mutex_lock(&e->lock);
    }
    if (event.ok) {
        *(hair ? &e->stats.hair : &e->stats.env) = info;
        event.asset = info;
        e->installed = INSTALLED;
    }
    if (!item->cancelled || event.ok)
        events_push(&e->events, &event);
    loader_item_free(item);
}

// False when the time `until` (clock_us) has come.
static bool wait_until(struct engine *e, pthread_cond_t *cond, int64_t until)
{
    if (until == INT64_MAX)
        return pthread_cond_wait(cond, &e->lock) == 0;
    struct timespec t = {.tv_sec = until / 1000000,
                         .tv_nsec = until % 1000000 * 1000};
    return pthread_cond_timedwait(cond, &e->lock, &t) != ETIMEDOUT;
}

static void render_turns(struct engine *e)
{
    while (!e->stop) {
        int64_t until;
        bool wants = studio_wants(&e->studio, &e->wish, clock_us(), &until);
        if (e->installed != SETTLED) {
            wait_until(e, &e->work, INT64_MAX);
        } else if (e->loaded) {
            do_install(e);
        } else if (e->captures && !(e->viewers_next && wants)) {
            do_capture(e);
            e->viewers_next = true;
        } else if (wants) {
            do_live(e);
            e->viewers_next = false;
        } else {
            e->viewers_next = false;
            wait_until(e, &e->work, until);
            continue;
        }
        if (e->events.first)
            e->wake(e->ctx);
    }
}

static void *render_main(void *arg)
{
    struct engine *e = arg;
    struct error err = {0};
    bool ok = studio_open(&e->studio, e->setup->cache_dir, &e->setup->hair,
                          &e->setup->sky, &err);
    pthread_mutex_lock(&e->lock);
    if (ok)
        snprintf(e->stats.device, sizeof e->stats.device, "%s",
                 renderer_device(e->studio.renderer));
    e->ready = ok;
    e->ended = !ok;
    e->start_error = err;
    pthread_cond_broadcast(&e->change);
    if (ok)
        render_turns(e);
    pthread_mutex_unlock(&e->lock);
    studio_close(&e->studio);
    pthread_mutex_lock(&e->lock);
    e->ended = true;
    pthread_cond_broadcast(&e->change);
    pthread_mutex_unlock(&e->lock);
    return NULL;
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
    int bad = pthread_create(&e->render, NULL, render_main, e);
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
    e->stats.hair = (struct engine_asset_info){.source = setup->hair.source,
                                               .strands = setup->hair.strands,
                                               .points = setup->hair.points};
    e->stats.env = (struct engine_asset_info){.source = setup->sky.source,
                                              .width = setup->sky.width,
                                              .height = setup->sky.height};
    bool ok = start(e, err);
    if (ok)
        e->loader = loader_create(setup->roots, loaded, e, err);
    assets_hair_finish(&setup->hair);
    assets_sky_finish(&setup->sky);
    e->setup = NULL;
    if (e->loader)
        return e;
    engine_stop(e, INT_MAX);
    engine_destroy(e);
    return NULL;
}

bool engine_stop(struct engine *e, int wait_ms)
{
    int64_t until = clock_us() + (int64_t)wait_ms * 1000;
    if (e->loader)
        loader_stop(e->loader);
    pthread_mutex_lock(&e->lock);
    e->stop = true;
    pthread_cond_broadcast(&e->work);
    pthread_cond_broadcast(&e->change);
    while (e->started && !e->ended && wait_until(e, &e->change, until))
        continue;
    bool ended = !e->started || e->ended;
    pthread_mutex_unlock(&e->lock);
    while (e->loader && !loader_ended(e->loader) && clock_us() < until)
        usleep(10000);
    if (!ended || (e->loader && !loader_ended(e->loader)))
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
