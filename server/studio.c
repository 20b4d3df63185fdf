// studio.c - decides what the renderer does next for viewers, and when a
// picture is worth encoding: a draft where edits keep coming and the first
// sample of a new state would be late, that first sample, then at 4, 16, 64 ...
// samples, and when it is final.
#include "server/studio.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "renderer/encode.h"
#include "server/clock.h"
#include "server/rehearsal.h"

// What changes these leaves the picture's samples as they are, and the tint's
// group where the renderer says so (renderer.h).
#define KEEPS_PICTURE (1u << GROUP_view | 1u << GROUP_output | 1u << GROUP_tint)

static void restart(struct studio *s)
{
    s->samples = 0;
    s->done = false;
    s->draft.divisor = 0;
    s->rehearsals = STUDIO_REHEARSALS;
}

bool studio_set_hair(struct studio *s, struct assets_hair *h, struct error *err)
{
    struct groom *g = h->groom;
    h->groom = NULL;
    if (!renderer_set_groom(s->renderer, g, err))
        return false;
    s->hair = h->source;
    restart(s);
    s->haste = (struct haste){0};
    s->failed_revision = 0;
    return true;
}

bool studio_set_sky(struct studio *s, struct assets_sky *m, struct error *err)
{
    struct sky_map *map = m->map;
    m->map = NULL;
    if (!renderer_set_sky(s->renderer, map, err))
        return false;
    s->env = m->source;
    restart(s);
    s->failed_revision = 0;
    return true;
}

bool studio_open(struct studio *s, const char *cache_dir, struct opening *o,
                 struct error *err)
{
    *s = (struct studio){0};
    params_defaults(&s->set);
    s->renderer = renderer_create(cache_dir, err);
    if (!s->renderer)
        return false;
    renderer_set_params(s->renderer, &s->set);
    return opening_wait(o, err) && studio_set_hair(s, opening_hair(o), err) &&
           studio_set_sky(s, opening_sky(o), err);
}

void studio_close(struct studio *s)
{
    renderer_destroy(s->renderer);
    s->renderer = NULL;
}

static void set(struct studio *s, const struct params *p)
{
    const bool other = (params_changed(&s->set, p) & ~KEEPS_PICTURE) != 0;
    if (renderer_set_params(s->renderer, p) || other)
        restart(s);
    s->set = *p;
}

// A state of which something was shown may give way to the next.  One of which
// nothing was may not, or who edits faster than pictures are made sees none.
static void watch(struct studio *s)
{
    const bool shown = s->samples > 0 || s->draft.divisor > 0;
    renderer_watch(s->renderer, shown ? s->newer : NULL, s->ctx);
}

bool studio_step(struct studio *s, bool *done, struct error *err)
{
    *done = s->done;
    if (s->done)
        return true;
    int64_t began = clock_us();
    watch(s);
    bool ok = renderer_step(s->renderer, &s->done, err);
    s->render_ms += (double)(clock_us() - began) / 1e3;
    if (!ok || renderer_was_cut(s->renderer)) {
        s->cuts += ok;
        s->done = *done = false;
        return ok;
    }
    s->stepped = true;
    s->steps++;
    struct renderer_stats stats;
    renderer_stats(s->renderer, &stats);
    s->samples = stats.samples;
    if (s->samples == 1 && !stats.refined && s->live) // not a capture's
        haste_full(&s->haste, stats.stage_ms);
    *done = s->done;
    return true;
}

// --- drafts -----------------------------------------------------------------
static bool in_haste(const struct studio_wish *w, int64_t now)
{
    return w->received_us > 0 && now < w->received_us + STUDIO_HASTE_US;
}

// Is a draft all that there is of the viewers' state?
static bool only_drafted(const struct studio *s)
{
    return s->live && s->samples == 0 && s->draft.divisor > 0;
}

// EXR is for numbers: nobody wants those of a draft.
static bool shows_drafts(const struct studio_demand *d)
{
    return d->how.format != STILL_EXR;
}

static int64_t rests_from(const struct studio *s, const struct studio_wish *w)
{
    return w->received_us + s->rest_us;
}

// Makes one where the first sample of this state would take longer than
// quality.draft_ms.  False: there is none, and the sample is next; where a
// draft failed it has the same reasons to fail, and says so.
static bool draft(struct studio *s, const struct studio_wish *w)
{
    const double budget = (double)s->set.quality.draft_ms;
    double forecast[RENDERER_STAGES];
    struct haste_ask ask;
    struct renderer_draft how;
    struct renderer_stats stats;
    bool shown = false;
    for (int i = 0; i < w->demand_count; i++)
        shown = shown || shows_drafts(&w->demand[i]);
    const int64_t began = clock_us();
    rehearsal_ask(s->renderer, &s->set, &ask);
    if (!shown || budget <= 0 || s->samples > 0 || !in_haste(w, began) ||
        !renderer_forecast(s->renderer, forecast) ||
        !haste_choose(&s->haste, forecast, &ask, &how) ||
        !renderer_draft(s->renderer, &how, NULL))
        return false;
    const int64_t whole = (int64_t)(1e3 * haste_full_ms(&s->haste, forecast));
    s->rest_us = whole < STUDIO_REST_US ? whole : STUDIO_REST_US;
    s->render_ms += (double)(clock_us() - began) / 1e3;
    s->draft = how;
    s->stepped = true;
    s->drafts++;
    renderer_stats(s->renderer, &stats);
    haste_draft(&s->haste, forecast, &how, stats.stage_ms);
    return true;
}

// Once a first picture was shown, for the edits to come.
static bool rehearses(const struct studio *s, const struct studio_wish *w)
{
    return s->live && s->samples > 0 && s->rehearsals > 0 && w->viewers > 0 &&
           s->set.quality.draft_ms > 0;
}

static void rehearse(struct studio *s)
{
    s->rehearsals--;
    watch(s);
    if (!rehearsal_next(&s->haste, s->renderer, &s->set))
        s->rehearsals = 0;
    s->cuts += renderer_was_cut(s->renderer);
}

// --- viewers ----------------------------------------------------------------
// The samples of the newest moment that is worth a frame; 0: none yet.
static int milestone(const struct studio *s)
{
    if (s->done)
        return s->samples;
    int m = 1;
    while (m * 4 <= s->samples)
        m *= 4;
    return s->samples > 0 ? m : 0;
}

static bool due(const struct studio *s, const struct studio_wish *w,
                const struct studio_demand *d, int64_t now)
{
    int reached = milestone(s);
    if (only_drafted(s))
        return d->revision != s->live_revision && shows_drafts(d);
    if (reached == 0)
        return false;
    return d->revision != s->live_revision || d->samples < reached ||
           (s->done && !d->final) || (d->hasty && s->done && !in_haste(w, now));
}

bool studio_wants(const struct studio *s, const struct studio_wish *w,
                  int64_t now, int64_t *until)
{
    *until = INT64_MAX;
    if (w->viewers == 0 || s->failed_revision == w->revision)
        return false;
    if (w->revision != s->live_revision)
        return w->demand_count > 0;
    const bool waits = only_drafted(s) && now < rests_from(s, w);
    if (waits)
        *until = rests_from(s, w);
    else if ((s->live && !s->done) || rehearses(s, w))
        return true;
    for (int i = 0; i < w->demand_count; i++) {
        const struct studio_demand *d = &w->demand[i];
        // After a capture at another size the live picture is made again
        // only for a viewer that lacks something.
        bool lacks = d->revision != s->live_revision || !d->final;
        if (s->live ? due(s, w, d, now)
                    : lacks || (d->hasty && !in_haste(w, now)))
            return true;
        if (d->hasty && !waits)
            *until = w->received_us + STUDIO_HASTE_US;
    }
    return false;
}

bool studio_turn(struct studio *s, const struct studio_wish *w,
                 struct error *err)
{
    if (w->revision != s->live_revision || !s->live) {
        s->render_ms = 0;
        s->stepped = false;
        set(s, &w->params);
        s->note = w->note;
        s->live_revision = w->revision;
        s->live = true;
        // Its samples hold for the new state too: shown at once, then refined.
        if (s->samples > 0)
            return true;
    }
    // A draft stays for now, or is made now.
    if (only_drafted(s) ? clock_us() < rests_from(s, w) : draft(s, w))
        return true;
    if (rehearses(s, w)) {
        rehearse(s);
        return true;
    }
    bool done;
    if (studio_step(s, &done, err))
        return true;
    s->failed_revision = w->revision;
    return false;
}

static struct still_encoding resolve(const struct still_encoding *how,
                                     bool haste)
{
    struct still_encoding e = *how;
    if (e.format == STILL_JPEG && e.quality == 0) {
        e.quality = haste ? STUDIO_HASTE_QUALITY : STUDIO_REST_QUALITY;
        e.chroma = haste ? ENCODE_420 : ENCODE_444;
    }
    return e;
}

static void stages(const struct studio *s, struct studio_frame *f)
{
    struct renderer_stats stats;
    renderer_stats(s->renderer, &stats);
    for (int i = 0; i < RENDERER_STAGES; i++) {
        // Without a step since the last frame only these ran.
        bool ran = s->stepped || i == RENDERER_TINT || i == RENDERER_DISPLAY ||
                   i == RENDERER_READ;
        f->stage_ms[i] = ran ? stats.stage_ms[i] : -1;
    }
    f->path = stats.path;
    // The stages of a fibre edit, whichever edit it was.
    static const int parts[] = {RENDERER_FIBRE, RENDERER_SHADE,
                                RENDERER_RESOLVE, RENDERER_DISPLAY,
                                RENDERER_READ};
    const bool first = s->stepped && s->samples == 1 && !stats.refined &&
                       f->stage_ms[RENDERER_SHADE] >= 0;
    for (size_t i = 0; first && i < sizeof parts / sizeof *parts; i++)
        f->first_ms += fmax(f->stage_ms[parts[i]], 0);
}

// What was measured on the way from picture to bytes.
static void note_tail(struct studio *s, const struct studio_frame *f)
{
    const double ms = fmax(f->stage_ms[RENDERER_DISPLAY], 0) +
                      fmax(f->stage_ms[RENDERER_READ], 0) + f->encode_ms;
    if (f->draft.divisor > 0)
        haste_draft_tail(&s->haste, ms);
    else if (f->samples == 1)
        haste_full_tail(&s->haste, ms);
}

static bool make(struct studio *s, struct still_request *q,
                 struct studio_frame *f, struct error *err)
{
    struct buf bytes = {0};
    bool ok = still_encode(&bytes, s->renderer, q, err);
    if (ok) {
        f->bytes = blob_from(bytes.data, bytes.size);
        f->used = q->how;
        f->width = q->state->params->image.width;
        f->height = q->state->params->image.height;
        f->samples = s->samples;
        f->final = s->done;
        f->render_ms = s->render_ms;
        f->encode_ms = q->encode_ms;
        f->note = s->note;
        if (only_drafted(s))
            f->draft = s->draft;
        stages(s, f);
        note_tail(s, f);
    }
    buf_finish(&bytes);
    return ok;
}

bool studio_publish(struct studio *s, const struct studio_wish *w, int64_t now,
                    struct studio_frame *out, int *count, struct error *err)
{
    bool haste = in_haste(w, now);
    struct still_state state = {.params = &s->set};
    *count = 0;
    if (!s->live)
        return true;
    for (int i = 0; i < w->demand_count; i++) {
        const struct studio_demand *d = &w->demand[i];
        if (!due(s, w, d, now))
            continue;
        struct still_request q = {.state = &state,
                                  .how = resolve(&d->how, haste)};
        struct studio_frame *f = &out[*count];
        *f = (struct studio_frame){
            .asked = d->how,
            .revision = s->live_revision,
            .received_us = w->received_us,
            .hasty =
                haste && d->how.format == STILL_JPEG && d->how.quality == 0,
        };
        if (!make(s, &q, f, err)) {
            s->failed_revision = w->revision;
            return false;
        }
        ++*count;
    }
    if (*count > 0) {
        s->render_ms = 0;
        s->stepped = false;
    }
    return true;
}

void studio_served(struct studio_demand *d, const struct studio_frame *f)
{
    d->revision = f->revision;
    d->samples = f->samples;
    d->final = f->final;
    d->hasty = f->hasty;
}

// --- the judge --------------------------------------------------------------
bool studio_rests(const struct studio *s)
{
    return s->live && s->done && s->set.quality.error_places > 0 &&
           s->set.render.components == 0;
}

bool studio_case(struct studio *s, struct judge_case *c, struct error *err)
{
    const size_t want = (size_t)s->set.quality.error_places;
    *c = (struct judge_case){.revision = s->live_revision};
    renderer_scene(s->renderer, &c->scene);
    c->scene.params = &s->set;
    c->scene.fit = NULL; // a judge does not look at the lights
    c->places = bytes_alloc(want * sizeof *c->places);
    bool ok = renderer_places(s->renderer, want, s->live_revision, c->places,
                              &c->count, err);
    if (ok && c->count > 0)
        return true;
    free(c->places);
    c->places = NULL;
    return false;
}

// --- captures ---------------------------------------------------------------
void studio_capture_begin(struct studio *s, const struct params *p,
                          const struct studio_wish *w)
{
    bool same = params_changed(p, &w->params) == 0;
    if (!same || w->revision != s->live_revision || !s->live) {
        s->render_ms = 0;
        s->stepped = false;
    }
    set(s, p);
    s->note = w->note;
    s->live = same;
    if (same)
        s->live_revision = w->revision;
}

bool studio_capture_layers(struct studio *s, struct error *err)
{
    if (!renderer_layers_on(s->renderer, err))
        return false;
    restart(s); // the same picture once more
    return true;
}

void studio_capture_leave(struct studio *s)
{
    if (renderer_layers_off(s->renderer))
        restart(s);
}

bool studio_capture_end(struct studio *s, const struct still_encoding *how,
                        uint64_t revision, struct studio_frame *out,
                        struct error *err)
{
    char governor[256];
    governor_text(&s->note, governor, sizeof governor);
    struct still_state state = {
        .params = &s->set,
        .hair = s->hair,
        .env = s->env,
        .device = renderer_device(s->renderer),
        .governor = s->note.asked[0] ? governor : NULL,
    };
    struct still_request q = {.state = &state, .how = *how, .with_state = true};
    *out = (struct studio_frame){.asked = *how, .revision = revision};
    bool ok = make(s, &q, out, err);
    s->render_ms = 0;
    s->stepped = false;
    return ok;
}
