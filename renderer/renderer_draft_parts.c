// renderer_draft_parts.c - what a draft is made of: strands, shading, lights, a
// coarse field of crossings, cells.  Each is kept until what it depends on
// changes; what is there already is taken as it is.
#include "renderer/renderer_private.h"

#include <math.h>
#include <string.h>

#include "renderer/place.h"

// The coarse field: fewer voxels than shadow.resolution has, and a single
// direction a light, along its centre.
enum { FIELD_VOXELS = 32, FIELD_WAYS = 1, CACHE_MB = 16 };

void renderer_draft_mark(struct renderer *r, enum renderer_stage first)
{
    struct draft *d = &r->draft;
    const bool hair = first == RENDERER_STRANDS;
    if (hair)
        d->stride = d->gridded = 0;
    if (first == RENDERER_FIBRE)
        d->shading = false;
    for (int i = 0; i < RENDERER_DRAFT_VIEWS; i++) {
        struct draft_view *v = &d->view[i];
        if (hair || first == RENDERER_VISIBLE)
            v->seen = false;
        if (hair || first == RENDERER_CROSSINGS)
            v->lit.known = false;
    }
}

void renderer_draft_fitted(struct renderer *r, const struct sky_fit *fit)
{
    struct sky_fit *most = &r->draft.fit;
    if (!fit)
        most->count = 0;
    else if (fit->count >= most->count)
        *most = *fit;
}

struct params renderer_draft_params(const struct renderer *r, int divisor)
{
    struct params p = r->params;
    p.image.width = (p.image.width + divisor - 1) / divisor;
    p.image.height = (p.image.height + divisor - 1) / divisor;
    p.quality.samples = 1;
    p.quality.cache_mb = CACHE_MB;
    p.shadow.rays = 0;
    return p;
}

// --- strands -----------------------------------------------------------------

static bool hair_moves(const struct renderer *r)
{
    return r->stale[RENDERER_STRANDS] || r->draft.as_if == RENDERER_STRANDS;
}

bool renderer_draft_owns_strands(const struct renderer *r)
{
    return r->draft.now->how.stride > 1 || hair_moves(r);
}

static const struct strands *strands_of(const struct renderer *r)
{
    return renderer_draft_owns_strands(r) ? &r->draft.strands : &r->strands;
}

// The strands that stay, and the parameters by which they cover as much.
static struct groom *share_groom(const struct renderer *r, int stride,
                                 struct params *p)
{
    *p = r->params;
    if (!place_diameter_varies(r->groom, p))
        p->hair.diameter = place_diameter(r->groom, p, 0) * (float)stride;
    return groom_share(r->groom, (uint32_t)stride);
}

// The box of all strands, so that the eye stands where it will: points are
// placed axis by axis without rounding between, so are their bounds.
static void whole_box(struct strands *s, const struct groom *g,
                      const struct params *p)
{
    float a[3], b[3];
    place_axes(place_up(g, p), g->box_min, a);
    place_axes(place_up(g, p), g->box_max, b);
    for (int k = 0; k < 3; k++) {
        const float x = p->hair.scale * a[k], y = p->hair.scale * b[k];
        s->box_min[k] = fminf(s->box_min[k], fminf(x, y));
        s->box_max[k] = fmaxf(s->box_max[k], fmaxf(x, y));
    }
}

static bool share_strands(struct renderer *r, struct error *err)
{
    struct draft *d = &r->draft;
    const int stride = d->now->how.stride;
    const bool axis = shading_wants_axis(&r->params);
    if (!renderer_draft_owns_strands(r) ||
        (d->stride == stride && (d->strands.axis || !axis)))
        return true;
    const double began = timer_now();
    struct params p;
    struct groom *g = share_groom(r, stride, &p);
    d->stride = 0;
    for (int i = 0; i < RENDERER_DRAFT_VIEWS; i++)
        if (d->view[i].how.stride > 1 || hair_moves(r))
            d->view[i].seen = false;
    const bool ok = strands_build(&d->strands, g, &p, err) &&
                    (!axis || strands_build_axis(&d->strands, g, err));
    whole_box(&d->strands, g, &p);
    groom_destroy(g);
    if (!ok)
        return false;
    d->stride = stride;
    r->stats.stage_ms[RENDERER_STRANDS] = 1e3 * (timer_now() - began);
    return true;
}

// --- shading and light -------------------------------------------------------

// Hair that moves leaves the fibre as it is.
static bool shade_it(struct renderer *r)
{
    const struct draft *d = &r->draft;
    const struct strands *s = strands_of(r);
    if (d->shading && d->coloured == (s->colour != 0) &&
        r->shading.shadowed == renderer_shadowed(r))
        return true;
    const double began = timer_now();
    renderer_shade_by(r, s, true);
    r->stats.stage_ms[RENDERER_FIBRE] = 1e3 * (timer_now() - began);
    return true;
}

// Lights stay stale where it is another fit that they should come from.
static bool put_lights(struct renderer *r, struct error *err)
{
    struct draft *d = &r->draft;
    d->now->how.fitted = r->stale[RENDERER_SKY];
    if (!r->stale[RENDERER_SKY])
        return renderer_run_setup(r, RENDERER_LIGHT, err) &&
               renderer_run_setup(r, RENDERER_TINT, err);
    struct sky_fit fewer;
    sky_fit_fewer(&d->fit, r->params.sky.lights, &fewer);
    const double began = timer_now();
    renderer_light_by(r, &fewer);
    r->stats.stage_ms[RENDERER_LIGHT] = 1e3 * (timer_now() - began);
    return true;
}

// --- crossings ---------------------------------------------------------------

static bool field_due(const struct renderer *r)
{
    return renderer_shadowed(r) &&
           (renderer_crossings_due(r) || hair_moves(r) ||
            r->draft.as_if == RENDERER_CROSSINGS);
}

// Of all strands where they rest, for a turn of the sky; of those that are
// drawn while the hair itself is dragged.
static bool grid(struct renderer *r, struct error *err)
{
    struct draft *d = &r->draft;
    const struct crossings_options o = {.resolution = FIELD_VOXELS,
                                        .most = FIELD_WAYS};
    const int stride = hair_moves(r) ? d->now->how.stride : 1;
    if (!d->crossings.block &&
        !crossings_init_beside(&d->crossings, &r->crossings, err))
        return false;
    d->crossings.watch = &r->watch;
    if (d->gridded == stride ||
        (d->gridded > 0 && stride == 1 && d->as_if == RENDERER_STAGES))
        return true; // those of a part do, while the hand moves
    d->gridded = 0;
    d->swept.known = false;
    struct params p = r->params;
    struct groom *g = stride > 1 ? share_groom(r, stride, &p) : NULL;
    const bool ok =
        crossings_build_grid(&d->crossings, g ? g : r->groom, &p, &o, err);
    groom_destroy(g);
    if (ok)
        d->gridded = stride;
    return ok;
}

static bool coarse_field(struct renderer *r, struct error *err)
{
    struct draft *d = &r->draft;
    struct crossings_light light[LIGHTS_MAX];
    const double began = timer_now();
    if (!grid(r, err))
        return false;
    if (draft_lights_same(&d->swept, &r->lights))
        return true;
    d->swept.known = false;
    const int count = renderer_crossings_lights(r, light);
    if (!crossings_update(&d->crossings, light, count, CROSSINGS_COARSE, err))
        return false;
    draft_lights_note(&d->swept, &r->lights);
    r->stats.stage_ms[RENDERER_CROSSINGS] = 1e3 * (timer_now() - began);
    for (int i = 0; i < RENDERER_DRAFT_VIEWS; i++)
        if (d->view[i].how.coarse)
            d->view[i].lit.known = false;
    return true;
}

// The renderer's own field where it is of these lights and this hair.
static bool light_it(struct renderer *r, struct error *err)
{
    struct draft_view *v = r->draft.now;
    const bool coarse = field_due(r);
    if (coarse && !coarse_field(r, err))
        return false;
    if (v->lit.known && v->how.coarse == coarse &&
        draft_lights_same(&v->lit, &r->lights))
        return true;
    v->nodes.first_valid = false;
    v->how.coarse = coarse;
    draft_lights_note(&v->lit, &r->lights);
    return true;
}

// --- what is seen ------------------------------------------------------------

static bool fit_picture(struct renderer *r, struct error *err)
{
    struct draft_view *v = r->draft.now;
    struct picture *pic = &v->picture;
    const struct strands *s = strands_of(r);
    const struct params p = renderer_draft_params(r, v->how.divisor);
    if (v->seen)
        return true;
    v->nodes.first_valid = false;
    // The whole's own: its box, its sides, whatever is left over by rounding.
    camera_resolve(&r->params, s->box_min, s->box_max, &v->camera);
    if (pic->width == p.image.width && pic->height == p.image.height) {
        picture_forget(pic);
        return true;
    }
    return picture_resize(pic, &p, err);
}

bool renderer_draft_parts(struct renderer *r, struct error *err)
{
    return put_lights(r, err) && share_strands(r, err) && shade_it(r) &&
           fit_picture(r, err) && light_it(r, err);
}
