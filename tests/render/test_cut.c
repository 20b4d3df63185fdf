// Steps that are left in the middle: what is made afterwards is the same as if
// they had never been begun, what is shown in between is what was there, and
// every stage that takes long asks often.
#include "tests/check.h"
#include "tests/render/scene.h"

#include <stdatomic.h>
#include <string.h>

static atomic_int looks; // since the last step began
static int cut_at;       // 0: never

static bool newer(void *ctx)
{
    (void)ctx;
    return atomic_fetch_add(&looks, 1) + 1 >= cut_at && cut_at > 0;
}

static void base(struct params *p)
{
    scene_shadowed(p, 2, 1, 32);
}

static void fibre(struct params *p, int k)
{
    p->fibre.sigma_a[0] = 0.2f + 0.01f * (float)k;
}
static void camera(struct params *p, int k)
{
    p->camera.fov = 20 + 0.2f * (float)k;
}
static void sky(struct params *p, int k)
{
    p->light.yaw = 3 * (float)k;
}
static void lights(struct params *p, int k)
{
    p->sky.lights = 3 + k % 7;
}
static void hair(struct params *p, int k)
{
    p->hair.diameter = 0.6f + 0.01f * (float)k;
}
static void voxels(struct params *p, int k)
{
    p->shadow.resolution = 32 + 4 * (k % 3);
}
static void elliptic(struct params *p, int k)
{
    p->fibre.a = 0.9f + 0.01f * (float)(k % 9);
}
static void unshadowed(struct params *p, int k)
{
    p->shadow.method = k % 2;
}

static const struct edit {
    const char *name;
    void (*run)(struct params *p, int k);
    int most; // looks at least that a first picture of it takes
} edits[] = {
    {"fibre", fibre, 2},       {"camera", camera, 4},
    {"sky", sky, 30},          {"lights", lights, 10},
    {"hair", hair, 30},        {"voxels", voxels, 30},
    {"elliptic", elliptic, 2}, {"shadows", unshadowed, 1},
};
enum { EDITS = sizeof edits / sizeof edits[0] };

static struct renderer *fresh(const struct params *p)
{
    return scene_renderer(scene_lock(300, 8), scene_two_lamps(), p);
}

// Steps until the picture is final or a step was cut; true: cut.
static bool run(struct renderer *r, int at)
{
    struct error err = {0};
    bool done = false;
    cut_at = at;
    while (!done) {
        atomic_store(&looks, 0);
        renderer_watch(r, newer, NULL);
        CHECK(renderer_step(r, &done, &err));
        if (renderer_was_cut(r)) {
            CHECK(!done);
            return true;
        }
    }
    return false;
}

static void same_as_fresh(struct renderer *r, const struct params *p)
{
    renderer_watch(r, NULL, NULL);
    struct buf got = scene_linear(r);
    struct renderer *f = fresh(p);
    struct buf want = scene_linear(f);
    CHECK(scene_same(&got, &want));
    buf_finish(&got);
    buf_finish(&want);
    renderer_destroy(f);
}

// Wherever it is cut; now and then a draft and a rehearsal come between.
static void law(void)
{
    struct params p;
    struct error err = {0};
    struct renderer_draft how = {.divisor = 2, .stride = 2};
    double ms[RENDERER_STAGES];
    base(&p);
    struct renderer *r = fresh(&p);
    scene_finish(r);
    for (int e = 0; e < EDITS; e++) {
        char name[64];
        int cuts = 0, k = 1;
        snprintf(name, sizeof name, "cut anywhere = fresh: %s", edits[e].name);
        check_case(name);
        for (int at = 1; at < 400; at += 1 + at / 2, k++) {
            edits[e].run(&p, k);
            renderer_set_params(r, &p);
            cuts += run(r, at);
            if (k % 3 == 0 && renderer_forecast(r, ms))
                CHECK(renderer_draft(r, &how, &err));
            if (k % 3 == 1 && renderer_foresee(r, RENDERER_CROSSINGS, ms)) {
                atomic_store(&looks, 0);
                renderer_rehearse(r, RENDERER_CROSSINGS, &how, ms, &err);
            }
        }
        CHECK(cuts >= 1);
        same_as_fresh(r, &p);
    }
    renderer_destroy(r);
}

// Until the newer state is there the older one can still be shown.
static void still_shown(void)
{
    struct params p;
    struct error err = {0};
    struct renderer_stats s;
    bool done;
    base(&p);
    check_case("what was there can be shown");
    struct renderer *r = fresh(&p);
    CHECK(renderer_step(r, &done, &err));
    struct buf before = {0}, after = {0};
    CHECK(renderer_read_linear(r, &before, &err));
    cut_at = 1; // in the middle of the first sample by rays
    atomic_store(&looks, 0);
    renderer_watch(r, newer, NULL);
    CHECK(renderer_step(r, &done, &err));
    CHECK(renderer_was_cut(r) && !done);
    CHECK(renderer_read_linear(r, &after, &err));
    CHECK(scene_same(&before, &after));
    renderer_stats(r, &s);
    CHECK(s.samples == 1 && !s.refined);
    same_as_fresh(r, &p);
    buf_finish(&before);
    buf_finish(&after);
    renderer_destroy(r);
}

// Counts of looks, not times: a step that is never asked could take any time.
static void asks_often(void)
{
    struct params p;
    struct error err = {0};
    bool done;
    base(&p);
    p.shadow.rays = 0;
    p.quality.samples = 1;
    struct renderer *r = fresh(&p);
    scene_finish(r);
    for (int e = 0; e < EDITS; e++) {
        char name[64];
        snprintf(name, sizeof name, "asked in the middle of: %s",
                 edits[e].name);
        check_case(name);
        edits[e].run(&p, 2);
        renderer_set_params(r, &p);
        cut_at = 0;
        atomic_store(&looks, 0);
        renderer_watch(r, newer, NULL);
        CHECK(renderer_step(r, &done, &err) && !renderer_was_cut(r));
        printf("  %s: %d looks\n", edits[e].name, atomic_load(&looks));
        CHECK(atomic_load(&looks) >= edits[e].most);
        edits[e].run(&p, 1);
        renderer_watch(r, NULL, NULL);
        renderer_set_params(r, &p);
        scene_finish(r);
    }
    renderer_destroy(r);
}

int main(int argc, char **argv)
{
    sky_helper_main(argc, argv);
    law();
    still_shown();
    asks_often();
    return check_end();
}
