// What the light does to a picture: modes add up, turning the sky is turning
// the hair, and what is left out stays within its stated bound.
#include "tests/check.h"
#include "tests/render/scene.h"

#include <stdlib.h>

static void base(struct params *p)
{
    scene_shadowed(p, 4, 1, 40);
    p->quality.light_bound = p->quality.group_deg = 0;
}

static struct buf picture(const struct params *p)
{
    struct renderer *r =
        scene_renderer(scene_lock(50, 14), scene_two_lamps(), p);
    struct buf b = scene_linear(r);
    renderer_destroy(r);
    return b;
}

static float *floats(const struct buf *b)
{
    return (float *)(void *)b->data;
}

// Sum of pictures of the given words of render.components, against another.
static double parts(struct params *p, const int *words, int count,
                    const struct buf *whole)
{
    struct buf sum = {0};
    buf_append(&sum, whole->data, whole->size);
    memset(sum.data, 0, sum.size);
    for (int m = 0; m < count; m++) {
        p->render.components = words[m];
        struct buf part = picture(p);
        CHECK(scene_sum(&part, 1) > 0.005 * scene_sum(whole, 1));
        for (size_t i = 0; i < sum.size / 4; i++)
            floats(&sum)[i] += floats(&part)[i];
        buf_finish(&part);
    }
    double difference = scene_difference(&sum, whole);
    buf_finish(&sum);
    return difference;
}

static void components(void)
{
    enum { ALL, R, TT, TRT, SINGLE, GLOBAL, LOCAL };
    struct params p;
    base(&p);
    p.fibre.sigma_a[2] = 0.05f;
    struct buf all = picture(&p);
    check_case("single + global + local = all from tables, to their error");
    // parts are read mode by mode, all of it from cells of each light: .0097
    // of these few lights; 1.5 times that
    CHECK_ATMOST(parts(&p, (int[]){SINGLE, GLOBAL, LOCAL}, 3, &all), 0.015);
    check_case("single + global + local = all, to 1e-6 of the sum");
    p.render.path = 0;
    p.render.components = ALL;
    buf_finish(&all);
    all = picture(&p);
    CHECK_ATMOST(parts(&p, (int[]){SINGLE, GLOBAL, LOCAL}, 3, &all), 1e-6);
    check_case("R + TT + TRT = single, to 1e-6 of the sum");
    p.render.components = SINGLE;
    struct buf single = picture(&p);
    CHECK_ATMOST(parts(&p, (int[]){R, TT, TRT}, 3, &single), 1e-6);
    check_case("multiple scattering adds light, but not much to black hair");
    CHECK(scene_sum(&all, 0) > 1.05 * scene_sum(&single, 0));
    for (int c = 0; c < 3; c++)
        p.fibre.sigma_a[c] = 4;
    p.render.components = SINGLE;
    struct buf black = picture(&p);
    p.render.components = ALL;
    struct buf both = picture(&p);
    CHECK(scene_sum(&both, 0) >= scene_sum(&black, 0));
    CHECK(scene_sum(&both, 0) < 1.1 * scene_sum(&black, 0));
    buf_finish(&all);
    buf_finish(&single);
    buf_finish(&black);
    buf_finish(&both);
}

// A groom without a head turned by 40 degrees about z under a sky turned by the
// same, seen by a turned camera: the same picture, but for pixels at which the
// raster of turned floats decides otherwise, about one in a thousand.
// With shadows the voxels stay where they are while the hair turns in them, so
// the pictures differ by what such a coarse field is wrong.
static void turning(bool shadows)
{
    check_case(shadows ? "... with shadows, to their error"
                       : "turning sky, hair and camera together changes "
                         "nothing");
    struct params p;
    base(&p);
    p.shadow.method = shadows;
    struct buf b[2];
    for (int turned = 0; turned < 2; turned++) {
        struct groom *g = scene_lock(50, 14);
        g->head.present = false;
        if (turned) {
            const float a = 40 * (float)M_PI / 180, y = p.camera.eye[1];
            scene_turn(g, 40);
            p.light.yaw = 40;
            p.camera.eye[0] = -sinf(a) * y;
            p.camera.eye[1] = cosf(a) * y;
        }
        struct renderer *r = scene_renderer(g, scene_two_lamps(), &p);
        b[turned] = scene_linear(r);
        renderer_destroy(r);
    }
    CHECK_ATMOST(scene_difference(&b[1], &b[0]), shadows ? 0.15 : 0.02);
    CHECK_NEAR(scene_sum(&b[1], 1) / scene_sum(&b[0], 1), 1,
               shadows ? 0.03 : 0.002);
    check_case("turning the sky alone changes the picture");
    p.light.yaw = 130;
    p.camera.eye[0] = 0;
    struct buf other = picture(&p);
    CHECK(scene_difference(&other, &b[0]) > 0.2);
    buf_finish(&b[0]);
    buf_finish(&b[1]);
    buf_finish(&other);
}

// The fit of a constant sky is constant to its predicted error (a few per mille
// at 40 lights), so turning it may change shading by about that.
static void constant_sky(void)
{
    check_case("a constant sky may be turned");
    struct params p;
    base(&p);
    p.sky.lights = 40;
    p.shadow.method = 0; // its directions have an error of their own
    struct buf b[2];
    for (int i = 0; i < 2; i++) {
        p.light.yaw = i ? 77 : 0;
        p.light.pitch = i ? -35 : 0;
        struct renderer *r =
            scene_renderer(scene_lock(50, 14), scene_constant_sky(0.7f), &p);
        b[i] = scene_linear(r);
        renderer_destroy(r);
    }
    CHECK_ATMOST(scene_difference(&b[1], &b[0]), 0.01);
    buf_finish(&b[0]);
    buf_finish(&b[1]);
}

static void exposure(void)
{
    check_case("a stop of light is a factor of two");
    struct params p;
    base(&p);
    struct buf one = picture(&p);
    p.tint.exposure = 1;
    struct buf two = picture(&p);
    for (size_t i = 0; i < one.size / 4; i++)
        if (i % 4 != 3)
            floats(&one)[i] *= 2;
    CHECK_ATMOST(scene_difference(&two, &one), 1e-6); // powers of two
    buf_finish(&one);
    buf_finish(&two);
}

static double bound_of(const struct renderer_stats *s, const char *what)
{
    for (int i = 0; i < s->left_out_count; i++)
        if (strcmp(s->left_out[i].what, what) == 0)
            return s->left_out[i].bound;
    return -1;
}

static const char *why_of(const struct renderer_stats *s, const char *what)
{
    for (int i = 0; i < s->left_out_count; i++)
        if (strcmp(s->left_out[i].what, what) == 0)
            return s->left_out[i].why;
    return "";
}

static struct buf with_stats(const struct params *p, struct renderer_stats *s)
{
    struct renderer *r =
        scene_renderer(scene_lock(50, 14), scene_two_lamps(), p);
    struct buf b = scene_linear(r);
    renderer_stats(r, s);
    renderer_destroy(r);
    return b;
}

static void left_out(void)
{
    struct params p;
    struct renderer_stats s, t;
    base(&p);
    p.render.path = 0; // tables know no eccentricity
    check_case("a circular fibre runs no eccentricity, and loses nothing");
    struct buf circular = with_stats(&p, &s);
    p.fibre.a = 1.000001f; // the eccentric program at a circle
    struct buf eccentric = with_stats(&p, &t);
    CHECK_NEAR(bound_of(&s, "eccentricity"), 0, 0);
    CHECK(bound_of(&t, "eccentricity") < 0);
    // eta* differs from eta by 4e-6, through tables in single precision
    CHECK_ATMOST(scene_difference(&circular, &eccentric), 1e-4);
    buf_finish(&circular);
    buf_finish(&eccentric);

    check_case("an opaque fibre runs no TT and TRT, within the stated bound");
    base(&p);
    p.render.path = 0; // cells of tables share their curvature among channels
    for (int c = 0; c < 3; c++)
        p.fibre.sigma_a[c] = 8.5f;
    struct buf opaque = with_stats(&p, &s);
    p.fibre.sigma_a[2] = 3; // one channel lets light through: nothing is left
    struct buf partly = with_stats(&p, &t);
    CHECK(bound_of(&s, "tt_trt") > 0 && bound_of(&s, "tt_trt") <= 1e-4);
    CHECK(bound_of(&t, "tt_trt") < 0);
    // red is as opaque in both; in the second TT and TRT are computed
    CHECK_ATMOST(fabs(scene_sum(&partly, 0) / scene_sum(&opaque, 0) - 1),
                 bound_of(&s, "tt_trt"));
    buf_finish(&opaque);
    buf_finish(&partly);
}

static void lights(void)
{
    struct params p;
    struct renderer_stats s, t;
    base(&p);
    p.sky.lights = 60;
    struct buf all = with_stats(&p, &s);
    check_case("no bound, no light dropped");
    CHECK(s.lights_used == s.lights_fitted && bound_of(&s, "lights") < 0);
    check_case("dropped lights hold at most the bound, and change the picture "
               "by about as much");
    p.quality.light_bound = 0.05f;
    struct buf few = with_stats(&p, &t);
    double share = bound_of(&t, "lights");
    CHECK(t.lights_used < s.lights_used);
    CHECK(share > 0 && share <= 0.05);
    // The bound is a share of the sky's light; a fibre sees a light through
    // its lobes, which weigh directions by a factor of a few.
    CHECK_ATMOST(scene_difference(&few, &all), 3 * share);
    check_case("suns are none of the lights that are dropped or not");
    p.sun1.strength = p.sun2.strength = p.sun3.strength = 1;
    struct renderer_stats sunny_stats;
    struct buf with_suns = with_stats(&p, &sunny_stats);
    CHECK(sunny_stats.lights_used == t.lights_used + 3);
    CHECK(strcmp(why_of(&sunny_stats, "lights"), why_of(&t, "lights")) == 0);
    buf_finish(&with_suns);
    buf_finish(&all);
    buf_finish(&few);
}

static void darkness(void)
{
    struct params p;
    check_case("a black sky is a black picture");
    base(&p);
    struct renderer *r =
        scene_renderer(scene_lock(50, 14), scene_constant_sky(0), &p);
    struct buf black = scene_linear(r);
    CHECK_NEAR(scene_sum(&black, 0) + scene_sum(&black, 2), 0, 0);
    CHECK(scene_sum(&black, 3) > 0);
    check_case("the first light of all brings shadows with it, the last takes "
               "them away");
    p.sun1.strength = 1;
    renderer_set_params(r, &p);
    struct buf edited = scene_linear(r);
    struct renderer *fresh =
        scene_renderer(scene_lock(50, 14), scene_constant_sky(0), &p);
    struct buf sunny = scene_linear(fresh);
    CHECK(scene_same(&edited, &sunny));
    p.shadow.method = 0;
    renderer_set_params(fresh, &p);
    struct buf open = scene_linear(fresh);
    CHECK(!scene_same(&edited, &open)); // else nothing was tested
    p.shadow.method = 1;
    p.sun1.strength = 0;
    renderer_set_params(r, &p);
    struct buf again = scene_linear(r);
    CHECK(scene_same(&again, &black));
    buf_finish(&black);
    buf_finish(&edited);
    buf_finish(&sunny);
    buf_finish(&open);
    buf_finish(&again);
    renderer_destroy(fresh);
    renderer_destroy(r);
}

// The extremes of every fibre parameter, one at a time and all together.
static void extremes(void)
{
    check_case("no extreme of a fibre parameter gives NaN or a negative");
    for (int i = 0; i < params_row_count; i++) {
        const struct params_row *row = &params_rows[i];
        if (row->group != GROUP_fibre)
            continue;
        for (int high = 0; high < 2; high++) {
            struct params p;
            base(&p);
            p.quality.samples = 1;
            for (int c = 0; c < row->count; c++)
                params_put(&p, row, c, high ? row->max : row->min);
            struct buf b = picture(&p);
            for (size_t k = 0; k < b.size / 4; k++)
                if (!(floats(&b)[k] >= 0) || isinf(floats(&b)[k])) {
                    printf("  fibre.%s = %g: %g\n", row->name,
                           high ? row->max : row->min, (double)floats(&b)[k]);
                    CHECK(false);
                    break;
                }
            buf_finish(&b);
        }
    }
}

int main(int argc, char **argv)
{
    sky_helper_main(argc, argv);
    components();
    turning(false);
    turning(true);
    constant_sky();
    exposure();
    left_out();
    lights();
    darkness();
    extremes();
    return check_end();
}
