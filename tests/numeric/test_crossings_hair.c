// test_crossings_hair.c - transmittances of real hair against rays.  Larger
// tables: tests/bench/bench_crossings.c.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "renderer/egl.h"
#include "tests/check.h"
#include "tests/numeric/crossings_scene.h"

static const char hard[] = "builtin:animation"; // dense, seen from outside

struct sample { // of the three grooms
    double clear, forward, sky;
    int grooms;
};

// The other source of transmittances.
static void check_maps(struct scene *s, const struct truth *t,
                       struct crossings_result *r)
{
    struct error err = {0};
    const struct crossings_options maps = {.resolution = 96,
                                           .map = &s->strands};
    CHECK(
        crossings_build_grid(&s->crossings, s->groom, &s->params, &maps, &err));
    scene_aim(s, t->light, TRUTH_LIGHTS, CROSSINGS_COARSE);
    scene_look(s, 0, t->place, t->places, TRUTH_LIGHTS, r);
    const struct truth_errors e = truth_compare(t, r);
    printf("  %s, depth maps: T~ %.3f (bias %+.3f), T_f(.6) %.3f, mean of 12 "
           "lights %.3f\n",
           s->groom->name, e.clear, e.bias, e.forward[1], e.sky);
    // measured .11 at most, bias -.05: the method's own, not rounding
    CHECK_ATMOST(e.clear, 0.14);
    CHECK_ATMOST(fabs(e.bias), 0.07);
}

// T~ etc. of 24 seen and 24 hidden places, 12 aims, 4 widths.
static void check_hair(const char *source, float diameter, struct sample *sum,
                       struct sample *sum_rays)
{
    struct scene s = {0};
    struct truth t = {0};
    struct error err = {0};
    params_defaults(&s.params);
    s.params.hair.diameter = diameter;
    struct groom *g = groom_open(source, &err);
    if (!g) {
        printf("  %s\n", err.text);
        CHECK(g);
        return;
    }
    struct shoot *shoot = shoot_create(g, &s.params, &err);
    truth_make(&t, g, shoot, 24, 64);
    shoot_destroy(shoot);
    struct crossings_result *r =
        bytes_zalloc((size_t)t.places * TRUTH_LIGHTS, sizeof *r);
    if (scene_open(&s, g, 96) &&
        CHECK(crossings_build_lists(&s.crossings, g, &s.params, &err)) &&
        scene_aim(&s, t.light, TRUTH_LIGHTS, CROSSINGS_COARSE))
        for (int rays = 0; rays <= 16; rays += 16) {
            scene_look(&s, rays, t.place, t.places, TRUTH_LIGHTS, r);
            const struct truth_errors e = truth_compare(&t, r);
            struct sample *to = rays ? sum_rays : sum;
            printf("  %s, %2d rays: T~ %.3f (bias %+.3f), T_f(.6) %.3f, mean "
                   "of 12 lights %.3f\n",
                   g->name, rays, e.clear, e.bias, e.forward[1], e.sky);
            // .08 and .045 over 400 places; 48 places vary by a sixth, 64 rays
            // of truth add their own .01 to .04; bias .025 at most
            CHECK_ATMOST(e.clear, rays ? 0.065 : 0.095);
            CHECK_ATMOST(fabs(e.bias), 0.045);
            if (strcmp(source, hard) == 0 && rays == 0) {
                // measured .078, .071 and .061: worse by a third at most
                CHECK_ATMOST(e.clear, 0.1);
                CHECK_ATMOST(e.forward[1], 0.095);
                CHECK_ATMOST(e.sky, 0.08);
            }
            to->clear += e.clear / 3;
            to->forward += e.forward[1] / 3;
            to->sky += e.sky / 3;
            to->grooms++;
        }
    check_maps(&s, &t, r);
    free(r);
    truth_free(&t);
    scene_close(&s);
}

static void test_hair(void)
{
    const char *data = getenv("GLINT_DATA");
    char straight[512], curls[512];
    struct sample sum = {0}, rays = {0};
    data = data ? data : "../shared/data";
    snprintf(straight, sizeof straight, "%s/hair/straight.hair", data);
    snprintf(curls, sizeof curls, "%s/hair/amd_testhair1.hair", data);
    check_case("crossings of builtin:animation against rays");
    check_hair(hard, 0, &sum, &rays);
    check_case("crossings of hair files against rays");
    FILE *there = fopen(straight, "rb");
    if (!there) {
        check_skip("no data (GLINT_DATA)");
        return;
    }
    fclose(there);
    check_hair(straight, 0.1f, &sum, &rays);
    check_hair(curls, 0.2f, &sum, &rays);
    CHECK_ATMOST(sum.clear, 0.07);
    CHECK_ATMOST(sum.forward, 0.055);
    CHECK_ATMOST(sum.sky, 0.05);
    CHECK_ATMOST(rays.clear, 0.04);
    CHECK_ATMOST(rays.forward, 0.035);
    CHECK_ATMOST(rays.sky, 0.022);
}

int main(void)
{
    struct error err = {0};
    struct egl *egl = egl_create(&err);
    if (!egl) {
        check_case("crossings_hair");
        check_skip(err.text);
        return check_end();
    }
    test_hair();
    egl_destroy(egl);
    return check_end();
}
