// The shader's scheme `paper` against its double-precision copy, and the laws
// that it must keep whatever the parameters.
#include <stdlib.h>

#include "renderer/egl.h"
#include "renderer/exact.h"
#include "renderer/probe.h"
#include "tests/check.h"
#include "tests/numeric/cases.h"
#include "tests/numeric/checks.h"
#include "tests/numeric/sets.h"
#include "tests/numeric/xu_double.h"

enum { RANDOM = 2000 };

static const double pi = 3.14159265358979323846;

static struct set random_set(size_t count)
{
    struct set s = sets_create(count);
    uint64_t state = 20110812;
    for (size_t i = 0; i < count; i++) {
        s.c[i] = cases_random(&state, i % 2 ? CASES_BROAD : CASES_TYPICAL, 1);
        exact_means(&s.c[i], s.mean[i]);
    }
    return s;
}

static void want(struct set *s, int m, bool fine)
{
    for (size_t i = 0; i < s->count; i++)
        xu_double_modes(&s->c[i], m, fine, s->want[i]);
}

static void test_check_values(void)
{
    struct set s = sets_create(CHECKS_ROWS);
    struct cases_errors e = {0};
    for (size_t i = 0; i < s.count; i++) {
        s.c[i] = cases_from_doubles(checks[i]);
        exact_means(&s.c[i], s.mean[i]);
    }
    check_case("xu_double_check_values");
    want(&s, 4, false);
    for (size_t i = 0; i < s.count; i++)
        for (int t = 0; t < EXACT_MODES; t++) {
            double row = checks[i][CHECKS_XU4 + t]; // printed to 7 digits
            CHECK_NEAR(s.want[i][t] / row, 1, 2e-6);
            s.want[i][t] = row;
        }
    // The paper's table resolution: what is printed in the paper, as far as its
    // tables carry it.
    check_case("xu_gpu_check_values");
    if (sets_on_gpu(&s, (struct probe_setup){.m = 4, .tables = 1})) {
        sets_compare(&s, &e);
        CHECK_ATMOST(cases_quantile(&e, 0.5), 0.01);
        CHECK_ATMOST(cases_quantile(&e, 1), 0.05);
    }
    cases_finish(&e);
    sets_destroy(&s);
}

// Tolerances: with fine tables what is left is single precision (exponents up
// to 80 make 1e-5 of 1e-7) and the last of the interpolation; with the paper's
// it is the bilinear interpolation of 128 x 64 entries.
static void test_random(void)
{
    struct set s = random_set(RANDOM);
    struct cases_errors fine = {0}, paper = {0};
    want(&s, 4, false);
    check_case("xu_gpu_as_double_fine_tables");
    if (sets_on_gpu(&s, (struct probe_setup){.m = 4, .tables = 8})) {
        sets_compare(&s, &fine);
        printf("  median %.2g, p99 %.2g, max %.2g\n",
               cases_quantile(&fine, 0.5), cases_quantile(&fine, 0.99),
               cases_quantile(&fine, 1));
        CHECK_ATMOST(cases_quantile(&fine, 0.5), 1e-5);
        CHECK_ATMOST(cases_quantile(&fine, 0.99), 3e-4);
    }
    check_case("xu_gpu_as_double_paper_tables");
    if (sets_on_gpu(&s, (struct probe_setup){.m = 4, .tables = 1})) {
        sets_compare(&s, &paper);
        printf("  median %.2g, p99 %.2g, max %.2g\n",
               cases_quantile(&paper, 0.5), cases_quantile(&paper, 0.99),
               cases_quantile(&paper, 1));
        CHECK_ATMOST(cases_quantile(&paper, 0.5), 5e-4);
        CHECK_ATMOST(cases_quantile(&paper, 0.99), 0.05);
    }
    cases_finish(&fine);
    cases_finish(&paper);
    sets_destroy(&s);
}

// The general loop, which m = 4 does not take, in both layouts.
static void test_layouts(void)
{
    static const struct {
        const char *name;
        int m;
        bool fine;
    } way[] = {{"xu_layout_m2", 2, false},
               {"xu_layout_m5", 5, false},
               {"xu_layout_m16", 16, false},
               {"xu_layout_m3_fine", 3, true},
               {"xu_layout_m64_fine", 64, true}};
    struct set s = random_set(100);
    for (size_t i = 0; i < sizeof way / sizeof way[0]; i++) {
        struct cases_errors e = {0};
        struct probe_setup setup = {
            .m = way[i].m, .tables = 8, .fine_nodes = way[i].fine};
        check_case(way[i].name);
        want(&s, way[i].m, way[i].fine);
        if (sets_on_gpu(&s, setup)) {
            sets_compare(&s, &e);
            CHECK_ATMOST(cases_quantile(&e, 0.5), 1e-5);
            CHECK_ATMOST(cases_quantile(&e, 0.99), 5e-4);
        }
        cases_finish(&e);
    }
    sets_destroy(&s);
}

// Largest error but for one case in ten, of s against `limit`.
static double distance(struct set *s, const float *limit)
{
    struct cases_errors e = {0};
    for (size_t i = 0; i < s->count; i++)
        for (size_t t = 0; t < EXACT_MODES; t++)
            s->want[i][t] = (double)limit[3 * i + t];
    sets_compare(s, &e);
    double d = cases_quantile(&e, 0.9);
    cases_finish(&e);
    return d;
}

static void test_convergence(void)
{
    struct set s = random_set(200);
    float *limit = sets_array(3 * s.count, sizeof *limit);
    check_case("xu_fine_nodes_converge");
    bool ok =
        sets_on_gpu(&s, (struct probe_setup){256, true, 8, 0, false, false});
    memcpy(limit, s.out, 3 * s.count * sizeof *limit);
    ok = ok &&
         sets_on_gpu(&s, (struct probe_setup){16, true, 8, 0, false, false});
    double at16 = distance(&s, limit);
    ok = ok &&
         sets_on_gpu(&s, (struct probe_setup){64, true, 8, 0, false, false});
    double at64 = distance(&s, limit);
    ok = ok &&
         sets_on_gpu(&s, (struct probe_setup){64, false, 8, 0, false, false});
    double paper = distance(&s, limit);
    printf("  distance from fine m = 256: fine 16 %.2g, fine 64 %.2g, paper 64 "
           "%.2g\n",
           at16, at64, paper);
    // Linear pieces: the error falls with the square of the spacing, which is
    // 0.38, 0.13 and 0.03 widths for m = 16, 64, 256; that makes 9.
    CHECK(ok);
    CHECK_ATMOST(at64, 2e-3);
    CHECK_ATMOST(at64, at16 / 5);
    // As printed, more segments only reach farther out.
    CHECK(paper > 5 * at64);
    check_case("xu_paper_nodes_do_not_converge");
    ok = sets_on_gpu(&s, (struct probe_setup){16, false, 8, 0, false, false});
    memcpy(limit, s.out, 3 * s.count * sizeof *limit);
    ok = ok &&
         sets_on_gpu(&s, (struct probe_setup){256, false, 8, 0, false, false});
    CHECK(ok);
    CHECK_ATMOST(distance(&s, limit), 1e-4);
    free(limit);
    sets_destroy(&s);
}

// Every corner of the legal box, and its middle where that is special.
static struct set corner_set(void)
{
    static const double eta[] = {1.05, 3}, sigma[] = {0, 1000};
    static const double alpha[] = {-30, 0, 30}, beta[] = {0.1, 60};
    static const double w_c[] = {0.5, 60}, a[] = {0.71, 1, 1.41};
    static const double lambda[] = {1e-3, 2}, theta[] = {-90, 0, 90};
    static const double phi[] = {0, 90, 180};
    struct set s = sets_create(2 * 2 * 3 * 2 * 2 * 3 * 2 * 3 * 3 * 3);
    const double deg = pi / 180;
    for (size_t i = 0; i < s.count; i++) {
        size_t n = i;
        double v[PROBE_INPUTS] = {0};
#define TAKE(list) \
    (list)[n % (sizeof(list) / sizeof *(list))]; \
    n /= sizeof(list) / sizeof *(list)
        v[0] = TAKE(eta);
        v[1] = TAKE(sigma);
        v[2] = v[3] = v[4] = deg * TAKE(alpha);
        v[5] = v[6] = v[7] = deg * TAKE(beta);
        v[8] = deg * TAKE(w_c);
        v[9] = TAKE(a);
        v[10] = TAKE(lambda);
        v[11] = deg * TAKE(theta);
        v[13] = deg * TAKE(theta);
        v[14] = deg * TAKE(phi);
        s.c[i] = cases_from_doubles(v);
    }
    return s;
}

static void test_extremes(void)
{
    static const struct {
        const char *corner, *wild;
        struct probe_setup setup;
    } way[] = {
        {"xu_corners", "xu_wild", {4, false, 1, 0, false, false}},
        {"xu_corners_m2", "xu_wild_m2", {2, false, 1, 0, false, false}},
        {"xu_corners_m17_fine",
         "xu_wild_m17_fine",
         {17, true, 2, 0, false, false}},
    };
    struct set corners = corner_set(), wild = sets_wild(20000);
    for (size_t i = 0; i < sizeof way / sizeof way[0]; i++) {
        check_case(way[i].corner);
        if (sets_on_gpu(&corners, way[i].setup))
            CHECK(sets_sane(&corners));
        check_case(way[i].wild);
        if (sets_on_gpu(&wild, way[i].setup))
            CHECK(sets_sane(&wild));
    }
    sets_destroy(&corners);
    sets_destroy(&wild);
}

static void test_symmetry(void)
{
    static const char *const name[] = {"xu_mirror_theta", "xu_mirror_phi",
                                       "xu_quarter_turn"};
    struct set s = random_set(500), m = random_set(500);
    const struct probe_setup setup = {4, false, 8, 0, false, false};
    for (int kind = 0; kind < 3; kind++) {
        struct cases_errors e = {0};
        check_case(name[kind]);
        bool ok = sets_on_gpu(&s, setup);
        for (size_t i = 0; i < m.count; i++) {
            m.c[i] = cases_mirror(s.c[i], kind);
            for (int t = 0; t < EXACT_MODES; t++)
                m.want[i][t] = (double)s.out[3 * i + (size_t)t];
        }
        if (ok && sets_on_gpu(&m, setup)) {
            sets_compare(&m, &e);
            // A turn moves angles by a rounding of 2e-7, which a lobe of width
            // 0.02 makes 1e-4 of in its flank.
            CHECK_ATMOST(cases_quantile(&e, 0.5), 1e-5);
            CHECK_ATMOST(cases_quantile(&e, 1), 2e-3);
        }
        cases_finish(&e);
    }
    sets_destroy(&s);
    sets_destroy(&m);
}

// Leaving out what a fibre does not need changes nothing.
static void test_variants(void)
{
    struct set s = random_set(500), m = random_set(500);
    struct cases_errors e = {0};
    for (size_t i = 0; i < s.count; i++) {
        s.c[i].a = 1;
        m.c[i].a = 1.000001;
    }
    const struct probe_setup setup = {4, false, 4, 0, false, false};
    check_case("xu_circular_is_the_limit_of_eccentric");
    bool ok = sets_on_gpu(&s, setup) && sets_on_gpu(&m, setup);
    for (size_t i = 0; i < 3 * s.count; i++)
        m.want[i / 3][i % 3] = (double)s.out[i];
    sets_compare(&m, &e);
    CHECK(ok);
    // d eta* = 4e-6 (eta - 1), seen through a caustic of width 0.05.
    CHECK_ATMOST(cases_quantile(&e, 1), 1e-3);
    check_case("xu_opaque_variant");
    struct probe_setup opaque = setup;
    opaque.opaque = true;
    for (size_t i = 0; i < m.count; i++)
        m.c[i].a = 1;
    ok = sets_on_gpu(&m, opaque);
    long differs = 0;
    for (size_t i = 0; i < m.count; i++)
        differs +=
            !(fabsf(m.out[3 * i] - s.out[3 * i]) <= 1e-5f * s.out[3 * i]) ||
            m.out[3 * i + 1] != 0 || m.out[3 * i + 2] != 0;
    CHECK(ok);
    CHECK(differs == 0);
    cases_finish(&e);
    sets_destroy(&s);
    sets_destroy(&m);
}

int main(void)
{
    struct error err = {0};
    struct egl *gl = egl_create(&err);
    if (!gl) {
        check_case("xu");
        check_skip(err.text);
        return check_end();
    }
    test_check_values();
    test_random();
    test_layouts();
    test_convergence();
    test_extremes();
    test_symmetry();
    test_variants();
    egl_destroy(gl);
    return check_end();
}
