// renderer_setup.c - the stages that prepare what samples read.
#include "renderer/renderer_private.h"

#include <string.h>

#include "renderer/gl.h"

bool renderer_setup_strands(struct renderer *r, struct error *err)
{
    struct strands built = {.watch = &r->watch};
    r->grid_stale = true;
    if (!strands_build(&built, r->groom, &r->params, err))
        return false;
    strands_finish(&r->strands);
    r->strands = built;
    return true;
}

bool renderer_setup_sky(struct renderer *r, struct error *err)
{
    const struct sky_fit_job job = {
        .map = r->map,
        .lights = r->params.sky.lights,
        .mode = (enum sky_fit_mode)r->params.sky.fit,
        .cache_dir = r->cache_dir,
        .watch = &r->watch,
    };
    struct sky_fit fit;
    if (!sky_fit_do(&job, &fit, err))
        return false;
    r->fit = fit;
    renderer_draft_fitted(r, &r->fit);
    return true;
}

bool renderer_setup_light(struct renderer *r, struct error *err)
{
    (void)err;
    r->idle = !lights_put(&r->lights, &r->fit, &r->params);
    r->directions_stale |= !r->idle;
    if (!r->idle)
        shading_forget(&r->shading);
    // the first light brings shadows, the last one takes them away
    r->stale[RENDERER_FIBRE] |= r->shading.shadowed != renderer_shadowed(r);
    return true;
}

bool renderer_setup_tint(struct renderer *r, struct error *err)
{
    (void)err;
    lights_tint(&r->lights, &r->fit, &r->params,
                renderer_tint_apart(&r->params));
    return true;
}

bool renderer_tint_apart(const struct params *p)
{
    struct lights_sun sun[LIGHTS_SUNS];
    return lights_suns(p, sun) == 0 && shading_adds_up(p);
}

void renderer_light_by(struct renderer *r, struct sky_fit *fit)
{
    const bool moved = lights_put(&r->lights, fit, &r->params);
    r->directions_stale |= moved;
    r->stale[RENDERER_FIBRE] |= r->shading.shadowed != renderer_shadowed(r);
    lights_tint(&r->lights, fit, &r->params, renderer_tint_apart(&r->params));
}

bool renderer_shadowed(const struct renderer *r)
{
    return r->params.shadow.method != 0 && r->lights.used > 0;
}

bool renderer_mapped(const struct renderer *r)
{
    return r->params.shadow.method == 2;
}

int renderer_rays(const struct renderer *r)
{
    return renderer_shadowed(r) && crossings_has_lists(&r->crossings)
               ? r->params.shadow.rays
               : 0;
}

static bool build_grid(struct renderer *r, struct error *err)
{
    const struct params *p = &r->params;
    const struct crossings_options o = {
        .resolution = p->shadow.resolution,
        .budget = (uint64_t)p->shadow.memory_mb << 20,
        .map = renderer_mapped(r) ? &r->strands : NULL,
    };
    r->grid_stale = true; // until there is one again
    if (!crossings_build_grid(&r->crossings, r->groom, p, &o, err))
        return false;
    r->grid_resolution = p->shadow.resolution;
    r->grid_memory_mb = p->shadow.memory_mb;
    r->grid_method = p->shadow.method;
    r->lists_tried = false;
    r->grid_stale = false;
    r->directions_stale = true;
    return true;
}

int renderer_crossings_lights(const struct renderer *r,
                              struct crossings_light out[LIGHTS_MAX])
{
    for (int j = 0; j < r->lights.used; j++) {
        const struct lights_place *from = &r->lights.place[j];
        memcpy(out[j].direction, from->direction, sizeof from->direction);
        out[j].lambda = from->lambda;
        out[j].dim = from->dim;
    }
    return r->lights.used;
}

static bool update_directions(struct renderer *r, struct error *err)
{
    struct crossings_light light[LIGHTS_MAX];
    const int count = renderer_crossings_lights(r, light);
    r->directions_quality = r->params.shadow.directions;
    if (!crossings_update(&r->crossings, light, count,
                          (enum crossings_quality)r->directions_quality, err))
        return false;
    r->directions_stale = false;
    r->nodes.first_valid = false;
    return true;
}

// Where they have no room the smooth field is final (renderer_rays), and the
// report says so.
static bool build_lists(struct renderer *r, struct error *err)
{
    struct error why = {0};
    r->lists_tried =
        crossings_build_lists(&r->crossings, r->groom, &r->params, &why) ||
        strcmp(why.code, "limit") == 0;
    if (!r->lists_tried && err)
        *err = why;
    return r->lists_tried;
}

static bool grid_due(const struct renderer *r)
{
    const struct params *p = &r->params;
    return r->grid_stale || r->grid_resolution != p->shadow.resolution ||
           r->grid_memory_mb != p->shadow.memory_mb ||
           r->grid_method != p->shadow.method;
}

bool renderer_crossings_due(const struct renderer *r)
{
    return r->stale[RENDERER_STRANDS] || grid_due(r) || r->directions_stale ||
           r->directions_quality != r->params.shadow.directions;
}

// Only what is not so already: a grid for this hair, directions for these
// lights, lists for rays.
bool renderer_setup_crossings(struct renderer *r, struct error *err)
{
    const struct params *p = &r->params;
    r->idle = true;
    if (!renderer_shadowed(r))
        return true;
    if (grid_due(r)) {
        r->idle = false;
        if (!build_grid(r, err))
            return false;
    }
    if (renderer_crossings_due(r)) {
        r->idle = false;
        if (!update_directions(r, err))
            return false;
    }
    if (p->shadow.rays > 0 && !renderer_mapped(r) && !r->lists_tried) {
        r->idle = false;
        return build_lists(r, err);
    }
    return true;
}

// Ways of drawing share lists and maps, but not what is in them.
static void choose_path(struct renderer *r)
{
    const bool forward = r->params.render.path == RENDERER_FORWARD;
    const int path = forward ? RENDERER_FORWARD : RENDERER_DIRECT;
    if (r->path == path) // tables light the cells of direct shading
        return;
    r->path = path;
    r->nodes.first_valid = false;
    if (r->picture.width > 0)
        picture_forget(&r->picture);
    forward_drop(&r->forward);
    if (forward)
        raster_drop(&r->picture.raster);
}

void renderer_shade_by(struct renderer *r, const struct strands *s, bool draft)
{
    struct params p = r->params;
    if (draft && r->shading.tables) // others take up to half a second
        p.render.tables = r->shading.tables->times;
    choose_path(r);
    shading_update(&r->shading, &p, s, renderer_shadowed(r));
    r->draft.shading = true;
    r->draft.coloured = s->colour != 0;
}

bool renderer_setup_fibre(struct renderer *r, struct error *err)
{
    if (shading_wants_axis(&r->params) &&
        !strands_build_axis(&r->strands, r->groom, err))
        return false;
    renderer_shade_by(r, &r->strands, false);
    return true;
}

bool renderer_setup_visible(struct renderer *r, struct error *err)
{
    const struct params *p = &r->params;
    struct picture *pic = &r->picture;
    r->nodes.first_valid = false;
    forward_forget(&r->forward);
    camera_resolve(p, r->strands.box_min, r->strands.box_max, &r->camera);
    strands_widths(&r->strands, &r->camera,
                   0.5f * (float)p->image.height / r->camera.tan_half);
    bool same = pic->width == p->image.width &&
                pic->height == p->image.height && pic->slots > 0 &&
                pic->cache_mb == p->quality.cache_mb;
    if (!same) {
        forward_drop(&r->forward);
        return picture_resize(pic, p, err);
    }
    picture_forget(pic);
    return true;
}
