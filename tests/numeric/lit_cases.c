// lit_cases.c - see the header.
#include "tests/numeric/lit_cases.h"

#include <math.h>

#include "tests/numeric/best_double.h"
#include "tests/numeric/dual_double.h"

static const double pi = 3.14159265358979323846, deg = pi / 180;

const char *const lit_region_names[LIT_REGIONS] = {
    "typical",
    "broad",
    "lobes .5 to 2 degrees",
    "lobes 20 to 40 degrees",
    "lambda .02 to .1",
    "lambda 1 to 2",
    "theta_o 60 to 75",
    "theta_o 75 to 85",
    "theta_o 85 to 89.9",
    "theta_j 85 to 90",
    "sigma_a to .01",
    "sigma_a 2 to 10",
    "opaque",
    "no multiple scattering",
    "tables shared",
};

static double logarithmic(uint64_t *s, double lo, double hi)
{
    return exp(cases_uniform(s, log(lo), log(hi)));
}

static void change_fibre(struct exact_case *c, enum lit_region region,
                         uint64_t *s)
{
    for (int t = 0; t < EXACT_MODES; t++)
        if (region == LIT_SHARP)
            c->beta[t] = logarithmic(s, .5, 2) * deg;
        else if (region == LIT_WIDE)
            c->beta[t] = cases_uniform(s, 20, 40) * deg;
    if (region == LIT_CLEAR)
        c->sigma_a = cases_uniform(s, 0, .01);
    else if (region == LIT_DARK)
        c->sigma_a = logarithmic(s, 2, 10);
}

static double width_of(enum lit_region region, uint64_t *s)
{
    switch (region) {
    case LIT_BROAD:
        return logarithmic(s, .02, 2);
    case LIT_NARROW:
        return logarithmic(s, .02, .1);
    case LIT_BRIGHT:
        return logarithmic(s, 1, 2);
    default:
        return logarithmic(s, .1, 1);
    }
}

// As a fit has them: some of the largest width; a few that hold most.
static void share_tables(struct lit_lights *l, uint64_t *s)
{
    double sum = 0;
    l->count = 38;
    for (int j = 0; j < l->count; j++) {
        l->lambda[j] = j < 11 ? 1 : (float)logarithmic(s, .1, 1);
        l->share[j] = (float)logarithmic(s, .03, 4);
        sum += (double)l->share[j];
    }
    for (int j = 0; j < l->count; j++)
        l->share[j] *= (float)(l->count / sum);
    l->apart = false;
    l->least = .1f;
}

struct lit_sky lit_cases_sky(uint64_t *state, enum lit_region region,
                             int lights)
{
    static const double more[LIT_CHANNELS] = {1, 1.6, 3};
    struct lit_sky sky = {.region = region};
    struct exact_case *c = &sky.grey;
    do {
        *c = cases_random(state,
                          region == LIT_BROAD ? CASES_BROAD : CASES_TYPICAL, 0);
        change_fibre(c, region, state);
        struct dual_fibre *f = &sky.fibre.fibre;
        *f = probe_dual_grey(c);
        for (int k = 0; k < LIT_CHANNELS; k++)
            f->sigma_a[k] = more[k] * c->sigma_a;
    } while (fast_tables_refuse(&sky.fibre.fibre));
    sky.fibre.opaque = region == LIT_OPAQUE;
    sky.fibre.multiple = region != LIT_SINGLE;
    sky.fibre.d_b = 0.7f;
    float lambda[LIT_PLAN_LIGHTS];
    for (int j = 0; j < lights; j++)
        lambda[j] = (float)width_of(region, state);
    sky.lights = lit_plan_apart(lambda, lights);
    if (region == LIT_SHARED)
        share_tables(&sky.lights, state);
    return sky;
}

static double view_of(enum lit_region region, uint64_t *s)
{
    static const double from[LIT_REGIONS] = {
        [LIT_VIEW_60] = 60, [LIT_VIEW_75] = 75, [LIT_VIEW_85] = 85};
    static const double to[LIT_REGIONS] = {
        [LIT_VIEW_60] = 75, [LIT_VIEW_75] = 85, [LIT_VIEW_85] = 89.9};
    if (to[region] == 0)
        return cases_uniform(s, -60, 60) * deg;
    const double sign = cases_uniform(s, -1, 1) < 0 ? -1 : 1;
    return sign * cases_uniform(s, from[region], to[region]) * deg;
}

// s = theta_o + theta_j within one and a half widths of a lobe.
static void meet(const struct lit_sky *sky, uint64_t *s, double lambda,
                 double theta[2]) // theta_o, theta_j
{
    for (;;) {
        const int modes = sky->fibre.opaque ? 1 : EXACT_MODES;
        const int t = (int)cases_uniform(s, 0, modes);
        const double w = hypot(sqrt(8) * sky->grey.beta[t], lambda);
        const double at =
            2 * sky->grey.alpha[t] + cases_uniform(s, -1.5, 1.5) * w;
        if (sky->region == LIT_LOW) {
            const double sign = cases_uniform(s, -1, 1) < 0 ? -1 : 1;
            theta[1] = sign * cases_uniform(s, 85, 90) * deg;
            theta[0] = at - theta[1];
        } else {
            theta[0] = view_of(sky->region, s);
            theta[1] = at - theta[0];
        }
        if (fabs(theta[0]) < pi / 2 && fabs(theta[1]) < pi / 2)
            return;
    }
}

void lit_cases_place(const struct lit_sky *sky, uint64_t *state,
                     float out[PROBE_LIT_INPUTS])
{
    static const double share[LIT_CHANNELS] = {1, .8, .5};
    const int j = (int)cases_uniform(state, 0, sky->lights.count);
    const double lambda = (double)sky->lights.lambda[j], *b = sky->grey.beta;
    const double beta2 = (b[0] * b[0] + b[1] * b[1] + b[2] * b[2]) / 3;
    const double crossed = logarithmic(state, 1e-2, 30);
    double theta[2];
    meet(sky, state, lambda, theta);
    out[0] = (float)j;
    out[1] = (float)theta[1];
    out[2] = (float)cases_uniform(state, -pi, pi);
    out[3] = (float)theta[0];
    for (int k = 0; k < LIT_CHANNELS; k++)
        out[4 + k] =
            (float)sqrt(lambda * lambda + 8 * share[k] * crossed * beta2);
}

void lit_cases_direct(const struct lit_sky *sky, const struct dual_tables *dual,
                      const float place[PROBE_LIT_INPUTS], int channel,
                      double out[2])
{
    struct exact_case c = sky->grey;
    double m[EXACT_MODES], far[4];
    const double sigma[LIT_CHANNELS] = {(double)place[4], (double)place[5],
                                        (double)place[6]};
    c.sigma_a = sky->fibre.fibre.sigma_a[channel];
    c.lambda_j = (double)sky->lights.lambda[(int)place[0]];
    c.theta_j = (double)place[1];
    c.phi_j = 0;
    c.phi_o = (double)place[2];
    c.theta_o = (double)place[3];
    best_double_modes(&c, m);
    out[0] = sky->fibre.opaque ? m[0] : m[0] + m[1] + m[2];
    out[1] = 0;
    if (!sky->fibre.multiple)
        return;
    dual_double_best(dual, &c, sigma, channel, far);
    out[0] += (double)sky->fibre.d_b * dual_double_glow(dual, &c, channel);
    out[1] = (sky->fibre.opaque ? far[0] : far[0] + far[1] + far[2]) +
             (double)sky->fibre.d_b * far[3];
}

void lit_cases_plan(const struct lit_sky *sky, struct lit_plan *plan)
{
    lit_plan_make(plan, &sky->fibre, &sky->lights);
}
