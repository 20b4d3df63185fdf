// The raster by compute shaders: what each pixel sees against the rule that
// raster_walk.comp states, segment by segment and pixel by pixel in double
// precision; against the driver's raster; and that it is the same every time.
#include "tests/check.h"
#include "tests/render/raster_truth.h"
#include "tests/render/scene.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "renderer/gl.h"
#include "renderer/renderer_private.h"

enum { WIDTH = TRUTH_WIDTH, HEIGHT = TRUTH_HEIGHT, PIXELS = TRUTH_PIXELS };
static const uint32_t NONE = TRUTH_NONE;

// --- cases -------------------------------------------------------------------

static void first_sample(struct renderer *r)
{
    struct error err = {0};
    bool done = false;
    if (!CHECK(renderer_step(r, &done, &err)))
        printf("  %s\n", err.text);
}

static uint32_t *seen_by(struct renderer *r)
{
    uint32_t *seen = bytes_alloc(PIXELS * sizeof *seen);
    gl.GetNamedBufferSubData(r->picture.raster.seen, 0, PIXELS * sizeof *seen,
                             seen);
    return seen;
}

// Pixels where single precision decides otherwise are those whose middle is
// within .002 pixel of a limit, whose strand's number is within 1e-4 of its
// share, or where two depths differ by less than 1e-5 of themselves; what is
// measured is below a quarter of each.  All others must agree.
static void against_truth(const char *name, struct groom *g, struct params *p,
                          bool crowded)
{
    check_case(name);
    p->quality.samples = 1;
    struct renderer *r = scene_renderer(g, scene_constant_sky(1), p);
    first_sample(r);
    struct raster_truth *t = raster_truth_make(r);
    uint32_t *seen = seen_by(r);
    GLuint work[7][4]; // raster_work.glsl; 2: windows of lines
    gl.GetNamedBufferSubData(r->picture.raster.work, 0, sizeof work, work);
    int hair = 0, wrong = 0, close = 0;
    for (int at = 0; at < PIXELS; at++) {
        hair += t->seen[at] != NONE;
        close += t->close[at];
        wrong += seen[at] != t->seen[at] && !t->close[at];
    }
    printf("  %d pixels of hair, %d too close to tell, %d wrong\n", hair, close,
           wrong);
    CHECK(hair > 300);
    CHECK(close < hair / 4);
    CHECK_NEAR(wrong, 0, 0);
    CHECK((work[2][3] > r->picture.raster.room[1]) == crowded);
    free(seen);
    raster_truth_free(t);
    renderer_destroy(r);
}

static struct groom *with_opacity(struct groom *g)
{
    g->opacity = bytes_zalloc(g->points, sizeof *g->opacity);
    for (uint32_t i = 0; i < g->points; i++)
        g->opacity[i] = 0.4f + 0.05f * (float)(i % 10);
    return g;
}

// Segments across the whole picture, more of them than there is room to list
// their windows.
static struct groom *long_ones(int strands)
{
    struct groom *g = scene_fan(strands, 2, 76, 0.6f);
    for (uint32_t i = 0; i < g->points; i++)
        g->position[3 * i + 1] = 0.02f * (float)(i / 2);
    return g;
}

static void against_truths(void)
{
    struct params p;
    scene_params(&p);
    p.hair.diameter = 0.4f;
    against_truth("lines", scene_lock(60, 12), &p, false);
    p.hair.diameter = 0.7f;
    against_truth("lines and ribbons", scene_lock(60, 12), &p, false);
    p.hair.diameter = 4;
    against_truth("ribbons", scene_lock(20, 12), &p, false);
    p.hair.use_opacity = 1;
    p.hair.diameter = 2;
    against_truth("ribbons with opacity", with_opacity(scene_lock(60, 12)), &p,
                  false);
    p.hair.diameter = 0.5f;
    against_truth("lines with opacity", with_opacity(scene_lock(90, 12)), &p,
                  false);
    scene_params(&p);
    p.hair.diameter = 0.6f;
    against_truth("windows of long lines", long_ones(60), &p, false);
    against_truth("more windows than are listed", long_ones(2600), &p, false);
    p.hair.diameter = 1.5f;
    against_truth("windows of long ribbons", long_ones(40), &p, false);
    memcpy(p.camera.eye, (float[3]){1, 0.5f, 2}, 12);
    memcpy(p.camera.target, (float[3]){1, 3, -4}, 12);
    p.camera.fov = 110;
    p.hair.diameter = 0.5f;
    against_truth("an eye amid the hair", scene_lock(60, 12), &p, false);
}

// --- ties, order, joints -----------------------------------------------------

// Every strand twice, in the same place: the first of two is seen, whichever
// thread comes first.
static void ties(void)
{
    struct params p;
    scene_params(&p);
    p.hair.diameter = 2;
    p.quality.samples = 1;
    struct groom *g = scene_lock(400, 12);
    const size_t half = g->points / 2;
    memcpy(g->position + 3 * half, g->position, 12 * half);
    check_case("of equally near segments the first is seen, every time");
    struct renderer *r = scene_renderer(g, scene_constant_sky(1), &p);
    first_sample(r);
    uint32_t *first = seen_by(r);
    int hair = 0, second = 0;
    for (int at = 0; at < PIXELS; at++) {
        hair += first[at] != NONE;
        second += first[at] != NONE && first[at] >= half;
    }
    CHECK(hair > 1000);
    CHECK_NEAR(second, 0, 0);
    for (int i = 0; i < 20; i++) {
        renderer_mark(r, RENDERER_VISIBLE);
        first_sample(r);
        uint32_t *again = seen_by(r);
        CHECK(memcmp(first, again, PIXELS * sizeof *first) == 0);
        free(again);
    }
    free(first);
    renderer_destroy(r);
}

// An arc of ribbons: what is well inside of its width is covered, joints too.
static void joints(void)
{
    enum { POINTS = 60 };
    const double radius = 25, width = 6;
    struct params p;
    scene_params(&p);
    p.hair.diameter = (float)width;
    p.quality.samples = 1;
    struct groom *g = scene_fan(1, POINTS, 10, 1);
    for (int i = 0; i < POINTS; i++) {
        const double a = 2 * M_PI * (i + 0.3) / POINTS;
        g->position[3 * i] = (float)(radius * cos(a));
        g->position[3 * i + 2] = (float)(radius * sin(a));
    }
    check_case("no gap where ribbons meet");
    struct renderer *r = scene_renderer(g, scene_constant_sky(1), &p);
    first_sample(r);
    uint32_t *seen = seen_by(r);
    int inner = 0, gaps = 0, outer = 0;
    for (int at = 0; at < PIXELS; at++) {
        const double x = at % WIDTH + 0.5 - WIDTH / 2.0;
        const double y = at / WIDTH + 0.5 - HEIGHT / 2.0;
        const double off = fabs(hypot(x, y) - radius);
        const double a = atan2(y, x) < 0 ? atan2(y, x) + 2 * M_PI : atan2(y, x);
        const double end = 2 * M_PI * 0.5 / POINTS; // where it is open
        const bool open = a < end || a > 2 * M_PI - 2 * end;
        // chords sag by radius (1 - cos(pi / POINTS)) = .03
        inner += off < width / 2 - 0.1 && !open;
        gaps += off < width / 2 - 0.1 && !open && seen[at] == NONE;
        outer += off > width / 2 + 0.1 && seen[at] != NONE;
    }
    CHECK(inner > 700);
    CHECK_NEAR(gaps, 0, 0);
    CHECK_NEAR(outer, 0, 0);
    free(seen);
    renderer_destroy(r);
}

// --- against the driver's raster ---------------------------------------------

static struct buf picture(struct groom *g, const struct params *p, bool drawn)
{
    struct renderer *r = scene_renderer(g, scene_two_lamps(), p);
    r->picture.always_drawn = drawn;
    struct buf b = scene_linear(r);
    CHECK((r->picture.target.framebuffer != 0) == drawn);
    CHECK((r->picture.raster.work != 0) == !drawn);
    renderer_destroy(r);
    return b;
}

struct far_off {
    const char *name;
    float diameter, fov;
    bool opacity;
    double coverage, apart; // allowed: of the sum; mean of a pixel's
};

// Same strands are kept, so what differs is which pixels an edge falls to: most
// where lines are a pixel or two long, for the driver leaves the last pixel of
// each to the next by a rule of diamonds.  Allowed is twice what is measured.
static void against_driver(const struct far_off *c)
{
    struct params p;
    char name[96];
    scene_params(&p);
    p.hair.diameter = c->diameter;
    p.hair.use_opacity = c->opacity;
    p.camera.fov = c->fov;
    p.quality.samples = 16;
    snprintf(name, sizeof name, "covers what the driver's does: %s", c->name);
    check_case(name);
    struct buf a = picture(with_opacity(scene_lock(300, 20)), &p, false);
    struct buf b = picture(with_opacity(scene_lock(300, 20)), &p, true);
    const float *x = (const float *)(const void *)a.data;
    const float *y = (const float *)(const void *)b.data;
    double apart = 0;
    for (size_t i = 3; i < a.size / 4; i += 4)
        apart += fabsf(x[i] - y[i]);
    const double sum = scene_sum(&b, 3);
    printf("  coverage %.5f of the driver's, a pixel's %.4f apart\n",
           scene_sum(&a, 3) / sum, apart / sum);
    CHECK(sum > 100);
    CHECK_NEAR(scene_sum(&a, 3) / sum, 1, c->coverage);
    CHECK_ATMOST(apart / sum, c->apart);
    buf_finish(&a);
    buf_finish(&b);
}

static void against_drivers(void)
{
    static const struct far_off cases[] = {
        {"lines", 0.3f, 20, false, 0.003, 0.025},
        {"far away", 0.3f, 60, false, 0.005, 0.08},
        {"lines and ribbons", 0.7f, 20, false, 0.01, 0.013},
        {"ribbons with opacity", 1.5f, 20, true, 0.001, 0.001},
        {"close by", 0.5f, 3, false, 0.001, 0.001},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++)
        against_driver(&cases[i]);
}

int main(int argc, char **argv)
{
    sky_helper_main(argc, argv);
    against_truths();
    ties();
    joints();
    against_drivers();
    return check_end();
}
