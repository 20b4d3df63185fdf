// engine_render.c - the render thread: what comes next, and its results to the
// loop.
#include "server/engine_private.h"

#include <errno.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "server/clock.h"

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
    e->stats.drafts = e->studio.drafts;
    e->stats.cuts = e->studio.cuts;
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

// A case that was halted before its last verdict is put before the judge anew.
static void judge_again(struct engine *e)
{
    const struct judge_verdict *v = &e->stats.verdict;
    if (v->revision != e->judged || v->paths < JUDGE_PATHS)
        e->judged = 0;
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
    judge_again(e);
    judge_halt(e->judge);
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

static struct engine_asset_info info_of_hair(const struct assets_hair *h)
{
    return (struct engine_asset_info){
        .source = h->source, .strands = h->strands, .points = h->points};
}

static struct engine_asset_info info_of_sky(const struct assets_sky *s)
{
    return (struct engine_asset_info){
        .source = s->source, .width = s->width, .height = s->height};
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
    struct engine_asset_info info =
        hair ? info_of_hair(&item->hair) : info_of_sky(&item->sky);
    if (item->ok && !item->cancelled) {
        pthread_mutex_unlock(&e->lock);
        judge_settle(e->judge);
        event.ok = hair ? studio_set_hair(&e->studio, &item->hair, &event.error)
                        : studio_set_sky(&e->studio, &item->sky, &event.error);
        pthread_mutex_lock(&e->lock);
        if (!event.ok)
            judge_again(e); // of what stays
    }
    if (event.ok) {
        *(hair ? &e->stats.hair : &e->stats.env) = info;
        event.asset = info;
        e->installed = INSTALLED;
        e->judged = 0;
    }
    if (!item->cancelled || event.ok)
        events_push(&e->events, &event);
    loader_item_free(item);
}

// False when the time `until` (clock_us) has come.
bool engine_render_wait(struct engine *e, pthread_cond_t *cond, int64_t until)
{
    if (until == INT64_MAX)
        return pthread_cond_wait(cond, &e->lock) == 0;
    struct timespec t = {.tv_sec = until / 1000000,
                         .tv_nsec = until % 1000000 * 1000};
    return pthread_cond_timedwait(cond, &e->lock, &t) != ETIMEDOUT;
}

// What the picture shows when it rests is put before the judge, once.
static void do_judge(struct engine *e)
{
    const uint64_t revision = e->studio.live_revision;
    const uint32_t shown_otherwise = 1u << GROUP_view | 1u << GROUP_output;
    const struct params *p = &e->studio.set;
    struct judge_verdict known = e->stats.verdict;
    bool same = (params_changed(p, &e->judged_params) & ~shown_otherwise) == 0;
    if (same && e->judged > 0 && known.revision == e->judged &&
        known.paths == JUDGE_PATHS) {
        known.revision = revision;
        e->stats.verdict = known;
        const struct engine_event event = {.type = ENGINE_JUDGED,
                                           .verdict = known};
        events_push(&e->events, &event);
    } else {
        struct judge_case c;
        struct error err = {0}; // without places there is no verdict
        pthread_mutex_unlock(&e->lock);
        bool ok = studio_case(&e->studio, &c, &err);
        pthread_mutex_lock(&e->lock);
        if (ok && e->wish.revision == revision)
            judge_hear(e->judge, &c);
        else
            free(c.places);
    }
    e->judged = revision;
    e->judged_params = *p;
}

// Once a picture of this state is shown and no hand moves; until then *until is
// no later than that.
static void ask_warmer(struct engine *e, int64_t *until)
{
    const struct studio *s = &e->studio;
    const int64_t due = e->wish.received_us + STUDIO_HASTE_US;
    if (!e->warmer || !s->live || s->samples == 0 ||
        e->warmed == s->live_revision || s->live_revision != e->wish.revision)
        return;
    if (clock_us() < due) {
        *until = due < *until ? due : *until;
        return;
    }
    e->warmed = s->live_revision;
    e->stats.warm_states_left = INT_MAX; // not known yet
    struct warm_scene scene;
    renderer_warm_scene(s->renderer, &scene);
    warmer_begin(e->warmer, &scene);
}

static bool has_names(const struct engine *e)
{
    return e->names_at < e->names.size;
}

// One program that the warmer has needed: from the driver's cache that takes a
// few milliseconds.
static void prepare_program(struct engine *e)
{
    char name[512];
    const unsigned char *at = e->names.data + e->names_at;
    const unsigned char *end = memchr(at, '\n', e->names.size - e->names_at);
    const size_t size = (size_t)(end - at);
    e->names_at += size + 1;
    if (size > sizeof name)
        return;
    memcpy(name, at, size);
    const struct span line = {(const unsigned char *)name, size};
    pthread_mutex_unlock(&e->lock);
    renderer_prepare(e->studio.renderer, line, NULL); // else an edit will say
    pthread_mutex_lock(&e->lock);
    note_stats(e);
}

static void note_warmth(struct engine *e)
{
    int left = 0;
    for (size_t i = e->names_at; i < e->names.size; i++)
        left += e->names.data[i] == '\n';
    e->stats.warm_programs_left = left;
    e->stats.warm = e->warmed > 0 && e->warmed == e->wish.revision &&
                    e->stats.warm_states_left == 0 && left == 0;
}

static void render_turns(struct engine *e)
{
    while (!e->stop) {
        int64_t until;
        bool wants = studio_wants(&e->studio, &e->wish, clock_us(), &until);
        ask_warmer(e, &until);
        note_warmth(e);
        if (e->installed != SETTLED) {
            engine_render_wait(e, &e->work, INT64_MAX);
        } else if (e->loaded) {
            do_install(e);
        } else if (e->captures && !(e->viewers_next && wants)) {
            do_capture(e);
            e->viewers_next = true;
        } else if (wants) {
            do_live(e);
            e->viewers_next = false;
        } else if (studio_rests(&e->studio) &&
                   e->judged != e->studio.live_revision) {
            do_judge(e);
        } else if (has_names(e)) {
            prepare_program(e);
        } else {
            e->viewers_next = false;
            engine_render_wait(e, &e->work, until);
            continue;
        }
        if (e->events.first)
            e->wake(e->ctx);
    }
}

// Asked in the middle of a step: is it still wanted?  A capture is, whatever
// comes, unless nobody waits for it any more.
static bool newer(void *ctx)
{
    struct engine *e = ctx;
    pthread_mutex_lock(&e->lock);
    const bool is = e->capturing
                        ? !capture_goes_on(e)
                        : e->stop || e->loaded ||
                              (e->studio.live &&
                               e->wish.revision != e->studio.live_revision);
    pthread_mutex_unlock(&e->lock);
    return is;
}

void *engine_render_main(void *arg)
{
    struct engine *e = arg;
    struct error err = {0};
    pthread_setname_np(pthread_self(), "glint-render");
    struct opening *o = e->setup->opening;
    bool ok = studio_open(&e->studio, e->setup->cache_dir, o, &err);
    e->studio.newer = newer;
    e->studio.ctx = e;
    pthread_mutex_lock(&e->lock);
    if (ok) {
        e->stats.hair = info_of_hair(opening_hair(o));
        e->stats.env = info_of_sky(opening_sky(o));
    }
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
    judge_settle(e->judge); // it may still be reading the strands
    studio_close(&e->studio);
    pthread_mutex_lock(&e->lock);
    e->ended = true;
    pthread_cond_broadcast(&e->change);
    pthread_mutex_unlock(&e->lock);
    return NULL;
}
