// Shadows in whole pictures: what memory allows decides how, never what.
#include "tests/check.h"
#include "tests/render/scene.h"

#include <stdlib.h>

static void base(struct params *p)
{
    scene_shadowed(p, 2, 1, 40);
}

static const struct renderer_left_out *left_out(const struct renderer_stats *s,
                                                const char *what)
{
    for (int i = 0; i < s->left_out_count; i++)
        if (strcmp(s->left_out[i].what, what) == 0)
            return &s->left_out[i];
    return NULL;
}

// Strands so wide that the lists of what is near each voxel are longer than the
// least memory.
static void no_room_for_lists(void)
{
    struct params p;
    struct renderer_stats s;
    base(&p);
    p.hair.diameter = 30;
    p.shadow.memory_mb = 16;
    check_case("rays without room for their lists: the smooth field, reported");
    struct renderer *r =
        scene_renderer(scene_lock(40, 10), scene_two_lamps(), &p);
    struct buf with = scene_linear(r);
    renderer_stats(r, &s);
    const struct renderer_left_out *l = left_out(&s, "shadow_rays");
    CHECK(l && l->bound == 1 && strstr(l->why, "memory_mb"));
    CHECK(!s.refined && s.samples == 2);
    p.shadow.rays = 0;
    renderer_set_params(r, &p);
    struct buf without = scene_linear(r);
    CHECK(scene_same(&with, &without));
    check_case("... and more room brings the rays");
    p.shadow.rays = 1;
    p.shadow.memory_mb = 512;
    renderer_set_params(r, &p);
    struct buf more = scene_linear(r);
    renderer_stats(r, &s);
    CHECK(s.refined && !left_out(&s, "shadow_rays"));
    CHECK(!scene_same(&more, &without));
    buf_finish(&with);
    buf_finish(&without);
    buf_finish(&more);
    renderer_destroy(r);
}

// More places and lights than the store of transmittances holds: rays work on a
// part after the other.
static void parts(void)
{
    struct params p;
    base(&p);
    p.hair.diameter = 0.05f;
    p.image.width = 384;
    p.image.height = 256;
    p.sky.lights = 40;
    p.quality.samples = 1;
    p.quality.light_bound = 0;
    p.render.path = 0; // memory decides how fine tables of lights are
    struct buf b[2];
    check_case("memory for transmittances does not change what rays find");
    for (int i = 0; i < 2; i++) {
        struct renderer_stats s;
        p.quality.cache_mb = i ? 16 : 1024;
        struct renderer *r =
            scene_renderer(scene_lock(3000, 10), scene_two_lamps(), &p);
        b[i] = scene_linear(r);
        renderer_stats(r, &s);
        // 8 bytes each, and half of cache_mb for them
        CHECK(s.visible_points * (uint32_t)s.lights_used > 1u << 20);
        CHECK(s.refined && !left_out(&s, "shadow_rays"));
        renderer_destroy(r);
    }
    CHECK(scene_same(&b[0], &b[1]));
    buf_finish(&b[0]);
    buf_finish(&b[1]);
}

static struct buf fresh(const struct params *p)
{
    struct renderer *r =
        scene_renderer(scene_lock(400, 10), scene_two_lamps(), p);
    struct buf b = scene_linear(r);
    renderer_destroy(r);
    return b;
}

enum { OFF, CROSSINGS, MAP, METHODS };

static void as_much(const struct buf want[METHODS])
{
    check_case("depth maps take away about as much light as the field");
    const double off = scene_sum(&want[OFF], 1);
    const double field = scene_sum(&want[CROSSINGS], 1);
    const double map = scene_sum(&want[MAP], 1);
    printf("  light that is left: %.3f, %.3f by the field; they differ by "
           "%.3f\n",
           map / off, field / off,
           scene_difference(&want[MAP], &want[CROSSINGS]));
    CHECK(map < off && field < off);
    // Measured: see the line above; T~ of either is off by up to .1 a place.
    CHECK_NEAR(map / off, field / off, 0.05);
    CHECK_ATMOST(scene_difference(&want[MAP], &want[CROSSINGS]), 0.2);
}

static void map_edits(struct renderer *r, const struct params *p,
                      const struct buf *start)
{
    check_case("... and of light, fibre and the hair's width");
    for (int i = 0; i < 3; i++) {
        struct params q = *p;
        q.light.yaw = i == 0 ? 33 : 0;
        q.fibre.sigma_a[0] = i == 1 ? 2 : q.fibre.sigma_a[0];
        q.hair.diameter = i == 2 ? 0.4f : q.hair.diameter;
        renderer_set_params(r, &q);
        struct buf edited = scene_linear(r), again = fresh(&q);
        CHECK(scene_same(&edited, &again));
        CHECK(!scene_same(&edited, start));
        buf_finish(&edited);
        buf_finish(&again);
    }
}

// Depth maps: another source of the same numbers.
static void maps(void)
{
    struct params p;
    struct buf want[METHODS];
    struct renderer_stats s;
    base(&p);
    p.shadow.rays = 0;
    for (int m = 0; m < METHODS; m++) {
        p.shadow.method = m;
        want[m] = fresh(&p);
    }
    check_case("depth maps: edited = fresh, from and to the field");
    struct params other = p;
    other.shadow.method = CROSSINGS;
    other.light.yaw = 70;
    other.hair.diameter = 0.3f;
    other.camera.fov = 25;
    struct renderer *r =
        scene_renderer(scene_lock(400, 10), scene_two_lamps(), &other);
    scene_finish(r);
    static const int order[] = {MAP, CROSSINGS, MAP, OFF, MAP};
    for (int i = 0; i < 5; i++) {
        p.shadow.method = order[i];
        renderer_set_params(r, &p);
        struct buf edited = scene_linear(r);
        CHECK(scene_same(&edited, &want[order[i]]));
        buf_finish(&edited);
    }
    map_edits(r, &p, &want[MAP]);
    as_much(want);
    check_case("depth maps have no rays, and say so");
    p.shadow.method = MAP;
    p.shadow.rays = 4;
    renderer_set_params(r, &p);
    struct buf rays = scene_linear(r);
    renderer_stats(r, &s);
    const struct renderer_left_out *l = left_out(&s, "shadow_rays");
    CHECK(scene_same(&rays, &want[MAP]));
    CHECK(l && strstr(l->why, "map") && !s.refined);
    CHECK(s.shadow_directions == s.lights_used);
    buf_finish(&rays);
    for (int m = 0; m < METHODS; m++)
        buf_finish(&want[m]);
    renderer_destroy(r);
}

int main(int argc, char **argv)
{
    sky_helper_main(argc, argv);
    no_room_for_lists();
    parts();
    maps();
    return check_end();
}
