// test_crossings.c - the shadows' field of crossings, run on the GPU, where a
// number can be written down.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "renderer/crossings_private.h"
#include "renderer/egl.h"
#include "renderer/lights.h"
#include "tests/check.h"
#include "tests/numeric/crossings_scene.h"

// --- directions --------------------------------------------------------------

static void test_ways(void)
{
    check_case("crossings directions stand for the lobe");
    uint64_t state = 3;
    for (int i = 0; i < 300; i++) {
        struct crossings_light l = scene_light(
            &state, (float)pow(10, 1.3 * truth_uniform(&state) - 1));
        const int n = crossings_ways_count(&l, CROSSINGS_FINE);
        const double kappa = 2 / ((double)l.lambda * (double)l.lambda);
        const double want = 1 / tanh(kappa) - 1 / kappa; // mean cosine
        double mean[3] = {0};
        for (int k = 0; k < n; k++) {
            float d[3];
            crossings_ways_direction(&l, k, n, d);
            double dd = 0;
            for (int c = 0; c < 3; c++) {
                mean[c] += (double)d[c] / n;
                dd += (double)d[c] * (double)d[c];
            }
            CHECK_NEAR(dd, 1, 1e-6);
        }
        double along = 0, all = 0;
        for (int c = 0; c < 3; c++) {
            along += mean[c] * (double)l.direction[c];
            all += mean[c] * mean[c];
        }
        // One direction ignores the width (at most lambda^2 / 2 = .0128).  Two
        // rings at the middle of their shares are nearer to the axis than the
        // lobe's mean, by .163 lambda^2 / 2 = .046 at lambda = .75; one by
        // .307 lambda^2 / 2 = .025 at .4; four by less.  Across the axis they
        // balance, to the root of single precision.
        CHECK_NEAR(along, want, n == 1 ? 0.013 : 0.047);
        CHECK_ATMOST(sqrt(fmax(0, all - along * along)), 1e-3);
    }
}

// Powers that fall by a third from light to light: which of them count as dim,
// and how many directions that leaves.
static void test_dim(void)
{
    enum { LIGHTS = 12 };
    check_case("dim lights have fewer directions");
    static struct sky_fit fit;
    static struct lights lights;
    struct params p;
    params_defaults(&p);
    p.quality.light_bound = 0;
    double power[LIGHTS], mean = 0;
    fit.count = LIGHTS;
    for (int j = 0; j < LIGHTS; j++) {
        power[j] = pow(2 / 3., j);
        mean += power[j] / LIGHTS;
        fit.light[j].direction[2] = 1;
        fit.light[j].lambda = 0.2 + 0.1 * (j % 3);
        for (int c = 0; c < 3; c++) // their mean is what counts
            fit.light[j].radiance[c] =
                c * power[j] / sky_lobe_omega(fit.light[j].lambda);
    }
    CHECK(lights_put(&lights, &fit, &p));
    CHECK(!lights_put(&lights, &fit, &p));
    int seen[3] = {0};
    for (int j = 0; j < LIGHTS; j++) {
        const double share = power[j] / mean;
        const int want = share < 1 / 16. ? 2 : share < 1 / 4. ? 1 : 0;
        CHECK(lights.place[j].dim == want);
        seen[want]++;
    }
    CHECK(seen[0] > 0 && seen[1] > 0 && seen[2] > 0);
    // brighter by itself: new directions, though no light moved
    for (int c = 0; c < 3; c++)
        fit.light[LIGHTS - 1].radiance[c] *= 20;
    CHECK(lights_put(&lights, &fit, &p));
    static const float lambda[4] = {0.1f, 0.3f, 0.5f, 1};
    static const int ways[2][4][3] = {
        {{1, 1, 1}, {1, 1, 1}, {3, 1, 1}, {6, 3, 1}}, // coarse
        {{1, 1, 1}, {3, 1, 1}, {6, 3, 1}, {12, 6, 3}}};
    for (int i = 0; i < 24; i++) {
        const struct crossings_light l = {{0, 0, 1}, lambda[i / 3 % 4], i % 3};
        CHECK(crossings_ways_count(&l, (enum crossings_quality)(i / 12)) ==
              ways[i / 12][i / 3 % 4][i % 3]);
    }
}

// --- what can be written down ------------------------------------------------

// From p along d to where the unit cube ends.
static double way_out(const float p[3], const float d[3])
{
    double t = INFINITY;
    for (int c = 0; c < 3; c++)
        if (d[c] != 0) {
            double to = d[c] > 0 ? 1 - (double)p[c] : -(double)p[c];
            t = fmin(t, to / (double)d[c]);
        }
    return t;
}

static double expected(const struct scene *s, double rho, const float p[3],
                       const float d[3])
{
    const double z = (double)d[2];
    // a lookup begins at the voxel's side
    const double a = fmax(fabs((double)d[0]), fabs((double)d[1]));
    const double start = 0.5 * (double)s->crossings.voxel / fmax(a, fabs(z));
    return rho * sqrt(1 - z * z) * fmax(0, way_out(p, d) - start);
}

// Parallel fibres, 180 x 180 / 6000 = 5.4 a unit of length across them.
static void test_lattice(void)
{
    enum { PLACES = 40, AIMS = 40 };
    check_case("crossings of a lattice of parallel fibres");
    struct scene s = {0};
    params_defaults(&s.params);
    static struct crossings_light light[AIMS];
    static struct crossings_place place[PLACES];
    static struct crossings_result r[PLACES * AIMS];
    uint64_t state = 4;
    for (int i = 0; i < AIMS; i++)
        light[i] = scene_light(&state, 0);
    light[0] = (struct crossings_light){{0, 0, 1}, 0, 0}; // along the fibres
    for (int i = 0; i < PLACES; i++)
        for (int c = 0; c < 3; c++)
            place[i].p[c] = 0.1f + 0.8f * (float)truth_uniform(&state);
    if (scene_open(&s, scene_lattice(180, 1 / 6000.f), 64) &&
        scene_aim(&s, light, AIMS, CROSSINGS_FINE) &&
        scene_look(&s, 0, place, PLACES, AIMS, r)) {
        double off = 0, bias = 0, most = 0;
        for (int i = 0; i < PLACES * AIMS; i++) {
            const float *d = light[i % AIMS].direction;
            double want = expected(&s, 5.4, place[i / AIMS].p, d);
            double n = -20 * log(scene_node(&r[i], 2));
            off += fabs(n - want) / (PLACES * AIMS);
            bias += (n - want) / (PLACES * AIMS);
            most = fmax(most, fabs(n - want) / (want + 0.7));
        }
        // A byte resolves n to 5 / 255 / q(n), .02 to .06 here.  A side of a
        // voxel holds two or three fibres of the lattice, which is 15 % along
        // the worst lines and averages out over all.
        CHECK_ATMOST(off, 0.08);
        CHECK_ATMOST(fabs(bias), 0.04);
        CHECK_ATMOST(most, 0.17);
    }
    scene_close(&s);
}

// Half the opacity counts half.
static void test_opacity(void)
{
    enum { PLACES = 20, AIMS = 8 };
    check_case("crossings are weighted by opacity, in voxels and by rays");
    struct scene s[2] = {{0}, {0}};
    struct crossings_light light[AIMS];
    struct crossings_place place[PLACES] = {{{0}, 0, {0}, 0}};
    static struct crossings_result r[2][PLACES * AIMS];
    uint64_t state = 6;
    for (int i = 0; i < AIMS; i++)
        light[i] = scene_light(&state, 0.05f);
    for (int k = 0; k < 2; k++) {
        struct groom *g = scene_tangle(3000, 0.004f);
        params_defaults(&s[k].params);
        s[k].params.hair.use_opacity = k;
        g->opacity = bytes_alloc(g->points * sizeof *g->opacity);
        for (uint32_t i = 0; i < g->points; i++)
            g->opacity[i] = 0.5f;
        struct error err = {0};
        CHECK(scene_open(&s[k], g, 48) &&
              crossings_build_lists(&s[k].crossings, g, &s[k].params, &err) &&
              scene_aim(&s[k], light, AIMS, CROSSINGS_FINE));
    }
    for (int i = 0; i < PLACES; i++) {
        place[i].segment = (uint32_t)i * 12 * 31;
        memcpy(place[i].p, s[0].groom->position + 3 * place[i].segment, 12);
    }
    for (int rays = 0; rays <= 1; rays++) {
        double worst = 0;
        for (int k = 0; k < 2; k++)
            scene_look(&s[k], rays, place, PLACES, AIMS, r[k]);
        for (int i = 0; i < PLACES * AIMS; i++) {
            const double whole = -20 * log(scene_node(&r[0][i], 2));
            const double half = -20 * log(scene_node(&r[1][i], 2));
            // from three fibres on a ray stops: elsewhere in the two scenes
            if (rays == 0 || whole < 2.9)
                worst = fmax(worst, fabs(whole - 2 * half));
        }
        // bytes: .03 in n on either side, doubled on one; .95 and .975^2 of
        // two fibres: another .03
        CHECK_ATMOST(worst, 0.2);
    }
    scene_close(&s[0]);
    scene_close(&s[1]);
}

// Rays that reach through all of a sparse tangle count what exact ones count.
static void test_rays(void)
{
    enum { PLACES = 200, AIMS = 16 };
    check_case("rays count the very fibres that are there");
    struct scene s = {0};
    struct error err = {0};
    params_defaults(&s.params);
    static struct crossings_light light[AIMS];
    static struct crossings_place place[PLACES];
    static struct crossings_result r[PLACES * AIMS];
    uint64_t state = 8;
    for (int i = 0; i < AIMS; i++)
        light[i] = scene_light(&state, 0);
    light[0] = (struct crossings_light){{0, 1, 0}, 0, 0}; // along an axis
    if (!scene_open(&s, scene_tangle(400, 0.01f), 32) ||
        !CHECK(crossings_build_lists(&s.crossings, s.groom, &s.params, &err)))
        return;
    s.crossings.block->inverse[3] = 1e4f; // reach
    if (!scene_aim(&s, light, AIMS, CROSSINGS_FINE))
        return;
    struct shoot *truth = shoot_create(s.groom, &s.params, &err);
    for (int i = 0; i < PLACES; i++) {
        place[i].segment = truth_segment(s.groom, &state);
        struct shoot_point p;
        shoot_point(truth, place[i].segment, truth_uniform(&state), &p);
        for (int c = 0; c < 3; c++)
            place[i].p[c] = (float)p.position[c];
    }
    scene_look(&s, 1, place, PLACES, AIMS, r);
    int wrong = 0, met = 0;
    for (int i = 0; i < PLACES * AIMS; i++) {
        struct shoot_ray ray = {.reach = INFINITY,
                                .segment = place[i / AIMS].segment};
        for (int c = 0; c < 3; c++) {
            ray.origin[c] = (double)place[i / AIMS].p[c];
            ray.direction[c] = (double)light[i % AIMS].direction[c];
        }
        struct shoot_hit hit;
        shoot_ray(truth, &ray, &hit);
        const double n = log(scene_node(&r[i], 2)) / log(0.95);
        met += hit.crossings > 0;
        // three or more: what is left is the voxels' affair
        wrong += hit.crossings < 3 ? fabs(n - hit.crossings) > 0.01 : n < 2.5;
        wrong += r[i].clear != (hit.crossings > 0 ? 0.f : 1.f);
    }
    CHECK(met > PLACES * AIMS / 3);
    // single precision may tell a fibre's edge otherwise than double
    CHECK_ATMOST(wrong, PLACES * AIMS / 500);
    shoot_destroy(truth);
    scene_close(&s);
}

// --- the head ----------------------------------------------------------------

static void test_head(void)
{
    enum { PLACES = 150 };
    check_case("the head hides what is behind it");
    struct scene s = {0};
    struct truth t = {0};
    struct error err = {0};
    params_defaults(&s.params);
    struct groom *g = scene_tangle(400, 1e-5f); // too thin to hide anything
    g->head.present = true;
    for (int c = 0; c < 3; c++)
        g->head.centre[c] = 0.5f;
    memcpy(g->head.radius, (float[3]){0.3f, 0.35f, 0.4f}, 12);
    struct shoot *shoot = shoot_create(g, &s.params, &err);
    truth_make(&t, g, shoot, PLACES / 2, 256);
    shoot_destroy(shoot);
    struct crossings_result *r =
        bytes_zalloc((size_t)t.places * TRUTH_LIGHTS, sizeof *r);
    if (scene_open(&s, g, 32))
        for (int rays = 0; rays <= 16; rays += 16) {
            CHECK(crossings_build_lists(&s.crossings, g, &s.params, &err));
            scene_aim(&s, t.light, TRUTH_LIGHTS, CROSSINGS_FINE);
            scene_look(&s, rays, t.place, t.places, TRUTH_LIGHTS, r);
            const struct truth_errors e = truth_compare(&t, r);
            // 256 rays are right to .01 on average where the rim is in view
            CHECK_ATMOST(e.clear, rays ? 0.02 : 0.03);
            CHECK_ATMOST(fabs(e.bias), 0.01);
            // what passes meets nothing: all of it arrives, whatever a
            CHECK_NEAR(e.forward[3], e.clear, 2e-3);
        }
    free(r);
    truth_free(&t);
    scene_close(&s);
}

// --- state -------------------------------------------------------------------

// Nodes depend on the hair and the lights alone, not on what was before.
static void test_state(void)
{
    enum { PLACES = 64, LIGHTS = 5, OTHERS = 20 };
    check_case("crossings: the same bits whatever was before");
    struct scene s = {0};
    struct error err = {0};
    params_defaults(&s.params);
    static struct crossings_place place[PLACES];
    static struct crossings_result fresh[PLACES * LIGHTS],
        used[PLACES * LIGHTS];
    struct crossings_light light[OTHERS];
    uint64_t state = 21;
    for (int i = 0; i < OTHERS; i++)
        light[i] = scene_light(&state, truth_width[i % 4]);
    if (!scene_open(&s, scene_tangle(5000, 0.004f), 40) ||
        !CHECK(crossings_build_lists(&s.crossings, s.groom, &s.params, &err)))
        return;
    for (int i = 0; i < PLACES; i++) {
        place[i].segment = (uint32_t)i * 12 * 70;
        place[i].key = (uint32_t)i * 977;
        memcpy(place[i].p, s.groom->position + 3 * place[i].segment, 12);
    }
    for (int rays = 0; rays <= 4; rays += 4) {
        const struct crossings_options o = {.resolution = 40};
        CHECK(crossings_build_grid(&s.crossings, s.groom, &s.params, &o, &err));
        CHECK(crossings_build_lists(&s.crossings, s.groom, &s.params, &err));
        scene_aim(&s, light, LIGHTS, CROSSINGS_FINE);
        scene_look(&s, rays, place, PLACES, LIGHTS, fresh);
        scene_aim(&s, light, OTHERS, CROSSINGS_FINE);
        scene_aim(&s, light + 7, 9, CROSSINGS_COARSE);
        scene_aim(&s, light, LIGHTS, CROSSINGS_FINE);
        scene_look(&s, rays, place, PLACES, LIGHTS, used);
        int differ = 0, shaded = 0;
        for (int i = 0; i < PLACES * LIGHTS; i++) {
            differ += memcmp(fresh[i].nodes, used[i].nodes, 8) != 0;
            shaded += fresh[i].clear < 0.9f;
        }
        CHECK(differ == 0);
        CHECK(shaded > PLACES);
    }
    scene_close(&s);
}

static void test_budget(void)
{
    check_case("crossings stay within their memory, or say why not");
    struct scene s = {0};
    struct error err = {0};
    struct crossings_stats st;
    struct crossings_light light[CROSSINGS_LIGHTS_MAX];
    uint64_t state = 22;
    params_defaults(&s.params);
    for (int i = 0; i < CROSSINGS_LIGHTS_MAX; i++)
        light[i] = scene_light(&state, 1);
    struct crossings_options o = {.resolution = 96, .budget = 24 << 20};
    if (!scene_open(&s, scene_tangle(500, 0.01f), 96))
        return;
    CHECK(crossings_build_grid(&s.crossings, s.groom, &s.params, &o, &err));
    CHECK(crossings_update(&s.crossings, light, 40, CROSSINGS_FINE, &err));
    crossings_read_stats(&s.crossings, &st);
    CHECK(st.resolution < 96 && st.resolution >= CROSSINGS_RESOLUTION_MIN);
    CHECK(st.ways_per_light < 1 && st.ways >= 40);
    CHECK(st.grid_bytes + st.ways_bytes <= o.budget);
    CHECK(!crossings_update(&s.crossings, light, CROSSINGS_LIGHTS_MAX + 1,
                            CROSSINGS_FINE, &err));
    CHECK_STR(err.code, "limit");
    err = (struct error){0};
    CHECK(crossings_update(&s.crossings, light, 0, CROSSINGS_FINE, &err));
    CHECK(crossings_build_lists(&s.crossings, s.groom, &s.params, &err));
    crossings_read_stats(&s.crossings, &st);
    CHECK(st.lists_bytes <= o.budget && st.lists_bytes > 0);
    o.budget = 1 << 20;
    CHECK(!crossings_build_grid(&s.crossings, s.groom, &s.params, &o, &err));
    CHECK_STR(err.code, "limit");
    CHECK(strstr(err.text, "1048576") != NULL);
    // and after a failure it can be used again
    o.budget = 0;
    CHECK(crossings_build_grid(&s.crossings, s.groom, &s.params, &o, &err));
    CHECK(crossings_update(&s.crossings, light, 2, CROSSINGS_COARSE, &err));
    scene_close(&s);
}

int main(void)
{
    struct error err = {0};
    struct egl *egl = egl_create(&err);
    if (!egl) {
        check_case("crossings");
        check_skip(err.text);
        return check_end();
    }
    test_ways();
    test_dim();
    test_lattice();
    test_opacity();
    test_rays();
    test_head();
    test_state();
    test_budget();
    egl_destroy(egl);
    return check_end();
}
