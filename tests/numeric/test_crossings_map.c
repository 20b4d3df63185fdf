// test_crossings_map.c - optical depth maps where a number can be written down.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "renderer/crossings_private.h"
#include "renderer/egl.h"
#include "tests/check.h"
#include "tests/numeric/crossings_scene.h"

static bool open_map(struct scene *s, struct groom *g, int resolution)
{
    struct error err = {0};
    const struct crossings_options o = {.resolution = resolution,
                                        .map = &s->strands};
    return scene_open(s, g, resolution) &&
           CHECK(crossings_build_grid(&s->crossings, g, &s->params, &o, &err));
}

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

// Parallel fibres along z, 300 x 300 / 16000 = 5.6 a unit of length across.
static void test_lattice(void)
{
    enum { PLACES = 60, AIMS = 20 };
    check_case("depth maps of a lattice of parallel fibres");
    struct scene s = {0};
    params_defaults(&s.params);
    static struct crossings_light light[AIMS];
    static struct crossings_place place[PLACES];
    static struct crossings_result r[PLACES * AIMS];
    uint64_t state = 4;
    for (int i = 0; i < AIMS; i++)
        light[i] = scene_light(&state, 0.2f);
    for (int i = 0; i < PLACES; i++)
        for (int c = 0; c < 3; c++)
            place[i].p[c] = 0.15f + 0.7f * (float)truth_uniform(&state);
    if (open_map(&s, scene_lattice(300, 1 / 16000.f), 64) &&
        scene_aim(&s, light, AIMS, CROSSINGS_FINE) &&
        scene_look(&s, 0, place, PLACES, AIMS, r)) {
        double clear = 0, bias = 0, forward = 0;
        int n = 0;
        for (int i = 0; i < PLACES * AIMS; i++) {
            const float *d = light[i % AIMS].direction;
            const double z = (double)d[2];
            double want =
                5.625 * sqrt(1 - z * z) * way_out(place[i / AIMS].p, d);
            const double got = -log(scene_node(&r[i], 0));
            const double far = -20 * log(scene_node(&r[i], 2));
            forward += fabs(far - want) / (PLACES * AIMS);
            clear += fabs(got - want) / (PLACES * AIMS);
            bias += (got - want) / (PLACES * AIMS);
            n += want > 1;
        }
        printf("  T~ off by %.3f (bias %+.3f) crossings, T_f by %.3f\n", clear,
               bias, forward);
        CHECK(n > PLACES * AIMS / 2);
        // Two cells of 1/60 (up to 1.7 times that, askew) are left out at the
        // start: .1 to .3.  A lobe of .2 ends at other distances than its
        // centre.  Measured: see the line above.
        CHECK_ATMOST(clear, 0.25);
        CHECK_ATMOST(fabs(bias), 0.2);
        CHECK_ATMOST(forward, 0.35);
    }
    scene_close(&s);
}

enum { STRANDS = 4000 };

static struct groom *sheet(void)
{
    struct groom *g = scene_tangle(STRANDS, 1e-4f);
    for (uint32_t i = 0; i < g->points; i++) {
        const uint32_t k = i / 12;
        float *p = g->position + 3 * (size_t)i;
        p[0] = 0.5f + 0.5f * (float)(k % 2000) / 2000;
        p[1] = (float)(i % 12) / 11;
        p[2] = k < 2000 ? 1 : 0.98f;
    }
    // two strands span the room
    memcpy(g->position, (float[3]){0, 0, 0}, 12);
    for (int c = 0; c < 3; c++) {
        g->box_min[c] = 0;
        g->box_max[c] = 1;
    }
    return g;
}

// A sheet of fibres over half of an empty room.  Under its edge a lobe sees as
// much of it as the box reaches: n = n_0 clamp(1/2 + x / (2 w), 0, 1), w =
// sqrt(3/2) lambda times the height.
static void test_kernel(void)
{
    enum { PLACES = 41, WIDTHS = 3 };
    check_case("depth maps: the kernel grows with lobe and distance");
    struct scene s = {0};
    params_defaults(&s.params);
    struct groom *g = sheet();
    const double depth = STRANDS * 1e-4 / 0.5; // crossings of the sheet
    struct crossings_light light[WIDTHS];
    struct crossings_place place[PLACES] = {{{0}, 0, {0}, 0}};
    static struct crossings_result r[PLACES * WIDTHS];
    for (int j = 0; j < WIDTHS; j++)
        light[j] = (struct crossings_light){
            {0, 0, 1}, (float[WIDTHS]){0.05f, 0.2f, 0.4f}[j], 0};
    for (int i = 0; i < PLACES; i++) {
        place[i].p[0] = 0.1f + 0.02f * (float)i;
        place[i].p[1] = 0.5f;
        place[i].p[2] = i % 2 ? 0.2f : 0.6f;
    }
    if (open_map(&s, g, 128) && scene_aim(&s, light, WIDTHS, CROSSINGS_FINE) &&
        scene_look(&s, 0, place, PLACES, WIDTHS, r)) {
        double worst = 0;
        for (int i = 0; i < PLACES * WIDTHS; i++) {
            const float *p = place[i / WIDTHS].p;
            const double lambda = (double)light[i % WIDTHS].lambda;
            const double w = sqrt(1.5) * lambda * (0.99 - (double)p[2]);
            const double x = ((double)p[0] - 0.5) / (2 * w);
            // beyond the room there is nothing
            const double end = (1 - (double)p[0]) / (2 * w);
            const double want = depth * fmax(0, fmin(0.5, x) + fmin(0.5, end));
            const double got = -log(scene_node(&r[i], 0));
            worst = fmax(worst, fabs(got - want) / depth);
        }
        // The sheet is all in the last layer, whose middle is up to 1/64 lower:
        // 4 % of the kernel at .6; cells are 1/191.
        CHECK_ATMOST(worst, 0.12);
    }
    scene_close(&s);
}

static void test_opacity(void)
{
    enum { PLACES = 30, AIMS = 8 };
    check_case("depth maps are weighted by opacity");
    struct scene s[2] = {{0}, {0}};
    struct crossings_light light[AIMS];
    struct crossings_place place[PLACES] = {{{0}, 0, {0}, 0}};
    static struct crossings_result r[2][PLACES * AIMS];
    uint64_t state = 6;
    double worst = 0, crossed = 0;
    for (int i = 0; i < AIMS; i++)
        light[i] = scene_light(&state, 0.05f);
    for (int k = 0; k < 2; k++) {
        struct groom *g = scene_tangle(3000, 0.004f);
        params_defaults(&s[k].params);
        s[k].params.hair.use_opacity = k;
        g->opacity = bytes_alloc(g->points * sizeof *g->opacity);
        for (uint32_t i = 0; i < g->points; i++)
            g->opacity[i] = 0.5f;
        for (int i = 0; i < PLACES; i++)
            memcpy(place[i].p, g->position + 3 * 12 * 31 * i, 12);
        CHECK(open_map(&s[k], g, 48) &&
              scene_aim(&s[k], light, AIMS, CROSSINGS_FINE) &&
              scene_look(&s[k], 0, place, PLACES, AIMS, r[k]));
    }
    for (int i = 0; i < PLACES * AIMS; i++) {
        const double whole = -log(scene_node(&r[0][i], 0));
        const double half = -log(scene_node(&r[1][i], 0));
        if (whole > 5) // a node has too few digits
            continue;
        worst = fmax(worst, fabs(whole - 2 * half));
        crossed += whole / (PLACES * AIMS);
    }
    CHECK(crossed > 0.1);
    CHECK_ATMOST(worst, 0.01); // of 16 bits near e^-5
    scene_close(&s[0]);
    scene_close(&s[1]);
}

// The head hides, and what was made before leaves no trace.
static void test_state(void)
{
    enum { PLACES = 64, LIGHTS = 6, OTHERS = 30 };
    check_case("depth maps: the same bits whatever was before");
    struct scene s = {0};
    struct error err = {0};
    params_defaults(&s.params);
    static struct crossings_place place[PLACES];
    static struct crossings_result fresh[PLACES * LIGHTS],
        used[PLACES * LIGHTS];
    struct crossings_light light[OTHERS];
    struct groom *g = scene_tangle(5000, 0.004f);
    uint64_t state = 21;
    for (int i = 0; i < OTHERS; i++)
        light[i] = scene_light(&state, truth_width[i % 4]);
    light[0] = (struct crossings_light){{1, 0, 0}, 0.05f, 0};
    g->head.present = true;
    for (int c = 0; c < 3; c++) {
        g->head.centre[c] = 0.5f;
        g->head.radius[c] = 0.2f;
    }
    if (!open_map(&s, g, 40))
        return;
    for (int i = 0; i < PLACES; i++)
        memcpy(place[i].p, g->position + 3 * 12 * 70 * i, 12);
    memcpy(place[0].p, (float[3]){0.1f, 0.5f, 0.5f}, 12);
    const struct crossings_options o[2] = {
        {.resolution = 40}, {.resolution = 40, .map = &s.strands}};
    scene_aim(&s, light, LIGHTS, CROSSINGS_FINE);
    CHECK(s.crossings.tensor[0] == 0 && s.crossings.stats.grid_bytes == 0);
    scene_look(&s, 0, place, PLACES, LIGHTS, fresh);
    CHECK(crossings_build_grid(&s.crossings, g, &s.params, &o[0], &err));
    CHECK(s.crossings.map.texture == 0 && s.crossings.stats.map_bytes == 0);
    scene_aim(&s, light, OTHERS, CROSSINGS_FINE);
    CHECK(crossings_build_grid(&s.crossings, g, &s.params, &o[1], &err));
    scene_aim(&s, light, OTHERS, CROSSINGS_FINE);
    scene_aim(&s, light, LIGHTS, CROSSINGS_COARSE);
    scene_look(&s, 0, place, PLACES, LIGHTS, used);
    int differ = 0, wrong = 0;
    for (int i = 0; i < PLACES * LIGHTS; i++) {
        differ += memcmp(fresh[i].nodes, used[i].nodes, 8) != 0;
        for (int k = 0; k < 3; k++)
            wrong += scene_node(&fresh[i], k) > scene_node(&fresh[i], k + 1);
    }
    CHECK(differ == 0 && wrong == 0);
    check_case("depth maps: the head hides what is behind it");
    CHECK(scene_node(&fresh[0], 3) == 0); // towards +x lies the head
    scene_close(&s);
}

static void test_budget(void)
{
    check_case("depth maps stay within their memory");
    struct scene s = {0};
    struct error err = {0};
    params_defaults(&s.params);
    struct crossings_light light[CROSSINGS_LIGHTS_MAX];
    uint64_t state = 5;
    for (int i = 0; i < CROSSINGS_LIGHTS_MAX; i++)
        light[i] = scene_light(&state, 0.3f);
    if (!open_map(&s, scene_tangle(300, 0.004f), 192))
        return;
    const uint64_t budget = 16u << 20; // the least of shadow.memory_mb
    const struct crossings_options o = {
        .resolution = 192, .budget = budget, .map = &s.strands};
    for (int n = 1; n <= CROSSINGS_LIGHTS_MAX; n += 66) {
        CHECK(crossings_build_grid(&s.crossings, s.groom, &s.params, &o, &err));
        CHECK(crossings_update(&s.crossings, light, n, CROSSINGS_FINE, &err));
        struct crossings_stats st;
        crossings_read_stats(&s.crossings, &st);
        CHECK(st.lights == n && st.map_bytes + st.ways_bytes <= budget);
    }
    scene_close(&s);
}

int main(void)
{
    struct error err = {0};
    struct egl *egl = egl_create(&err);
    if (!egl) {
        check_case("crossings_map");
        check_skip(err.text);
        return check_end();
    }
    test_lattice();
    test_kernel();
    test_opacity();
    test_state();
    test_budget();
    egl_destroy(egl);
    return check_end();
}
