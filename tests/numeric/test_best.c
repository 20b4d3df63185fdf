// The scheme `best`: against brute force, against its double-precision copy,
// and the laws that it must keep whatever the parameters.
#include <stdlib.h>

#include "renderer/best_lobes.h"
#include "renderer/egl.h"
#include "tests/check.h"
#include "tests/numeric/best_double.h"
#include "tests/numeric/checks.h"
#include "tests/numeric/sets.h"

static const double pi = 3.14159265358979323846;
static const struct probe_setup best = {.m = 4, .tables = 1, .best = true};

// Brute force; circular fibres of one kind.
static struct set true_set(size_t count, enum cases_kind kind)
{
    struct set s = sets_create(count);
    uint64_t state = 20110812 + (uint64_t)kind;
    for (size_t i = 0; i < count; i++) {
        s.c[i] = cases_random(&state, kind, 0);
        exact_modes(&s.c[i], s.want[i]);
        exact_means(&s.c[i], s.mean[i]);
    }
    return s;
}

// Errors of single modes, and of their sum against the sum's own mean.
static void split(const struct set *s, struct cases_errors e[4])
{
    for (size_t i = 0; i < s->count; i++) {
        const double *m = s->mean[i], *w = s->want[i];
        const float *got = s->out + 3 * i;
        double top = fmax(m[0], fmax(m[1], m[2]));
        if (top <= 1e-30)
            continue;
        for (int t = 0; t < EXACT_MODES; t++)
            if (m[t] > 1e-5 * top)
                cases_add(&e[t], cases_error((double)got[t], w[t], m[t]));
        cases_add(&e[3],
                  cases_error((double)got[0] + (double)got[1] + (double)got[2],
                              w[0] + w[1] + w[2], m[0] + m[1] + m[2]));
    }
}

// Limits: 1.4 times what was measured with these cases, so that a scheme that
// has become half as bad again is found.
static void test_accuracy(void)
{
    static const struct {
        const char *name;
        enum cases_kind kind;
        double limit[4][3]; // R, TT, TRT, sum; median, p90, p99
    } way[] = {
        {"best_typical",
         CASES_TYPICAL,
         {{0.0014, 0.0146, 0.021},
          {0.0006, 0.0075, 0.013},
          {0.0017, 0.0203, 0.1},
          {0.0013, 0.0061, 0.0184}}},
        {"best_broad",
         CASES_BROAD,
         {{0.0009, 0.0148, 0.054},
          {0.0024, 0.0094, 0.0173},
          {0.0014, 0.0254, 0.103},
          {0.0017, 0.0114, 0.053}}},
    };
    static const char *const word[4] = {"R", "TT", "TRT", "sum"};
    static const double share[3] = {0.5, 0.9, 0.99};
    for (size_t i = 0; i < sizeof way / sizeof way[0]; i++) {
        struct cases_errors e[4] = {{0}};
        struct set s = true_set(300, way[i].kind);
        check_case(way[i].name);
        if (sets_on_gpu(&s, best)) {
            split(&s, e);
            for (int t = 0; t < 4; t++) {
                printf("  %s", word[t]);
                for (int k = 0; k < 3; k++) {
                    double q = cases_quantile(&e[t], share[k]);
                    printf(" %.4f", q);
                    CHECK_ATMOST(q, way[i].limit[t][k]);
                }
                printf("\n");
            }
        }
        for (int t = 0; t < 4; t++)
            cases_finish(&e[t]);
        sets_destroy(&s);
    }
}

// Sixteen values found elsewhere; two of them eccentric, which the mean index
// only follows roughly.
static void test_check_values(void)
{
    struct set s = sets_create(CHECKS_ROWS);
    struct cases_errors e[4] = {{0}};
    check_case("best_check_values");
    for (size_t i = 0; i < s.count; i++) {
        s.c[i] = cases_from_doubles(checks[i]);
        exact_means(&s.c[i], s.mean[i]);
        memcpy(s.want[i], checks[i] + CHECKS_EXACT, sizeof s.want[i]);
    }
    if (sets_on_gpu(&s, best)) {
        split(&s, e);
        for (int t = 0; t < 4; t++) {
            printf("  median %.4f, largest %.4f\n", cases_quantile(&e[t], 0.5),
                   cases_quantile(&e[t], 1));
            // measured .0031 (R) and .080 (TT where the lobe has ended but for
            // the light's own width, which falls steeply along theta_i)
            CHECK_ATMOST(cases_quantile(&e[t], 0.5), 0.0044);
            CHECK_ATMOST(cases_quantile(&e[t], 1), 0.11);
        }
    }
    for (int t = 0; t < 4; t++)
        cases_finish(&e[t]);
    sets_destroy(&s);
}

static struct set mixed_set(size_t count)
{
    struct set s = sets_create(count);
    uint64_t state = 7;
    for (size_t i = 0; i < count; i++) {
        s.c[i] = cases_random(&state, i % 2 ? CASES_BROAD : CASES_TYPICAL, 1);
        exact_means(&s.c[i], s.mean[i]);
    }
    return s;
}

// What is left is single precision, the polynomials of the rule's nodes, and of
// TRT those in theta_d (eccentric: a texture).
static void test_as_double(void)
{
    struct set s = mixed_set(600);
    struct cases_errors e[4] = {{0}};
    check_case("best_gpu_as_double");
    for (size_t i = 0; i < s.count; i++)
        best_double_modes(&s.c[i], s.want[i]);
    if (sets_on_gpu(&s, best)) {
        split(&s, e);
        for (int t = 0; t < 4; t++) {
            // three times what was measured, all of it the polynomials'
            const double median = t == EXACT_TRT ? 4e-4 : 4e-5;
            const double p99 = t == EXACT_TRT ? 9e-3 : 3.3e-3;
            printf("  median %.2g, p99 %.2g, largest %.2g\n",
                   cases_quantile(&e[t], 0.5), cases_quantile(&e[t], 0.99),
                   cases_quantile(&e[t], 1));
            CHECK_ATMOST(cases_quantile(&e[t], 0.5), median);
            CHECK_ATMOST(cases_quantile(&e[t], 0.99), p99);
        }
    }
    for (int t = 0; t < 4; t++)
        cases_finish(&e[t]);
    sets_destroy(&s);
}

// --- whatever the parameters -------------------------------------------------
// Every corner of the legal box, and its middle where that is special.  What
// the lobes are made of changes last, for they are made anew for each fibre.
static void test_corners(void)
{
    static const double eta[] = {1.05, 2, 3}, sigma[] = {0, 1000};
    static const double alpha[] = {-30, 0, 30}, beta[] = {0.1, 60};
    static const double w_c[] = {0.5, 60}, a[] = {0.71, 1, 1.41};
    static const double lambda[] = {1e-3, 2}, theta[] = {-90, 0, 90};
    static const double phi[] = {0, 90, 180}, deg = pi / 180;
    struct set s = sets_create(3 * 3 * 3 * 2 * 3 * 2 * 2 * 3 * 2 * 3);
    for (size_t i = 0; i < s.count; i++) {
        size_t n = i;
        double v[PROBE_INPUTS] = {0};
#define TAKE(list) \
    (list)[n % (sizeof(list) / sizeof *(list))]; \
    n /= sizeof(list) / sizeof *(list)
        v[11] = deg * TAKE(theta);
        v[13] = deg * TAKE(theta);
        v[14] = deg * TAKE(phi);
        v[10] = TAKE(lambda);
        v[2] = v[3] = v[4] = deg * TAKE(alpha);
        v[5] = v[6] = v[7] = deg * TAKE(beta);
        v[8] = deg * TAKE(w_c);
        v[9] = TAKE(a);
        v[1] = TAKE(sigma);
        v[0] = TAKE(eta);
#undef TAKE
        s.c[i] = cases_from_doubles(v);
    }
    check_case("best_corners");
    if (sets_on_gpu(&s, best))
        CHECK(sets_sane(&s));
    sets_destroy(&s);
}

static void test_wild(void)
{
    struct set s = sets_wild(3000);
    check_case("best_wild");
    if (sets_on_gpu(&s, best))
        CHECK(sets_sane(&s));
    sets_destroy(&s);
}

// Windows that meet an end of their range, a centre that leaves it: nothing may
// jump.  A sweep in small steps; the second difference of a smooth function is
// (step/width)^2 of it, at a bend step/width, and a jump is what it is.
static double largest_jump(struct set *s)
{
    double worst = 0;
    for (size_t t = 0; t < 3; t++) {
        double top = 0;
        for (size_t i = 0; i < s->count; i++)
            top = fmax(top, (double)s->out[3 * i + t]);
        for (size_t i = 1; i + 1 < s->count && top > 1e-20; i++) {
            const float *v = s->out + 3 * i + t;
            double at = (double)v[0], d = (double)v[-3] - 2 * at + (double)v[3];
            worst = fmax(worst, fabs(d) / fmax(at, 0.02 * top));
        }
    }
    return worst;
}

static void test_continuity(void)
{
    static const char *const name[] = {
        "best_continuous_theta_o", "best_continuous_theta_j",
        "best_continuous_phi", "best_continuous_lambda"};
    struct set s = sets_create(16000);
    for (int kind = 0; kind < 4; kind++) {
        uint64_t state = 99;
        double worst = 0;
        bool ok = true;
        check_case(name[kind]);
        for (int i = 0; ok && i < 12; i++) {
            struct exact_case c =
                cases_random(&state, i % 2 ? CASES_BROAD : CASES_TYPICAL, 0);
            c.lambda_j = fmax(c.lambda_j, 0.1);
            for (size_t k = 0; k < s.count; k++) {
                double x = (double)k / (double)(s.count - 1);
                s.c[k] = c;
                if (kind == 0)
                    s.c[k].theta_o = pi * (x - 0.5);
                else if (kind == 1)
                    s.c[k].theta_j = pi * (x - 0.5);
                else if (kind == 2)
                    s.c[k].phi_o = 2 * pi * (x - 0.5);
                else
                    s.c[k].lambda_j = 0.1 * pow(20, x);
            }
            ok = sets_on_gpu(&s, best);
            worst = fmax(worst, largest_jump(&s));
        }
        printf("  largest jump %.2g\n", worst);
        CHECK_ATMOST(worst, 2e-3);
    }
    sets_destroy(&s);
}

// --- symmetries, variants ----------------------------------------------------
static void test_symmetry(void)
{
    static const char *const name[] = {"best_mirror_theta", "best_mirror_phi",
                                       "best_quarter_turn"};
    struct set s = mixed_set(300), m = mixed_set(300);
    for (int kind = 0; kind < 3; kind++) {
        struct cases_errors e = {0};
        check_case(name[kind]);
        bool ok = sets_on_gpu(&s, best);
        for (size_t i = 0; i < m.count; i++) {
            m.c[i] = cases_mirror(s.c[i], kind);
            for (int t = 0; t < EXACT_MODES; t++)
                m.want[i][t] = (double)s.out[3 * i + (size_t)t];
        }
        if (ok && sets_on_gpu(&m, best)) {
            sets_compare(&m, &e);
            printf("  median %.2g, largest %.2g\n", cases_quantile(&e, 0.5),
                   cases_quantile(&e, 1));
            // a turn moves angles by a rounding of 2e-7, seen through lobes
            // that may be .02 wide
            CHECK_ATMOST(cases_quantile(&e, 0.5), 1e-5);
            CHECK_ATMOST(cases_quantile(&e, 1), 2e-3);
        }
        cases_finish(&e);
    }
    sets_destroy(&s);
    sets_destroy(&m);
}

static void test_variants(void)
{
    struct set s = mixed_set(300), m = mixed_set(300);
    struct cases_errors e = {0};
    struct probe_setup opaque = best;
    opaque.opaque = true;
    for (size_t i = 0; i < s.count; i++) {
        s.c[i].a = 1;
        m.c[i].a = 1.0001;
    }
    check_case("best_circular_is_the_limit_of_eccentric");
    bool ok = sets_on_gpu(&s, best) && sets_on_gpu(&m, best);
    for (size_t i = 0; i < 3 * s.count; i++)
        m.want[i / 3][i % 3] = (double)s.out[i];
    sets_compare(&m, &e);
    printf("  median %.2g, p99 %.2g\n", cases_quantile(&e, 0.5),
           cases_quantile(&e, 0.99));
    CHECK(ok);
    // polynomial against bilinear texture of 40 rows
    CHECK_ATMOST(cases_quantile(&e, 0.99), 0.02);
    check_case("best_opaque_variant");
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

// --- what an edit makes ------------------------------------------------------
// Panels as polynomials against their definition: angle, 1/kappa, energy.
static void test_lobes(void)
{
    static const struct {
        double eta, w_c, limit[3]; // |sin|, relative 1/kappa, relative energy
    } way[] = {{1.3, 0.05, {4e-5, 5e-3, 5e-3}},
               {1.55, 0.05, {5e-6, 3e-3, 4e-3}},
               {1.55, 0.17, {5e-6, 1e-4, 4e-3}},
               {2, 0.17, {1e-6, 1e-5, 1e-2}}};
    for (size_t i = 0; i < sizeof way / sizeof way[0]; i++) {
        const struct best_fibre f = {
            way[i].eta, {0.15, 0.25, 0.45}, 1, way[i].w_c};
        struct best_lobes *t = best_lobes_create();
        double worst[3] = {0}, a[5], b[5];
        best_lobes_update(t, &f);
        for (int q = 0; q < BEST_LOBES_PANELS; q++)
            for (int k = 0; k < 100; k++) {
                double cos_d = cos(pi / 2 * k / 100);
                best_lobes_panel(t, q, cos_d, a);
                best_lobes_exact(&f, q, cos_d, b);
                worst[0] = fmax(worst[0], fabs(a[0] - b[0]));
                worst[1] = fmax(worst[1], fabs(a[1] / b[1] - 1));
                for (int c = 2; c < 5; c++)
                    worst[2] = fmax(worst[2], fabs(a[c] / b[c] - 1));
            }
        check_case("best_lobes_fit");
        printf("  eta %.2f w_c %.2f: %.2g %.2g %.2g, %.2f ms\n", way[i].eta,
               way[i].w_c, worst[0], worst[1], worst[2], best_lobes_ms(t));
        for (int k = 0; k < 3; k++)
            CHECK_ATMOST(worst[k], way[i].limit[k]);
        best_lobes_destroy(t);
    }
}

int main(void)
{
    struct error err = {0};
    struct egl *gl = egl_create(&err);
    if (!gl) {
        check_case("best");
        check_skip(err.text);
        return check_end();
    }
    test_accuracy();
    test_check_values();
    test_as_double();
    test_corners();
    test_wild();
    test_continuity();
    test_symmetry();
    test_variants();
    test_lobes();
    egl_destroy(gl);
    return check_end();
}
