// renderer_draft.c - a draft: the first sample of the picture that is asked
// for, with another picture, other strands and where need be another field of
// crossings in the places of the renderer's own, which come back untouched.
// When a draft is worth making, and how coarse, is not decided here.
#include "renderer/renderer_private.h"

#include <string.h>

#include "renderer/egl.h"
#include "renderer/gl.h"
#include "renderer/glsl.h"

#define SWAP(type, a, b) \
    do { \
        type kept_ = (a); \
        (a) = (b); \
        (b) = kept_; \
    } while (0)

// Are there drafts of what is asked for at all?
static bool draws_drafts(const struct renderer *r)
{
    return r->groom && r->map && renderer_first_of(r) && !r->layers.on &&
           r->params.render.path != RENDERER_FORWARD && !renderer_mapped(r) &&
           (!r->stale[RENDERER_SKY] || r->draft.fit.count > 0);
}

bool renderer_forecast(const struct renderer *r, double ms[RENDERER_STAGES])
{
    bool any = false;
    if (!draws_drafts(r) || r->samples > 0 || r->refined)
        return false;
    const struct renderer_first *first = renderer_first_of(r);
    for (int i = 0; i < RENDERER_STAGES; i++) {
        ms[i] = r->stale[i] ? first->ms[i] : -1;
        any |= r->stale[i];
    }
    return any;
}

bool renderer_foresee(const struct renderer *r, enum renderer_stage first,
                      double ms[RENDERER_STAGES])
{
    const uint32_t after = renderer_after(r, first);
    if (!draws_drafts(r) || r->samples == 0)
        return false;
    for (int i = 0; i < RENDERER_STAGES; i++) {
        if (i < RENDERER_SHADOW && i != RENDERER_TINT && r->stale[i])
            return false;
        ms[i] = after >> i & 1 ? renderer_first_of(r)->ms[i] : -1;
    }
    return true;
}

int renderer_drafts_seen(const struct renderer *r,
                         struct renderer_draft out[RENDERER_DRAFT_VIEWS])
{
    const struct draft *d = &r->draft;
    unsigned below = d->clock + 1;
    for (int n = 0;; n++) {
        const struct draft_view *next = NULL;
        for (int i = 0; i < RENDERER_DRAFT_VIEWS; i++) {
            const struct draft_view *v = &d->view[i];
            if (v->seen && v->age < below && (!next || v->age > next->age))
                next = v;
        }
        if (!next)
            return n;
        out[n] = next->how;
        below = next->age;
    }
}

// --- in the renderer's place -------------------------------------------------

// Programs and buffers that do not depend on the picture's size.
static void lend(struct picture *to, struct picture *from)
{
    unsigned *const a[] = {&to->cells, &to->cells_drawn, &to->number,
                           &to->count, &to->add,         &to->scene};
    unsigned *const b[] = {&from->cells, &from->cells_drawn, &from->number,
                           &from->count, &from->add,         &from->scene};
    for (size_t i = 0; i < sizeof a / sizeof a[0]; i++) {
        *a[i] = *b[i];
        *b[i] = 0;
    }
    to->raster = from->raster;
    to->drawn = from->drawn;
    to->always_drawn = from->always_drawn;
    memset(&from->raster, 0, sizeof from->raster);
    memset(&from->drawn, 0, sizeof from->drawn);
}

static void lend_display(struct display *to, struct display *from)
{
    for (size_t i = 0; i < sizeof to->program / sizeof to->program[0]; i++)
        SWAP(unsigned, to->program[i], from->program[i]);
    SWAP(unsigned, to->sky, from->sky);
    SWAP(unsigned, to->sky_number, from->sky_number);
    SWAP(const void *, to->sky_of, from->sky_of);
}

// Its own inverse.
static void exchange(struct renderer *r)
{
    struct draft *d = &r->draft;
    struct draft_view *v = d->now;
    SWAP(struct picture, r->picture, v->picture);
    SWAP(struct nodes_store, r->nodes.first, v->nodes.first);
    SWAP(struct nodes_store, r->nodes.rest, v->nodes.rest);
    SWAP(bool, r->nodes.first_valid, v->nodes.first_valid);
    SWAP(unsigned, r->nodes.made, v->nodes.made);
    SWAP(struct camera, r->camera, v->camera);
    if (renderer_draft_owns_strands(r))
        SWAP(struct strands, r->strands, d->strands);
    if (v->how.coarse)
        SWAP(struct crossings, r->crossings, d->crossings);
}

static void find_widths(struct renderer *r, int height)
{
    if (r->camera.tan_half > 0) // it was found before
        strands_widths(&r->strands, &r->camera,
                       0.5f * (float)height / r->camera.tan_half);
}

// The draft's only sample, as renderer_sample makes any.
static bool sample(struct renderer *r, struct params *p, struct error *err)
{
    bool stale[RENDERER_STAGES];
    struct draft *d = &r->draft;
    const uint64_t budget = r->nodes_budget;
    const int samples = r->samples;
    const bool refined = r->refined;
    if (budget == 0) // by the whole's quality.cache_mb
        r->nodes_budget = ((uint64_t)r->params.quality.cache_mb << 20) / 2;
    memcpy(stale, r->stale, sizeof stale);
    lend(&d->now->picture, &r->picture);
    exchange(r);
    r->samples = 0;
    r->refined = false;
    SWAP(struct params, r->params, *p);
    find_widths(r, r->picture.height);
    r->drafting = true; // few places: tables of each light would cost more
    const bool ok = renderer_sample(r, err);
    r->drafting = false;
    SWAP(struct params, r->params, *p);
    exchange(r);
    lend(&r->picture, &d->now->picture);
    memcpy(r->stale, stale, sizeof stale);
    r->nodes_budget = budget;
    r->samples = samples;
    r->refined = refined;
    // Where all strands are drawn they are the renderer's own.
    find_widths(r, r->params.image.height);
    return ok;
}

static bool make(struct renderer *r, struct renderer_draft *how,
                 struct error *err)
{
    struct draft *d = &r->draft;
    egl_use(r->egl);
    d->shown = NULL;
    for (int i = 0; i < RENDERER_STAGES; i++)
        r->stats.stage_ms[i] = -1;
    if (how->stride < 2 && !r->strands.axis && shading_wants_axis(&r->params))
        how->stride = 2; // an axis for all of them takes longer than a picture
    d->now = draft_view_of(d, how);
    draft_view_take(d, d->now, how);
    d->now->picture.watch = d->strands.watch = &r->watch;
    struct params p = renderer_draft_params(r, how->divisor);
    if (d->as_if == RENDERER_VISIBLE)
        d->now->seen = false;
    if (d->as_if == RENDERER_STRANDS)
        d->stride = d->gridded = 0;
    if (d->as_if == RENDERER_STRANDS || d->as_if == RENDERER_CROSSINGS)
        d->swept.known = false;
    if (!renderer_draft_parts(r, err) || !sample(r, &p, err))
        return false;
    d->now->seen = true;
    *how = d->now->how;
    return true;
}

bool renderer_draft(struct renderer *r, struct renderer_draft *how,
                    struct error *err)
{
    double ms[RENDERER_STAGES];
    r->work_from = gl_count_now();
    if (!renderer_forecast(r, ms))
        return error_set(err, "state", "quality.draft_ms",
                         "no draft is to be had of this");
    // Never cut: while edits keep coming it is all that is shown of any.
    bool (*const newer)(void *) = r->watch.newer;
    r->watch.newer = NULL;
    const bool ok = make(r, how, err);
    r->watch.newer = newer;
    if (ok)
        r->draft.shown = r->draft.now;
    else
        draft_finish(&r->draft);
    return ok;
}

bool renderer_rehearse(struct renderer *r, enum renderer_stage first,
                       struct renderer_draft *how, double ms[RENDERER_STAGES],
                       struct error *err)
{
    struct renderer_stats kept = r->stats;
    if (!renderer_foresee(r, first, ms))
        return error_set(err, "state", "quality.draft_ms",
                         "no draft is to be had of this");
    r->draft.as_if = first;
    r->watch.cut = false;
    struct buf pixels = {0};
    bool ok = make(r, how, err);
    r->draft.shown = r->draft.now;
    ok = ok && renderer_draft_read(r, &pixels, err);
    buf_finish(&pixels);
    r->draft.shown = NULL;
    r->draft.as_if = RENDERER_STAGES;
    memcpy(ms, r->stats.stage_ms, sizeof r->stats.stage_ms);
    r->stats = kept;
    if (!ok && !r->watch.cut)
        draft_finish(&r->draft);
    return ok;
}

// At the draft's size, then enlarged: tone curve and encoding of pixels that
// are interpolated anyway would cost as much as the hair.
bool renderer_draft_read(struct renderer *r, struct buf *out, struct error *err)
{
    struct draft_view *v = r->draft.now = r->draft.shown;
    struct timer *t = &r->timer;
    const int width = r->params.image.width, height = r->params.image.height;
    struct params p = renderer_draft_params(r, v->how.divisor);
    struct buf small = {0};
    float values[512];
    renderer_freshen_tint(r);
    glsl_params_values(&r->params, values);
    gl.NamedBufferSubData(r->shading.params, 0, 16 * params_row_count, values);
    timer_begin(t, RENDERER_DISPLAY, "display");
    lend(&v->picture, &r->picture);
    exchange(r);
    renderer_bind_scene(r, 0);
    picture_bind(&r->picture);
    exchange(r);
    lend(&r->picture, &v->picture);
    lend_display(&v->display, &r->display);
    const struct display_input in = {r->map, 1, &r->lights, &r->camera,
                                     &r->strands};
    bool ok = display_draw(&v->display, &p, &in, err);
    timer_end(t, RENDERER_DISPLAY);
    ok = ok && renderer_wait_for_gpu("display", err);
    lend_display(&r->display, &v->display);
    if (!ok)
        return false;
    const double began = timer_now();
    display_read(&v->display, &small);
    draft_enlarge(small.data, (const int[2]){p.image.width, p.image.height},
                  buf_grow(out, 4 * (size_t)width * (size_t)height),
                  (const int[2]){width, height});
    buf_finish(&small);
    timer_collect(t, r->stats.stage_ms, RENDERER_STAGES);
    r->stats.stage_ms[RENDERER_READ] = 1e3 * (timer_now() - began);
    return true;
}
