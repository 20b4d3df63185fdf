// renderer.c - runs the stages that a change made stale, in order, and nothing
// else.  What a stage does is in its own room; what the stages read is in the
// table below, and nowhere else.
#include "renderer/renderer.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "renderer/camera.h"
#include "renderer/display.h"
#include "renderer/egl.h"
#include "renderer/gl.h"
#include "renderer/glsl.h"
#include "renderer/lights.h"
#include "renderer/picture.h"
#include "renderer/shading.h"
#include "renderer/strands.h"
#include "renderer/timer.h"

struct renderer {
    struct egl *egl;
    char *cache_dir; // NULL: none
    struct groom *groom;
    struct sky_map *map;
    struct params params;
    struct sky_fit fit;
    struct strands strands;
    struct lights lights;
    struct shading shading;
    struct picture picture;
    struct display display;
    struct camera camera;
    struct timer timer;
    bool stale[RENDERER_STAGES]; // of those that set up
    int samples;                 // in the picture's sum
    uint32_t listed;             // before the last step
    struct renderer_stats stats;
};

typedef bool stage_fn(struct renderer *r, struct error *err);
static stage_fn run_strands, run_sky, run_light, run_fibre, run_visible;

struct stage {
    const char *name;
    stage_fn *run;        // NULL: part of every sample
    uint32_t groups;      // parameter groups read
    uint32_t after;       // stages whose output is read
};

#define BIT(x) (1u << (x))
static const struct stage stages[RENDERER_STAGES] = {
    [RENDERER_STRANDS] = {"strands", run_strands, BIT(GROUP_hair), 0},
    [RENDERER_SKY] = {"sky", run_sky, BIT(GROUP_sky), 0},
    [RENDERER_LIGHT] = {"light", run_light,
                        BIT(GROUP_light) | BIT(GROUP_tint) | BIT(GROUP_quality),
                        BIT(RENDERER_SKY)},
    [RENDERER_FIBRE] = {"fibre", run_fibre,
                        BIT(GROUP_fibre) | BIT(GROUP_render),
                        BIT(RENDERER_STRANDS)},
    [RENDERER_VISIBLE] = {"visible", run_visible,
                          BIT(GROUP_camera) | BIT(GROUP_image) |
                              BIT(GROUP_quality),
                          BIT(RENDERER_STRANDS)},
    [RENDERER_SHADE] = {"shade", NULL, 0,
                        BIT(RENDERER_LIGHT) | BIT(RENDERER_FIBRE) |
                            BIT(RENDERER_VISIBLE)},
    [RENDERER_RESOLVE] = {"resolve", NULL, 0, BIT(RENDERER_SHADE)},
    [RENDERER_DISPLAY] = {"display", NULL, BIT(GROUP_view),
                          BIT(RENDERER_RESOLVE)},
    [RENDERER_READ] = {"read", NULL, 0, BIT(RENDERER_DISPLAY)},
};

const char *const renderer_stage_names[RENDERER_STAGES] = {
    "strands", "sky",     "light",   "fibre", "visible",
    "shade",   "resolve", "display", "read"};

// --- life --------------------------------------------------------------------

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
    timer_init(&r->timer);
    lights_init(&r->lights);
    shading_init(&r->shading);
    display_init(&r->display);
    if (!picture_init(&r->picture, err))
        goto fail;
    for (int i = 0; i < RENDERER_STAGES; i++)
        r->stale[i] = true;
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
        picture_finish(&r->picture);
        display_finish(&r->display);
        shading_finish(&r->shading);
        lights_finish(&r->lights);
        strands_finish(&r->strands);
        timer_finish(&r->timer);
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

// Marks a stage and all that come after it.
static void mark(struct renderer *r, enum renderer_stage first)
{
    uint32_t marked = BIT(first);
    for (int i = (int)first + 1; i < RENDERER_STAGES; i++)
        if (stages[i].after & marked)
            marked |= BIT(i);
    for (int i = 0; i < RENDERER_STAGES; i++)
        if (marked & BIT(i))
            r->stale[i] = true;
    if (marked & BIT(RENDERER_RESOLVE)) {
        r->samples = 0;
        picture_restart(&r->picture);
    }
}

bool renderer_set_groom(struct renderer *r, struct groom *g, struct error *err)
{
    struct strands built = {0};
    egl_use(r->egl);
    if (!strands_build(&built, g, &r->params, err)) {
        groom_destroy(g);
        return false;
    }
    groom_destroy(r->groom);
    r->groom = g;
    strands_finish(&r->strands);
    r->strands = built;
    mark(r, RENDERER_STRANDS);
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
    mark(r, RENDERER_SKY);
    return true;
}

void renderer_set_params(struct renderer *r, const struct params *p)
{
    struct params before = r->params;
    egl_use(r->egl);
    // More samples only continue a picture; fewer begin it anew.
    if (p->quality.samples < r->samples) {
        r->samples = 0;
        picture_restart(&r->picture);
    }
    before.quality.samples = p->quality.samples;
    uint32_t changed = params_changed(&before, p);
    r->params = *p;
    for (int i = 0; i < RENDERER_STAGES; i++)
        if (stages[i].groups & changed)
            mark(r, (enum renderer_stage)i);
}

// --- stages that set up ------------------------------------------------------

static bool run_strands(struct renderer *r, struct error *err)
{
    return strands_build(&r->strands, r->groom, &r->params, err);
}

static bool run_sky(struct renderer *r, struct error *err)
{
    return sky_fit_run(r->map, r->params.sky.lights,
                       (enum sky_fit_mode)r->params.sky.fit, r->cache_dir,
                       &r->fit, err);
}

static bool run_light(struct renderer *r, struct error *err)
{
    (void)err;
    lights_update(&r->lights, &r->fit, &r->params);
    return true;
}

static bool run_fibre(struct renderer *r, struct error *err)
{
    if (shading_wants_axis(&r->params) &&
        !strands_build_axis(&r->strands, r->groom, err))
        return false;
    return shading_update(&r->shading, &r->params, &r->strands, err);
}

static bool run_visible(struct renderer *r, struct error *err)
{
    const struct params *p = &r->params;
    struct picture *pic = &r->picture;
    camera_resolve(p, r->strands.box_min, r->strands.box_max, &r->camera);
    strands_widths(&r->strands, &r->camera,
                   0.5f * (float)p->image.height / r->camera.tan_half);
    bool same = pic->width == p->image.width &&
                pic->height == p->image.height && pic->slots > 0 &&
                pic->cache_mb == p->quality.cache_mb;
    if (!same)
        return picture_resize(pic, p, err);
    picture_forget(pic);
    return true;
}

static bool run_setup(struct renderer *r, struct error *err)
{
    for (int i = 0; i < RENDERER_STAGES; i++) {
        if (!stages[i].run || !r->stale[i])
            continue;
        double began = timer_now(); // set-up works on the CPU and uploads
        if (!stages[i].run(r, err))
            return false;
        r->stats.stage_ms[i] = 1e3 * (timer_now() - began);
        r->stale[i] = false;
    }
    return true;
}

// --- a sample ----------------------------------------------------------------

static void bind_scene(struct renderer *r, int k)
{
    const struct picture_scene scene = {
        .camera = &r->camera,
        .strands = &r->strands,
        .to_map = r->lights.to_map,
        .mask = r->shading.mask,
    };
    picture_scene(&r->picture, &scene, k);
    gl.BindBufferBase(GL_UNIFORM_BUFFER, LIGHTS_BINDING, r->lights.block);
    gl.BindBufferBase(GL_UNIFORM_BUFFER, GLSL_PARAMS_BINDING,
                      r->shading.params);
}

// Waits for the GPU without spinning.
static bool wait_for_gpu(const char *doing, struct error *err)
{
    GLsync fence = gl.FenceSync(GL_SYNC_GPU_COMMANDS_COMPLETE, 0);
    gl.Flush();
    const GLuint64 second = 1000000000;
    GLenum state = GL_TIMEOUT_EXPIRED;
    for (int i = 0; i < 600 && state == GL_TIMEOUT_EXPIRED; i++)
        state = gl.ClientWaitSync(fence, GL_SYNC_FLUSH_COMMANDS_BIT, second);
    gl.DeleteSync(fence);
    if (state == GL_TIMEOUT_EXPIRED)
        return error_set(err, "gpu", doing, "%s: the GPU did not answer for "
                                            "600 s",
                         doing);
    return gl_check(doing, err);
}

static bool run_sample(struct renderer *r, struct error *err)
{
    const int k = r->samples;
    struct timer *t = &r->timer;
    bind_scene(r, k);
    if (picture_must_see(&r->picture, k)) {
        timer_begin(t, RENDERER_VISIBLE, "visible");
        if (!picture_see(&r->picture, &r->strands, k, err))
            return false;
        timer_end(t, RENDERER_VISIBLE);
    }
    timer_begin(t, RENDERER_SHADE, "shade");
    picture_prepare(&r->picture, k);
    shading_bind(&r->shading, &r->strands, k);
    picture_dispatch(&r->picture);
    timer_end(t, RENDERER_SHADE);
    timer_begin(t, RENDERER_RESOLVE, "resolve");
    picture_add(&r->picture);
    timer_end(t, RENDERER_RESOLVE);
    if (!wait_for_gpu("sample", err))
        return false;
    timer_collect(t, r->stats.stage_ms, RENDERER_STAGES);
    r->stats.visible_points = picture_counters(&r->picture);
    r->samples = k + 1;
    r->stale[RENDERER_SHADE] = r->stale[RENDERER_RESOLVE] = false;
    return true;
}

bool renderer_step(struct renderer *r, bool *done, struct error *err)
{
    *done = false;
    egl_use(r->egl);
    if (!r->groom)
        return error_set(err, "state", "hair", "no groom is loaded");
    if (!r->map)
        return error_set(err, "state", "env", "no sky is loaded");
    for (int i = 0; i < RENDERER_STAGES; i++)
        r->stats.stage_ms[i] = -1;
    if (!run_setup(r, err))
        return false;
    if (r->samples < r->params.quality.samples && !run_sample(r, err))
        return false;
    *done = r->samples >= r->params.quality.samples;
    return true;
}

// --- reading -----------------------------------------------------------------

bool renderer_read_display(struct renderer *r, struct buf *out,
                           struct error *err)
{
    struct timer *t = &r->timer;
    buf_clear(out);
    egl_use(r->egl);
    if (r->samples == 0)
        return error_set(err, "state", "image", "nothing is rendered yet");
    // The parameter block may be older than view.*, which it also holds.
    float values[512];
    glsl_params_values(&r->params, values);
    gl.NamedBufferSubData(r->shading.params, 0, 16 * params_row_count, values);
    bind_scene(r, r->samples - 1);
    timer_begin(t, RENDERER_DISPLAY, "display");
    picture_bind(&r->picture);
    if (!display_draw(&r->display, &r->params, r->map, r->samples, err))
        return false;
    timer_end(t, RENDERER_DISPLAY);
    if (!wait_for_gpu("display", err))
        return false;
    double began = timer_now();
    display_read(&r->display, out);
    timer_collect(t, r->stats.stage_ms, RENDERER_STAGES);
    r->stats.stage_ms[RENDERER_READ] = 1e3 * (timer_now() - began);
    r->stale[RENDERER_DISPLAY] = r->stale[RENDERER_READ] = false;
    return true;
}

bool renderer_read_linear(struct renderer *r, struct buf *out,
                          struct error *err)
{
    buf_clear(out);
    egl_use(r->egl);
    if (r->samples == 0)
        return error_set(err, "state", "image", "nothing is rendered yet");
    const size_t n = (size_t)r->picture.width * (size_t)r->picture.height;
    picture_read_sum(&r->picture, (float *)(void *)buf_grow(out, 16 * n),
                     r->samples);
    return gl_check("read-back", err);
}

// --- what is known about it --------------------------------------------------

static void leave_out(struct renderer_stats *s, const char *what, double bound,
                      const char *why)
{
    struct renderer_left_out *l = &s->left_out[s->left_out_count++];
    l->what = what;
    l->bound = bound;
    snprintf(l->why, sizeof l->why, "%s", why);
}

static void list_left_out(const struct renderer *r, struct renderer_stats *s)
{
    char why[96];
    s->left_out_count = 0;
    if (r->shading.circular)
        leave_out(s, "eccentricity", 0, "fibre.a is 1: a circular fibre");
    if (r->shading.opaque)
        leave_out(s, "tt_trt", r->shading.opaque_bound,
                  "fibre.sigma_a lets no light through");
    if (r->lights.used < r->lights.fitted) {
        snprintf(why, sizeof why, "%d of %d lights hold less of the sky's "
                                  "light than quality.light_bound",
                 r->lights.fitted - r->lights.used, r->lights.fitted);
        leave_out(s, "lights", r->lights.dropped_share, why);
    }
    if (!r->strands.opacity && r->strands.plain_colour[3] >= 1)
        leave_out(s, "opacity", 0, "hair.use_opacity is off or the file has "
                                   "none");
    if (!r->strands.draw_wide)
        leave_out(s, "wide_strands", 0, "every strand is thinner than 0.7 "
                                        "pixels");
    else if (!r->strands.draw_thin)
        leave_out(s, "thin_strands", 0, "every strand is wider than 0.7 "
                                        "pixels");
    if (r->params.view.background != 2)
        leave_out(s, "sky_picture", 0, "view.background does not show the sky");
}

void renderer_stats(const struct renderer *r, struct renderer_stats *out)
{
    *out = r->stats;
    out->samples = r->samples;
    out->samples_wanted = r->params.quality.samples;
    out->lights_used = r->lights.used;
    out->lights_fitted = r->lights.fitted;
    out->diameter = r->strands.diameter;
    out->up = r->strands.up;
    memcpy(out->eye, r->camera.eye, sizeof out->eye);
    memcpy(out->target, r->camera.target, sizeof out->target);
    out->memory_strands = r->strands.bytes;
    out->memory_targets = r->picture.target_bytes;
    out->memory_cache = r->picture.cache_bytes;
    out->fit = r->fit;
    if (r->map)
        out->cleaned = r->map->cleaned;
    list_left_out(r, out);
}
