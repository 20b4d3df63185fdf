// Scheme `best` where a light is as wide as one of TRT's lobes and right
// opposite: two equal circular Gaussians half a turn apart, whose product is
// constant.  The root in its exponent is there of nothing but what sin^2 of
// half the angle lacks of 1, which rounding may bring below 0.
#include "renderer/best_lobes.h"
#include "renderer/egl.h"
#include "tests/check.h"
#include "tests/numeric/best_double.h"
#include "tests/numeric/sets.h"

static const double pi = 3.14159265358979323846;
static const double deg = 3.14159265358979323846 / 180;
static const struct probe_setup best = {.m = 4, .tables = 1, .best = true};

// What a picture found: builtin:animation in builtin:studio, eta 1.3.
static void test_seen(void)
{
    struct set s = sets_create(2);
    check_case("best_light_opposite_its_like_seen");
    for (size_t i = 0; i < s.count; i++) {
        s.c[i] =
            (struct exact_case){.eta = 1.3,
                                .sigma_a = i ? 0.25 : 0.2,
                                .alpha = {-7.5 * deg, 3.75 * deg, 11.25 * deg},
                                .beta = {7.5 * deg, 3.75 * deg, 15 * deg},
                                .w_c = 10 * deg,
                                .a = 1,
                                .lambda_j = 0.165455073,
                                .theta_j = 0.539847851,
                                .phi_j = 2.61068869,
                                .theta_o = -0.0982543081,
                                .phi_o = 1.12298011e-08,
                                .delta_eta = 0.3};
        best_double_modes(&s.c[i], s.want[i]);
    }
    // TRT is exp(-40) there; its error of 6e-3 is one of 1.5e-4 in the
    // exponent, what the polynomials have in 1/kappa.
    if (sets_on_gpu(&s, best))
        for (size_t i = 0; i < EXACT_MODES * s.count; i++)
            CHECK_NEAR((double)s.out[i] / s.want[i / 3][i % 3], 1, 0.02);
    sets_destroy(&s);
}

// One lobe's light, and what is next to it.  Light and lobe meet in theta too,
// where the middle node has cos theta_d = 1.
enum { STEPS = 41 };
static void add(struct set *s, struct exact_case c, double lobe, double lambda)
{
    for (int i = 0; i < STEPS; i++)
        for (int k = 0; k < STEPS; k++) {
            c.lambda_j = lambda * (1 + 2e-5 * (i - STEPS / 2));
            c.phi_j = pi + lobe + 2e-5 * (k - STEPS / 2);
            s->c[s->count++] = c;
        }
}

static void test_round(void)
{
    static const double eta[] = {1.05, 1.3, 1.5, 2, 3};
    enum { ETAS = sizeof eta / sizeof *eta };
    struct set s =
        sets_create((size_t)ETAS * BEST_LOBES_PANELS * 2 * STEPS * STEPS);
    struct best_lobes *t = best_lobes_create();
    s.count = 0;
    for (int i = 0; i < ETAS; i++) {
        const struct best_fibre f = {eta[i], {.2, .2, .2}, 1, 10 * deg};
        const struct exact_case c = {.eta = f.eta,
                                     .sigma_a = f.sigma_a[0],
                                     .beta = {5 * deg, 5 * deg, 5 * deg},
                                     .w_c = f.w_c,
                                     .a = 1};
        best_lobes_update(t, &f);
        for (int q = 0; q < BEST_LOBES_PANELS; q++) {
            double p[5];
            best_lobes_panel(t, q, 1, p);
            for (int side = -1; side <= 1; side += 2)
                add(&s, c, side * 2 * asin(p[0]), sqrt(2 * p[1]));
        }
    }
    check_case("best_light_opposite_its_like");
    if (sets_on_gpu(&s, best)) {
        long bad = 0;
        for (size_t i = 0; i < EXACT_MODES * s.count; i++)
            bad += !(s.out[i] >= 0 && s.out[i] < 1e6f);
        CHECK(bad == 0);
    }
    best_lobes_destroy(t);
    sets_destroy(&s);
}

int main(void)
{
    struct error err = {0};
    struct egl *gl = egl_create(&err);
    if (!gl) {
        check_case("best_twins");
        check_skip(err.text);
        return check_end();
    }
    test_seen();
    test_round();
    egl_destroy(gl);
    return check_end();
}
