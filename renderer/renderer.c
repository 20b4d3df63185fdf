// renderer.c - runs the stages that a change made stale, in order, and nothing
// else.  What a stage does is in its own room; what the stages read is in the
// table below, and nowhere else.
#include "renderer/renderer.h"

#include <stdlib.h>
#include <string.h>

#include "protocol/edit.h"
#include "renderer/crew.h"
#include "renderer/egl.h"
#include "renderer/gl.h"
#include "renderer/program.h"
#include "renderer/renderer_private.h"

struct stage {
    const char *name;
    renderer_setup_fn *run; // NULL: part of every sample
    uint32_t groups;        // parameter groups read
    uint32_t after;         // stages whose output is read
};
// Besides: where the tint is not a factor of the whole (renderer_tint_apart),
// `shade` reads it.

#define BIT(x) (1u << (x))
#define SUNS (BIT(GROUP_sun1) | BIT(GROUP_sun2) | BIT(GROUP_sun3))
static const struct stage stages[RENDERER_STAGES] = {
    [RENDERER_STRANDS] = {"strands", renderer_setup_strands, BIT(GROUP_hair),
                          0},
    [RENDERER_SKY] = {"sky", renderer_setup_sky, BIT(GROUP_sky), 0},
    [RENDERER_LIGHT] = {"light", renderer_setup_light,
                        BIT(GROUP_light) | BIT(GROUP_quality) | SUNS,
                        BIT(RENDERER_SKY)},
    [RENDERER_TINT] = {"tint", renderer_setup_tint, BIT(GROUP_tint) | SUNS,
                       BIT(RENDERER_LIGHT)},
    [RENDERER_CROSSINGS] = {"crossings", renderer_setup_crossings,
                            BIT(GROUP_shadow),
                            BIT(RENDERER_STRANDS) | BIT(RENDERER_LIGHT)},
    [RENDERER_FIBRE] = {"fibre", renderer_setup_fibre,
                        BIT(GROUP_fibre) | BIT(GROUP_render) |
                            BIT(GROUP_shadow),
                        BIT(RENDERER_STRANDS)},
    [RENDERER_VISIBLE] = {"visible", renderer_setup_visible,
                          BIT(GROUP_camera) | BIT(GROUP_image) |
                              BIT(GROUP_quality),
                          BIT(RENDERER_STRANDS)},
    [RENDERER_SHADOW] = {"shadow", NULL, 0,
                         BIT(RENDERER_CROSSINGS) | BIT(RENDERER_VISIBLE)},
    [RENDERER_SHADE] = {"shade", NULL, 0,
                        BIT(RENDERER_LIGHT) | BIT(RENDERER_FIBRE) |
                            BIT(RENDERER_SHADOW)},
    [RENDERER_RESOLVE] = {"resolve", NULL, 0, BIT(RENDERER_SHADE)},
    [RENDERER_DISPLAY] = {"display", NULL, BIT(GROUP_view),
                          BIT(RENDERER_TINT) | BIT(RENDERER_RESOLVE)},
    [RENDERER_READ] = {"read", NULL, 0, BIT(RENDERER_DISPLAY)},
};

const char *const renderer_stage_names[RENDERER_STAGES] = {
    "strands", "sky",    "light", "tint",    "crossings", "fibre",
    "visible", "shadow", "shade", "resolve", "display",   "read"};

// --- life --------------------------------------------------------------------

static void forget_first(struct renderer *r)
{
    for (int f = 0; f < 2; f++) {
        r->first[f].width = 0;
        for (int i = 0; i < RENDERER_STAGES; i++)
            r->first[f].ms[i] = -1;
    }
}

struct renderer *renderer_create(const char *cache_dir, struct error *err)
{
    struct renderer *r = bytes_zalloc(1, sizeof *r);
    params_defaults(&r->params);
    r->egl = egl_create(err);
    if (!r->egl)
        goto fail;
    if (cache_dir) {
        size_t n = strlen(cache_dir) + 1;
        r->cache_dir = memcpy(bytes_alloc(n), cache_dir, n);
    }
    crew_start();
    timer_init(&r->timer);
    lights_init(&r->lights);
    shading_init(&r->shading);
    display_init(&r->display);
    if (!picture_init(&r->picture, err) || !crossings_init(&r->crossings, err))
        goto fail;
    r->crossings.watch = r->picture.watch = &r->watch;
    for (int i = 0; i < RENDERER_STAGES; i++)
        r->stale[i] = true;
    r->draft.as_if = RENDERER_STAGES;
    forget_first(r);
    return r;
fail:
    renderer_destroy(r);
    return NULL;
}

void renderer_destroy(struct renderer *r)
{
    if (!r)
        return;
    if (r->egl) {
        egl_use(r->egl);
        layers_drop(&r->layers);
        draft_finish(&r->draft);
        picture_finish(&r->picture);
        forward_finish(&r->forward);
        display_finish(&r->display);
        shading_finish(&r->shading);
        crossings_finish(&r->crossings);
        lights_finish(&r->lights);
        nodes_finish(&r->nodes);
        strands_finish(&r->strands);
        timer_finish(&r->timer);
        program_drop(r->places);
        egl_destroy(r->egl);
    }
    groom_destroy(r->groom);
    sky_map_destroy(r->map);
    free(r->cache_dir);
    free(r);
}

const char *renderer_device(const struct renderer *r)
{
    return egl_device(r->egl);
}

// --- what is stale -----------------------------------------------------------

// The next sample is the picture's first.  Where the list of cells has to be
// made anew its order is another, and what was kept by it is lost.
static void restart(struct renderer *r, bool refined)
{
    if (r->picture.flushed)
        r->nodes.first_valid = false;
    picture_restart(&r->picture);
    r->samples = 0;
    r->refined = refined;
    r->draft.shown = NULL;
}

uint32_t renderer_after(const struct renderer *r, enum renderer_stage first)
{
    uint32_t marked = BIT(first);
    if (first == RENDERER_TINT && !renderer_tint_apart(&r->params))
        marked |= BIT(RENDERER_SHADE);
    for (int i = (int)first + 1; i < RENDERER_STAGES; i++)
        if (stages[i].after & marked)
            marked |= BIT(i);
    return marked;
}

// Marks a stage and all that come after it.
void renderer_mark(struct renderer *r, enum renderer_stage first)
{
    const uint32_t marked = renderer_after(r, first);
    for (int i = 0; i < RENDERER_STAGES; i++)
        if (marked & BIT(i))
            r->stale[i] = true;
    // lights may turn out to stand where they stood: renderer_setup_light
    if ((marked & BIT(RENDERER_SHADOW)) && first != RENDERER_LIGHT)
        shading_forget(&r->shading);
    if (marked & BIT(RENDERER_RESOLVE))
        restart(r, false);
    renderer_draft_mark(r, first);
}

bool renderer_set_groom(struct renderer *r, struct groom *g, struct error *err)
{
    struct strands built = {0};
    egl_use(r->egl);
    const double began = timer_now();
    if (!strands_build(&built, g, &r->params, err)) {
        groom_destroy(g);
        return false;
    }
    groom_destroy(r->groom);
    r->groom = g;
    strands_finish(&r->strands);
    r->strands = built;
    r->strands.watch = &r->watch; // from now on
    r->grid_stale = true;
    forget_first(r);
    r->first[0].ms[RENDERER_STRANDS] = 1e3 * (timer_now() - began);
    renderer_mark(r, RENDERER_STRANDS);
    r->stale[RENDERER_STRANDS] = false; // its work is done; what follows is not
    return true;
}

bool renderer_set_sky(struct renderer *r, struct sky_map *m, struct error *err)
{
    (void)err;
    egl_use(r->egl);
    sky_map_destroy(r->map);
    r->map = m;
    display_forget_sky(&r->display);
    renderer_draft_fitted(r, NULL);
    renderer_mark(r, RENDERER_SKY);
    return true;
}

bool renderer_set_params(struct renderer *r, const struct params *p)
{
    struct params before = r->params;
    const bool had = r->samples > 0 || r->draft.shown;
    egl_use(r->egl);
    // More samples only continue a picture; fewer begin it anew.
    if (p->quality.samples < r->samples)
        renderer_mark(r, RENDERER_SHADE);
    before.quality.samples = p->quality.samples;
    before.quality.error_places = p->quality.error_places; // no pixel's affair
    before.quality.draft_ms = p->quality.draft_ms;
    before.quality.budget_ms = p->quality.budget_ms; // who sets them resolves
    before.quality.error = p->quality.error;         // them
    uint32_t changed = params_changed(&before, p);
    r->params = *p;
    for (int i = 0; changed != 0 && i < RENDERER_STAGES; i++)
        r->stats.stage_ms[i] = -1; // of another state
    for (int i = 0; i < RENDERER_STAGES; i++)
        if (stages[i].groups & changed)
            renderer_mark(r, (enum renderer_stage)i);
    if (renderer_tint_apart(&before) != renderer_tint_apart(p))
        renderer_mark(r, RENDERER_TINT);
    return had && r->samples == 0 && !r->draft.shown;
}

// Who has samples, or a draft, has lights too.
void renderer_freshen_tint(struct renderer *r)
{
    if (r->stale[RENDERER_LIGHT])
        return;
    renderer_run_setup(r, RENDERER_TINT, NULL); // does not fail
}

bool renderer_layers_on(struct renderer *r, struct error *err)
{
    const char *name = "render.components";
    const struct span word = edit_choice(params_find(name, strlen(name)),
                                         r->params.render.components);
    if (r->params.render.components != 0)
        return error_set(err, "state", name,
                         "layers: %s is %.*s; only of all are there parts",
                         name, (int)word.size, (const char *)word.data);
    if (r->params.render.path == RENDERER_FORWARD)
        return error_set(err, "state", "render.path",
                         "layers: render.path is forward; only direct shading "
                         "makes parts beside the whole");
    egl_use(r->egl);
    r->layers.on = true;
    restart(r, r->refined);
    return true;
}

bool renderer_layers_off(struct renderer *r)
{
    const bool again = r->layers.on && r->shading.tabled;
    egl_use(r->egl);
    if (again)
        restart(r, r->refined);
    layers_drop(&r->layers);
    return again;
}

// --- a step ------------------------------------------------------------------

bool renderer_run_setup(struct renderer *r, enum renderer_stage i,
                        struct error *err)
{
    if (!stages[i].run || !r->stale[i])
        return true;
    double began = timer_now(); // set-up works on the CPU and uploads
    r->idle = false;
    if (!stages[i].run(r, err))
        return false;
    if (!r->idle)
        r->stats.stage_ms[i] = 1e3 * (timer_now() - began);
    r->stale[i] = false;
    return true;
}

static bool run_setup(struct renderer *r, struct error *err)
{
    for (int i = 0; i < RENDERER_STAGES; i++)
        if (!renderer_run_setup(r, (enum renderer_stage)i, err))
            return false;
    return true;
}

static const struct renderer_first *first_of_size(const struct renderer *r)
{
    for (int i = 0; i < 2; i++)
        if (r->first[i].width == r->params.image.width &&
            r->first[i].height == r->params.image.height)
            return &r->first[i];
    return NULL;
}

const struct renderer_first *renderer_first_of(const struct renderer *r)
{
    const struct renderer_first *f = first_of_size(r);
    return f ? f : r->first[0].width > 0 ? &r->first[0] : NULL;
}

// What a first sample takes, stage by stage (renderer_forecast); a capture of
// another size does not disturb what is known of this one.
static void remember_first(struct renderer *r)
{
    if (r->samples != 1 || r->refined || r->layers.on)
        return;
    const struct renderer_first *same = first_of_size(r);
    struct renderer_first f = same ? *same : r->first[0];
    f.width = r->params.image.width;
    f.height = r->params.image.height;
    for (int i = 0; i < RENDERER_STAGES; i++)
        if (r->stats.stage_ms[i] >= 0)
            f.ms[i] = r->stats.stage_ms[i];
    if (same != &r->first[0])
        r->first[1] = r->first[0];
    r->first[0] = f;
}

void renderer_watch(struct renderer *r, bool (*newer)(void *ctx), void *ctx)
{
    r->watch.newer = newer;
    r->watch.ctx = ctx;
    r->watch.cut = false;
}

bool renderer_was_cut(const struct renderer *r)
{
    return r->watch.cut;
}

bool renderer_step(struct renderer *r, bool *done, struct error *err)
{
    *done = false;
    r->watch.cut = false;
    r->work_from = gl_count_now();
    egl_use(r->egl);
    if (!r->groom)
        return error_set(err, "state", "hair", "no groom is loaded");
    if (!r->map)
        return error_set(err, "state", "env", "no sky is loaded");
    for (int i = 0; i < RENDERER_STAGES; i++)
        r->stats.stage_ms[i] = -1;
    if (!run_setup(r, err))
        return r->watch.cut;
    const bool refine = renderer_rays(r) > 0;
    const int samples = r->samples;
    const bool refined = r->refined;
    if (refine && !r->refined && r->samples > 0)
        restart(r, true); // the smooth picture was shown; now the real one
    if (r->samples < r->params.quality.samples && !renderer_sample(r, err)) {
        if (r->watch.cut) { // nothing of it is in the sum
            r->samples = samples;
            r->refined = refined;
            timer_collect(&r->timer, r->stats.stage_ms, RENDERER_STAGES);
            return true;
        }
        renderer_mark(r, RENDERER_VISIBLE); // half a sample may be in the sum
        return false;
    }
    remember_first(r);
    *done = r->samples >= r->params.quality.samples && (!refine || r->refined);
    return true;
}
