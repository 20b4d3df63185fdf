// bench_truth.c - asks reference.h for what a view needs to be judged, unless
// it is kept from before.  What is true is reference.h's business.
#include "server/bench_truth.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "protocol/bytes.h"
#include "protocol/edit.h"
#include "renderer/reference.h"
#include "renderer/timer.h"
#include "server/bench_keep.h"
#include "server/bench_time.h"

enum { SEED = 1 };

struct making {
    struct bench_truth *t;
    struct renderer *r;
    const struct bench_truth_ask *ask;
    struct reference *scene;
    struct digest mark; // of what the reference computes
};

static void add(struct digest *d, const void *data, size_t size)
{
    digest_add(d, (struct span){data, size});
}

static void add_text(struct digest *d, const char *text)
{
    add(d, text, strlen(text) + 1);
}

static void add_groups(struct digest *d, const struct params *p,
                       const char *groups)
{
    struct buf text = {0};
    for (int i = 0; i < params_row_count; i++) {
        char name[40];
        snprintf(name, sizeof name, " %s ", params_rows[i].group_name);
        if (!strstr(groups, name))
            continue;
        buf_printf(&text, "%s.%s=", params_rows[i].group_name,
                   params_rows[i].name);
        edit_print(&text, p, &params_rows[i]);
        buf_byte(&text, '\n');
    }
    add(d, text.data, text.size);
    buf_finish(&text);
}

static bool scene_of(struct making *m, struct error *err)
{
    if (!m->scene)
        m->scene = renderer_reference(m->r, FIBRE_EXACT, err);
    return m->scene != NULL;
}

// A few values of every kind, made anew each time: whoever changes what the
// reference computes need not think of what was kept from before.
static bool mark(struct making *m, struct error *err)
{
    const struct places_item *place = m->t->place;
    const size_t n = m->t->count < 3 ? m->t->count : 3;
    const struct reference_paths how = {.samples = 8, .seed = SEED};
    struct reference_single one = {0}, light = {0};
    struct reference_estimate paths[3] = {{0}};
    if (!scene_of(m, err) || !reference_path(m->scene, place, n, &how, paths))
        return false;
    reference_single(m->scene, place, 1, 0, SEED, &one);
    if (m->t->exact > 0) // a tenth of a second and more
        reference_single(m->scene, place, 1, REFERENCE_SRBF, SEED, &light);
    digest_begin(&m->mark);
    for (size_t i = 0; i < n; i++)
        add(&m->mark, paths[i].whole, sizeof paths[i].whole);
    add(&m->mark, one.sum, sizeof one.sum);
    add(&m->mark, light.sum, sizeof light.sum);
    return true;
}

// What every part depends on.
static struct bench_keep keep_of(const struct making *m, const char *part)
{
    const struct bench_truth_ask *a = m->ask;
    struct bench_keep k = {.directory = a->cache, .key = m->mark};
    add_text(&k.key, part);
    add_text(&k.key, a->hair_sha);
    add_text(&k.key, a->sky_sha);
    add_groups(&k.key, a->params, " hair fibre light tint sun1 sun2 sun3 ");
    return k;
}

static void add_places(struct digest *d, const struct bench_truth *t,
                       size_t count)
{
    for (size_t i = 0; i < count; i++) { // not the radiance
        const struct places_item *p = &t->place[i];
        add(d, &p->segment, sizeof p->segment);
        add(d, p->position, sizeof p->position);
        add(d, p->tangent, sizeof p->tangent);
        add(d, p->across, sizeof p->across);
        add(d, p->to_eye, sizeof p->to_eye);
    }
}

// --- parts -------------------------------------------------------------------

typedef bool part_fn(struct making *m, double *out, struct error *err);

static bool get(struct making *m, const struct bench_keep *k, part_fn *make,
                double **out, size_t count, struct error *err)
{
    *out = bytes_zalloc(count > 0 ? count : 1, sizeof **out);
    if (bench_keep_load(k, *out, count)) {
        m->t->kept++;
        return true;
    }
    const double began = timer_now();
    if (!scene_of(m, err) || !make(m, *out, err))
        return false;
    m->t->seconds += timer_now() - began;
    m->t->made++;
    bench_keep_save(k, *out, count);
    return true;
}

static void single(struct making *m, unsigned flags, size_t count, double *out)
{
    struct reference_single *s = bytes_alloc((count + 1) * sizeof *s);
    reference_single(m->scene, m->t->place, count, flags, SEED, s);
    for (size_t i = 0; i < count; i++)
        memcpy(out + 3 * i, s[i].sum, sizeof s[i].sum);
    free(s);
}

static bool make_single(struct making *m, double *out, struct error *err)
{
    (void)err;
    single(m, 0, m->t->count, out);
    return true;
}

static bool make_lights(struct making *m, double *out, struct error *err)
{
    (void)err;
    single(m, REFERENCE_SRBF, m->t->exact, out);
    return true;
}

static bool make_open(struct making *m, double *out, struct error *err)
{
    (void)err;
    single(m, REFERENCE_SRBF | REFERENCE_UNSHADOWED, m->t->exact, out);
    return true;
}

// Multiple scattering, then its variance.
static bool make_multiple(struct making *m, double *out, struct error *err)
{
    const size_t n = m->t->count;
    const struct reference_paths how = {.samples = m->ask->paths, .seed = SEED};
    struct reference_estimate *e = bytes_alloc((n + 1) * sizeof *e);
    const bool ok = reference_path(m->scene, m->t->place, n, &how, e);
    for (size_t i = 0; ok && i < n; i++) {
        memcpy(out + 3 * i, e[i].multiple, sizeof e[i].multiple);
        memcpy(out + 3 * (n + i), e[i].multiple_variance,
               sizeof e[i].multiple_variance);
    }
    free(e);
    return ok || error_set(err, "state", "bench", "the reference was stopped");
}

enum { PIXELS = BENCH_TRUTH_WIDTH * BENCH_TRUTH_HEIGHT };

// The picture, then its variance.
static bool make_picture(struct making *m, double *out, struct error *err)
{
    const struct reference_paths how = {.samples = m->ask->picture_paths,
                                        .seed = SEED};
    float *rgba = bytes_alloc(8 * PIXELS * sizeof *rgba);
    int samples = 0;
    const bool ok = reference_picture(m->scene, &how, rgba, rgba + 4 * PIXELS,
                                      &samples, err);
    for (size_t i = 0; ok && i < 8 * PIXELS; i++)
        out[i] = rgba[i];
    free(rgba);
    return ok;
}

// --- all of them -------------------------------------------------------------

static bool places(struct making *m, struct error *err)
{
    struct bench_truth *t = m->t;
    t->place = bytes_zalloc(m->ask->places + 1, sizeof *t->place);
    if (!renderer_places(m->r, m->ask->places, SEED, t->place, &t->count, err))
        return false;
    if (t->count == 0)
        return error_set(err, "state", "camera", "no hair is in view");
    t->exact = m->ask->exact < t->count ? m->ask->exact : t->count;
    return true;
}

static bool at_places(struct making *m, struct error *err)
{
    struct bench_truth *t = m->t;
    struct bench_keep k = keep_of(m, "single");
    add_places(&k.key, t, t->count);
    if (!get(m, &k, make_single, &t->single, 3 * t->count, err))
        return false;
    k = keep_of(m, "multiple");
    add_places(&k.key, t, t->count);
    add(&k.key, &m->ask->paths, sizeof m->ask->paths);
    if (!get(m, &k, make_multiple, &t->multiple, 6 * t->count, err))
        return false;
    t->variance = bytes_alloc(3 * t->count * sizeof *t->variance);
    t->whole = bytes_alloc(3 * t->count * sizeof *t->whole);
    for (size_t c = 0; c < 3 * t->count; c++) {
        t->variance[c] = t->multiple[3 * t->count + c];
        t->whole[c] = t->single[c] + t->multiple[c];
    }
    k = keep_of(m, "lights");
    add_places(&k.key, t, t->exact);
    add_groups(&k.key, m->ask->params, " sky ");
    if (!m->ask->no_lights &&
        !get(m, &k, make_lights, &t->lights, 3 * t->exact, err))
        return false;
    k = keep_of(m, "open");
    add_places(&k.key, t, t->exact);
    add_groups(&k.key, m->ask->params, " sky ");
    return get(m, &k, make_open, &t->open, 3 * t->exact, err);
}

static void take_picture(struct bench_truth *t, const double *v)
{
    double mean = 0, variance = 0;
    t->picture = bytes_alloc(4 * PIXELS * sizeof *t->picture);
    t->picture_variance = bytes_alloc(3 * PIXELS * sizeof *t->picture_variance);
    for (size_t i = 0; i < 4 * PIXELS; i++) {
        t->picture[i] = (float)v[i];
        if (i % 4 != 3) {
            mean += v[i];
            variance += v[4 * PIXELS + i];
            t->picture_variance[3 * (i / 4) + i % 4] = v[4 * PIXELS + i];
        }
    }
    size_t covered = 0;
    for (size_t i = 3; i < 4 * PIXELS; i += 4)
        covered += v[i] > 0;
    mean /= 3 * (double)covered;
    t->picture_noise = sqrt(variance / (3 * (double)covered)) / mean;
}

// The picture is smaller, so the reference's camera is another one.
static bool whole_picture(struct making *m, struct error *err)
{
    struct params small = *m->ask->params;
    double *values = NULL;
    struct bench_keep k = keep_of(m, "picture");
    small.image.width = BENCH_TRUTH_WIDTH;
    small.image.height = BENCH_TRUTH_HEIGHT;
    add_groups(&k.key, &small, " camera image ");
    add(&k.key, &m->ask->picture_paths, sizeof m->ask->picture_paths);
    reference_destroy(m->scene);
    m->scene = NULL;
    const bool ok = bench_time_finish(m->r, &small, NULL, err) &&
                    get(m, &k, make_picture, &values, 8 * PIXELS, err) &&
                    bench_time_finish(m->r, m->ask->params, NULL, err);
    if (ok)
        take_picture(m->t, values);
    free(values);
    return ok;
}

bool bench_truth_make(struct bench_truth *t, struct renderer *r,
                      const struct bench_truth_ask *ask, struct error *err)
{
    struct making m = {.t = t, .r = r, .ask = ask};
    *t = (struct bench_truth){0};
    const bool ok = places(&m, err) && mark(&m, err) && at_places(&m, err) &&
                    (ask->picture_paths == 0 || whole_picture(&m, err));
    reference_destroy(m.scene);
    return ok;
}

void bench_truth_finish(struct bench_truth *t)
{
    free(t->place);
    free(t->single);
    free(t->multiple);
    free(t->variance);
    free(t->whole);
    free(t->lights);
    free(t->open);
    free(t->picture);
    free(t->picture_variance);
    *t = (struct bench_truth){0};
}

bool bench_truth_radiance(const struct bench_truth *t, struct renderer *r,
                          size_t count, double *radiance, struct error *err)
{
    struct places_item *now = bytes_alloc((t->count + 1) * sizeof *now);
    size_t got = 0;
    bool ok = renderer_places(r, t->count, SEED, now, &got, err);
    for (size_t i = 0; ok && i < count; i++) {
        if (i >= got || now[i].segment != t->place[i].segment ||
            now[i].along != t->place[i].along)
            ok = error_set(err, "state", "bench",
                           "the picture sees other places than its reference");
        for (size_t c = 0; c < 3; c++)
            radiance[3 * i + c] = (double)now[i].radiance[c];
    }
    free(now);
    return ok;
}
