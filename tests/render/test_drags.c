// Whatever is dragged: every parameter of the table gets a draft, or its full
// frame needs nothing but the display; and what is rehearsed at rest leaves the
// picture alone and is there when the drag begins.
#include "tests/check.h"
#include "tests/render/scene.h"

#include <math.h>
#include <string.h>

static void base(struct params *p)
{
    scene_shadowed(p, 1, 0, 32);
}

static struct renderer *rendered(const struct params *p)
{
    struct groom *g = scene_lock(200, 8);
    g->opacity = bytes_zalloc(g->points, sizeof *g->opacity);
    g->colour = bytes_zalloc(3 * (size_t)g->points, sizeof *g->colour);
    for (uint32_t i = 0; i < g->points; i++) {
        g->opacity[i] = 0.5f;
        g->colour[3 * i] = 1;
    }
    struct renderer *r = scene_renderer(g, scene_two_lamps(), p);
    scene_finish(r);
    return r;
}

static struct renderer_stats stats_of(const struct renderer *r)
{
    struct renderer_stats s;
    renderer_stats(r, &s);
    return s;
}

// --- every parameter ---------------------------------------------------------

// Words that draw otherwise, to compare with: chosen, not dragged.
static bool has_no_drafts(const struct params *p)
{
    return p->render.path == 1 || p->shadow.method == 2;
}

// Samples stay: they go on, or are shown otherwise.
static bool goes_on(const struct renderer *r)
{
    return stats_of(r).samples > 0;
}

// The k-th value of a drag; false: there is no such one.
static bool drag(struct params *p, const struct params_row *row, int k)
{
    double at = params_get(p, row, 0), step = 0.01 * (row->max - row->min);
    if (row->type == PARAMS_CHOICE || row->type == PARAMS_BOOL)
        step = 1;
    else if (row->type == PARAMS_INT)
        step = fmax(1, fmin(8, floor(step)));
    else
        step = fmin(step, 0.02 * (1 + fabs(at)));
    if (isnan(at))
        at = 0.5 * (row->min + row->max);
    if (k == 0)
        at += at + step <= row->max ? step : -step;
    else if (row->type == PARAMS_CHOICE || row->type == PARAMS_BOOL)
        return false;
    else
        at -= at - step >= row->min ? step : -step;
    for (int i = 0; i < row->count; i++)
        params_put(p, row, i, at + 0.1 * step * i);
    return true;
}

// Bits of the stages that ran.
static unsigned ran(const struct renderer *r)
{
    const struct renderer_stats s = stats_of(r);
    unsigned bits = 0;
    for (int i = 0; i < RENDERER_STAGES; i++)
        bits |= (unsigned)(s.stage_ms[i] >= 0) << i;
    return bits;
}

static void put_words(unsigned bits)
{
    for (int i = 0; i < RENDERER_STAGES; i++)
        if (bits >> i & 1)
            printf(" %s", renderer_stage_names[i]);
    printf("\n");
}

// What is there is shown: no stage that makes a sample runs.
static void no_sample(struct renderer *r, const struct params_row *row)
{
    struct error err = {0};
    struct buf b = {0};
    const struct renderer_stats before = stats_of(r);
    CHECK(renderer_read_display(r, &b, &err));
    buf_finish(&b);
    const struct renderer_stats after = stats_of(r);
    for (int i = RENDERER_CROSSINGS; i < RENDERER_DISPLAY; i++)
        CHECK(before.stage_ms[i] == after.stage_ms[i]);
    CHECK(before.samples == after.samples);
    printf("  %s.%s: shown as it is\n", row->group_name, row->name);
}

static void draft_of(struct renderer *r, const struct params_row *row, int k)
{
    double ms[RENDERER_STAGES];
    struct error err = {0};
    struct renderer_draft how = {.divisor = 2, .stride = 2};
    struct buf b = {0};
    CHECK(renderer_forecast(r, ms));
    CHECK(renderer_draft(r, &how, &err));
    CHECK(renderer_read_display(r, &b, &err) && b.size > 0);
    buf_finish(&b);
    // No draft waits for the sky's fit; shadows of what moved are a coarse
    // field's.
    CHECK(!(ran(r) >> RENDERER_SKY & 1));
    CHECK(how.coarse || !(ran(r) >> RENDERER_CROSSINGS & 1));
    if (k == 1) {
        printf("  %s.%s: draft%s%s:", row->group_name, row->name,
               how.coarse ? ", coarse" : "", how.fitted ? ", earlier fit" : "");
        put_words(ran(r));
    }
}

static void every_parameter(void)
{
    struct params start, p;
    base(&start);
    struct renderer *r = rendered(&start);
    for (int i = 0; i < params_row_count; i++) {
        const struct params_row *row = &params_rows[i];
        char name[80];
        snprintf(name, sizeof name, "dragged: %s.%s", row->group_name,
                 row->name);
        check_case(name);
        p = start;
        for (int k = 0; k < 3; k++) {
            if (!drag(&p, row, k))
                break;
            if (has_no_drafts(&p))
                continue;
            renderer_set_params(r, &p);
            if (goes_on(r))
                no_sample(r, row);
            else
                draft_of(r, row, k);
        }
        renderer_set_params(r, &start);
        scene_finish(r);
    }
    renderer_destroy(r);
}

// --- rehearsals --------------------------------------------------------------

static const enum renderer_stage kinds[] = {RENDERER_STRANDS, RENDERER_VISIBLE,
                                            RENDERER_CROSSINGS, RENDERER_FIBRE};

static void rehearse(struct renderer *r, enum renderer_stage first,
                     struct renderer_draft how)
{
    struct error err = {0};
    double ms[RENDERER_STAGES];
    if (!renderer_rehearse(r, first, &how, ms, &err)) {
        printf("  %s\n", err.text);
        CHECK(false);
    }
    CHECK(ms[RENDERER_SHADE] >= 0 && ms[RENDERER_READ] >= 0);
    CHECK(ms[RENDERER_STRANDS] >= 0 || first != RENDERER_STRANDS);
    CHECK((ms[RENDERER_CROSSINGS] >= 0) ==
          (first == RENDERER_STRANDS || first == RENDERER_CROSSINGS));
}

// Between any two samples, with and without rays: the same picture.
static void leaves_no_trace(void)
{
    struct params p;
    struct error err = {0};
    base(&p);
    p.quality.samples = 3;
    p.shadow.rays = 1;
    check_case("a rehearsal leaves no trace");
    struct renderer *r =
        scene_renderer(scene_lock(200, 8), scene_two_lamps(), &p);
    bool done = false;
    for (int k = 0; !done; k++) {
        CHECK(renderer_step(r, &done, &err));
        const struct renderer_stats before = stats_of(r);
        for (int i = 0; i < 4; i++)
            rehearse(r, kinds[(i + k) % 4],
                     (struct renderer_draft){.divisor = 1 + k % 3,
                                             .stride = 1 + i % 3});
        const struct renderer_stats after = stats_of(r);
        CHECK(before.samples == after.samples);
        CHECK(before.visible_points == after.visible_points);
        CHECK(memcmp(before.stage_ms, after.stage_ms, sizeof before.stage_ms) ==
              0);
    }
    struct buf got = scene_linear(r);
    struct renderer *f =
        scene_renderer(scene_lock(200, 8), scene_two_lamps(), &p);
    struct buf want = scene_linear(f);
    CHECK(scene_same(&got, &want));
    buf_finish(&got);
    buf_finish(&want);
    renderer_destroy(f);
    renderer_destroy(r);
}

// The draft after a rehearsal: neither strands nor cells nor memory are new.
static void is_ready(void)
{
    struct params p;
    struct error err = {0};
    struct renderer_draft seen[RENDERER_DRAFT_VIEWS];
    struct renderer_draft still = {.divisor = 2, .stride = 1};
    struct renderer_draft moving = {.divisor = 4, .stride = 3};
    base(&p);
    check_case("what is rehearsed is there");
    struct renderer *r = rendered(&p);
    CHECK(renderer_drafts_seen(r, seen) == 0);
    rehearse(r, RENDERER_STRANDS, moving);
    rehearse(r, RENDERER_VISIBLE, moving);
    rehearse(r, RENDERER_CROSSINGS, still);
    rehearse(r, RENDERER_FIBRE, still);
    CHECK(renderer_drafts_seen(r, seen) == 2);
    CHECK(seen[0].divisor == 2 && seen[0].stride == 1);
    const uint64_t memory = stats_of(r).memory_draft;
    p.fibre.eta = 1.5f;
    renderer_set_params(r, &p);
    CHECK(renderer_draft(r, &still, &err));
    CHECK(ran(r) == (1u << RENDERER_FIBRE | 1u << RENDERER_SHADE |
                     1u << RENDERER_RESOLVE));
    p.camera.fov = 21;
    renderer_set_params(r, &p);
    CHECK(renderer_draft(r, &moving, &err));
    CHECK(ran(r) == (1u << RENDERER_VISIBLE | 1u << RENDERER_SHADOW |
                     1u << RENDERER_SHADE | 1u << RENDERER_RESOLVE));
    CHECK(renderer_drafts_seen(r, seen) == 1);
    p.light.yaw = 10;
    renderer_set_params(r, &p);
    CHECK(renderer_draft(r, &moving, &err));
    CHECK(!(ran(r) >> RENDERER_VISIBLE & 1) && moving.coarse);
    CHECK(stats_of(r).memory_draft == memory);
    renderer_destroy(r);
}

// A capture of another size between two pictures.
static void other_size(void)
{
    struct params p;
    double before[RENDERER_STAGES], after[RENDERER_STAGES];
    base(&p);
    check_case("another size does not disturb the forecast");
    struct renderer *r = rendered(&p);
    CHECK(renderer_foresee(r, RENDERER_FIBRE, before));
    p.image.width = 301;
    renderer_set_params(r, &p);
    scene_finish(r);
    p.image.width = 96;
    renderer_set_params(r, &p);
    CHECK(renderer_forecast(r, after));
    CHECK(after[RENDERER_SHADE] == before[RENDERER_SHADE]);
    renderer_destroy(r);
}

int main(int argc, char **argv)
{
    sky_helper_main(argc, argv);
    every_parameter();
    leaves_no_trace();
    is_ready();
    other_size();
    return check_end();
}
