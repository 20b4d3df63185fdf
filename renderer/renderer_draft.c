// renderer_draft.c - a draft: the first sample of the picture that is asked
// for, with another picture, other strands and where need be another field of
// crossings in the places of the renderer's own, which come back untouched.
// When a draft is worth making, and how coarse, is not decided here.
#include "renderer/renderer_private.h"

#include <string.h>

#include "renderer/egl.h"
#include "renderer/gl.h"
#include "renderer/glsl.h"
#include "renderer/place.h"

// The coarse field: fewer voxels than shadow.resolution has, and a single
// direction a light, along its centre.
enum { FIELD_VOXELS = 32, FIELD_WAYS = 1, CACHE_MB = 16 };

#define SWAP(type, a, b) \
    do { \
        type kept_ = (a); \
        (a) = (b); \
        (b) = kept_; \
    } while (0)

void renderer_draft_mark(struct renderer *r, enum renderer_stage first)
{
    struct draft *d = &r->draft;
    if (first == RENDERER_STRANDS)
        d->shared = d->gridded = false;
    if (first == RENDERER_STRANDS || first == RENDERER_VISIBLE)
        d->seen = false;
    if (first == RENDERER_STRANDS || first == RENDERER_CROSSINGS)
        d->lit = false;
}

bool renderer_forecast(const struct renderer *r, double ms[RENDERER_STAGES])
{
    bool any = false;
    if (!r->groom || !r->map || !r->first_done || r->samples > 0 ||
        r->refined || r->layers.on || r->stale[RENDERER_STRANDS] ||
        r->stale[RENDERER_SKY] || r->params.render.path == RENDERER_FORWARD ||
        renderer_mapped(r))
        return false;
    for (int i = 0; i < RENDERER_STAGES; i++) {
        ms[i] = r->stale[i] ? r->first_ms[i] : -1;
        any |= ms[i] >= 0;
    }
    return any;
}

// --- what a draft is made of -------------------------------------------------

// The strands that stay, and the parameters by which they cover as much.
static struct groom *share_groom(const struct renderer *r, int stride,
                                 struct params *p)
{
    *p = r->params;
    if (!place_diameter_varies(r->groom, p))
        p->hair.diameter = r->strands.diameter * (float)stride;
    return groom_share(r->groom, (uint32_t)stride);
}

static bool share_strands(struct renderer *r, int stride, struct error *err)
{
    struct draft *d = &r->draft;
    if (d->shared && d->how.stride == stride)
        return true;
    d->shared = d->seen = false;
    strands_finish(&d->strands);
    d->how.stride = stride;
    if (stride > 1) {
        struct params p;
        struct groom *g = share_groom(r, stride, &p);
        const bool ok =
            strands_build(&d->strands, g, &p, err) &&
            (!r->strands.axis || strands_build_axis(&d->strands, g, err));
        groom_destroy(g);
        if (!ok)
            return false;
    }
    d->shared = true;
    return true;
}

// The axis was asked for after the strands were made.
static bool share_axis(struct renderer *r, struct error *err)
{
    struct draft *d = &r->draft;
    if (d->how.stride > 1 && r->strands.axis && !d->strands.axis)
        d->shared = false;
    return share_strands(r, d->how.stride, err);
}

static struct params draft_params(const struct renderer *r, int divisor)
{
    struct params p = r->params;
    p.image.width = (p.image.width + divisor - 1) / divisor;
    p.image.height = (p.image.height + divisor - 1) / divisor;
    p.quality.samples = 1;
    p.quality.cache_mb = CACHE_MB;
    p.shadow.rays = 0;
    return p;
}

static bool fit_picture(struct renderer *r, const struct params *p,
                        struct error *err)
{
    struct draft *d = &r->draft;
    struct picture *pic = &d->picture;
    if (d->seen)
        return true;
    d->nodes.first_valid = false;
    // The whole's own: its box, its sides, whatever is left over by rounding.
    camera_resolve(&r->params, r->strands.box_min, r->strands.box_max,
                   &d->camera);
    if (pic->width == p->image.width && pic->height == p->image.height) {
        picture_forget(pic);
        return true;
    }
    return picture_resize(pic, p, err);
}

static bool same_lights(const struct renderer *r)
{
    const struct draft *d = &r->draft;
    return d->lights == r->lights.used &&
           memcmp(d->place, r->lights.place, sizeof d->place) == 0;
}

static bool coarse_field(struct renderer *r, struct error *err)
{
    struct draft *d = &r->draft;
    struct crossings_light light[LIGHTS_MAX];
    const struct crossings_options o = {.resolution = FIELD_VOXELS,
                                        .most = FIELD_WAYS};
    if (!d->crossings.block &&
        !crossings_init_beside(&d->crossings, &r->crossings, err))
        return false;
    if (!d->gridded &&
        !crossings_build_grid(&d->crossings, r->groom, &r->params, &o, err))
        return false;
    d->gridded = true;
    for (int j = 0; j < r->lights.used; j++) {
        const struct lights_place *from = &r->lights.place[j];
        memcpy(light[j].direction, from->direction, sizeof from->direction);
        light[j].lambda = from->lambda;
    }
    return crossings_update(&d->crossings, light, r->lights.used,
                            CROSSINGS_COARSE, err);
}

// The renderer's own field where it is of these lights and this hair.
static bool light_it(struct renderer *r, struct error *err)
{
    struct draft *d = &r->draft;
    const bool coarse = renderer_shadowed(r) && renderer_crossings_due(r);
    if (d->lit && d->coarse == coarse && same_lights(r))
        return true;
    d->lit = false;
    d->coarse = coarse;
    d->nodes.first_valid = false;
    const double began = timer_now();
    if (coarse && !coarse_field(r, err))
        return false;
    if (coarse)
        r->stats.stage_ms[RENDERER_CROSSINGS] = 1e3 * (timer_now() - began);
    d->lights = r->lights.used;
    memcpy(d->place, r->lights.place, sizeof d->place);
    d->lit = true;
    return true;
}

// --- in the renderer's place -------------------------------------------------

// Programs and buffers that do not depend on the picture's size.
static void lend(struct picture *to, struct picture *from)
{
    unsigned *const a[] = {&to->thin,     &to->wide,  &to->solid,
                           &to->cells,    &to->count, &to->add,
                           &to->vertices, &to->quads, &to->scene};
    unsigned *const b[] = {&from->thin,     &from->wide,  &from->solid,
                           &from->cells,    &from->count, &from->add,
                           &from->vertices, &from->quads, &from->scene};
    for (size_t i = 0; i < sizeof a / sizeof a[0]; i++) {
        *a[i] = *b[i];
        *b[i] = 0;
    }
    to->opacity_variant = from->opacity_variant;
}

static void lend_display(struct display *to, struct display *from)
{
    for (size_t i = 0; i < sizeof to->program / sizeof to->program[0]; i++)
        SWAP(unsigned, to->program[i], from->program[i]);
    SWAP(unsigned, to->sky, from->sky);
    SWAP(const void *, to->sky_of, from->sky_of);
}

// Its own inverse.
static void exchange(struct renderer *r)
{
    struct draft *d = &r->draft;
    SWAP(struct picture, r->picture, d->picture);
    SWAP(struct nodes_store, r->nodes.first, d->nodes.first);
    SWAP(struct nodes_store, r->nodes.rest, d->nodes.rest);
    SWAP(bool, r->nodes.first_valid, d->nodes.first_valid);
    SWAP(struct camera, r->camera, d->camera);
    if (d->how.stride > 1)
        SWAP(struct strands, r->strands, d->strands);
    if (d->coarse)
        SWAP(struct crossings, r->crossings, d->crossings);
}

// The draft's only sample, as renderer_sample makes any.
static bool sample(struct renderer *r, struct params *p, struct error *err)
{
    bool stale[RENDERER_STAGES];
    struct draft *d = &r->draft;
    const uint64_t budget = r->nodes_budget;
    if (budget == 0) // by the whole's quality.cache_mb
        r->nodes_budget = ((uint64_t)r->params.quality.cache_mb << 20) / 2;
    memcpy(stale, r->stale, sizeof stale);
    lend(&d->picture, &r->picture);
    exchange(r);
    SWAP(struct params, r->params, *p);
    strands_widths(&r->strands, &r->camera,
                   0.5f * (float)r->picture.height / r->camera.tan_half);
    const bool ok = renderer_sample(r, err);
    SWAP(struct params, r->params, *p);
    exchange(r);
    lend(&r->picture, &d->picture);
    memcpy(r->stale, stale, sizeof stale);
    r->nodes_budget = budget;
    r->samples = 0;
    // Where all strands are drawn they are the renderer's own.
    strands_widths(&r->strands, &r->camera,
                   0.5f * (float)r->params.image.height / r->camera.tan_half);
    return ok;
}

bool renderer_draft(struct renderer *r, struct renderer_draft *how,
                    struct error *err)
{
    static const enum renderer_stage first[] = {RENDERER_LIGHT, RENDERER_TINT,
                                                RENDERER_FIBRE};
    struct draft *d = &r->draft;
    double ms[RENDERER_STAGES];
    if (!renderer_forecast(r, ms))
        return error_set(err, "state", "quality.draft_ms",
                         "no draft is to be had of this");
    egl_use(r->egl);
    d->shown = false;
    for (int i = 0; i < RENDERER_STAGES; i++)
        r->stats.stage_ms[i] = -1;
    for (int i = 0; i < 3; i++)
        if (!renderer_run_setup(r, first[i], err))
            return false;
    d->seen = d->seen && d->how.divisor == how->divisor;
    d->how.divisor = how->divisor;
    struct params p = draft_params(r, how->divisor);
    if (!share_strands(r, how->stride, err) || !share_axis(r, err) ||
        !fit_picture(r, &p, err) || !light_it(r, err) || !sample(r, &p, err)) {
        draft_finish(d);
        return false;
    }
    d->seen = d->shown = true;
    how->coarse = d->coarse;
    return true;
}

// At the draft's size, then enlarged: tone curve and encoding of pixels that
// are interpolated anyway would cost as much as the hair.
bool renderer_draft_read(struct renderer *r, struct buf *out, struct error *err)
{
    struct draft *d = &r->draft;
    struct timer *t = &r->timer;
    const int width = r->params.image.width, height = r->params.image.height;
    struct params p = draft_params(r, d->how.divisor);
    struct buf small = {0};
    float values[512];
    renderer_freshen_tint(r);
    glsl_params_values(&r->params, values);
    gl.NamedBufferSubData(r->shading.params, 0, 16 * params_row_count, values);
    timer_begin(t, RENDERER_DISPLAY, "display");
    lend(&d->picture, &r->picture);
    exchange(r);
    renderer_bind_scene(r, 0);
    picture_bind(&r->picture);
    exchange(r);
    lend(&r->picture, &d->picture);
    lend_display(&d->display, &r->display);
    const struct display_input in = {r->map, 1, r->lights.tint};
    bool ok = display_draw(&d->display, &p, &in, err);
    timer_end(t, RENDERER_DISPLAY);
    ok = ok && renderer_wait_for_gpu("display", err);
    lend_display(&r->display, &d->display);
    if (!ok)
        return false;
    const double began = timer_now();
    display_read(&d->display, &small);
    draft_enlarge(small.data, (const int[2]){p.image.width, p.image.height},
                  buf_grow(out, 4 * (size_t)width * (size_t)height),
                  (const int[2]){width, height});
    buf_finish(&small);
    timer_collect(t, r->stats.stage_ms, RENDERER_STAGES);
    r->stats.stage_ms[RENDERER_READ] = 1e3 * (timer_now() - began);
    return true;
}
