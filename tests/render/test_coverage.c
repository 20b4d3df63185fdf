// Strand width, opacity and the head: what a pixel is covered by must be what
// geometry says, at both ends of the width.
#include "tests/check.h"
#include "tests/render/scene.h"

enum { STRANDS = 24 };
static const float LENGTH = 12;

// Coverage of the fan over its true area, strands of `width` pixels.
static double covered(float width, float opacity, int samples)
{
    struct params p;
    scene_params(&p);
    p.hair.diameter = width;
    p.quality.samples = samples;
    p.hair.use_opacity = opacity < 1;
    struct groom *g = opacity < 1 ? scene_fan_opacity(STRANDS, opacity)
                                  : scene_fan(STRANDS, 4, LENGTH, 14);
    struct renderer *r = scene_renderer(g, scene_constant_sky(1), &p);
    struct buf b = scene_linear(r);
    double share = scene_sum(&b, 3) / (STRANDS * (double)(LENGTH * width));
    buf_finish(&b);
    renderer_destroy(r);
    return share;
}

// Every strand is kept in its share of the 64 samples to within one, and ends
// of lines are cut to whole fragments: 24 strands average that to about
// 1 / (64 x width) and 1 / 12 pixel, so 5 % holds for .3 pixel and more.
static void widths(void)
{
    static const float width[] = {0.3f, 0.6f, 0.69f, 0.72f, 1, 2, 5};
    for (unsigned i = 0; i < sizeof width / sizeof *width; i++) {
        char name[64];
        snprintf(name, sizeof name, "a strand of %g pixels covers %g",
                 (double)width[i], (double)width[i]);
        check_case(name);
        CHECK_NEAR(covered(width[i], 1, 64), 1, 0.05);
    }
    check_case("a strand of 0.05 pixels covers 0.05");
    CHECK_NEAR(covered(0.05f, 1, 256), 1, 0.1); // 1 / (256 x .05) = 8 %
}

static void opacities(void)
{
    check_case("a thin strand of opacity 0.5 lets half through");
    CHECK_NEAR(covered(0.6f, 0.5f, 64), 0.5, 0.03);
    check_case("a wide strand of opacity 0.5 lets half through");
    CHECK_NEAR(covered(4, 0.5f, 64), 0.5, 0.03);
    check_case("opacity is ignored unless asked for");
    struct params p;
    scene_params(&p);
    p.hair.diameter = 4;
    struct renderer *r = scene_renderer(scene_fan_opacity(STRANDS, 0.5f),
                                        scene_constant_sky(1), &p);
    struct buf b = scene_linear(r);
    CHECK_NEAR(scene_sum(&b, 3) / (STRANDS * 12 * 4.0), 1, 0.05);
    buf_finish(&b);
    renderer_destroy(r);
}

// One vertical strand of 5 pixels through the middle: its profile.
static void profile(void)
{
    struct params p;
    scene_params(&p);
    p.hair.diameter = 5;
    p.quality.samples = 64;
    struct groom *g = scene_fan(1, 2, 40, 1);
    for (int i = 0; i < 2; i++) {
        g->position[3 * i] = 0;
        g->position[3 * i + 2] = i ? -20 : 20;
    }
    struct renderer *r = scene_renderer(g, scene_constant_sky(1), &p);
    struct buf b = scene_linear(r);
    const float *row = (const float *)(const void *)b.data + 4 * 96 * 32;
    check_case("a strand of 5 pixels is 5 pixels wide, edge to edge");
    for (int x = 0; x < 96; x++) { // edges at 45.5 and 50.5
        double want = x >= 46 && x <= 49 ? 1 : x == 45 || x == 50 ? 0.5 : 0;
        CHECK_NEAR(row[4 * x + 3], want, 0.04);
    }
    buf_finish(&b);
    renderer_destroy(r);
}

// Coverage of a fan shifted by `y` while a ball of radius 30 sits at the
// origin.
static double with_head(float y)
{
    struct params p;
    scene_params(&p);
    p.hair.diameter = 1;
    struct groom *g = scene_fan(6, 4, 6, 7);
    for (uint32_t i = 0; i < g->points; i++)
        g->position[3 * i + 1] = y;
    g->head.present = true;
    for (int c = 0; c < 3; c++)
        g->head.radius[c] = 30;
    struct renderer *r = scene_renderer(g, scene_constant_sky(1), &p);
    struct buf b = scene_linear(r);
    double sum = scene_sum(&b, 3);
    buf_finish(&b);
    renderer_destroy(r);
    return sum;
}

static void heads(void)
{
    check_case("hair behind the head is hidden");
    CHECK_NEAR(with_head(40), 0, 0);
    CHECK_NEAR(with_head(0), 0, 0); // inside it
    check_case("hair before the head is not");
    CHECK(with_head(-40) > 0.8 * 6 * 6);
}

static void eye_inside(void)
{
    check_case("an eye amid the hair gives a finite picture");
    struct params p;
    scene_params(&p);
    memcpy(p.camera.eye, (float[3]){1, 0.5f, 2}, 12);
    memcpy(p.camera.target, (float[3]){1, 3, -4}, 12);
    p.camera.fov = 110;
    p.hair.diameter = 0.5f;
    struct renderer *r =
        scene_renderer(scene_lock(60, 12), scene_two_lamps(), &p);
    struct buf b = scene_linear(r);
    for (size_t i = 0; i < b.size / 4; i++)
        if (!CHECK(isfinite(((const float *)(const void *)b.data)[i])))
            break;
    buf_finish(&b);
    renderer_destroy(r);
}

int main(int argc, char **argv)
{
    sky_helper_main(argc, argv);
    widths();
    opacities();
    profile();
    heads();
    eye_inside();
    return check_end();
}
