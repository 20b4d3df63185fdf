// renderer_sample.c - one sample of the picture, and reading what is summed.
#include "renderer/renderer_private.h"

#include <math.h>
#include <string.h>

#include "renderer/gl.h"
#include "renderer/egl.h"
#include "renderer/glsl.h"

void renderer_bind_scene(struct renderer *r, int k)
{
    const struct picture_scene scene = {
        .camera = &r->camera,
        .strands = &r->strands,
        .to_map = r->lights.to_map,
        .mask = r->shading.mask,
        .share = r->shading.share,
    };
    picture_scene(&r->picture, &scene, k);
    gl.BindBufferBase(GL_UNIFORM_BUFFER, LIGHTS_BINDING, r->lights.block);
    gl.BindBufferBase(GL_UNIFORM_BUFFER, GLSL_PARAMS_BINDING,
                      r->shading.params);
}

// Waits for the GPU without spinning.
bool renderer_wait_for_gpu(const char *doing, struct error *err)
{
    GLsync fence = gl.FenceSync(GL_SYNC_GPU_COMMANDS_COMPLETE, 0);
    gl.Flush();
    const GLuint64 second = 1000000000;
    GLenum state = GL_TIMEOUT_EXPIRED;
    for (int i = 0; i < 600 && state == GL_TIMEOUT_EXPIRED; i++)
        state = gl.ClientWaitSync(fence, GL_SYNC_FLUSH_COMMANDS_BIT, second);
    gl.DeleteSync(fence);
    if (state == GL_TIMEOUT_EXPIRED)
        return error_set(err, "gpu", doing,
                         "%s: the GPU did not answer for 600 s", doing);
    return gl_check(doing, err);
}

// The words of render.components that a picture is the sum of.
static const int layer_words[RENDERER_LAYERS] = {1, 2, 3, 5, 6};
const char *const renderer_layer_names[RENDERER_LAYERS] = {
    "single_R", "single_TT", "single_TRT", "global", "local"};

static bool has_layer(const struct renderer *r, int i)
{
    if (!r->layers.on)
        return false;
    return i == 0 ||
           (i < 3 ? !r->shading.opaque
                  : r->shading.shadowed && r->params.render.multiple > 0);
}

// --- work in parts -----------------------------------------------------------

// So that whoever edits waits for one part of it only; where nobody looks, all
// of it is one.  Sizes go by what the part before took.
enum { SHADOW_PART, RAYS_PART, SHADE_PART, PART_FIRST = 128, PART_LEAST = 64 };
static const double part_seconds = 4e-3;

struct parts {
    int which;
    uint32_t all; // places
    bool (*run)(struct renderer *r, const struct parts *p, uint32_t from,
                uint32_t count, struct error *err);
    int k;
    const struct nodes_store *nodes;
    const struct nodes_request *request;
};

static uint32_t next_part(const double *size, uint32_t left)
{
    const double n = *size > PART_LEAST ? *size / PART_LEAST : 1;
    return n * PART_LEAST < left ? (uint32_t)n * PART_LEAST : left;
}

static bool run_parts(struct renderer *r, const struct parts *p,
                      struct error *err)
{
    double *size = &r->part[p->which];
    if (!r->watch.newer)
        return p->run(r, p, 0, p->all, err);
    *size = *size > 0 ? *size : PART_FIRST;
    for (uint32_t from = 0; from < p->all;) {
        const double began = timer_now();
        const uint32_t count = next_part(size, p->all - from);
        if (!p->run(r, p, from, count, err) ||
            !renderer_wait_for_gpu("part of a sample", err))
            return false;
        const double took = timer_now() - began;
        if (count >= *size / 2) // at most twice as many: the first one compiles
            *size = fmin(count * part_seconds / fmax(took, 1e-5), 2 * *size);
        from += count;
        if (watch_cut(&r->watch))
            return false;
    }
    return true;
}

static uint64_t budget_of(const struct renderer *r, uint64_t given)
{
    return given ? given : ((uint64_t)r->params.quality.cache_mb << 20) / 2;
}

// A draft has too few places for tables of each light to pay, and parts of a
// picture are to add up to it.
static struct shading_sample sample_of(const struct renderer *r, int k,
                                       const struct nodes_store *nodes,
                                       uint32_t from)
{
    const bool modes = r->layers.on || r->drafting;
    return (struct shading_sample){
        .part = k,
        .nodes = nodes,
        .from = from,
        .lights = modes ? NULL : &r->lights,
        .lit_bytes = budget_of(r, r->lit_budget),
        .lit_spread = (float)(r->params.quality.group_deg * M_PI / 180),
        .picture = &r->picture,
        .again = k == 0 && (!nodes || nodes == &r->nodes.first),
        .made = nodes ? r->nodes.made : 0,
    };
}

static bool shade_all(struct renderer *r, int k, struct error *err)
{
    const struct shading_sample how = sample_of(r, k, NULL, 0);
    if (!shading_bind(&r->shading, &r->strands, &how, err))
        return false;
    picture_dispatch(&r->picture);
    return true;
}

static bool shade_part(struct renderer *r, const struct parts *p, uint32_t from,
                       uint32_t count, struct error *err)
{
    const struct shading_sample how = sample_of(r, p->k, p->nodes, from);
    if (!shading_bind(&r->shading, &r->strands, &how, err))
        return false;
    picture_dispatch_some(&r->picture, count);
    return true;
}

static bool shadow_part(struct renderer *r, const struct parts *p,
                        uint32_t from, uint32_t count, struct error *err)
{
    (void)err;
    nodes_run(&r->nodes, p->request, &r->picture, from, count);
    return true;
}

// --- shading -----------------------------------------------------------------

// Of sample k those places of `nodes` alone, or all that there are.
static bool shade_shown(struct renderer *r, int k,
                        const struct nodes_store *nodes, struct error *err)
{
    struct parts parts = {
        .which = SHADE_PART, .run = shade_part, .k = k, .nodes = nodes};
    if (nodes)
        parts.all = nodes->stride;
    else if (!r->watch.newer) // how many there are is the GPU's affair
        return shade_all(r, k, err);
    else if (renderer_wait_for_gpu("visible", err) && !watch_cut(&r->watch))
        parts.all = picture_counters(&r->picture);
    else
        return false;
    return run_parts(r, &parts, err);
}

// Shows one of the words from now on, by uniforms and program.
static void show(struct renderer *r, int word, int k)
{
    shading_show(&r->shading, &r->params, &r->strands, word);
    renderer_bind_scene(r, k);
    picture_bind(&r->picture);
}

// The same places once more for each part that the scene has.
static bool shade_layers(struct renderer *r, int k,
                         const struct nodes_store *nodes, struct error *err)
{
    bool ok = true;
    for (int i = 0; ok && i < RENDERER_LAYERS; i++) {
        if (!has_layer(r, i))
            continue;
        show(r, layer_words[i], k);
        ok = layers_fit(&r->layers, i, &r->picture, err);
        layers_bind(&r->layers, i);
        ok = ok && shade_shown(r, k, nodes, err);
    }
    show(r, r->params.render.components, k);
    return ok;
}

static bool shade_fragments(struct renderer *r, int k,
                            const struct nodes_store *nodes, struct error *err)
{
    const struct forward_pass pass = {
        .picture = &r->picture,
        .shading = &r->shading,
        .strands = &r->strands,
        .nodes = nodes,
        .lights = r->lights.used,
    };
    return forward_shade(&r->forward, &pass, k, err);
}

static bool shade(struct renderer *r, int k, const struct nodes_store *nodes,
                  struct error *err)
{
    timer_begin(&r->timer, RENDERER_SHADE, "shade");
    bool ok;
    if (r->path == RENDERER_FORWARD)
        ok = shade_fragments(r, k, nodes, err);
    else
        ok = shade_shown(r, k, nodes, err) &&
             (!r->layers.on || shade_layers(r, k, nodes, err));
    timer_end(&r->timer, RENDERER_SHADE);
    return ok;
}

static bool add_layers(struct renderer *r, struct error *err)
{
    for (int i = 0; i < RENDERER_LAYERS; i++) {
        if (!has_layer(r, i))
            continue;
        if (!layers_fit(&r->layers, i, &r->picture, err))
            return false;
        layers_bind(&r->layers, i);
        layers_add(&r->layers, &r->picture);
    }
    picture_bind(&r->picture);
    return true;
}

// The fragments that sample k sees become the picture's list.
static void list_fragments(struct renderer *r, int k)
{
    forward_bind(&r->forward, &r->picture, k);
    if (!forward_list(&r->forward, &r->picture, k))
        return;
    r->nodes.first_valid &= k > 0; // they go by other numbers
    picture_prepare(&r->picture, k);
}

// The shadow stage, what of the lights reaches the places of a request, and
// their shading.
static bool shadow(struct renderer *r, const struct nodes_request *q,
                   struct error *err)
{
    const struct nodes_store *nodes = NULL;
    const bool kept = nodes_kept(&r->nodes, q->part, q->rays);
    if (!kept)
        timer_begin(&r->timer, RENDERER_SHADOW, "shadow");
    bool ok = nodes_make(&r->nodes, q, &r->strands, &nodes, err);
    if (!kept) {
        const struct parts parts = {.which =
                                        q->rays > 0 ? RAYS_PART : SHADOW_PART,
                                    .all = q->places,
                                    .run = shadow_part,
                                    .request = q};
        ok = ok && run_parts(r, &parts, err);
        if (ok)
            nodes_made(&r->nodes, q);
        timer_end(&r->timer, RENDERER_SHADOW);
    }
    return ok && shade(r, q->part, nodes, err);
}

// All places at once where memory has room for what reaches them; else rays
// take a part after the other, and the smooth field is looked up as it is
// shaded, which gives the same bits.
static bool shadow_and_shade(struct renderer *r, int k, struct error *err)
{
    struct nodes_request q = {
        .part = k,
        .rays = r->refined ? renderer_rays(r) : 0,
        .map = renderer_mapped(r),
        .lights = r->lights.used,
        .budget = budget_of(r, r->nodes_budget),
        .by_pixel = r->path == RENDERER_FORWARD,
        .centres = r->forward.centres,
    };
    crossings_bind(&r->crossings, q.rays > 0 ? &r->strands : NULL);
    if (nodes_kept(&r->nodes, k, q.rays))
        return shadow(r, &q, err);
    if (q.by_pixel)
        list_fragments(r, k);
    // How many places there are.
    if (!renderer_wait_for_gpu("visible", err) || watch_cut(&r->watch))
        return false;
    const uint32_t all = picture_counters(&r->picture);
    const uint32_t room = nodes_room(&q);
    q.places = all;
    if (all <= room)
        return all == 0 || shadow(r, &q, err);
    if (q.rays == 0)
        return shade(r, k, NULL, err);
    for (; q.begin < all; q.begin += room) {
        q.places = all - q.begin < room ? all - q.begin : room;
        if (!shadow(r, &q, err) || !renderer_wait_for_gpu("shadow", err))
            return false;
        timer_collect(&r->timer, r->stats.stage_ms, RENDERER_STAGES);
    }
    return true;
}

// What sample k sees, as cells or as fragments, ready to be shaded.
static bool see(struct renderer *r, int k, struct error *err)
{
    const bool forward = r->path == RENDERER_FORWARD;
    struct picture *p = &r->picture;
    bool seen = true;
    if (forward ? forward_must_see(&r->forward, p, k)
                : picture_must_see(p, k)) {
        timer_begin(&r->timer, RENDERER_VISIBLE, "visible");
        if (forward)
            seen = forward_see(&r->forward, p, &r->strands, k, err);
        else
            seen = picture_see(p, &r->strands, &r->camera, k, err);
        if (seen && forward)
            list_fragments(r, k);
        timer_end(&r->timer, RENDERER_VISIBLE);
    }
    if (seen && forward)
        forward_bind(&r->forward, p, k);
    else if (seen)
        picture_prepare(p, k);
    return seen;
}

static bool resolve(struct renderer *r, struct error *err)
{
    bool ok = true;
    timer_begin(&r->timer, RENDERER_RESOLVE, "resolve");
    if (r->path == RENDERER_FORWARD) {
        forward_add(&r->forward, &r->picture);
    } else {
        picture_add(&r->picture);
        ok = !r->layers.on || add_layers(r, err);
    }
    timer_end(&r->timer, RENDERER_RESOLVE);
    return ok;
}

static uint32_t places_seen(struct renderer *r, int k)
{
    struct forward *f = &r->forward;
    const uint32_t listed = picture_counters(&r->picture);
    if (r->path != RENDERER_FORWARD || k > 0)
        return listed;
    if (f->listed == 0)
        f->first_places = listed; // else the list is another sample's
    return f->first_places;
}

bool renderer_sample(struct renderer *r, struct error *err)
{
    const int k = r->samples;
    renderer_bind_scene(r, k);
    if (!see(r, k, err) ||
        !(renderer_shadowed(r) ? shadow_and_shade(r, k, err)
                               : shade(r, k, NULL, err)) ||
        !resolve(r, err) || !renderer_wait_for_gpu("sample", err))
        return false;
    timer_collect(&r->timer, r->stats.stage_ms, RENDERER_STAGES);
    r->stats.visible_points = places_seen(r, k);
    r->samples = k + 1;
    r->stale[RENDERER_SHADOW] = r->stale[RENDERER_SHADE] = false;
    r->stale[RENDERER_RESOLVE] = false;
    return true;
}

// --- reading -----------------------------------------------------------------

bool renderer_read_display(struct renderer *r, struct buf *out,
                           struct error *err)
{
    struct timer *t = &r->timer;
    buf_clear(out);
    egl_use(r->egl);
    if (r->samples == 0 && r->draft.shown)
        return renderer_draft_read(r, out, err);
    if (r->samples == 0)
        return error_set(err, "state", "image", "nothing is rendered yet");
    renderer_freshen_tint(r);
    // The parameter block may be older than view.*, which it also holds.
    float values[512];
    glsl_params_values(&r->params, values);
    gl.NamedBufferSubData(r->shading.params, 0, 16 * params_row_count, values);
    renderer_bind_scene(r, r->samples - 1);
    timer_begin(t, RENDERER_DISPLAY, "display");
    picture_bind(&r->picture);
    const struct display_input in = {r->map, r->samples, &r->lights, &r->camera,
                                     &r->strands};
    bool drawn = display_draw(&r->display, &r->params, &in, err);
    timer_end(t, RENDERER_DISPLAY);
    if (!drawn || !renderer_wait_for_gpu("display", err))
        return false;
    double began = timer_now();
    display_read(&r->display, out);
    timer_collect(t, r->stats.stage_ms, RENDERER_STAGES);
    r->stats.stage_ms[RENDERER_READ] = 1e3 * (timer_now() - began);
    r->stale[RENDERER_DISPLAY] = r->stale[RENDERER_READ] = false;
    return true;
}

// What is summed knows no tint that is apart.
static void tint(struct renderer *r, float *rgba, size_t pixels)
{
    renderer_freshen_tint(r);
    for (size_t i = 0; i < 4 * pixels; i += 4)
        for (size_t c = 0; c < 3; c++)
            rgba[i + c] *= r->lights.tint[c];
}

bool renderer_read_linear(struct renderer *r, struct buf *out,
                          struct error *err)
{
    buf_clear(out);
    egl_use(r->egl);
    if (r->samples == 0)
        return error_set(err, "state", "image", "nothing is rendered yet");
    const size_t n = (size_t)r->picture.width * (size_t)r->picture.height;
    float *rgba = (float *)(void *)buf_grow(out, 16 * n);
    picture_read_sum(&r->picture, rgba, r->samples);
    tint(r, rgba, n);
    return gl_check("read-back", err);
}

bool renderer_read_layer(struct renderer *r, int layer, struct buf *out,
                         struct error *err)
{
    buf_clear(out);
    egl_use(r->egl);
    if (r->samples == 0 || !r->layers.on)
        return error_set(err, "state", "layers", "no layers are rendered yet");
    const size_t n = (size_t)r->picture.width * (size_t)r->picture.height;
    float *rgba = (float *)(void *)buf_grow(out, 16 * n);
    layers_read(&r->layers, layer, &r->picture, rgba, r->samples);
    tint(r, rgba, n);
    return gl_check("read-back", err);
}
