// What happens when the store of shaded cells is full: the list begins anew,
// and no edit after that may show it.
#include "tests/check.h"
#include "tests/render/scene.h"

#include <string.h>

#include "renderer/renderer_private.h"

static void crowd(struct params *p)
{
    scene_params(p);
    p->image.width = 48;
    p->image.height = 32;
    p->hair.diameter = 0.15f;
    p->sky.lights = 4;
    p->quality.samples = 96;
    p->quality.cache_mb = 16;
    p->shadow.method = 1;
    p->shadow.resolution = 32;
    p->shadow.rays = 0;
}

static struct renderer *renderer_of(const struct params *p)
{
    return scene_renderer(scene_lock(6000, 12), scene_two_lamps(), p);
}

static void full_store(void)
{
    struct params p;
    crowd(&p);
    check_case("an edit after the store of cells was full");
    struct renderer *r = renderer_of(&p);
    struct buf first = scene_linear(r), again;
    CHECK(r->picture.flushed); // else this shows nothing
    CHECK(r->picture.lost == 0);
    const float old = p.fibre.sigma_a[0];
    // many times, for a wrong order is only likely to be another one
    for (int i = 0; i < 12; i++) {
        p.fibre.sigma_a[0] = i % 2 ? old : old + 0.3f;
        renderer_set_params(r, &p);
        again = scene_linear(r);
        CHECK(scene_same(&again, &first) == (i % 2 == 1));
        buf_finish(&again);
    }
    renderer_destroy(r);
    r = renderer_of(&p);
    again = scene_linear(r);
    CHECK(scene_same(&again, &first));
    renderer_destroy(r);
    buf_finish(&first);
    buf_finish(&again);
}

// 65536 groups of 64 are one more than GL promises along an axis.
static void large(void)
{
    struct params p;
    struct error err = {0};
    bool done = false;
    scene_params(&p);
    p.image.width = p.image.height = 2048;
    p.quality.samples = 1;
    check_case("2048 x 2048 pixels");
    struct renderer *r =
        scene_renderer(scene_fan(9, 4, 400, 250), scene_constant_sky(1), &p);
    bool ok = renderer_step(r, &done, &err);
    if (!ok && strcmp(err.code, "limit") == 0) {
        check_skip("the device allows no such picture");
        renderer_destroy(r);
        return;
    }
    struct buf rgba = {0};
    CHECK(ok && done && renderer_read_linear(r, &rgba, &err));
    CHECK(scene_sum(&rgba, 3) > 100); // something of the strands is there
    CHECK(renderer_read_display(r, &rgba, &err));
    buf_finish(&rgba);
    renderer_destroy(r);
}

int main(void)
{
    full_store();
    large();
    return check_end();
}
