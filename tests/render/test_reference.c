// The references: places as the picture has them, two ways to light scattered
// once, energy, and that nothing depends on the number of cores.
#include "renderer/reference.h"

#include <sched.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "renderer/places.h"
#include "renderer/reference_private.h"
#include "tests/check.h"
#include "tests/render/scene.h"

static const double pi = 3.14159265358979323846;

// --- scenes -----------------------------------------------------------------

struct fixture {
    struct renderer *r;
    struct params p;
    struct reference *s;
    struct places_item *place;
    size_t count;
};

static struct groom *lock(bool head)
{
    struct groom *g = scene_lock(300, 12);
    g->default_diameter = 0.8f;
    g->head.present = head;
    return g;
}

static void begin(struct fixture *f, struct groom *g, struct sky_map *m,
                  size_t want)
{
    struct error err = {0};
    f->p.quality.samples = 1;
    f->r = scene_renderer(g, m, &f->p);
    scene_finish(f->r);
    f->place = bytes_zalloc(want, sizeof *f->place);
    CHECK(renderer_places(f->r, want, 5, f->place, &f->count, &err));
    f->s = renderer_reference(f->r, FIBRE_EXACT, &err);
    CHECK(f->s != NULL && f->count > want / 2);
}

static void end(struct fixture *f)
{
    reference_destroy(f->s);
    renderer_destroy(f->r);
    free(f->place);
}

static struct fixture plain(void)
{
    struct fixture f = {0};
    scene_params(&f.p);
    return f;
}

static struct reference_estimate *paths(const struct fixture *f, int samples,
                                        uint64_t seed)
{
    struct reference_estimate *e = bytes_zalloc(f->count, sizeof *e);
    const struct reference_paths how = {.samples = samples, .seed = seed};
    CHECK(reference_path(f->s, f->place, f->count, &how, e));
    return e;
}

// --- places -----------------------------------------------------------------

// With one sample a covered pixel is what its cell sends, bit for bit; the cell
// is a pixel long, so its middle is at most that far from where it is seen.
static void places(void)
{
    struct fixture f = plain();
    struct error err = {0};
    struct places_item again[80];
    size_t count;
    check_case("places: what the picture shows, where it shows it");
    begin(&f, lock(true), scene_two_lamps(), 80);
    struct buf linear = scene_linear(f.r);
    const float *rgba = (const float *)(const void *)linear.data;
    for (size_t i = 0; i < f.count; i++) {
        const struct places_item *q = &f.place[i];
        const float *pixel = rgba + 4 * (96 * q->y + q->x);
        CHECK(memcmp(pixel, q->radiance, 12) == 0 && pixel[3] == 1);
        // 1 pixel = 1 unit at y = 0; perspective elsewhere (scene.h)
        const double far = 32 / tan(10 * pi / 180);
        const double zoom = far / (far + q->position[1]);
        CHECK_ATMOST(fabs(q->position[0] * zoom + 48 - (q->x + 0.5)), 1.6);
        CHECK_ATMOST(fabs(32 - q->position[2] * zoom - (q->y + 0.5)), 1.6);
        double u = 0, v = 0, uv = 0;
        for (int k = 0; k < 3; k++) {
            u += q->tangent[k] * q->tangent[k];
            v += q->across[k] * q->across[k];
            uv += q->tangent[k] * q->across[k];
        }
        CHECK_NEAR(u, 1, 1e-6); // single precision
        CHECK_NEAR(v, 1, 1e-6);
        CHECK_NEAR(uv, 0, 1e-6);
    }
    check_case("places: the same again by the same seed, others by another");
    CHECK(renderer_places(f.r, 80, 5, again, &count, &err));
    CHECK(count == f.count &&
          memcmp(again, f.place, count * sizeof *again) == 0);
    CHECK(renderer_places(f.r, 80, 6, again, &count, &err));
    CHECK(memcmp(again, f.place, count * sizeof *again) != 0);
    check_case("places: nothing rendered, nothing given");
    f.p.fibre.eta = 1.4f;
    renderer_set_params(f.r, &f.p);
    CHECK(!renderer_places(f.r, 80, 5, again, &count, &err));
    CHECK_STR(err.code, "state");
    buf_finish(&linear);
    end(&f);
}

// --- light scattered once ---------------------------------------------------

// Sums over all places and channels: their difference in standard errors, and
// chi-square over those that are lit well enough to have a normal mean.
static void agree(const struct fixture *f, int samples)
{
    struct reference_single *a = bytes_zalloc(f->count, sizeof *a);
    struct reference_estimate *e = paths(f, samples, 3);
    double off[3] = {0}, variance[3] = {0}, chi = 0, n = 0, mean = 0;
    reference_single(f->s, f->place, f->count, 0, 1, a);
    for (size_t i = 0; i < f->count; i++)
        mean += a[i].sum[1] / (double)f->count;
    for (size_t i = 0; i < f->count; i++)
        for (int c = 0; c < 3; c++) {
            const double d = e[i].single[c] - a[i].sum[c];
            off[c] += d;
            variance[c] += e[i].single_variance[c];
            if (a[i].sum[c] > 0.3 * mean) {
                chi += d * d / e[i].single_variance[c];
                n++;
            }
        }
    for (int c = 0; c < 3; c++) {
        // texels' jitter is noise as well, far below the paths'
        CHECK_ATMOST(fabs(off[c]), 4 * sqrt(variance[c]));
    }
    // the channels of a place are one draw: a third as many degrees of freedom
    CHECK_ATMOST(fabs(chi / n - 1), 5 * sqrt(2 / (n / 3)));
    CHECK(n > 40);
    free(a);
    free(e);
}

static void once(void)
{
    struct fixture f = plain();
    f.p.sun1.strength = 2;
    check_case("once: texel by texel is the direct part of paths");
    begin(&f, lock(true), scene_two_lamps(), 60);
    agree(&f, 512);
    end(&f);

    check_case("once: the same with half-transparent hair");
    f.p.hair.use_opacity = true;
    f.p.light.yaw = 50;
    f.p.tint.exposure = 1;
    begin(&f, scene_fan_opacity(40, 0.5f), scene_two_lamps(), 60);
    agree(&f, 512);
    end(&f);

    check_case("once: the same with an eccentric fibre");
    f = plain();
    f.p.fibre.a = 0.85f;
    begin(&f, lock(true), scene_two_lamps(), 40);
    agree(&f, 256);
    end(&f);
}

// An even sky of 1 makes of an unshadowed fibre what its albedo says: to .7 %
// by one jittered direction a texel, to 2.4 % by eight SRBF lights, to 13 % as
// the picture has it, by a scheme whose R is that much too dark (all measured).
static void even_sky(void)
{
    struct fixture f = plain();
    struct fibre_direction o = {0, 0};
    check_case("once: an even sky, three ways");
    f.p.render.components = 4;
    begin(&f, lock(true), scene_constant_sky(1), 12);
    struct reference_single t[12], l[12];
    const unsigned bare = REFERENCE_UNSHADOWED;
    reference_single(f.s, f.place, f.count, bare, 1, t);
    reference_single(f.s, f.place, f.count, bare | REFERENCE_SRBF, 1, l);
    for (size_t i = 0; i < f.count; i++) {
        const struct places_item *q = &f.place[i];
        double a[FIBRE_MODES][3], s = 0;
        for (int k = 0; k < 3; k++)
            s += q->tangent[k] * q->to_eye[k];
        o.theta = asin(s);
        fibre_albedo(reference_fibre(f.s), o.theta, a);
        for (int c = 0; c < 3; c++) {
            const double want = a[0][c] + a[1][c] + a[2][c];
            CHECK_NEAR(t[i].sum[c] / want, 1, 0.02);
            CHECK_NEAR(l[i].sum[c] / want, 1, 0.05);
            CHECK_NEAR((double)q->radiance[c] / want, 1, 0.2);
        }
        CHECK_NEAR(t[i].seen, 1, 1e-12);
    }
    end(&f);
}

// --- energy -----------------------------------------------------------------

// What a path leaves behind at each scattering: 1 - albedo.  Under an even sky
// of 1 that is all that is missing.
static double left_behind(const struct fixture *f,
                          const struct places_item *from,
                          struct reference_random *random)
{
    const struct fibre *fibre = reference_fibre(f->s);
    struct reference_vertex v;
    double through = 1, sum = 0;
    reference_vertex_at(f->s, from, &v);
    for (int n = 0; n < 200 && through > 1e-6; n++) {
        const double white[3] = {1, 1, 1};
        double a[FIBRE_MODES][3], s[FIBRE_MODES][3], d[3], along;
        struct fibre_view view;
        struct fibre_direction i;
        uint32_t segment;
        fibre_albedo(fibre, v.eye.theta, a);
        sum += through * (1 - a[0][0] - a[1][0] - a[2][0]);
        fibre_look(fibre, &v.eye, white, &view);
        const double u[3] = {reference_random_next(random),
                             reference_random_next(random),
                             reference_random_next(random)};
        if (!fibre_sample(fibre, &view, u, &i))
            break;
        fibre_scatter(fibre, &v.eye, &i, s);
        through *= (s[0][0] + s[1][0] + s[2][0]) / fibre_pdf(fibre, &view, &i);
        reference_vertex_out(&v, &i, d);
        const struct shoot_ray ray = {
            {v.position[0], v.position[1], v.position[2]},
            {d[0], d[1], d[2]},
            INFINITY,
            v.segment};
        shoot_first(f->s->shoot, &ray, &segment, &along);
        if (segment == UINT32_MAX)
            break; // the sky: nothing is missing
        const double back[3] = {-d[0], -d[1], -d[2]};
        reference_vertex_of(f->s, segment, along, back, &v);
    }
    return sum;
}

static void furnace(void)
{
    enum { PATHS = 256 };
    struct fixture f = plain();
    check_case("furnace: what comes out is what came in but for longer modes");
    memset(f.p.fibre.sigma_a, 0, sizeof f.p.fibre.sigma_a);
    begin(&f, lock(false), scene_constant_sky(1), 60);
    struct reference_estimate *e = paths(&f, PATHS, 9);
    double out = 0, variance = 0, missing = 0, squares = 0, events = 0;
    for (size_t i = 0; i < f.count; i++) {
        double sum = 0, square = 0;
        for (int k = 0; k < PATHS; k++) {
            struct reference_random random;
            reference_random_begin(&random, 77, i, (uint64_t)k);
            const double x = left_behind(&f, &f.place[i], &random);
            sum += x / PATHS;
            square += x * x / PATHS;
        }
        missing += sum;
        squares += (square - sum * sum) / PATHS;
        out += e[i].whole[0];
        variance += e[i].whole_variance[0];
        events += e[i].events / (double)f.count;
    }
    const double n = (double)f.count;
    CHECK_NEAR((out + missing) / n, 1, 4 * sqrt(variance + squares) / n);
    CHECK(events > 2); // or it would test little
    free(e);
    end(&f);
}

// --- how it is run ----------------------------------------------------------

static bool stop(void *self, const struct reference_progress *p)
{
    int *calls = self;
    ++*calls;
    return p->share >= 1;
}

static void running(void)
{
    struct fixture f = plain();
    cpu_set_t all, one;
    check_case("paths: the same bits on one core as on all, by the same seed");
    begin(&f, lock(true), scene_two_lamps(), 30);
    struct reference_estimate *a = paths(&f, 40, 4), *b = NULL;
    sched_getaffinity(0, sizeof all, &all);
    CPU_ZERO(&one);
    for (size_t k = 0; k < CPU_SETSIZE && CPU_COUNT(&one) == 0; k++)
        if (CPU_ISSET(k, &all))
            CPU_SET(k, &one);
    sched_setaffinity(0, sizeof one, &one);
    b = paths(&f, 40, 4);
    sched_setaffinity(0, sizeof all, &all);
    CHECK(memcmp(a, b, f.count * sizeof *a) == 0);
    free(b);
    b = paths(&f, 40, 5);
    CHECK(memcmp(a, b, f.count * sizeof *a) != 0);

    check_case("paths: single and multiple add up, one event is single");
    for (size_t i = 0; i < f.count; i++)
        for (int c = 0; c < 3; c++) {
            double sum = 0;
            for (int n = 0; n < REFERENCE_BOUNCES; n++)
                sum += a[i].bounce[n][c];
            CHECK_NEAR(a[i].single[c] + a[i].multiple[c], a[i].whole[c], 1e-12);
            CHECK_NEAR(sum, a[i].whole[c], 1e-12);
        }
    int calls = 0;
    struct reference_paths how = {.samples = 40, .seed = 4, .events = 1};
    CHECK(reference_path(f.s, f.place, f.count, &how, b));
    for (size_t i = 0; i < f.count; i++)
        CHECK(b[i].multiple[0] == 0 && b[i].whole[1] == b[i].single[1]);

    check_case("paths: progress may stop them");
    how = (struct reference_paths){
        .samples = 100000, .seed = 4, .progress = stop, .self = &calls};
    CHECK(!reference_path(f.s, f.place, f.count, &how, b));
    CHECK(calls == 1 && b[0].samples > 0 && b[0].samples < 100000);
    CHECK(isfinite(b[0].whole[0]) && isfinite(b[0].whole_variance[0]));
    free(a);
    free(b);
    end(&f);
}

// Every kind of change, one after the other, against one made afresh.
static void updates(void)
{
    static const struct {
        const char *what;
        size_t at;
        float to;
    } edits[] = {
        {"fibre", offsetof(struct params, fibre.eta), 1.3f},
        {"axis", offsetof(struct params, fibre.a), 0.9f},
        {"sky", offsetof(struct params, light.yaw), 30},
        {"tint", offsetof(struct params, tint.exposure), 1},
        {"sun", offsetof(struct params, sun2.strength), 3},
        {"hair", offsetof(struct params, hair.diameter), 1.1f},
    };
    struct fixture f = plain();
    struct error err = {0};
    check_case("reference: brought up to date is made anew");
    begin(&f, lock(true), scene_two_lamps(), 10);
    for (size_t k = 0; k < sizeof edits / sizeof edits[0]; k++) {
        struct reference_estimate *before = paths(&f, 8, 1), *a, *b;
        memcpy((char *)&f.p + edits[k].at, &edits[k].to, sizeof(float));
        renderer_set_params(f.r, &f.p);
        CHECK(renderer_reference_update(f.r, FIBRE_EXACT, f.s, &err));
        a = paths(&f, 8, 1);
        reference_destroy(f.s);
        f.s = renderer_reference(f.r, FIBRE_EXACT, &err);
        b = paths(&f, 8, 1);
        CHECK(memcmp(a, b, f.count * sizeof *a) == 0);
        if (!CHECK(memcmp(a, before, f.count * sizeof *a) != 0))
            printf("  %s\n", edits[k].what);
        free(a);
        free(b);
        free(before);
    }
    end(&f);
}

// --- pictures ---------------------------------------------------------------

static void picture(void)
{
    enum { PIXELS = 96 * 64, N = 4 * PIXELS };
    struct fixture f = plain();
    struct error err = {0};
    int made;
    check_case("picture: covers what the picture covers");
    f.p.quality.samples = 64;
    f.r = scene_renderer(lock(true), scene_two_lamps(), &f.p);
    struct buf linear = scene_linear(f.r);
    f.s = renderer_reference(f.r, FIBRE_EXACT, &err);
    float *x = bytes_alloc(4 * N * sizeof *x);
    float *y = x + N, *vx = y + N, *vy = vx + N;
    struct reference_paths how = {.samples = 16, .seed = 1};
    CHECK(reference_picture(f.s, &how, x, vx, &made, &err) && made == 16);
    how.seed = 2;
    CHECK(reference_picture(f.s, &how, y, vy, &made, &err));
    const float *r = (const float *)(const void *)linear.data;
    double mine = 0, theirs = 0, apart = 0, chi = 0, n = 0;
    for (int i = 3; i < N; i += 4) {
        mine += (double)(x[i] + y[i]) / 2;
        theirs += (double)r[i];
        apart += fabs((double)(x[i] + y[i]) / 2 - (double)r[i]);
    }
    // measured: 1.0006 and .009; four times and more
    CHECK_NEAR(mine / theirs, 1, 5e-3);
    CHECK_ATMOST(apart / theirs, 0.04);

    check_case("picture: its variance is that of another seed's picture");
    for (int i = 0; i < N; i++)
        if (vx[i] > 1e-4f && vy[i] > 1e-4f && i % 4 < 3) {
            const double d = (double)(x[i] - y[i]);
            chi += d * d / (double)(vx[i] + vy[i]);
            n++;
        }
    // R2 within a pixel leaves less than independent samples would have;
    // estimates of a variance from 16 draws are themselves rough
    CHECK(n > 500 && chi / n > 0.5 && chi / n < 1.5);

    check_case("picture: too many paths are refused");
    how.samples = 65536;
    CHECK(!reference_picture(f.s, &how, x, vx, &made, &err));
    CHECK_STR(err.code, "limit");
    free(x);
    buf_finish(&linear);
    end(&f);
}

// Of three strands two stand in one place and let everything pass: a ray goes
// through both of them and does not stay between.
static void coincident(void)
{
    check_case("transparent strands in one place let paths pass");
    struct fixture f = plain();
    struct groom *g = lock(false);
    g->opacity = bytes_alloc(g->points * sizeof *g->opacity);
    for (uint32_t i = 0; i < g->points; i++)
        g->opacity[i] = i / 12 % 3 == 2;
    for (uint32_t k = 0; k < g->strands; k += 3)
        memcpy(g->position + 36 * (k + 1), g->position + 36 * k,
               36 * sizeof *g->position);
    f.p.hair.use_opacity = true;
    begin(&f, g, scene_two_lamps(), 40);
    alarm(60); // it never ended
    struct reference_estimate *e = paths(&f, 64, 3);
    alarm(0);
    for (size_t i = 0; i < f.count; i++)
        CHECK(e[i].events >= 1);
    free(e);
    end(&f);
}

int main(void)
{
    places();
    once();
    coincident();
    even_sky();
    furnace();
    running();
    updates();
    picture();
    return check_end();
}
