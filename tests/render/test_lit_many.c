// Many lights with render.path=table: all have tables and what these err stays
// as small as for few; memory is bounded, and what it costs is told; edited =
// fresh, bit for bit.
#include "tests/check.h"
#include "tests/render/scene.h"

#include <stdlib.h>

#include "renderer/renderer_private.h"

static void base(struct params *p)
{
    scene_params(p);
    p->hair.diameter = 0.6f;
    p->quality.samples = 1;
    p->quality.light_bound = 0;
    p->quality.group_deg = 0; // lights' tables apart from what groups err
    p->shadow.method = 1;
    p->shadow.rays = 0;
    p->shadow.resolution = 40;
}

// Lights all over the sky, of many widths and of the widest that a fit of so
// many may have, some bright and most dim: no fit, which takes seconds.
static void sky_of(int count, struct sky_fit *fit)
{
    const double widest = 2.2 / sqrt(count);
    memset(fit, 0, sizeof *fit);
    fit->count = count;
    for (int j = 0; j < count; j++) {
        struct sky_light *l = &fit->light[j];
        const double z = 1 - 2 * (j + 0.5) / count, phi = 2.399963 * j;
        const double r = sqrt(1 - z * z), part = fmod(0.618034 * j, 1) * 1.6;
        l->direction[0] = r * cos(phi);
        l->direction[1] = r * sin(phi);
        l->direction[2] = z;
        l->lambda = fmax(0.02, widest * fmin(part, 1));
        const double power = exp(-4.0 * j / count); // by falling energy
        for (int c = 0; c < 3; c++)
            l->radiance[c] = power * (1 + 0.3 * ((j + c) % 3)) /
                             sky_lobe_omega(l->lambda) / count;
    }
}

static struct renderer *renderer_of(const struct params *p, int count)
{
    struct renderer *r =
        scene_renderer(scene_lock(60, 10), scene_constant_sky(1), p);
    sky_of(count, &r->fit);
    r->stale[RENDERER_SKY] = false;
    return r;
}

static double told(const struct renderer *r, const char *what)
{
    struct renderer_stats s;
    renderer_stats(r, &s);
    for (int i = 0; i < s.left_out_count; i++)
        if (strcmp(s.left_out[i].what, what) == 0)
            return strlen(s.left_out[i].why) > 0 ? s.left_out[i].bound : -2;
    return -1;
}

static int by_size(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

struct errors {
    double median, p99, most, rmse; // rmse over the mean
};

// As docs/METHODS.md has it: relative to a pixel's light and a twentieth of the
// mean.
static struct errors errors_of(const struct buf *got, const struct buf *want)
{
    const float *a = (const float *)(const void *)got->data;
    const float *b = (const float *)(const void *)want->data;
    const size_t pixels = want->size / 16;
    double *all = bytes_alloc(3 * pixels * sizeof *all);
    double mean = 0, square = 0;
    size_t n = 0;
    for (size_t i = 0; i < pixels; i++)
        for (int c = 0; c < 3 && b[4 * i + 3] > 0.5f; c++, n++)
            mean += (double)b[4 * i + (size_t)c];
    mean /= (double)n;
    n = 0;
    for (size_t i = 0; i < 4 * pixels; i++) {
        if (i % 4 == 3 || b[i / 4 * 4 + 3] <= 0.5f)
            continue;
        const double off = (double)a[i] - (double)b[i];
        square += off * off;
        all[n++] = fabs(off) / ((double)b[i] + 0.05 * mean);
    }
    qsort(all, n, sizeof *all, by_size);
    const struct errors e = {all[n / 2], all[n * 99 / 100], all[n - 1],
                             sqrt(square / (double)n) / mean};
    free(all);
    return e;
}

static void show(int count, const struct renderer *r, const struct errors *e)
{
    struct renderer_stats s;
    renderer_stats(r, &s);
    printf("  %d lights, %d tables, %d without, %.0f MB: median %.4f, p99 "
           "%.4f, most %.3f, RMSE %.4f\n",
           count, s.tables, s.tables_missing, (double)s.memory_tables / 1e6,
           e->median, e->p99, e->most, e->rmse);
}

static struct buf direct_of(struct params p, int count)
{
    p.render.path = 0;
    struct renderer *r = renderer_of(&p, count);
    struct buf b = scene_linear(r);
    renderer_destroy(r);
    return b;
}

static void all_have_tables(int count)
{
    char name[64];
    struct params p;
    struct renderer_stats s;
    base(&p);
    snprintf(name, sizeof name, "%d lights have tables, as fine as few", count);
    check_case(name);
    struct renderer *r = renderer_of(&p, count);
    struct buf got = scene_linear(r), want = direct_of(p, count);
    const struct errors e = errors_of(&got, &want);
    renderer_stats(r, &s);
    show(count, r, &e);
    CHECK(s.lights_used == count && strcmp(s.path, "table") == 0);
    CHECK(s.tables_missing == 0 && s.tables > 0 && 3 * s.tables < 2 * count);
    CHECK(told(r, "light_tables") == -1);
    CHECK(count > 120 || told(r, "fine_tables") == -1);
    // Measured, the largest of 40, 120 and 200: .0033, .0135, .019, .0053.
    CHECK(e.median < 0.005 && e.p99 < 0.02);
    CHECK(e.most < 0.03 && e.rmse < 0.008);
    buf_finish(&got);
    buf_finish(&want);
    renderer_destroy(r);
}

static struct buf fresh(const struct params *p, int count)
{
    struct renderer *r = renderer_of(p, count);
    struct buf b = scene_linear(r);
    renderer_destroy(r);
    return b;
}

static bool edited_is_fresh(struct renderer *r, const struct params *p,
                            int count)
{
    renderer_set_params(r, p);
    struct buf edited = scene_linear(r), anew = fresh(p, count);
    const bool same = scene_same(&edited, &anew);
    buf_finish(&edited);
    buf_finish(&anew);
    return same;
}

// Widths change who has how many cells, memory who has a table at all.
static void law(int count)
{
    struct params p;
    base(&p);
    check_case("edited = fresh with many lights, however much memory");
    struct renderer *r = renderer_of(&p, count);
    CHECK(edited_is_fresh(r, &p, count));
    p.fibre.sigma_a[1] = 0.4f;
    CHECK(edited_is_fresh(r, &p, count));
    p.fibre.beta_r = 3;
    CHECK(edited_is_fresh(r, &p, count));
    p.quality.cache_mb = 16;
    CHECK(edited_is_fresh(r, &p, count));
    p.sun1.strength = 2;
    CHECK(edited_is_fresh(r, &p, count));
    p.fibre.beta_r = 7.5f;
    p.quality.cache_mb = 64;
    CHECK(edited_is_fresh(r, &p, count));
    p.quality.cache_mb = 256;
    CHECK(edited_is_fresh(r, &p, count));
    renderer_destroy(r);
}

// Half of quality.cache_mb for tables, and what does not fit is told.
static void bounded(int count)
{
    struct params p;
    struct renderer_stats s;
    base(&p);
    check_case("tables stay within half of quality.cache_mb");
    struct renderer *r = renderer_of(&p, count);
    struct buf want = direct_of(p, count);
    static const int mb[] = {256, 64, 32, 16};
    for (int i = 0; i < 4; i++) {
        p.quality.cache_mb = mb[i];
        renderer_set_params(r, &p);
        struct buf got = scene_linear(r);
        const struct errors e = errors_of(&got, &want);
        show(count, r, &e);
        renderer_stats(r, &s);
        const struct lit_plan *plan = lit_tables_plan(r->shading.lit);
        // Besides: records of 24 bytes a place and light and a quarter more,
        // their order, who wants which column.
        const uint64_t pairs = (uint64_t)s.visible_points * (uint64_t)count;
        const uint64_t half = (uint64_t)mb[i] << 19;
        const uint64_t more = 30 * pairs + (1u << 20);
        CHECK(lit_tables_bytes(r->shading.lit) <= half + more);
        CHECK((told(r, "light_tables") == 0) == (s.tables_missing > 0));
        CHECK((told(r, "fine_tables") > 0) == (plan->coarser > 0));
        // measured, 64 MB: .0048, .024
        CHECK(e.median < 0.007 && e.most < 0.035);
        buf_finish(&got);
    }
    CHECK(s.tables_missing > 0); // or 16 MB tested nothing
    buf_finish(&want);
    renderer_destroy(r);
}

// Tables know no colour: a sun's makes none, nor does a sky's.
static void colours(void)
{
    struct params p;
    struct renderer_stats fibre, sun;
    base(&p);
    p.sun1.strength = 1;
    check_case("a light's colour makes no tables");
    struct renderer *r = renderer_of(&p, 40);
    CHECK(scene_finish(r));
    p.fibre.sigma_a[1] = 0.4f;
    renderer_set_params(r, &p);
    CHECK(scene_finish(r));
    renderer_stats(r, &fibre);
    p.sun1.colour[1] = 0.2f;
    p.tint.colour[0] = 0.5f;
    renderer_set_params(r, &p);
    CHECK(scene_finish(r));
    renderer_stats(r, &sun);
    printf("  dispatches: %llu of a fibre, %llu of colours\n",
           (unsigned long long)fibre.work.dispatches,
           (unsigned long long)sun.work.dispatches);
    // values and cells of the lights' tables and of the far one
    CHECK(sun.work.dispatches + 4 <= fibre.work.dispatches);
    CHECK(edited_is_fresh(r, &p, 40));
    renderer_destroy(r);
}

int main(void)
{
    all_have_tables(40);
    all_have_tables(120);
    all_have_tables(200);
    law(120);
    bounded(120);
    colours();
    return check_end();
}
