// Multiple scattering as the shader evaluates it: limits that are known without
// an integration, and the laws that it must keep whatever the parameters.
#include <stdlib.h>

#include "renderer/exact_dual.h"
#include "renderer/lights.h"
#include "tests/check.h"
#include "tests/numeric/checks_dual.h"
#include "tests/numeric/dual_bench.h"

#define pi 3.14159265358979323846

// --- what must hold ---------------------------------------------------------
// Light 1/cos theta_i g(theta_i)/pi over half a circle brings Int g cos theta_i
// to a piece of fibre; a white one sends all of it out again but what stays
// after TRT, in whatever direction.
static void test_furnace(const struct dual_bench *b)
{
    enum { THETAS = 180, PHIS = 24 };
    const double sigma_f = 0.4, theta_j = 0.5;
    float *in = calloc(THETAS * PHIS * DUAL_IN, sizeof *in);
    float *out = calloc(THETAS * PHIS * DUAL_OUT, sizeof *out);
    struct exact_case c = {.eta = 1.55,
                           .alpha = {-0.02, 0.01, 0.03},
                           .beta = {0.04, 0.04, 0.04},
                           .w_c = 0.2,
                           .a = 1,
                           .lambda_j = 0.3,
                           .theta_j = theta_j,
                           .delta_eta = 0.3};
    double sum = 0, came = 0;
    check_case("dual_global_white_furnace");
    for (int i = 0; i < THETAS * PHIS; i++) {
        c.theta_o = pi * ((i / PHIS + 0.5) / THETAS - 0.5);
        c.phi_o = pi * (i % PHIS + 0.5) / PHIS; // even in phi
        dual_bench_put(in + DUAL_IN * i, &c, sigma_f);
    }
    dual_bench_fibre(b->best, &c);
    bool ok = in && out && dual_bench_ask(b->best, in, THETAS * PHIS, out);
    for (int i = 0; ok && i < THETAS * PHIS; i++) {
        double theta_o = pi * ((i / PHIS + 0.5) / THETAS - 0.5);
        const float *v = out + DUAL_OUT * i;
        sum += (double)(v[0] + v[3] + v[6]) * cos(theta_o) * cos(theta_o) *
               (pi / THETAS) * (2 * pi / PHIS);
    }
    for (int i = 0; i < 2000; i++) {
        double t = pi * ((i + 0.5) / 2000 - 0.5), x = (t - theta_j) / sigma_f;
        came += exp(-x * x) / (sqrt(pi) * sigma_f) * cos(t) * pi / 2000;
    }
    printf("  %.4f of what came\n", sum / came);
    // 0.991 for the specular cone; lobes of 2 deg, tilted, move the cosines.
    CHECK_NEAR(sum / came, 0.988, 0.01);
    free(in);
    free(out);
}

// Zinke 2008's own case, one direction of light, in double precision: eq 7 and
// 22 with a Gaussian of theta_h in the place of M, and eq 10 and 15 (their
// corrections: docs/METHODS.md).  global: light that spread by nothing; local:
// what the light itself brings, for a unit of irradiance.
static void zinke(const struct exact_dual *e, const struct exact_case *c,
                  double global[3], double *local)
{
    double d = (c->theta_o - c->theta_j) / 2, phi = c->phi_o - c->phi_j;
    double fall = cos(c->theta_j) / (cos(d) * cos(d)), n[3];
    struct exact_dual_mean m;
    exact_dual_half(e, d, phi, n);
    exact_dual_mean(e, -d, &m);
    for (int t = 0; t < 3; t++) {
        double width = 2 * c->beta[t];
        double y = (c->theta_j + c->theta_o - 2 * c->alpha[t]) / width;
        global[t] = exp(-y * y / 2) / (width * sqrt(2 * pi)) * fall * n[t];
    }
    double z = (c->theta_j + c->theta_o - m.delta_b) / m.sigma_b;
    *local = cos(phi) < 0 ? 0
                          : m.A_b * exp(-z * z / 2) /
                                (m.sigma_b * sqrt(2 * pi)) * fall / pi;
}

struct narrow {
    struct cases_errors global, local, still;
};

// out: of lights 1e-3, 2e-3 (as wide as a sun), 3e-3 and 1e-2 wide.
enum { WIDTHS = 4 };
static const double widths[WIDTHS] = {1e-3, LIGHTS_SUN_LAMBDA, 3e-3, 1e-2};

static void add_narrow(const struct exact_case *c, const struct exact_dual *e,
                       const float *out, struct narrow *to)
{
    double want[3], back, first = 0, side = cos(c->phi_o - c->phi_j);
    zinke(e, c, want, &back);
    const double sum = want[0] + want[1] + want[2];
    for (int k = 0; k < WIDTHS; k++, out += DUAL_OUT) {
        double omega = pi * widths[k] * widths[k];
        if (sum > 1e-4 && k < 2)
            cases_add(&to->global,
                      fabs((double)(out[0] + out[3] + out[6]) / sum - 1));
        if (side < -0.05 && k < 2) // behind, and all of it
            CHECK(out[DUAL_MLD] == 0);
        if (side < 0.05 || back < 1e-4)
            continue;
        double per = (double)out[DUAL_MLD] / omega;
        if (k == 0)
            first = per;
        else
            cases_add(&to->still, fabs(per / first - 1));
        if (k < 2)
            cases_add(&to->local, fabs(per / back - 1));
    }
}

// A sun: the light is a direction, and so is what reaches the fibre.
static void test_narrow(const struct dual_bench *b)
{
    enum { CASES = 40 };
    struct narrow n = {{0}, {0}, {0}};
    uint64_t state = 4;
    check_case("dual_narrow_limit_is_zinke");
    for (int i = 0; i < CASES; i++) {
        struct exact_case c = cases_random(&state, CASES_TYPICAL, 0);
        struct exact_dual *e = exact_dual_create(&c);
        float in[WIDTHS * DUAL_IN], out[WIDTHS * DUAL_OUT];
        for (int k = 0; k < WIDTHS; k++) {
            c.lambda_j = widths[k];
            dual_bench_put(in + DUAL_IN * k, &c, widths[k]);
        }
        dual_bench_fibre(b->best, &c);
        if (dual_bench_ask(b->best, in, WIDTHS, out))
            add_narrow(&c, e, out, &n);
        exact_dual_destroy(e);
    }
    dual_bench_report("M^G", &n.global);
    // The series of N^G, as in test_dual.c: 3e-4 and 8e-4 were measured.
    CHECK_ATMOST(cases_quantile(&n.global, 0.5), 1e-3);
    CHECK_ATMOST(cases_quantile(&n.global, 0.9), 3e-3);
    dual_bench_report("direct", &n.local);
    // Two Hermite terms for a shape that is none: .012 and .028.
    CHECK_ATMOST(cases_quantile(&n.local, 0.5), 0.03);
    CHECK_ATMOST(cases_quantile(&n.local, 0.9), 0.06);
    dual_bench_report("still", &n.still);
    // The centre of the product moves by a part of the width: 1.2e-3 at .01.
    CHECK_ATMOST(cases_quantile(&n.still, 1), 5e-3);
    cases_finish(&n.global);
    cases_finish(&n.local);
    cases_finish(&n.still);
}

// Along a strand theta changes little by little: so must what is seen of it.
// Largest second difference of 2000 steps, in parts of the largest value.
static void test_continuity(const struct dual_bench *b)
{
    enum { STEPS = 2000 };
    float *in = calloc(STEPS * DUAL_IN, sizeof *in);
    float *out = calloc(STEPS * DUAL_OUT, sizeof *out);
    uint64_t state = 31;
    check_case("dual_continuity");
    for (int i = 0; in && out && i < 20; i++) {
        struct exact_case c = cases_random(&state, CASES_TYPICAL, 1);
        double sigma_f = fmax(dual_bench_widened(&c, &state), 0.2);
        for (int k = 0; k < STEPS; k++) {
            double x = 3.1 * ((k + 0.5) / STEPS - 0.5);
            *(i % 2 ? &c.theta_o : &c.theta_j) = x;
            dual_bench_put(in + DUAL_IN * k, &c, sigma_f);
        }
        dual_bench_fibre(b->best, &c);
        if (!dual_bench_ask(b->best, in, STEPS, out))
            break;
        for (int v = 0; v <= DUAL_ML; v += 3) {
            double top = 1e-9, jump = 0;
            for (int k = 1; k + 1 < STEPS; k++) {
                const float *y = out + DUAL_OUT * k + v;
                top = fmax(top, (double)y[0]);
                jump =
                    fmax(jump,
                         fabs((double)(y[DUAL_OUT] + y[-DUAL_OUT] - 2 * y[0])));
            }
            // Lobes 0.2 wide and more, steps of 1.5e-3: curvature 2e-4. What
            // is left are the bends of 256 columns eight steps apart.
            CHECK_ATMOST(jump / top, 0.01);
        }
    }
    free(in);
    free(out);
}

static void check_sane(const float *in, const float *out, size_t count)
{
    for (size_t i = 0; i < count; i++)
        for (size_t k = 0; k < DUAL_OUT; k++)
            if (!CHECK(out[DUAL_OUT * i + k] >= 0 &&
                       out[DUAL_OUT * i + k] < 1e12f)) {
                printf("  output %zu is %g for", k,
                       (double)out[DUAL_OUT * i + k]);
                for (size_t v = 0; v < DUAL_IN; v++)
                    printf(" %.9g", (double)in[DUAL_IN * i + v]);
                printf("\n");
                return;
            }
}

static double pick(uint64_t *state, const double *list, int count)
{
    return list[(int)cases_uniform(state, 0, count)];
}

static void test_extremes(const struct dual_bench *b)
{
    enum { LIGHTS = 3 * 3 * 3 * 3 * 3 };
    static const double eta[] = {1.05, 1.55, 3}, sigma[] = {0, 1, 1000};
    static const double tilt[] = {-pi / 6, 0, pi / 6};
    static const double beta[] = {0.1 * pi / 180, 0.1, pi / 3};
    static const double w_c[] = {0.5 * pi / 180, pi / 3}, a[] = {0.71, 1, 1.41};
    static const double lambda[] = {1e-3, 0.1, 2},
                        theta[] = {-pi / 2, 0, pi / 2};
    static const double phi[] = {0, pi / 2, pi}, wide[] = {1e-3, 0.3, 30};
    static float in[LIGHTS * DUAL_IN], out[LIGHTS * DUAL_OUT];
    for (int i = 0; i < LIGHTS; i++) {
        struct exact_case c = {.lambda_j = lambda[i % 3],
                               .theta_j = theta[i / 3 % 3],
                               .theta_o = theta[i / 9 % 3],
                               .phi_o = phi[i / 27 % 3]};
        dual_bench_put(in + DUAL_IN * i, &c, wide[i / 81]);
    }
    for (int kind = 0; kind < 3; kind++) {
        struct probe_dual *p = kind == 0   ? b->best
                               : kind == 1 ? b->paper
                                           : b->opaque;
        uint64_t state = 99;
        check_case(kind == 0   ? "dual_best_extremes"
                   : kind == 1 ? "dual_paper_extremes"
                               : "dual_opaque_extremes");
        for (int i = 0; i < 60; i++) {
            struct exact_case c = {.eta = pick(&state, eta, 3),
                                   .sigma_a = pick(&state, sigma, 3),
                                   .w_c = pick(&state, w_c, 2),
                                   .a = pick(&state, a, 3),
                                   .delta_eta = 0.05};
            for (int t = 0; t < 3; t++) {
                c.alpha[t] = pick(&state, tilt, 3);
                c.beta[t] = pick(&state, beta, 3);
            }
            dual_bench_fibre(p, &c);
            if (dual_bench_ask(p, in, LIGHTS, out))
                check_sane(in, out, LIGHTS);
        }
    }
}

// Without TT and TRT the rest is the same.
static void test_opaque(const struct dual_bench *b)
{
    enum { VIEWS = 200 };
    static float in[VIEWS * DUAL_IN], out[VIEWS * DUAL_OUT];
    static float other[VIEWS * DUAL_OUT];
    uint64_t state = 5;
    check_case("dual_opaque_variant");
    struct exact_case c = cases_from_doubles(dual_multiples[0]);
    for (int i = 0; i < VIEWS; i++) {
        struct exact_case view = cases_random(&state, CASES_BROAD, 0);
        dual_bench_put(in + DUAL_IN * i, &view,
                       dual_bench_widened(&view, &state));
    }
    dual_bench_fibre(b->best, &c);
    dual_bench_fibre(b->opaque, &c);
    if (dual_bench_ask(b->best, in, VIEWS, out) &&
        dual_bench_ask(b->opaque, in, VIEWS, other))
        for (int i = 0; i < VIEWS * DUAL_OUT; i++) {
            int v = i % DUAL_OUT;
            bool gone = v >= 3 && v < DUAL_ML;
            CHECK(gone ? other[i] == 0
                       : fabsf(other[i] - out[i]) <= 1e-5f * out[i]);
        }
}

int main(void)
{
    struct dual_bench b;
    if (dual_bench_open(&b, "dual_limits_probes")) {
        test_furnace(&b);
        test_narrow(&b);
        test_continuity(&b);
        test_extremes(&b);
        test_opaque(&b);
    }
    dual_bench_close(&b);
    return check_end();
}
