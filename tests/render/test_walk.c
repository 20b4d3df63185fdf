// A walk of edits, drafts and cut work through one renderer: after each of its
// steps the picture is a fresh renderer's, bit for bit, whatever was kept on
// the way.  GLINT_LONG=1 walks farther.
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "renderer/renderer_private.h"
#include "tests/check.h"
#include "tests/render/scene.h"

enum { EDITS = 21, STEPS = 12, LONG_STEPS = 200 };
#define ANY(...) \
    ((const float[]){__VA_ARGS__})[pick( \
        (int)(sizeof((const float[]){__VA_ARGS__}) / sizeof(float)))]

// One that finds what was broken on purpose: marks that outlive the tables'
// shape, records that outlive the groups.
static unsigned seed = 3;

static int pick(int below)
{
    seed = seed * 1664525u + 1013904223u;
    return (int)((seed >> 8) % (unsigned)below);
}

// What tables of lights, their groups, marks and records go by, and what they
// do not; mostly what leaves the tables on.
static const char *edit(struct params *p)
{
    switch (pick(EDITS)) {
    case 0:
        return p->fibre.sigma_a[pick(3)] = ANY(.1f, .5f, 1, 20), "sigma_a";
    case 1:
        return p->fibre.w_c = ANY(5.5f, 8, 10, 20), "w_c";
    case 2:
        return p->light.yaw = ANY(0, 10, 40, 90), "yaw";
    case 3:
        return p->tint.colour[pick(3)] = ANY(.1f, .3f, 1), "tint";
    case 4:
        return p->camera.fov = ANY(18, 20, 22), "fov";
    case 5:
        return p->sun1.strength = ANY(0, 1, 2), "sun";
    case 6:
        return p->quality.group_deg = ANY(0, 4.3f, 12, 45), "group_deg";
    case 7:
        return p->quality.cache_mb = (int)ANY(16, 32, 256), "cache_mb";
    case 8:
        return p->render.multiple = (int)ANY(0, 1, 2, 2, 2, 2), "multiple";
    case 9:
        return p->shadow.method = (int)ANY(0, 1, 1), "shadow.method";
    case 10:
        return p->render.components = (int)ANY(0, 0, 0, 0, 1), "components";
    case 11:
        return p->sky.lights = (int)ANY(20, 40), "sky.lights";
    case 12:
        return p->quality.light_bound = ANY(0, .01f, .05f), "light_bound";
    case 13:
        return p->render.path = (int)ANY(0, 1, 2, 2, 2, 2), "path";
    case 14:
        return p->shadow.rays = (int)ANY(0, 2), "rays";
    default: // shapes of tables go by it, and groups by steps of its half
        return p->fibre.beta_r = ANY(.3f, 1, 2, 3, 4, 7.5f), "beta_r";
    }
}

static bool newer(void *ctx)
{
    (void)ctx;
    return pick(6) == 0;
}

static void draft(struct renderer *r)
{
    struct error err = {0}; // there may be none
    struct renderer_draft how = {.divisor = 2, .stride = 1 + pick(2)};
    renderer_draft(r, &how, &err);
}

// One that something newer may cut.
static void begin(struct renderer *r)
{
    struct error err = {0};
    bool done = false;
    r->watch.newer = pick(2) == 0 ? newer : NULL;
    renderer_step(r, &done, &err);
    r->watch.newer = NULL;
    atomic_store(&r->watch.cut, false);
}

// Up to three edits, with what may come between; their names.
static void edits(struct renderer *r, struct params *p, char name[80])
{
    name[0] = 0;
    for (int left = 1 + pick(3); left > 0; left--) {
        strcat(strcat(name, left > 0 && name[0] ? ", " : ""), edit(p));
        renderer_set_params(r, p);
        if (pick(3) == 0)
            draft(r);
        if (pick(3) == 0)
            begin(r);
    }
}

static void same_as_fresh(struct renderer *r, const struct params *p)
{
    struct renderer *other =
        scene_renderer(scene_lock(40, 10), scene_two_lamps(), p);
    other->lit_budget = r->lit_budget;
    struct buf edited = scene_linear(r), fresh = scene_linear(other);
    CHECK(scene_same(&edited, &fresh));
    CHECK(scene_sum(&edited, 1) > 0);
    renderer_destroy(other);
    buf_finish(&edited);
    buf_finish(&fresh);
}

// lit_budget, bytes: 0, or so few that records, or most lights' tables, have no
// room.
static void walk(uint64_t lit_budget, int steps)
{
    struct params p;
    scene_shadowed(&p, 2, 0, 40);
    p.quality.group_deg = 12;
    p.render.multiple = 0;
    struct renderer *r =
        scene_renderer(scene_lock(40, 10), scene_two_lamps(), &p);
    r->lit_budget = lit_budget;
    check_case("multiple scattering comes after records were made");
    CHECK(scene_finish(r));
    p.render.multiple = 2;
    renderer_set_params(r, &p);
    same_as_fresh(r, &p);
    for (int i = 0; i < steps; i++) {
        char name[80], all[100];
        edits(r, &p, name);
        snprintf(all, sizeof all, "walk %d: %s", i, name);
        check_case(all);
        same_as_fresh(r, &p);
    }
    renderer_destroy(r);
}

int main(void)
{
    const int steps = getenv("GLINT_LONG") ? LONG_STEPS : STEPS;
    walk(0, steps);
    walk(3000000, steps / 2);
    return check_end();
}
