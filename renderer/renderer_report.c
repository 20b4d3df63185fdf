// renderer_report.c - what is known about a picture, and what it did without.
#include "renderer/renderer_private.h"

#include <stdio.h>
#include <string.h>

#include "renderer/egl.h"
#include "renderer/program.h"
#include "renderer/program_pool.h"
#include "renderer/warm.h"

static void leave_out(struct renderer_stats *s, const char *what, double bound,
                      const char *why)
{
    struct renderer_left_out *l = &s->left_out[s->left_out_count++];
    l->what = what;
    l->bound = bound;
    snprintf(l->why, sizeof l->why, "%s", why);
}

// The plan of the lights' tables, where they draw.
static const struct lit_plan *plan_of(const struct renderer *r)
{
    const bool used = r->shading.tabled && r->shading.whole && r->shading.lit;
    return used ? lit_tables_plan(r->shading.lit) : NULL;
}

static void list_tables(const struct lit_plan *plan, struct renderer_stats *s)
{
    // as LIT_TABLES_ERROR, of cells so many steps larger
    static const double coarser[LIT_PLAN_COARSER + 1] = {0,    0.1,  0.1, 0.12,
                                                         0.12, 0.15, 0.15};
    char why[96];
    if (plan->rest > 0) {
        snprintf(why, sizeof why,
                 "of %d lights: lobes too narrow for %d, quality.cache_mb "
                 "too small for %d",
                 (int)plan->rest, (int)plan->narrow,
                 (int)(plan->rest - plan->narrow));
        leave_out(s, "light_tables", 0, why);
    }
    if (plan->coarser > 0)
        leave_out(s, "fine_tables", coarser[plan->coarser],
                  "quality.cache_mb has no room for the finest cells of the "
                  "lights' tables");
}

static void leave_out_apart(struct renderer_stats *s,
                            const struct light_groups *g)
{
    char why[96];
    if (g->count == g->lights)
        return;
    snprintf(why, sizeof why,
             "%d lights are %d for what other fibres scatter forward: radians "
             "moved, rms",
             g->lights, g->count);
    leave_out(s, "lights_apart", g->spread, why);
}

static void leave_out_shadows(struct renderer_stats *s,
                              const struct renderer *r)
{
    if (!r->shading.shadowed)
        leave_out(s, "shadows", 0, "shadow.method is off, or nothing shines");
    else if (r->params.shadow.rays == 0)
        leave_out(s, "shadow_rays", 0, "shadow.rays is 0: the smooth field");
    else if (renderer_mapped(r))
        leave_out(s, "shadow_rays", 1,
                  "shadow.method is map, which has no rays: for comparison");
    else if (r->lists_tried && renderer_rays(r) == 0)
        leave_out(s, "shadow_rays", 1,
                  "shadow.memory_mb or the device has no room for the lists "
                  "of near fibres: the smooth field");
}

static void list_left_out(const struct renderer *r, struct renderer_stats *s)
{
    char why[96];
    const int dropped = r->lights.fitted - (r->lights.used - r->lights.suns);
    s->left_out_count = 0;
    if (r->shading.circular)
        leave_out(s, "eccentricity", 0, "fibre.a is 1: a circular fibre");
    if (r->shading.opaque)
        leave_out(s, "tt_trt", r->shading.opaque_bound,
                  "fibre.sigma_a lets no light through");
    if (dropped > 0) {
        snprintf(why, sizeof why,
                 "%d of %d lights hold less of the sky's "
                 "light than quality.light_bound",
                 dropped, r->lights.fitted);
        leave_out(s, "lights", r->lights.dropped_share, why);
    }
    if (r->shading.tabled && r->shading.whole && r->shading.multiple)
        leave_out_apart(s, lit_tables_groups(r->shading.lit));
    leave_out_shadows(s, r);
    if (!r->shading.multiple)
        leave_out(s, "multiple", 0,
                  "render.multiple or shadows are off, or a part is shown that "
                  "has none");
    if (r->shading.refused) {
        snprintf(why, sizeof why, "%s: lit directly", r->shading.refused);
        leave_out(s, "tables", 0, why);
    }
    if (r->shading.tabled)
        leave_out(s, "exact_integrals",
                  r->shading.whole ? LIT_TABLES_ERROR : FAST_TABLES_ERROR,
                  r->shading.whole
                      ? "render.path is table: the largest error measured of a "
                        "place; median .006"
                      : "render.path is table: the largest error measured of a "
                        "sky's sum; median .001 to .025");
    if (plan_of(r))
        list_tables(plan_of(r), s);
    if (!r->strands.opacity && r->strands.plain_colour[3] >= 1)
        leave_out(s, "opacity", 0,
                  "hair.use_opacity is off or the file has none");
    if (!r->strands.draw_wide)
        leave_out(s, "wide_strands", 0,
                  "every strand is thinner than 0.7 pixels");
    else if (!r->strands.draw_thin)
        leave_out(s, "thin_strands", 0,
                  "every strand is wider than 0.7 pixels");
    if (r->params.view.background != 2)
        leave_out(s, "sky_picture", 0, "view.background does not show the sky");
}

// Of the picture that is asked for.
static double strand_pixels(const struct renderer *r)
{
    const struct camera *c = &r->camera;
    double depth = 0;
    for (int k = 0; k < 3; k++)
        depth += (double)((c->target[k] - c->eye[k]) * c->forward[k]);
    return depth > 0
               ? (double)r->strands.diameter_max * 0.5 *
                     r->params.image.height / ((double)c->tan_half * depth)
               : 0;
}

void renderer_stats(const struct renderer *r, struct renderer_stats *out)
{
    static const char *const paths[] = {[RENDERER_DIRECT] = "direct",
                                        [RENDERER_FORWARD] = "forward",
                                        [RENDERER_TABLE] = "table"};
    *out = r->stats;
    out->samples = r->samples;
    out->samples_wanted = r->params.quality.samples;
    out->lights_used = r->lights.used;
    out->lights_fitted = r->lights.fitted;
    out->diameter = r->strands.diameter;
    out->strand_pixels = strand_pixels(r);
    out->up = r->strands.up;
    memcpy(out->eye, r->camera.eye, sizeof out->eye);
    memcpy(out->target, r->camera.target, sizeof out->target);
    out->memory_strands = r->strands.bytes;
    out->memory_targets = r->picture.target_bytes + r->picture.raster.bytes +
                          r->forward.bytes + display_bytes(&r->display);
    out->path = paths[r->shading.tabled ? RENDERER_TABLE : r->path];
    out->memory_cache = r->picture.cache_bytes;
    out->memory_draft = draft_bytes(&r->draft);
    out->memory_tables =
        fast_tables_bytes(r->shading.fast) + lit_tables_bytes(r->shading.lit);
    if (plan_of(r)) {
        out->tables = (int)plan_of(r)->tables;
        out->tables_missing = (int)plan_of(r)->rest;
    }
    out->work = gl_count_since(&r->work_from);
    out->refined = r->refined;
    if (r->shading.shadowed) {
        out->shadow_resolution = r->crossings.stats.resolution;
        out->shadow_directions = r->crossings.stats.ways;
        out->shadow_grid_ms = r->crossings.stats.grid_ms;
        out->shadow_sweep_ms = r->crossings.stats.sweep_ms;
        out->memory_shadow =
            r->crossings.stats.grid_bytes + r->crossings.stats.ways_bytes +
            r->crossings.stats.lists_bytes + r->crossings.stats.map_bytes +
            r->nodes.first.bytes + r->nodes.rest.bytes;
    }
    egl_use(r->egl);
    out->programs_compiled = program_pool_compiled();
    out->programs = program_pool_count();
    out->fit = r->fit;
    if (r->map)
        out->cleaned = r->map->cleaned;
    list_left_out(r, out);
}

void renderer_warm_scene(const struct renderer *r, struct warm_scene *out)
{
    *out = (struct warm_scene){r->params, r->fit, r->map->width, r->map->height,
                               warm_sample(r->groom)};
}

void renderer_programs(const struct renderer *r, struct buf *out)
{
    egl_use(r->egl);
    program_pool_list(out);
}

bool renderer_prepare(struct renderer *r, struct span line, struct error *err)
{
    egl_use(r->egl);
    return program_prepare(line, err);
}
