// What a governor chooses from a front: never worse than the default, monotone,
// steady.
#include "server/governor.h"
#include "tests/check.h"

#include <math.h>

#include "protocol/edit.h"

static void set(struct params *p, const char *text)
{
    struct error err = {0};
    CHECK(edit_apply_text(p, text, &err));
}

static void shipped(void)
{
    struct fronts f = {0};
    struct params p;
    params_defaults(&p);
    fronts_shipped(&f);
    CHECK(f.count > 0);
    for (int i = 0; i < f.count; i++) {
        struct governor_ask ask = {&f.item[i], &p, 1, 1};
        CHECK(f.item[i].shipped);
        for (int rays = 0; rays < 2; rays++) {
            p.shadow.rays = rays;
            const struct governor_choice c = governor_choose(&ask);
            CHECK(c.base >= 0 && c.row == c.base);
            CHECK(f.item[i].row[c.base].knob[FRONT_RAYS] == rays);
        }
    }
    fronts_finish(&f);
}

// --- the choice --------------------------------------------------------------

static uint32_t state = 1;
static double uniform(double low, double high)
{
    state = state * 1664525u + 1013904223u;
    return low + (high - low) * (state >> 8) / 16777216.0;
}

static void add(struct front *f, double lights, double resolution, double rays)
{
    struct front_row *r = &f->row[f->rows++];
    const struct front_row *smooth = rays > 0 ? r - 1 : r;
    const double knob[] = {lights, front_knob_default(FRONT_LIGHT_BOUND),
                           resolution, 1, rays};
    memcpy(r->knob, knob, sizeof knob);
    for (int e = 0; e < FRONT_EDITS; e++)
        r->first_ms[e] = rays > 0 ? smooth->first_ms[e] : uniform(10, 300);
    r->rest_ms = r->first_ms[FRONT_FIBRE] + rays * uniform(50, 900);
    r->error = uniform(0.2, 0.9);
}

static void make(struct front *f)
{
    static const double lights[] = {5, 10, 40, 80}, voxels[] = {64, 96};
    *f = (struct front){.strands = 6000};
    for (size_t l = 0; l < 4; l++)
        for (size_t v = 0; v < 2; v++)
            for (int rays = 0; rays < 3; rays++)
                add(f, lights[l], voxels[v], rays);
}

static double relative(const struct front *f, int row, int base)
{
    const struct front_row *r = &f->row[row], *b = &f->row[base];
    double sum = r->rest_ms / b->rest_ms;
    for (int e = 0; e < FRONT_EDITS; e++)
        sum += r->first_ms[e] / b->first_ms[e];
    return sum / 4;
}

static void budgets(const struct front *f, double ratio)
{
    struct params p;
    params_defaults(&p);
    const struct governor_ask ask = {f, &p, ratio, 1};
    double last = INFINITY;
    for (p.quality.budget_ms = 1; p.quality.budget_ms < 4000;
         p.quality.budget_ms *= 1.2f) {
        const double budget = (double)p.quality.budget_ms;
        const struct governor_choice c = governor_choose(&ask);
        CHECK(c.row >= 0 && c.base >= 0);
        const struct front_row *r = &f->row[c.row], *b = &f->row[c.base];
        const double ms = ratio * r->first_ms[FRONT_FIBRE];
        const double default_ms = ratio * b->first_ms[FRONT_FIBRE];
        CHECK(b->knob[FRONT_LIGHTS] == 40 && b->knob[FRONT_RAYS] == 1);
        CHECK(r->knob[FRONT_RAYS] == 1); // no affair of a budget
        CHECK((c.verdict == GOVERNOR_FITS) == (ms <= budget));
        // never worse
        CHECK(default_ms > budget || (c.verdict == GOVERNOR_FITS &&
                                      ms <= budget && r->error <= b->error));
        CHECK(ms <= fmax(default_ms, budget));
        for (int e = 0; e < FRONT_EDITS; e++)
            CHECK(ratio * r->first_ms[e] <=
                  fmax(budget, 1.1001 * ratio * b->first_ms[e]));
        // what fits is the least error of all that fits in every way
        for (int i = 0; i < f->rows && c.verdict == GOVERNOR_FITS; i++) {
            bool fits = f->row[i].knob[FRONT_RAYS] == 1 &&
                        ratio * f->row[i].first_ms[FRONT_FIBRE] <= budget;
            for (int e = 0; e < FRONT_EDITS; e++)
                fits = fits && ratio * f->row[i].first_ms[e] <= budget;
            CHECK(!fits || r->error <= f->row[i].error);
        }
        if (c.verdict != GOVERNOR_FITS)
            continue;
        CHECK(r->error <= last); // monotone
        last = r->error;
    }
}

static void errors(const struct front *f, double ratio)
{
    struct params p;
    params_defaults(&p);
    const struct governor_ask ask = {f, &p, 1, ratio};
    double last = INFINITY, least = INFINITY;
    for (int i = 0; i < f->rows; i++)
        least = fmin(least, f->row[i].error);
    for (p.quality.error = 0.1f; p.quality.error < 1.2f;
         p.quality.error += 0.02f) {
        const double wanted = (double)p.quality.error;
        const struct governor_choice c = governor_choose(&ask);
        const double error = ratio * f->row[c.row].error;
        CHECK((c.verdict == GOVERNOR_FITS) == (ratio * least <= wanted));
        CHECK((c.verdict == GOVERNOR_FITS) == (error <= wanted));
        CHECK(c.verdict == GOVERNOR_FITS || f->row[c.row].error == least);
        const double time = relative(f, c.row, c.base);
        CHECK(c.verdict != GOVERNOR_FITS || time <= last);
        // never worse: the default's own time is 1
        CHECK(ratio * f->row[c.base].error > wanted || time <= 1 + 1e-12);
        last = time;
    }
    CHECK(last < INFINITY);
}

static void both(const struct front *f)
{
    struct params p;
    params_defaults(&p);
    const struct governor_ask ask = {f, &p, 1, 1};
    for (p.quality.budget_ms = 5; p.quality.budget_ms < 500;
         p.quality.budget_ms *= 1.5f)
        for (p.quality.error = 0.1f; p.quality.error < 1;
             p.quality.error *= 2) {
            const struct governor_choice c = governor_choose(&ask);
            const struct front_row *r = &f->row[c.row];
            const bool quick =
                r->first_ms[FRONT_FIBRE] <= (double)p.quality.budget_ms;
            const bool good = r->error <= (double)p.quality.error;
            CHECK((c.verdict == GOVERNOR_FITS) == (quick && good));
            CHECK((c.verdict == GOVERNOR_LATE) == (quick && !good));
            CHECK((c.verdict == GOVERNOR_NEAREST) == !quick);
        }
}

static void ties_and_gaps(void)
{
    struct front f;
    struct params p;
    make(&f);
    for (int i = 0; i < f.rows; i++) {
        f.row[i].error = 0.5;
        f.row[i].rest_ms = 100;
        for (int e = 0; e < FRONT_EDITS; e++)
            f.row[i].first_ms[e] = 20;
    }
    params_defaults(&p);
    struct governor_ask ask = {&f, &p, 1, 1};
    p.quality.budget_ms = 50;
    const struct governor_choice first = governor_choose(&ask);
    check_case("ties: the first, each time");
    CHECK(first.verdict == GOVERNOR_FITS && first.row == 1);
    f.row[10].rest_ms = 90; // lights 10, 96 voxels, ray 1: as good, quicker
    CHECK(f.row[10].knob[FRONT_RAYS] == 1 && governor_choose(&ask).row == 10);
    check_case("no front, an empty one, one without the default");
    ask.front = NULL;
    CHECK(governor_choose(&ask).verdict == GOVERNOR_NONE);
    struct front empty = {0};
    ask.front = &empty;
    CHECK(governor_choose(&ask).verdict == GOVERNOR_NONE &&
          governor_choose(&ask).row < 0);
    ask.front = &f;
    for (int i = 0; i < f.rows; i++)
        if (f.row[i].knob[FRONT_LIGHTS] == 40)
            f.row[i].knob[FRONT_LIGHTS] = 41;
    CHECK(governor_choose(&ask).verdict == GOVERNOR_NONE);
    p.sky.lights = 41; // the user's now, and measured
    CHECK(governor_choose(&ask).verdict == GOVERNOR_FITS);
}

static void pins(void)
{
    struct front f;
    struct params p;
    make(&f);
    params_defaults(&p);
    const struct governor_ask ask = {&f, &p, 1, 1};
    p.sky.lights = 12; // the nearest that was measured is 10
    p.quality.error = 0.3f;
    for (int i = 0; i < 20; i++, p.quality.error += 0.03f) {
        const struct governor_choice c = governor_choose(&ask);
        CHECK(f.row[c.row].knob[FRONT_LIGHTS] == 10);
        CHECK(f.row[c.base].knob[FRONT_LIGHTS] == 10 &&
              f.row[c.base].knob[FRONT_RESOLUTION] == 96);
    }
    p.shadow.rays = 0;
    p.shadow.resolution = 32;
    const struct governor_choice c = governor_choose(&ask);
    CHECK(c.row == c.base && f.row[c.row].knob[FRONT_RESOLUTION] == 64 &&
          f.row[c.row].knob[FRONT_RAYS] == 0);
}

// --- as it goes on -----------------------------------------------------------

struct desk { // a governor with one front, and a state
    struct governor g;
    struct params p, out;
    struct governor_state state;
};

static void open_desk(struct desk *d)
{
    *d = (struct desk){0};
    params_defaults(&d->p);
    d->g.fronts.item = bytes_zalloc(1, sizeof *d->g.fronts.item);
    d->g.fronts.count = 1;
    make(d->g.fronts.item);
    // Quicker with fewer lights, and worse.
    struct front *f = d->g.fronts.item;
    for (int i = 0; i < f->rows; i++) {
        const double n = f->row[i].knob[FRONT_LIGHTS];
        for (int e = 0; e < FRONT_EDITS; e++)
            f->row[i].first_ms[e] = 2 * n;
        f->row[i].rest_ms = 2 * n * (1 + 3 * f->row[i].knob[FRONT_RAYS]);
        f->row[i].error = (0.2 + 1 / n) /
                          (1 + 0.2 * f->row[i].knob[FRONT_RAYS]) *
                          (f->row[i].knob[FRONT_RESOLUTION] == 96 ? 1 : 1.1);
    }
    d->state = (struct governor_state){.params = &d->p,
                                       .scene = {"dev", "hair", "env", 6000}};
}

static int lights(struct desk *d, int64_t after_ms)
{
    d->state.now_us += after_ms * 1000;
    governor_resolve(&d->g, &d->state, &d->out);
    return d->out.sky.lights;
}

static void off_is_off(void)
{
    struct desk d;
    open_desk(&d);
    CHECK(lights(&d, 2000) == 40);
    CHECK(params_changed(&d.p, &d.out) == 0 && !d.g.note.asked[0]);
    CHECK(d.g.note.front_ms == 80); // so that times are learned before
    set(&d.p, "quality.budget_ms=25");
    CHECK(lights(&d, 2000) == 10);
    CHECK_STR(d.g.note.asked, "quality.budget_ms=25");
    CHECK_STR(d.g.note.set, "sky.lights=10");
    CHECK(d.out.quality.budget_ms == 0 && d.g.note.expects_ms == 20);
    CHECK(d.g.note.default_ms == 80);
    set(&d.p, "quality.budget_ms=0");
    CHECK(lights(&d, 1) == 40 && params_changed(&d.p, &d.out) == 0);
    set(&d.p, "quality.budget_ms=25");
    set(&d.p, "sky.lights=33"); // the user's stays
    CHECK(lights(&d, 2000) == 33);
    governor_finish(&d.g);
}

// Frames of the state as it stands take `factor` times what the front says.
static void took(struct desk *d, double factor, int times)
{
    for (int i = 0; i < times; i++)
        governor_took(&d->g, &d->g.note, factor * d->g.note.front_ms);
}

static void steady(void)
{
    struct desk d;
    open_desk(&d);
    set(&d.p, "quality.budget_ms=25");
    CHECK(lights(&d, 2000) == 10);
    check_case("noise changes nothing");
    for (int i = 0; i < 200; i++) {
        took(&d, uniform(0.75, 1.35), 1);
        took(&d, i % 5 == 0 ? 30 : 1, 1); // someone else had the processor
        d.p.fibre.eta = (float)uniform(1.4, 1.6);
        CHECK(lights(&d, 2000) == 10);
    }
    check_case("not while edits follow one another, but after");
    took(&d, 2, GOVERNOR_SEEN);
    for (int i = 0; i < 20; i++)
        CHECK(lights(&d, 30) == 10);
    CHECK(lights(&d, 2000) == 5);
    took(&d, 2, 20);
    CHECK(lights(&d, 2000) == 5 && d.g.note.expects_ms == 20);
    check_case("a drag of the budget itself is followed");
    set(&d.p, "quality.budget_ms=50");
    CHECK(lights(&d, 1) == 10);
    check_case("another picture size: the old times count for little");
    set(&d.p, "image.width=360");
    CHECK(lights(&d, 1) == 10);
    took(&d, 0.5, 2);
    CHECK(lights(&d, 2000) == 40);
    governor_finish(&d.g);
}

static void verdicts(void)
{
    struct desk d;
    open_desk(&d);
    set(&d.p, "quality.error=0.27");
    check_case("errors of this scene are learned, and forgotten with it");
    const int before = lights(&d, 2000), rays = d.out.shadow.rays;
    CHECK(d.g.note.expects_error <= 0.27);
    governor_judged(&d.g, &d.g.note, 1.6 * d.g.note.front_error);
    CHECK(lights(&d, 2000) > before || d.out.shadow.rays > rays);
    CHECK(d.g.used_error > 1.59 && d.g.used_error < 1.61);
    d.state.scene.hair = "another";
    CHECK(lights(&d, 2000) == before && d.g.used_error == 1);
    check_case("what fronts say nothing about is left as it is");
    set(&d.p, "shadow.method=off");
    lights(&d, 2000);
    CHECK(d.out.shadow.rays == d.p.shadow.rays && !d.g.note.set[0]);
    CHECK(strstr(d.g.note.why, "shadow.method") != NULL);
    set(&d.p, "shadow.method=crossings");
    d.g.fronts.count = 0;
    CHECK(lights(&d, 2000) == 40 && strstr(d.g.note.why, "no front"));
    d.g.fronts.count = 1;
    governor_finish(&d.g);
}

int main(void)
{
    check_case("what ships is sound and has the default");
    shipped();
    check_case("a budget: never worse, the least error, monotone");
    struct front f;
    for (int i = 0; i < 40; i++) {
        make(&f);
        budgets(&f, i % 2 ? 1 : uniform(0.2, 5));
    }
    check_case("an error: never worse, the least time, monotone");
    for (int i = 0; i < 40; i++) {
        make(&f);
        errors(&f, i % 2 ? 1 : uniform(0.6, 1.5));
    }
    check_case("both: the budget holds");
    for (int i = 0; i < 40; i++) {
        make(&f);
        both(&f);
    }
    ties_and_gaps();
    check_case("the user's knobs stay");
    pins();
    check_case("off, on and off again");
    off_is_off();
    steady();
    verdicts();
    return check_end();
}
