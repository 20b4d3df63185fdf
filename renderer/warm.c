// warm.c - which states are one edit away, and rendering them.  When there is
// time for that, server/warmer.c knows.
#include "renderer/warm.h"

#include <stdlib.h>
#include <string.h>

#include "renderer/places.h"
#include "renderer/renderer_private.h"

enum {
    STATES_MAX = 128,
    STRANDS = 24,
    WIDTH = 60, // no power of two: drivers make programs of their own then
    HEIGHT = 44,
    M_MOST = 9, // of render.m: above it is no constant (shading.c)
    KIND = 64
};

// All of a state that can decide about programs.
struct kind {
    uint8_t of[KIND];
};

struct warm {
    struct renderer *renderer;
    struct groom *sample;
    struct sky_fit fit;
    int sky[2];
    uint64_t lit_budget; // bytes of lights' tables: they decide about programs
    bool installed;      // all this is the renderer's
    uint8_t hair;        // its properties
    struct params state[STATES_MAX];
    int count, next;
    struct kind *done;
    size_t done_count;
    struct buf known; // names that were given, a line each
};

struct warm *warm_create(void)
{
    return bytes_zalloc(1, sizeof(struct warm));
}

void warm_rest(struct warm *w)
{
    renderer_destroy(w->renderer);
    w->renderer = NULL;
    w->installed = false;
}

void warm_destroy(struct warm *w)
{
    if (!w)
        return;
    warm_rest(w);
    groom_destroy(w->sample);
    buf_finish(&w->known);
    free(w->done);
    free(w);
}

// --- hair -------------------------------------------------------------------

struct groom *warm_sample(const struct groom *g)
{
    const uint32_t stride = g->strands / STRANDS;
    struct groom *s = groom_share(g, stride > 0 ? stride : 1);
    float size = 0;
    for (int c = 0; c < 3; c++)
        if (g->box_max[c] - g->box_min[c] > size)
            size = g->box_max[c] - g->box_min[c];
    if (!s->diameter)
        s->diameter = bytes_zalloc(s->points, sizeof *s->diameter);
    for (uint32_t k = 0; k < s->strands; k++)
        for (uint32_t i = s->first[k]; i < s->first[k + 1]; i++)
            s->diameter[i] = size * (k % 2 ? 0.1f : 1e-5f);
    return s;
}

// --- states -----------------------------------------------------------------

static bool decides(const struct params_row *row)
{
    const uint32_t others = 1u << GROUP_sky | 1u << GROUP_output |
                            1u << GROUP_image | 1u << GROUP_quality;
    return (row->type == PARAMS_CHOICE || row->type == PARAMS_BOOL) &&
           !(others >> row->group & 1);
}

static bool reads_m(const struct params *p)
{
    return p->render.scheme == 0 || p->render.multiple == 1;
}

static bool opaque(const struct params *p)
{
    const float *s = p->fibre.sigma_a;
    return s[0] > 8 && s[1] > 8 && s[2] > 8;
}

static bool sunny(const struct params *p)
{
    return p->sun1.strength > 0 || p->sun2.strength > 0 || p->sun3.strength > 0;
}

// Narrow lights then have no table (lit_plan.c).
static bool narrow(const struct params *p)
{
    struct params r = *p;
    params_fibre_resolve(&r);
    return r.fibre.beta_r < 0.5f || r.fibre.beta_tt < 0.5f ||
           r.fibre.beta_trt < 0.5f;
}

static struct kind kind_of(const struct params *p, uint8_t hair)
{
    struct kind k = {{0}};
    int n = 0;
    k.of[n++] = hair;
    k.of[n++] = p->fibre.a != 1;
    k.of[n++] = opaque(p);
    k.of[n++] = sunny(p);
    k.of[n++] = narrow(p);
    k.of[n++] = p->shadow.rays > 0;
    k.of[n++] = reads_m(p) && p->render.m < M_MOST ? (uint8_t)p->render.m : 0;
    for (int i = 0; i < params_row_count && n < KIND; i++)
        if (decides(&params_rows[i]))
            k.of[n++] = (uint8_t)params_get(p, &params_rows[i], 0);
    return k;
}

static bool is_done(const struct warm *w, const struct kind *k)
{
    for (size_t i = 0; i < w->done_count; i++)
        if (memcmp(&w->done[i], k, sizeof *k) == 0)
            return true;
    return false;
}

static void put(struct warm *w, const struct params *p)
{
    const struct kind k = kind_of(p, w->hair);
    if (is_done(w, &k) || w->count == STATES_MAX)
        return;
    for (int i = 0; i < w->count; i++) {
        const struct kind other = kind_of(&w->state[i], w->hair);
        if (memcmp(&other, &k, sizeof k) == 0)
            return;
    }
    w->state[w->count++] = *p;
}

static void put_choices(struct warm *w, const struct params *p)
{
    for (int i = 0; i < params_row_count; i++) {
        const struct params_row *row = &params_rows[i];
        if (!decides(row))
            continue;
        const char *at = row->choices;
        int words = row->type == PARAMS_BOOL ? 2 : 1;
        for (; row->type == PARAMS_CHOICE && (at = strchr(at, '|')); at++)
            words++;
        for (int k = 0; k < words; k++) {
            struct params q = *p;
            params_put(&q, row, 0, k);
            put(w, &q);
        }
    }
}

static void put_extremes(struct warm *w, const struct params *p)
{
    struct params q = *p;
    q.fibre.a = p->fibre.a == 1 ? 0.9f : 1;
    put(w, &q);
    q = *p;
    for (int c = 0; c < 3; c++)
        q.fibre.sigma_a[c] = opaque(p) ? 0.2f : 20;
    put(w, &q);
    q = *p;
    q.fibre.beta_r = narrow(p) ? 8 : 0.2f;
    q.sun1.strength = narrow(p) ? p->sun1.strength : 1;
    put(w, &q);
    q = *p;
    q.sun2.strength = q.sun3.strength = 0;
    q.sun1.strength = sunny(p) ? 0 : 1;
    put(w, &q);
    q = *p;
    q.shadow.rays = p->shadow.rays > 0 ? 0 : 1;
    put(w, &q);
    for (int m = 2; reads_m(p) && m <= M_MOST; m++) {
        q = *p;
        q.render.m = m;
        put(w, &q);
    }
}

// Nothing of these decides about programs, and this is quick.
static struct params small(const struct params *p)
{
    struct params q, def;
    params_defaults(&def);
    q = *p;
    q.camera = def.camera;
    q.image.width = WIDTH;
    q.image.height = HEIGHT;
    q.quality.samples = 2;
    q.quality.cache_mb = 16;
    q.render.tables = 1;
    q.hair.scale = 1;
    q.hair.diameter = 0; // the sample's
    if (q.shadow.rays > 1)
        q.shadow.rays = 1;
    return q;
}

void warm_begin(struct warm *w, const struct warm_scene *scene)
{
    const struct params q = small(&scene->params);
    const struct groom *sample = scene->sample;
    groom_destroy(w->sample);
    w->sample = scene->sample;
    w->fit = scene->fit;
    w->lit_budget = ((uint64_t)scene->params.quality.cache_mb << 20) / 2;
    w->sky[0] = scene->sky_width;
    w->sky[1] = scene->sky_height;
    w->installed = false;
    w->hair = (uint8_t)((sample->colour ? 1 : 0) | (sample->opacity ? 2 : 0) |
                        (sample->head.present ? 4 : 0) |
                        (sample->default_opacity < 1 ? 8 : 0));
    w->count = w->next = 0;
    put(w, &q);
    put_choices(w, &q);
    put_extremes(w, &q);
}

int warm_left(const struct warm *w)
{
    return w->count - w->next;
}

int warm_done(const struct warm *w)
{
    return (int)w->done_count;
}

// --- rendering --------------------------------------------------------------

static int side(int n) // as small as a power of two, or as none
{
    return (n & (n - 1)) == 0 ? 32 : 24;
}

static struct sky_map *black(const int size[2])
{
    struct sky_map *m = bytes_zalloc(1, sizeof *m);
    m->width = side(size[0]);
    m->height = side(size[1]);
    m->rgb =
        bytes_zalloc(3 * (size_t)m->width * (size_t)m->height, sizeof *m->rgb);
    return m;
}

// The scene's own lights, so that the field of crossings is of the same size;
// all states have the same parameters of the sky.
static bool set_up(struct warm *w, struct error *err)
{
    if (!w->renderer) {
        w->renderer = renderer_create(NULL, err);
        w->installed = false;
    }
    struct renderer *r = w->renderer;
    if (!r || w->installed)
        return r != NULL;
    renderer_set_params(r, &w->state[0]);
    w->installed = renderer_set_sky(r, black(w->sky), err) &&
                   renderer_set_groom(r, groom_share(w->sample, 1), err);
    r->fit = w->fit;
    r->lit_budget = w->lit_budget; // the scene's, not that of `small`
    r->stale[RENDERER_SKY] = false;
    return w->installed;
}

// As a viewer gets it, as the judge does, and as layers.
static bool render(struct renderer *r, const struct params *p,
                   struct error *err)
{
    struct buf pixels = {0};
    struct places_item item[4];
    size_t got;
    bool done = false, ok = true;
    renderer_set_params(r, p);
    while (ok && !done)
        ok = renderer_step(r, &done, err);
    ok = ok && renderer_read_display(r, &pixels, err);
    if (ok && p->render.path != 1 && p->render.components == 0) {
        ok = renderer_places(r, 4, 1, item, &got, err) &&
             renderer_layers_on(r, err);
        for (done = false; ok && !done;)
            ok = renderer_step(r, &done, err);
        renderer_layers_off(r);
    }
    buf_finish(&pixels);
    return ok;
}

static bool is_known(const struct buf *known, const unsigned char *line,
                     size_t size)
{
    return memmem(known->data, known->size, line, size) != NULL;
}

// Lines of `all` that are new; a line ends in '\n' and begins after one.
static void name_new(struct warm *w, const struct buf *all, struct buf *names)
{
    for (size_t at = 0, end; at < all->size; at = end) {
        const unsigned char *stop =
            memchr(all->data + at, '\n', all->size - at);
        end = stop ? (size_t)(stop - all->data) + 1 : all->size;
        if (w->known.size == 0)
            buf_byte(&w->known, '\n');
        struct buf line = {0};
        buf_byte(&line, '\n');
        buf_append(&line, all->data + at, end - at);
        if (!is_known(&w->known, line.data, line.size)) {
            buf_append(&w->known, line.data + 1, line.size - 1);
            buf_append(names, line.data + 1, line.size - 1);
        }
        buf_finish(&line);
    }
}

bool warm_step(struct warm *w, struct buf *names, struct error *err)
{
    if (w->next >= w->count)
        return true;
    const struct params *p = &w->state[w->next++];
    const struct kind k = kind_of(p, w->hair);
    const bool ok = set_up(w, err) && render(w->renderer, p, err);
    // Not tried again where it failed: an edit will say why.
    w->done = bytes_realloc(w->done, (w->done_count + 1) * sizeof *w->done);
    w->done[w->done_count++] = k;
    if (w->renderer) {
        struct buf all = {0};
        renderer_programs(w->renderer, &all);
        name_new(w, &all, names);
        buf_finish(&all);
    }
    return ok;
}
