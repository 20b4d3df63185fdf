// The law of the house: an incremental picture equals a fresh one, bit for bit,
// for every parameter; and only the stages that read a change run for it.
#include "tests/check.h"
#include "tests/render/scene.h"

#include <stdlib.h>

enum { STRANDS = 40, POINTS = 10 };

static void base(struct params *p)
{
    // rays have a case of their own: they take another program
    scene_shadowed(p, 3, 0, 40);
    p->view.background = 2;
}

// Another legal value of a row, as far from the one in use as it is sane.
static void change(struct params *p, const struct params_row *row)
{
    for (int i = 0; i < row->count; i++) {
        double old = params_get(p, row, i), new = 0;
        double span = row->max - row->min;
        switch (row->type) {
        case PARAMS_CHOICE:
            new = strchr(row->choices, '|') && old == 0 ? 1 : 0;
            break;
        case PARAMS_BOOL:
            new = !(old > 0);
            break;
        case PARAMS_INT:
            new = old + 2 <= row->max ? old + 2 : old - 2;
            break;
        default:
            if (isnan(old)) // auto
                new = row->type == PARAMS_VEC3 ? 0.3 + 0.2 * i : row->min + 0.2;
            else
                new = old + fmin(0.1 * span, 0.3 + 0.1 * fabs(old)) <= row->max
                          ? old + fmin(0.1 * span, 0.3 + 0.1 * fabs(old))
                          : old - fmin(0.1 * span, 0.3 + 0.1 * fabs(old));
        }
        params_put(p, row, i, new);
    }
}

struct both {
    struct buf linear, display;
};

static struct both take(struct renderer *r)
{
    struct both b = {scene_linear(r), {0}};
    b.display = scene_display(r);
    return b;
}

static bool same(const struct both *a, const struct both *b)
{
    return scene_same(&a->linear, &b->linear) &&
           scene_same(&a->display, &b->display);
}

static void drop(struct both *b)
{
    buf_finish(&b->linear);
    buf_finish(&b->display);
}

static struct both fresh(const struct params *p)
{
    struct renderer *r = scene_renderer(scene_lock_tinted(STRANDS, POINTS),
                                        scene_two_lamps(), p);
    struct both b = take(r);
    renderer_destroy(r);
    return b;
}

// output.* does not touch the picture: nothing to compare.
static bool of_picture(const struct params_row *row)
{
    return row->group != GROUP_output;
}

// As a picture is lit unless told otherwise, and by the two schemes directly,
// which are edited in what they read by themselves or in their own way.
enum way { DEFAULT, PAPER, BEST };

static bool of_way(const struct params_row *row, enum way way)
{
    static const char *const rows[] = {"eta", "sigma_a", "a", "w_c"};
    if (way == PAPER &&
        (row->group == GROUP_render || strcmp(row->name, "delta_eta") == 0))
        return true;
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++)
        if (row->group == GROUP_fibre && strcmp(row->name, rows[i]) == 0)
            return true;
    return way == DEFAULT && of_picture(row);
}

static void law(enum way way)
{
    static const char *const words[] = {"", " (paper)", " (best)"};
    struct params start;
    base(&start);
    start.render.scheme = way != PAPER;
    if (way != DEFAULT)
        start.render.path = 0;
    struct renderer *r = scene_renderer(scene_lock_tinted(STRANDS, POINTS),
                                        scene_two_lamps(), &start);
    struct both first = take(r);
    for (int i = 0; i < params_row_count; i++) {
        const struct params_row *row = &params_rows[i];
        if (!of_way(row, way))
            continue;
        char name[96];
        snprintf(name, sizeof name, "edited = fresh: %s.%s%s", row->group_name,
                 row->name, words[way]);
        check_case(name);
        struct params p = start;
        change(&p, row);
        renderer_set_params(r, &p);
        struct both edited = take(r), want = fresh(&p);
        CHECK(same(&edited, &want));
        renderer_set_params(r, &start); // and back
        struct both back = take(r);
        CHECK(same(&back, &first));
        drop(&edited);
        drop(&want);
        drop(&back);
    }
    drop(&first);
    renderer_destroy(r);
}

static void assets(void)
{
    struct params p;
    base(&p);
    struct error err = {0};
    struct renderer *r =
        scene_renderer(scene_lock(9, 6), scene_constant_sky(1), &p);
    struct both other = take(r), want = fresh(&p);
    check_case("another groom and sky = fresh");
    CHECK(!same(&other, &want));
    CHECK(renderer_set_groom(r, scene_lock_tinted(STRANDS, POINTS), &err));
    CHECK(renderer_set_sky(r, scene_two_lamps(), &err));
    struct both edited = take(r);
    CHECK(same(&edited, &want));
    drop(&other);
    drop(&want);
    drop(&edited);
    renderer_destroy(r);
}

static void refinement(void)
{
    struct params p;
    base(&p);
    p.quality.samples = 6;
    struct both want = fresh(&p);
    p.quality.samples = 2;
    struct renderer *r = scene_renderer(scene_lock_tinted(STRANDS, POINTS),
                                        scene_two_lamps(), &p);
    struct both two = take(r);
    check_case("raising the samples continues to the same picture");
    p.quality.samples = 6;
    renderer_set_params(r, &p);
    struct both edited = take(r);
    CHECK(same(&edited, &want));
    CHECK(!same(&two, &want));
    check_case("lowering them begins anew");
    p.quality.samples = 2;
    renderer_set_params(r, &p);
    struct both again = take(r);
    CHECK(same(&again, &two));
    check_case("an edit in the midst of refinement = fresh");
    p.quality.samples = 6;
    p.fibre.eta = 1.3f;
    renderer_set_params(r, &p);
    bool done;
    CHECK(renderer_step(r, &done, NULL) && renderer_step(r, &done, NULL));
    p.fibre.eta = 1.55f;
    renderer_set_params(r, &p);
    struct both third = take(r);
    CHECK(same(&third, &want));
    drop(&want);
    drop(&two);
    drop(&edited);
    drop(&again);
    drop(&third);
    renderer_destroy(r);
}

// Shadows by real rays: the picture begins anew once the smooth one is shown.
static void rays(void)
{
    struct params p;
    base(&p);
    p.shadow.rays = 2;
    check_case("refined by rays: edited = fresh");
    struct both want = fresh(&p);
    struct params other = p;
    other.light.yaw = 50;
    other.fibre.sigma_a[0] = 2;
    other.camera.fov = 23;
    struct renderer *r = scene_renderer(scene_lock_tinted(STRANDS, POINTS),
                                        scene_two_lamps(), &other);
    struct both first = take(r);
    renderer_set_params(r, &p);
    bool done;
    CHECK(renderer_step(r, &done, NULL) && renderer_step(r, &done, NULL));
    struct both edited = take(r);
    CHECK(same(&edited, &want) && !same(&first, &want));
    check_case("... and they are not the smooth field");
    p.shadow.rays = 0;
    struct both smooth = fresh(&p);
    CHECK(!same(&smooth, &want));
    drop(&want);
    drop(&first);
    drop(&edited);
    drop(&smooth);
    renderer_destroy(r);
}

// A store so small that it is emptied several times gives the same picture.
static void small_store(void)
{
    struct params p;
    struct error err = {0};
    params_defaults(&p);
    p.quality.samples = 5;
    p.sky.lights = 2;
    p.render.scheme = 0; // the cheapest
    p.render.m = 2;
    p.shadow.rays = 0;
    struct both b[2];
    check_case("memory for radiance does not change the picture");
    for (int i = 0; i < 2; i++) {
        p.quality.cache_mb = i ? 16 : 1024;
        struct renderer *r =
            scene_renderer(groom_builtin("dark", &err), scene_two_lamps(), &p);
        b[i] = take(r);
        p.fibre.beta_r = 9; // restart after the store was emptied
        renderer_set_params(r, &p);
        struct both edited = take(r);
        p.fibre.beta_r = 7.5f;
        renderer_set_params(r, &p);
        struct both back = take(r);
        CHECK(same(&back, &b[i]) && !same(&edited, &b[i]));
        drop(&edited);
        drop(&back);
        renderer_destroy(r);
    }
    CHECK(same(&b[0], &b[1]));
    drop(&b[0]);
    drop(&b[1]);
}

// --- only what is needed runs ------------------------------------------------

// Names of the stages that one step and one reading ran, blanks between.
static const char *ran(struct renderer *r)
{
    static char names[256];
    struct renderer_stats s;
    struct buf b = {0};
    bool done;
    names[0] = 0;
    if (!renderer_step(r, &done, NULL) || !renderer_read_display(r, &b, NULL))
        return "failed";
    buf_finish(&b);
    renderer_stats(r, &s);
    for (int i = 0; i < RENDERER_STAGES; i++)
        if (s.stage_ms[i] >= 0) {
            if (names[0])
                strcat(names, " ");
            strcat(names, renderer_stage_names[i]);
        }
    return names;
}

static void stage_names(void)
{
    struct params p;
    base(&p);
    p.quality.samples = 1;
    struct renderer *r = scene_renderer(scene_lock_tinted(STRANDS, POINTS),
                                        scene_two_lamps(), &p);
    check_case("the first picture runs all stages but the strands' upload");
    CHECK_STR(ran(r), "sky light tint crossings fibre visible shadow shade "
                      "resolve display read");
    check_case("an absorption edit runs fibre and shading only");
    p.fibre.sigma_a[1] = 1;
    renderer_set_params(r, &p);
    CHECK_STR(ran(r), "fibre shade resolve display read");
    check_case("turning the sky never fits anew");
    p.light.yaw = 30;
    renderer_set_params(r, &p);
    CHECK_STR(ran(r), "light tint crossings shadow shade resolve display read");
    check_case("colouring it shades nothing: it is a factor of the whole");
    p.tint.exposure = 1;
    renderer_set_params(r, &p);
    CHECK_STR(ran(r), "tint display read");
    check_case("... but of what is no light");
    p.render.components = 7; // transmittance: lights are its weights
    renderer_set_params(r, &p);
    CHECK_STR(ran(r), "tint fibre shade resolve display read");
    p.tint.colour[0] = 0.5f;
    renderer_set_params(r, &p);
    CHECK_STR(ran(r), "tint shade resolve display read");
    p.render.components = 0;
    renderer_set_params(r, &p);
    CHECK_STR(ran(r), "tint fibre shade resolve display read");
    check_case("a sun that comes sweeps, one that brightens does not");
    p.sun1.strength = 1;
    renderer_set_params(r, &p);
    CHECK_STR(ran(r), "light tint crossings shadow shade resolve display read");
    p.sun1.strength = 2;
    renderer_set_params(r, &p);
    CHECK_STR(ran(r), "tint shade resolve display read");
    check_case("where a sun shines the tint is no factor of the whole");
    p.tint.exposure = 2;
    renderer_set_params(r, &p);
    CHECK_STR(ran(r), "tint shade resolve display read");
    p.sun1.strength = 0;
    renderer_set_params(r, &p);
    CHECK_STR(ran(r), "light tint crossings shadow shade resolve display read");
    check_case("a display edit shades nothing");
    p.view.exposure = 1;
    renderer_set_params(r, &p);
    CHECK_STR(ran(r), "display read");
    check_case("a camera edit touches neither fibre nor light");
    p.camera.fov = 25;
    renderer_set_params(r, &p);
    CHECK_STR(ran(r), "visible shadow shade resolve display read");
    check_case("a hair edit does not touch the sky");
    p.hair.diameter = 0.5f;
    renderer_set_params(r, &p);
    CHECK_STR(ran(r), "strands crossings fibre visible shadow shade resolve "
                      "display read");
    check_case("nothing changed: nothing is shaded");
    CHECK_STR(ran(r), "display read");
    check_case("without shadows nothing is swept");
    p.shadow.method = 0;
    renderer_set_params(r, &p);
    CHECK_STR(ran(r), "fibre shade resolve display read");
    renderer_destroy(r);
}

// Edits of the tint alone, one after the other: with every sample in the sum,
// between two, with a sun, of a part, of what is no light, black and back.
static void tints(void)
{
    static const struct {
        float exposure, colour[3], sun;
        int components;
    } state[] = {
        {1.3f, {.5f, 1, 2}, 0, 0}, {1.3f, {0, 0, 0}, 0, 0},
        {-2, {1, .7f, .1f}, 0, 0}, {-2, {1, .7f, .1f}, 3, 0},
        {-1, {0, .7f, .1f}, 3, 0}, {-1, {0, .7f, .1f}, 3, 7},
        {-1, {2, .7f, .1f}, 0, 7}, {.4f, {2, .7f, 0}, 0, 7},
        {.4f, {2, .1f, 1}, 0, 2},  {.5f, {2, .1f, 1}, 0, 2},
        {.5f, {1, .1f, 1}, 0, 0},
    };
    struct params p;
    base(&p);
    struct renderer *r = scene_renderer(scene_lock_tinted(STRANDS, POINTS),
                                        scene_two_lamps(), &p);
    struct both shown = take(r);
    for (size_t i = 0; i < sizeof state / sizeof *state; i++) {
        char name[64];
        bool done;
        snprintf(name, sizeof name, "edited = fresh: tint, state %zu", i);
        check_case(name);
        p.tint.exposure = state[i].exposure;
        memcpy(p.tint.colour, state[i].colour, sizeof p.tint.colour);
        p.sun1.strength = state[i].sun;
        p.render.components = state[i].components;
        renderer_set_params(r, &p);
        struct both edited = take(r), want = fresh(&p);
        CHECK(same(&edited, &want) && !same(&edited, &shown));
        p.fibre.beta_r += 0.1f; // the next one comes in the midst
        renderer_set_params(r, &p);
        CHECK(renderer_step(r, &done, NULL));
        drop(&shown);
        drop(&want);
        shown = edited;
    }
    drop(&shown);
    renderer_destroy(r);
}

static void refusals(void)
{
    struct params p;
    base(&p);
    struct renderer *r = scene_renderer(scene_lock_tinted(STRANDS, POINTS),
                                        scene_two_lamps(), &p);
    struct both before = take(r);
    struct error err = {0};
    struct params big = p;
    bool done;
    check_case("a picture too large for the device is one clear error");
    big.image.width = 8192;
    big.image.height = 4000;
    renderer_set_params(r, &big);
    if (renderer_step(r, &done, &err)) {
        check_skip("this device draws 33 megapixels");
    } else {
        CHECK_STR(err.name, "image");
        CHECK(strstr(err.text, "8192 x 4000"));
        renderer_set_params(r, &p);
        struct both after = take(r);
        CHECK(same(&after, &before));
        drop(&after);
    }
    drop(&before);
    renderer_destroy(r);
    check_case("without a groom there is an error, not a picture");
    r = renderer_create(NULL, &err);
    CHECK(r && !renderer_step(r, &done, &err));
    CHECK_STR(err.name, "hair");
    renderer_destroy(r);
}

int main(int argc, char **argv)
{
    sky_helper_main(argc, argv);
    stage_names();
    refinement();
    rays();
    tints();
    assets();
    refusals();
    small_store();
    law(DEFAULT);
    law(PAPER);
    law(BEST);
    return check_end();
}
