// How coarse a draft is chosen, against a machine whose every cost is known.
#include "tests/check.h"

#include <math.h>

#include "server/haste.h"

struct machine {                  // ms
    double raster, shadow, shade; // of a full sample
    double fixed, field, tail;    // of any draft; of a coarse field; to bytes
};
static const struct machine quick = {4, 3, 5, 1, 2, 3};
static const struct machine usual = {130, 80, 190, 2, 5, 4};
static const struct machine slow = {900, 600, 1500, 4, 9, 7};

enum { FIBRE, CAMERA, SKY };

static void forecast(const struct machine *m, int kind, double *ms)
{
    for (int i = 0; i < RENDERER_STAGES; i++)
        ms[i] = -1;
    ms[RENDERER_SHADE] = m->shade;
    ms[RENDERER_FIBRE] = kind == FIBRE ? m->fixed : -1;
    ms[RENDERER_VISIBLE] = kind == CAMERA ? m->raster : -1;
    ms[RENDERER_CROSSINGS] = kind == SKY ? 10 * m->shade : -1;
    ms[RENDERER_SHADOW] = kind != FIBRE ? m->shadow : -1;
}

// What the draft took, noted as the studio notes it; ms in all.
static struct haste_ask ask(double budget, int height)
{
    return (struct haste_ask){
        .budget_ms = budget, .height = height, .width_pixels = 0.1};
}

static bool choose(struct haste *h, const double *ms, double budget, int height,
                   struct renderer_draft *how)
{
    const struct haste_ask a = ask(budget, height);
    return haste_choose(h, ms, &a, how);
}

static double take(struct haste *h, const struct machine *m, int kind,
                   const struct renderer_draft *how)
{
    double ms[RENDERER_STAGES], asked[RENDERER_STAGES], sum = m->tail;
    const double area = how->divisor * how->divisor;
    forecast(m, kind, asked);
    for (int i = 0; i < RENDERER_STAGES; i++)
        ms[i] = asked[i];
    ms[RENDERER_SHADE] = m->shade / area;
    if (kind != FIBRE)
        ms[RENDERER_SHADOW] = m->shadow / area;
    if (kind == CAMERA)
        ms[RENDERER_VISIBLE] = 2 + 0.13 * m->raster / how->stride;
    if (kind == SKY)
        ms[RENDERER_CROSSINGS] = m->field;
    for (int i = 0; i < RENDERER_STAGES; i++)
        sum += ms[i] > 0 ? ms[i] : 0;
    haste_draft(h, asked, how, ms);
    haste_draft_tail(h, m->tail);
    return sum;
}

static struct haste known(const struct machine *m)
{
    struct haste h = {0};
    double ms[RENDERER_STAGES];
    forecast(m, CAMERA, ms);
    haste_full(&h, ms);
    haste_full_tail(&h, m->tail);
    return h;
}

static void within(const struct machine *m, double budget)
{
    struct renderer_draft how, before = {0};
    for (int kind = FIBRE; kind <= SKY; kind++) {
        struct haste h = known(m);
        double ms[RENDERER_STAGES], took = 0;
        int changes = 0;
        forecast(m, kind, ms);
        for (int k = 0; k < 40; k++) {
            CHECK(choose(&h, ms, budget, 480, &how));
            changes += k > 0 && (how.divisor != before.divisor ||
                                 how.stride != before.stride);
            before = how;
            took = take(&h, m, kind, &how);
        }
        // coarser_above of haste.c
        CHECK(took <= 1.15 * budget || how.divisor == 10);
        CHECK(how.divisor >= 2 && how.divisor <= 10); // 48 rows of 480
        CHECK(changes <= 3);                          // it settles
    }
}

static void not_worth_it(void)
{
    struct haste h = known(&quick);
    struct renderer_draft how;
    double ms[RENDERER_STAGES];
    forecast(&quick, FIBRE, ms);
    // 5 + 1 of the stages, 3 to bytes
    CHECK(fabs(haste_full_ms(&h, ms) - 9) < 1e-12);
    CHECK(!choose(&h, ms, 9, 480, &how));
    CHECK(choose(&h, ms, 8.99, 480, &how));
}

// A raster that is late again and again: fewer strands.  Once: the same.
static void stride(void)
{
    struct haste h = known(&usual);
    struct renderer_draft how, next;
    double ms[RENDERER_STAGES], took[RENDERER_STAGES];
    forecast(&usual, CAMERA, ms);
    CHECK(choose(&h, ms, 33, 480, &how));
    CHECK(how.stride == 2); // .13 x 130 / (.3 x 33)
    for (int i = 0; i < RENDERER_STAGES; i++)
        took[i] = ms[i] < 0 ? -1 : 1;
    took[RENDERER_VISIBLE] = 25;
    haste_draft(&h, ms, &how, took);
    CHECK(choose(&h, ms, 33, 480, &next) && next.stride == 2);
    haste_draft(&h, ms, &how, took);
    haste_draft(&h, ms, &how, took);
    CHECK(choose(&h, ms, 33, 480, &next) && next.stride == 4);
    haste_full(&h, ms); // and it stays so
    CHECK(choose(&h, ms, 33, 480, &next) && next.stride == 4);
    took[RENDERER_VISIBLE] = 4; // until the machine has nothing else to do
    for (int k = 0; k < 8; k++) {
        CHECK(choose(&h, ms, 33, 480, &next) && next.stride == 4);
        haste_draft(&h, ms, &next, took);
    }
    CHECK(choose(&h, ms, 33, 480, &next) && next.stride == 2);
    took[RENDERER_VISIBLE] = 8;
    for (int k = 0; k < 40; k++) { // and no to and fro
        CHECK(choose(&h, ms, 33, 480, &next) && next.stride == 2);
        haste_draft(&h, ms, &next, took);
    }
}

static void sizes(void)
{
    struct renderer_draft how;
    double ms[RENDERER_STAGES];
    forecast(&slow, SKY, ms);
    struct haste h = known(&slow);
    CHECK(choose(&h, ms, 0.01, 64, &how) && how.divisor == 2);
    h = known(&slow);
    CHECK(choose(&h, ms, 0.01, 2160, &how) &&
          how.divisor == RENDERER_DRAFT_MOST);
    CHECK(how.stride == 16);
}

// What a resting camera sees is taken where its size serves; else there is a
// raster, or the camera's own coarser one while that is near enough.
static void seen(void)
{
    struct haste h = known(&usual);
    struct haste_ask a = ask(33, 480);
    struct renderer_draft how;
    double ms[RENDERER_STAGES];
    forecast(&usual, FIBRE, ms);
    a.resting = true;
    CHECK(haste_choose(&h, ms, &a, &how) && how.stride == 1);
    const int d = how.divisor;
    CHECK(!haste_settled(&h, ms, &how));
    take(&h, &usual, FIBRE, &how);
    CHECK(haste_choose(&h, ms, &a, &how) && how.divisor == d);
    take(&h, &usual, FIBRE, &how);
    CHECK(haste_settled(&h, ms, &how));
    a.resting = false;
    CHECK(haste_choose(&h, ms, &a, &how) && how.stride == h.stride);
    a.seen_count = 2;
    a.seen[0] = (struct renderer_draft){.divisor = 2 * d, .stride = 4};
    a.seen[1] = (struct renderer_draft){.divisor = d, .stride = 1};
    CHECK(haste_choose(&h, ms, &a, &how));
    CHECK(how.divisor == d && how.stride == 1);
    a.seen_count = 1;
    CHECK(haste_choose(&h, ms, &a, &how));
    CHECK(how.divisor == 2 * d && how.stride == 4);
    a.seen[0].divisor = 2 * d + 1; // too coarse to be taken for it
    CHECK(haste_choose(&h, ms, &a, &how) && how.divisor <= 2 * d);
    a.seen[0] = (struct renderer_draft){.divisor = 1, .stride = 1}; // too slow
    CHECK(haste_choose(&h, ms, &a, &how) && how.divisor > 1);
    forecast(&usual, CAMERA, ms); // nothing is seen of another camera
    a.seen[0] = (struct renderer_draft){.divisor = 16, .stride = 16};
    CHECK(haste_choose(&h, ms, &a, &how) && how.stride == h.stride);
}

// Hair that is made anew for each draft: fewer strands than a camera needs, but
// none wider than two pixels of the draft.
static void hair(void)
{
    struct haste h = known(&usual);
    struct haste_ask a = ask(33, 480);
    struct renderer_draft how;
    double ms[RENDERER_STAGES];
    forecast(&usual, CAMERA, ms);
    CHECK(haste_choose(&h, ms, &a, &how) && how.stride == 2);
    ms[RENDERER_CROSSINGS] = 500;
    ms[RENDERER_STRANDS] = 60; // 60 / 16 is below .15 x 33
    CHECK(haste_choose(&h, ms, &a, &how) && how.stride == 16);
    a.width_pixels = 4;
    CHECK(haste_choose(&h, ms, &a, &how));
    CHECK(how.stride * a.width_pixels <= 2 * how.divisor);
    a.width_pixels = 1000; // a close-up: all of them
    CHECK(haste_choose(&h, ms, &a, &how) && how.stride == 1);
}

int main(void)
{
    check_case("a full frame within the budget");
    not_worth_it();
    check_case("a budget is kept, or all is done for it");
    within(&usual, 33);
    within(&usual, 12);
    within(&slow, 33);
    within(&slow, 100);
    check_case("strands");
    stride();
    check_case("small and large pictures");
    sizes();
    check_case("what is seen already");
    seen();
    check_case("hair that moves");
    hair();
    return check_end();
}
