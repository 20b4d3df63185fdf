// render.path=table: the law holds on it too (edited = fresh, bit for bit), it
// shows what the direct path shows, and where it cannot run stats say so.
#include "tests/check.h"
#include "tests/render/scene.h"

#include <string.h>

static void base(struct params *p)
{
    scene_shadowed(p, 3, 0, 40);
    p->quality.group_deg = 0;
    CHECK(p->render.path == 2); // the default
}

static struct renderer *renderer_of(const struct params *p)
{
    return scene_renderer(scene_lock(40, 10), scene_two_lamps(), p);
}

static const char *path(const struct renderer *r)
{
    struct renderer_stats s;
    renderer_stats(r, &s);
    return s.path;
}

static bool says(const struct renderer *r, const char *what)
{
    struct renderer_stats s;
    renderer_stats(r, &s);
    for (int i = 0; i < s.left_out_count; i++)
        if (strcmp(s.left_out[i].what, what) == 0)
            return strlen(s.left_out[i].why) > 0;
    return false;
}

static bool says_why(const struct renderer *r)
{
    return says(r, "tables");
}

// What tables may err is told where they light the picture, and only there; so
// is their memory.
static void told(void)
{
    struct params p;
    struct renderer_stats s;
    base(&p);
    check_case("what tables may err, and their memory");
    p.render.path = 0;
    struct renderer *r = renderer_of(&p);
    CHECK(scene_finish(r) && !says(r, "exact_integrals"));
    renderer_stats(r, &s);
    CHECK(s.memory_tables == 0); // nothing is made that is not needed
    p.render.path = 2;
    renderer_set_params(r, &p);
    CHECK(scene_finish(r) && says(r, "exact_integrals") && !says_why(r));
    renderer_stats(r, &s);
    CHECK(s.memory_tables > 1000000);
    renderer_destroy(r);
}

static void edit(struct params *p, int k)
{
    switch (k) {
    case 0:
        p->fibre.sigma_a[1] = 1;
        break;
    case 1:
        p->fibre.eta = 1.4f;
        break;
    case 2:
        p->fibre.beta_r = 3;
        break;
    case 3:
        p->light.yaw = 40;
        break;
    case 4:
        p->tint.colour[0] = 0.3f;
        break;
    case 5:
        p->camera.fov = 21;
        break;
    case 6:
        p->sun1.strength = 2;
        break;
    case 7:
        p->quality.samples = 5;
        break;
    default:
        p->fibre.w_c = 5.5f; // more terms in the series
    }
}

static void law(void)
{
    struct params start;
    base(&start);
    struct renderer *r = renderer_of(&start);
    struct buf first = scene_linear(r);
    for (int k = 0; k < 9; k++) {
        char name[64];
        snprintf(name, sizeof name, "edited = fresh from tables: %d", k);
        check_case(name);
        struct params p = start;
        edit(&p, k);
        renderer_set_params(r, &p);
        struct buf edited = scene_linear(r);
        struct renderer *other = renderer_of(&p);
        struct buf fresh = scene_linear(other);
        CHECK(strcmp(path(r), "table") == 0);
        CHECK(scene_same(&edited, &fresh));
        CHECK(!scene_same(&edited, &first));
        renderer_set_params(r, &start);
        struct buf back = scene_linear(r);
        CHECK(scene_same(&back, &first));
        renderer_destroy(other);
        buf_finish(&edited);
        buf_finish(&fresh);
        buf_finish(&back);
    }
    check_case("forward and back changes nothing");
    struct params p = start;
    p.render.path = 1; // lists of its own, in whose order places then come
    renderer_set_params(r, &p);
    CHECK(scene_finish(r));
    renderer_set_params(r, &start);
    struct buf back = scene_linear(r);
    CHECK(scene_same(&back, &first));
    buf_finish(&back);
    buf_finish(&first);
    renderer_destroy(r);
}

// Light that others scattered comes from the same formulas on both paths.
static void agrees(void)
{
    struct params p;
    base(&p);
    check_case("multiple scattering from tables = direct");
    struct renderer *r = renderer_of(&p);
    for (int shown = 5; shown <= 6; shown++) { // global, local
        p.render.components = shown;
        p.render.path = 0;
        renderer_set_params(r, &p);
        struct buf direct = scene_linear(r);
        CHECK(strcmp(path(r), "direct") == 0 && !says_why(r));
        p.render.path = 2;
        renderer_set_params(r, &p);
        struct buf table = scene_linear(r);
        // global: 0.3 % measured, two approximations of one integral
        CHECK_ATMOST(scene_difference(&table, &direct), 0.01);
        CHECK(scene_sum(&direct, 0) > 0);
        buf_finish(&direct);
        buf_finish(&table);
    }
    renderer_destroy(r);
}

struct variety {
    const char *name;
    void (*change)(struct params *p);
    double limit; // 1.5 times what is measured
};

static void usual(struct params *p)
{
    (void)p;
}
static void narrow_lobes(struct params *p)
{
    p->fibre.beta_r = 3;
}
// some lights have no table then
static void needles(struct params *p)
{
    p->fibre.beta_r = 0.3f;
    p->sun1.strength = 2;
}
static void narrow_caustics(struct params *p)
{
    p->fibre.w_c = 5;
}
static void opaque(struct params *p)
{
    for (int c = 0; c < 3; c++)
        p->fibre.sigma_a[c] = 20;
}
static void alone(struct params *p)
{
    p->render.multiple = 0;
}
static void unshadowed(struct params *p)
{
    p->shadow.method = 0;
}
// What comes through other fibres from few lights: by 12 degrees, where a sky's
// forty are moved by 4.
static void groups(struct params *p)
{
    p->quality.group_deg = 12;
}
static void no_room(struct params *p) // shadows are looked up as it is shaded
{
    p->quality.cache_mb = 16;
    p->sky.lights = 200;
}

// All the light, from cells of each light, against the integrals themselves.
// Few and narrow lamps: under a sky of forty lights it is a quarter of that.
static void whole_agrees(void)
{
    static const struct variety all[] = {
        {"usual", usual, 0.0145},
        {"narrow lobes", narrow_lobes, 0.0132},
        {"lights without a table", needles, 0.0134},
        {"narrow caustics", narrow_caustics, 0.0144},
        {"no TT, no TRT", opaque, 0.01},
        {"single scattering alone", alone, 0.0146},
        {"no shadows", unshadowed, 0.0146},
        {"no room for transmittances", no_room, 0.005},
        {"lights in groups", groups, 0.0214},
    };
    struct params p;
    base(&p);
    struct renderer *r = renderer_of(&p);
    for (size_t i = 0; i < sizeof all / sizeof all[0]; i++) {
        check_case(all[i].name);
        base(&p);
        all[i].change(&p);
        renderer_set_params(r, &p);
        struct buf table = scene_linear(r);
        p.render.path = 0;
        renderer_set_params(r, &p);
        struct buf direct = scene_linear(r);
        CHECK_ATMOST(scene_difference(&table, &direct), all[i].limit);
        CHECK(!scene_same(&table, &direct)); // they are two ways
        buf_finish(&direct);
        buf_finish(&table);
    }
    renderer_destroy(r);
}

static void falls_back(void)
{
    struct params p;
    base(&p);
    check_case("where tables do not hold");
    struct renderer *r = renderer_of(&p);
    for (int k = 0; k < 4; k++) {
        base(&p);
        if (k == 0)
            p.fibre.a = 0.9f;
        else if (k == 1)
            p.fibre.w_c = 3;
        else if (k == 2)
            p.render.multiple = 1;
        else
            p.render.scheme = 0;
        renderer_set_params(r, &p);
        struct buf asked = scene_linear(r);
        CHECK(strcmp(path(r), "direct") == 0 && says_why(r));
        p.render.path = 0;
        renderer_set_params(r, &p);
        struct buf direct = scene_linear(r);
        CHECK(scene_same(&asked, &direct));
        buf_finish(&asked);
        buf_finish(&direct);
    }
    renderer_destroy(r);
}

// What layers have in all, of the whole's sum.
static double parts_of(struct renderer *r)
{
    double sum = 0;
    for (int i = 0; i < RENDERER_LAYERS; i++) {
        struct buf part = {0};
        CHECK(renderer_read_layer(r, i, &part, NULL));
        sum += scene_sum(&part, 0);
        buf_finish(&part);
    }
    struct buf whole = scene_linear(r);
    sum /= scene_sum(&whole, 0);
    buf_finish(&whole);
    return sum;
}

// Where tables do not light the whole, they do not light those of its parts
// either for which they would do: nothing has made them, or not for this fibre.
static void parts(void)
{
    for (int tabled = 0; tabled < 2; tabled++) {
        struct params p;
        base(&p);
        p.render.multiple = tabled ? 2 : 1; // best, paper
        check_case(tabled ? "parts, tables of another fibre" : "parts");
        struct renderer *r = renderer_of(&p);
        CHECK(scene_finish(r) && (strcmp(path(r), "table") == 0) == tabled);
        p.render.multiple = 1;
        p.fibre.sigma_a[0] = 0.1f;
        renderer_set_params(r, &p);
        CHECK(renderer_layers_on(r, NULL));
        CHECK(scene_finish(r) && strcmp(path(r), "direct") == 0);
        CHECK_NEAR(parts_of(r), 1, 1e-7); // 2.6e-9 measured: roundings
        renderer_destroy(r);
    }
}

int main(void)
{
    told();
    law();
    agrees();
    whole_agrees();
    falls_back();
    parts();
    return check_end();
}
