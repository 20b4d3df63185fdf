// hub.c - hands frames to whom they fit, and sums up what is still wanted.
#include "server/hub.h"

#include <string.h>

#include "server/clock.h"
#include "server/log.h"

// The state as it is drawn goes to the engine.
static void draw(struct hub *h)
{
    struct engine_stats stats;
    engine_stats(h->engine, &stats);
    const struct governor_state state = {
        .params = &h->params,
        .scene = {.device = stats.device,
                  .hair = h->hair.source.sha256,
                  .env = h->env.source.sha256,
                  .strands = h->hair.strands},
        .now_us = clock_us()};
    governor_resolve(&h->governor, &state, &h->drawn);
    engine_edit(h->engine, &h->drawn, &h->governor.note, h->revision,
                h->received_us);
}

void hub_init(struct hub *h, struct loop *loop, struct engine *engine,
              const struct params *p, const struct fronts *fronts)
{
    *h = (struct hub){.loop = loop,
                      .engine = engine,
                      .params = *p,
                      .governor.fronts = *fronts,
                      .revision = 1,
                      .started_us = clock_us()};
    struct engine_stats stats;
    engine_stats(engine, &stats);
    h->hair = stats.hair;
    h->env = stats.env;
    draw(h);
}

static void drop_held(struct hub *h, int i)
{
    blob_unref(h->held[i].frame.bytes);
    h->held[i] = h->held[--h->held_count];
}

void hub_finish(struct hub *h)
{
    while (h->held_count > 0)
        drop_held(h, h->held_count - 1);
    governor_finish(&h->governor);
}

void hub_add(struct hub *h, struct session *s)
{
    s->next = h->sessions;
    if (h->sessions)
        h->sessions->previous = s;
    h->sessions = s;
    h->session_count++;
}

void hub_remove(struct hub *h, struct session *s)
{
    if (s->previous)
        s->previous->next = s->next;
    else
        h->sessions = s->next;
    if (s->next)
        s->next->previous = s->previous;
    h->session_count--;
}

static struct hub_held *held_of(struct hub *h, const struct still_encoding *how)
{
    for (int i = 0; i < h->held_count; i++)
        if (still_encoding_same(&h->held[i].frame.asked, how))
            return &h->held[i];
    return NULL;
}

// Keeps only what somebody streams.
static void forget_unused(struct hub *h)
{
    for (int i = h->held_count - 1; i >= 0; i--) {
        bool used = false;
        for (struct session *s = h->sessions; s && !used; s = s->next) {
            struct still_encoding how = session_encoding(s);
            used = s->streaming &&
                   still_encoding_same(&how, &h->held[i].frame.asked);
        }
        if (!used)
            drop_held(h, i);
    }
}

static void send_held(struct hub *h, struct session *s, bool fresh)
{
    struct still_encoding how = session_encoding(s);
    struct hub_held *held = held_of(h, &how);
    if (!held || held->serial <= s->sent_serial || !session_has_credit(s))
        return;
    // Who has credit only now waits for the newest state rather than getting
    // one that is known to be old.
    if (fresh || held->frame.revision == h->revision)
        session_send_frame(s, &held->frame, held->serial);
}

static int demand(struct hub *h, struct studio_demand out[STUDIO_DEMANDS])
{
    int count = 0;
    for (struct session *s = h->sessions; s; s = s->next) {
        if (!session_has_credit(s))
            continue;
        struct still_encoding how = session_encoding(s);
        bool known = false;
        for (int i = 0; i < count && !known; i++)
            known = still_encoding_same(&out[i].how, &how);
        if (known || count == STUDIO_DEMANDS)
            continue;
        struct hub_held *held = held_of(h, &how);
        out[count] = (struct studio_demand){.how = how};
        if (held)
            studio_served(&out[count], &held->frame);
        count++;
    }
    return count;
}

static void serve(struct hub *h, bool fresh)
{
    if (h->stopping)
        return;
    struct studio_demand wanted[STUDIO_DEMANDS];
    for (struct session *s = h->sessions; s; s = s->next)
        if (s->streaming)
            send_held(h, s, fresh);
    forget_unused(h);
    engine_demand(h->engine, h->viewers, wanted, demand(h, wanted));
}

void hub_serve(struct hub *h)
{
    serve(h, false);
}

static void hold(struct hub *h, const struct studio_frame *f)
{
    struct hub_held *held = held_of(h, &f->asked);
    governor_took(&h->governor, &f->note, f->first_ms);
    if (held) {
        blob_unref(held->frame.bytes);
    } else if (h->held_count < STUDIO_DEMANDS) {
        held = &h->held[h->held_count++];
    } else {
        blob_unref(f->bytes);
        return;
    }
    held->frame = *f;
    if (f->final && h->verdict.revision == f->revision)
        held->frame.verdict = h->verdict;
    held->serial = ++h->next_serial;
}

// The same bytes go out again, with what is known of them now.
static void judge(struct hub *h, const struct judge_verdict *v)
{
    h->verdict = *v;
    bool told = false;
    for (int i = 0; i < h->held_count; i++) {
        struct hub_held *held = &h->held[i];
        if (!held->frame.final || held->frame.revision != v->revision)
            continue;
        held->frame.verdict = *v;
        held->serial = ++h->next_serial;
        if (v->paths == JUDGE_PATHS && !told)
            governor_judged(&h->governor, &held->frame.note, v->value);
        told = true;
    }
}

static struct session *waiting_for(struct hub *h, uint64_t job)
{
    for (struct session *s = h->sessions; s; s = s->next)
        if (s->job == job &&
            (s->wait == SESSION_CAPTURE || s->wait == SESSION_LOAD))
            return s;
    return NULL;
}

static void handle(struct hub *h, struct engine_event *event)
{
    switch (event->type) {
    case ENGINE_FRAME:
        hold(h, &event->frame);
        return;
    case ENGINE_LOADED:
        if (event->ok) {
            *(event->which == LOADER_HAIR ? &h->hair : &h->env) = event->asset;
            hub_edit(h, &h->params);
        }
        break;
    case ENGINE_FAILED:
        log_line("rendering failed: %s", event->error.text);
        for (struct session *s = h->sessions; s; s = s->next)
            if (s->streaming)
                session_event(s, event);
        return;
    case ENGINE_JUDGED:
        judge(h, &event->verdict);
        return;
    case ENGINE_CAPTURED:
        break;
    }
    struct session *s = waiting_for(h, event->id);
    if (s)
        session_event(s, event);
    blob_unref(event->frame.bytes);
}

void hub_events(struct hub *h)
{
    struct engine_event event;
    bool fresh = false;
    while (engine_take(h->engine, &event)) {
        fresh =
            fresh || event.type == ENGINE_FRAME || event.type == ENGINE_JUDGED;
        handle(h, &event);
    }
    if (fresh)
        serve(h, true);
}

void hub_edit(struct hub *h, const struct params *p)
{
    h->params = *p;
    h->revision++;
    h->edits++;
    h->received_us = clock_us();
    draw(h);
    for (struct session *s = h->sessions, *next; s; s = next) {
        next = s->next;
        session_revision(s);
    }
    serve(h, false); // output.format may have changed what streams want
}
