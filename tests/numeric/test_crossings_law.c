// test_crossings_law.c - what is read from the four nodes of a transmittance.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "renderer/egl.h"
#include "tests/check.h"
#include "tests/numeric/crossings_scene.h"

static void pack(struct crossings_place *p, const double g[4])
{
    uint32_t bits[2];
    for (int k = 0; k < 2; k++)
        bits[k] = (uint32_t)lrint(65535 * g[2 * k]) |
                  (uint32_t)lrint(65535 * g[2 * k + 1]) << 16;
    memcpy(p->p, bits, sizeof bits);
}

// A few ways of the crossings n[k], each open or not.
struct mixture {
    int ways;
    double n[16], open[16];
};

static double mixture_mean(const struct mixture *m, double s)
{
    double sum = 0;
    for (int k = 0; k < m->ways; k++)
        sum += m->open[k] * exp(-s * m->n[k]) / m->ways;
    return sum;
}

static struct mixture random_mixture(uint64_t *state, bool alike)
{
    static const int ways[4] = {1, 4, 8, 16};
    struct mixture m = {.ways = ways[(int)(4 * truth_uniform(state))]};
    const double typical = exp(5 * truth_uniform(state) - 2);
    const double spread = alike ? 0 : 1.5 * truth_uniform(state);
    const double hidden = truth_uniform(state) < 0.5 ? truth_uniform(state) : 0;
    for (int k = 0; k < m.ways; k++) {
        const double x = sqrt(-2 * log(truth_uniform(state) + 1e-12)) *
                         cos(2 * M_PI * truth_uniform(state));
        m.n[k] = fmin(typical * exp(spread * x), 27);
        m.open[k] = k > 0 && k < hidden * m.ways ? 0 : 1;
    }
    return m;
}

static void check_law(bool alike)
{
    enum { CASES = 4000 };
    static struct crossings_place place[CASES];
    static struct crossings_result r[CASES];
    static struct mixture m[CASES];
    struct error err = {0};
    struct crossings_probe_run run = {.given_nodes = true};
    const double a[4] = {0, 0.6, 0.85, 1};
    uint64_t state = 12;
    for (int i = 0; i < CASES; i++) {
        m[i] = random_mixture(&state, alike);
        const double g[4] = {mixture_mean(&m[i], 1), mixture_mean(&m[i], 0.3),
                             mixture_mean(&m[i], 0.05), mixture_mean(&m[i], 0)};
        pack(&place[i], g);
    }
    for (int k = 0; k < 4; k++)
        run.attenuation[k] = (float)a[k];
    CHECK(crossings_probe(&run, place, CASES, 1, r, &err));
    double mean = 0, most = 0, crossed = 0;
    for (int i = 0; i < CASES; i++) {
        for (int k = 0; k < 4; k++) {
            double d =
                fabs((double)r[i].forward[k] - mixture_mean(&m[i], 1 - a[k]));
            mean += d / (4 * CASES);
            most = fmax(most, d);
        }
        if (alike && m[i].n[0] < 5) // above, nodes hold too few digits
            crossed =
                fmax(crossed,
                     fabs((double)r[i].crossings[1] / (0.6 * m[i].n[0]) - 1));
        CHECK((double)r[i].clear == (double)(float)scene_node(&r[i], 0));
    }
    CHECK_ATMOST(mean, alike ? 2e-4 : 1.5e-3);
    CHECK_ATMOST(most, alike ? 0.01 : 0.07);
    CHECK_ATMOST(crossed, 0.01);
}

static void test_law(void)
{
    check_case("E[a^N] from nodes: all ways alike");
    check_law(true); // exact but for 16 bits
    check_case("E[a^N] from nodes: ways that differ");
    check_law(false); // SHADOW_LAW's own error: mean .0009, rarely .05
}

// Any bits at all: finite, and between the bounds; the ends exact.
static void test_law_limits(void)
{
    enum { CASES = 3000 };
    check_case("E[a^N] from nodes: limits");
    static struct crossings_place place[CASES];
    static struct crossings_result r[CASES];
    struct error err = {0};
    uint64_t state = 13;
    const struct crossings_probe_run run = {.given_nodes = true,
                                            .attenuation = {0, 0.5, 0.999f, 1}};
    for (int i = 2; i < CASES; i++) {
        double g[4];
        for (int k = 0; k < 4; k++)
            g[k] = fmin(1, 1.2 * truth_uniform(&state) *
                               (i % 3 ? 1 : truth_uniform(&state) * 1e-4));
        pack(&place[i], g);
    }
    pack(&place[0], (const double[4]){0, 0, 0, 0});
    pack(&place[1], (const double[4]){1, 1, 1, 1});
    CHECK(crossings_probe(&run, place, CASES, 1, r, &err));
    int bad = 0;
    for (int i = 0; i < CASES; i++)
        for (int k = 0; k < 4; k++)
            bad += !(r[i].forward[k] >= 0 && r[i].forward[k] <= 1) ||
                   !(r[i].crossings[k] >= 0 && r[i].crossings[k] < 1e8f);
    CHECK(bad == 0);
    for (int k = 0; k < 4; k++) {
        CHECK(r[0].forward[k] == 0 && r[0].crossings[k] == 0);
        CHECK(r[1].forward[k] == 1 && r[1].crossings[k] < 1e-4f);
    }
}

int main(void)
{
    struct error err = {0};
    struct egl *egl = egl_create(&err);
    if (!egl) {
        check_case("crossings_law");
        check_skip(err.text);
        return check_end();
    }
    test_law();
    test_law_limits();
    egl_destroy(egl);
    return check_end();
}
