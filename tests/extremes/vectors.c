// vectors.c - see the header.
#include "tests/extremes/vectors.h"

#include <math.h>
#include <stdbool.h>

#include "tests/numeric/cases.h"

#define PI 3.14159265358979323846
static const double deg = PI / 180;

const struct vectors_region_row vectors_regions[VECTORS_REGIONS] = {
    {"typical",
     "eta 1.45 to 1.65, beta 5 to 10 deg, &#124;theta&#124; < 60 deg"},
    {"broad", "eta 1.3 to 2, beta 2 to 20 deg, &#124;theta&#124; < 85 deg"},
    {"eta", "1.05 to 1.2, 2.2 to 3"},
    {"merge", "eta' 2 (1 +- 1e-7 to 1e-1) at the centre of TRT"},
    {"clear", "sigma_a 0 or below 1e-3"},
    {"dark", "sigma_a 5 to 1000"},
    {"tilted", "each alpha up to +-30 deg"},
    {"sharp", "beta .1 to 1 deg"},
    {"wide", "beta 30 to 60 deg"},
    {"caustic", "w_c .5 to 2 deg or 40 to 60 deg"},
    {"flat", "a .71 to .8 or 1.25 to 1.41"},
    {"narrow light", "lambda .001 to .02"},
    {"wide light", "lambda 2 to 10"},
    {"grazing light", "&#124;theta_j&#124; 85 to 90 deg"},
    {"grazing view", "&#124;theta_o&#124; 85 to 90 deg"},
    {"turn", "Phi 0 or +-pi, +- 0 to 1e-2"},
    {"several", "two to five of the above"},
    {"box", "anything legal, logarithmic where the range is"},
    {"corner", "every value at a limit"},
    {"round", "values as people write them, some in float steps beside"},
};

static double flat(uint64_t *s, double lo, double hi)
{
    return cases_uniform(s, lo, hi);
}

static double logarithmic(uint64_t *s, double lo, double hi)
{
    return exp(cases_uniform(s, log(lo), log(hi)));
}

static bool coin(uint64_t *s)
{
    return cases_uniform(s, 0, 1) < 0.5;
}

// Between an inner value and a limit: the limit itself, the next float before
// it, a thousandth before it, or anywhere.
static double near(uint64_t *s, double inner, double limit)
{
    double turn = cases_uniform(s, 0, 4);
    if (turn < 1)
        return limit;
    if (turn < 2)
        return (double)nextafterf((float)limit, (float)inner);
    if (turn < 3)
        return limit + 1e-3 * (inner - limit);
    return cases_uniform(s, inner, limit);
}

static double signed_near(uint64_t *s, double inner, double limit)
{
    double v = near(s, inner, limit);
    return coin(s) ? v : -v;
}

// eta with which eta' is `want` where TRT's lobe has its centre.
static double eta_of(const struct exact_case *c, double want)
{
    double theta_i = 2 * c->alpha[EXACT_TRT] - c->theta_o;
    double x = cos(0.5 * (c->theta_o - theta_i));
    return sqrt(1 + (want * want - 1) * x * x);
}

static void make_fibre_extreme(struct exact_case *c, uint64_t *s, int what)
{
    switch (what) {
    case VECTORS_ETA:
        c->eta = coin(s) ? near(s, 1.2, 1.05) : near(s, 2.2, 3);
        break;
    case VECTORS_CLEAR:
        c->sigma_a = coin(s) ? 0 : logarithmic(s, 1e-30, 1e-3);
        break;
    case VECTORS_DARK:
        c->sigma_a = coin(s) ? logarithmic(s, 5, 1000) : near(s, 500, 1000);
        break;
    case VECTORS_TILTED:
        for (int t = 0; t < EXACT_MODES; t++)
            c->alpha[t] = signed_near(s, 10 * deg, 30 * deg);
        break;
    case VECTORS_SHARP:
        for (int t = 0; t < EXACT_MODES; t++)
            c->beta[t] = near(s, deg, .1 * deg);
        break;
    case VECTORS_WIDE:
        for (int t = 0; t < EXACT_MODES; t++)
            c->beta[t] = near(s, 30 * deg, 60 * deg);
        break;
    case VECTORS_CAUSTIC:
        c->w_c =
            coin(s) ? near(s, 2 * deg, .5 * deg) : near(s, 40 * deg, 60 * deg);
        break;
    default:
        c->a = coin(s) ? near(s, .8, .71) : near(s, 1.25, 1.41);
    }
}

static void make_extreme(struct exact_case *c, uint64_t *s, int what)
{
    switch (what) {
    case VECTORS_NARROW_LIGHT:
        c->lambda_j = near(s, .02, 1e-3);
        break;
    case VECTORS_WIDE_LIGHT:
        c->lambda_j = near(s, 2, 10);
        break;
    case VECTORS_GRAZING_LIGHT:
        c->theta_j = signed_near(s, 85 * deg, 90 * deg);
        break;
    case VECTORS_GRAZING_VIEW:
        c->theta_o = signed_near(s, 85 * deg, 90 * deg);
        break;
    case VECTORS_TURN:
        c->phi_j = coin(s) ? -PI : PI;
        c->phi_o = coin(s) ? 0 : coin(s) ? -PI : PI;
        c->phi_o += coin(s) ? 0 : flat(s, -1, 1) * logarithmic(s, 1e-7, 1e-2);
        break;
    case VECTORS_MERGE:
        c->eta = eta_of(c, 2 + (coin(s) ? 1 : -1) * logarithmic(s, 2e-7, .2));
        break;
    default:
        make_fibre_extreme(c, s, what);
    }
}

static void fill_box(struct exact_case *c, uint64_t *s)
{
    c->eta = flat(s, 1.05, 3);
    c->sigma_a = logarithmic(s, 1e-3, 1000);
    for (int t = 0; t < EXACT_MODES; t++) {
        c->alpha[t] = flat(s, -30, 30) * deg;
        c->beta[t] = logarithmic(s, .1, 60) * deg;
    }
    c->w_c = logarithmic(s, .5, 60) * deg;
    c->a = coin(s) ? 1 : flat(s, .71, 1.41);
    c->lambda_j = logarithmic(s, 1e-3, 10);
    c->theta_j = flat(s, -90, 90) * deg;
    c->theta_o = flat(s, -90, 90) * deg;
    c->phi_j = flat(s, -180, 180) * deg;
    c->phi_o = flat(s, -180, 180) * deg;
}

static void fill_corner(struct exact_case *c, uint64_t *s)
{
    c->eta = coin(s) ? 1.05 : 3;
    c->sigma_a = coin(s) ? 0 : 1000;
    for (int t = 0; t < EXACT_MODES; t++) {
        c->alpha[t] = (coin(s) ? -30 : 30) * deg;
        c->beta[t] = (coin(s) ? .1 : 60) * deg;
    }
    c->w_c = (coin(s) ? .5 : 60) * deg;
    c->a = coin(s) ? 1 : coin(s) ? .71 : 1.41;
    c->lambda_j = coin(s) ? 1e-3 : 10;
    c->theta_j = coin(s) ? 0 : (coin(s) ? -90 : 90) * deg;
    c->theta_o = coin(s) ? 0 : (coin(s) ? -90 : 90) * deg;
    c->phi_j = coin(s) ? 0 : (coin(s) ? -180 : 180) * deg;
    c->phi_o = coin(s) ? 0 : (coin(s) ? -180 : 180) * deg;
}

// What no random number meets: zeros, halves and doubles of each other, a light
// as wide as a caustic, lobe and light centre on centre or right opposite.
#define ONE_OF(s, list) one_of(s, list, (int)(sizeof(list) / sizeof *(list)))
static double one_of(uint64_t *s, const double *list, int count)
{
    return list[(int)flat(s, 0, count)];
}

// Up to two floats away, in one of two cases.
static double beside(uint64_t *s, double v)
{
    float f = (float)v;
    for (int n = coin(s) ? (int)flat(s, 0, 3) : 0; n > 0; n--)
        f = nextafterf(f, coin(s) ? 9 : -9);
    return (double)f;
}

static void fill_round_fibre(struct exact_case *c, uint64_t *s)
{
    static const double eta[] = {
        1.05, 1.1, 1.2,        1.25, 1.3, 1.33, 1.41421356, 1.4,  1.5, 1.55,
        1.6,  1.7, 1.73205081, 1.75, 2,   2.25, 2.5,        2.75, 3};
    static const double sigma[] = {0,  .01, .05, .1, .15, .2,  .25,
                                   .5, 1,   2,   5,  10,  100, 1000};
    static const double alpha[] = {0, 0, -2, -3, -5, -7.5, -10, 5, -30, 30};
    static const double width[] = {.5, 1,  2,  2.5, 5,  7.5,
                                   10, 15, 20, 30,  45, 60};
    static const double a[] = {1, 1, 1, 1, .71, .8, .9, 1.1, 1.25, 1.41};
    c->eta = ONE_OF(s, eta);
    c->sigma_a = ONE_OF(s, sigma);
    c->alpha[0] = ONE_OF(s, alpha) * deg;
    c->beta[0] = ONE_OF(s, width) * deg;
    bool alike = coin(s); // else tied as the parameters' `auto` has them
    c->alpha[1] = c->alpha[0] * (alike ? 1 : -.5);
    c->alpha[2] = c->alpha[0] * (alike ? 1 : -1.5);
    c->beta[1] = c->beta[0] * (alike ? 1 : .5);
    c->beta[2] = c->beta[0] * (alike ? 1 : 2);
    c->w_c = ONE_OF(s, width) * deg;
    c->a = ONE_OF(s, a);
}

static void fill_round(struct exact_case *c, uint64_t *s)
{
    static const double lambda[] = {.001, .002, .01, .02, .05, .1, .2,
                                    .25,  .5,   1,   1.5, 2,   5,  10};
    static const double width[] = {.5, 1,  2,  2.5, 5,  7.5,
                                   10, 15, 20, 30,  45, 60};
    static const double theta[] = {0,   0,   0,   10,  15,  30,  45,
                                   60,  75,  80,  89,  90,  -5,  -10,
                                   -15, -30, -45, -60, -75, -80, -90};
    static const double phi[] = {0,   0,   0,   15,  30,  45,  60,  90,   120,
                                 135, 150, 180, 180, 180, -30, -90, -180, 360};
    fill_round_fibre(c, s);
    c->lambda_j = coin(s) ? ONE_OF(s, lambda) : ONE_OF(s, width) * deg;
    c->theta_j = ONE_OF(s, theta) * deg;
    c->theta_o = ONE_OF(s, theta) * deg;
    if (coin(s)) // centre on centre, where that is legal
        c->theta_o = 2 * c->alpha[(int)flat(s, 0, EXACT_MODES)] - c->theta_j;
    c->phi_j = beside(s, ONE_OF(s, phi) * deg);
    c->phi_o = beside(s, ONE_OF(s, phi) * deg);
    c->lambda_j = beside(s, c->lambda_j);
    c->theta_j = beside(s, c->theta_j);
    c->theta_o = beside(s, c->theta_o);
}

// A float's limit may lie beyond the double's (pi/2): bring it inside.
static double inside(double v, double lo, double hi)
{
    float f = (float)fmin(fmax(v, lo), hi);
    if ((double)f > hi)
        f = nextafterf(f, (float)lo);
    if ((double)f < lo)
        f = nextafterf(f, (float)hi);
    return (double)f;
}

static void round_to_floats(struct exact_case *c)
{
    c->eta = inside(c->eta, 1.05, 3);
    c->sigma_a = inside(c->sigma_a, 0, 1000);
    for (int t = 0; t < EXACT_MODES; t++) {
        c->alpha[t] = inside(c->alpha[t], -PI / 6, PI / 6);
        c->beta[t] = inside(c->beta[t], .1 * deg, 60 * deg);
    }
    c->w_c = inside(c->w_c, .5 * deg, 60 * deg);
    c->a = inside(c->a, .71, 1.41);
    c->lambda_j = inside(c->lambda_j, 1e-3, 10);
    // The shader gets the rounded half turn, as people write it.
    c->theta_j = (double)(float)fmin(fmax(c->theta_j, -PI / 2), PI / 2);
    c->theta_o = (double)(float)fmin(fmax(c->theta_o, -PI / 2), PI / 2);
    c->phi_j = (double)(float)c->phi_j;
    c->phi_o = (double)(float)c->phi_o;
}

// Most of what is extreme lights nothing. Brings light and view of half of the
// cases into one mode's cone.
static void meet(struct exact_case *c, uint64_t *s, bool move_view)
{
    int t = (int)flat(s, 0, EXACT_MODES);
    double w = 2 * sqrt(2) * c->beta[t];
    double off = flat(s, -1, 1) * sqrt(w * w + c->lambda_j * c->lambda_j);
    double *moved = move_view ? &c->theta_o : &c->theta_j;
    double kept = move_view ? c->theta_j : c->theta_o;
    double v = 2 * c->alpha[t] - kept + off;
    if (fabs(v) <= PI / 2 && coin(s))
        *moved = v;
}

struct exact_case vectors_case(uint64_t *s, enum vectors_region region)
{
    enum cases_kind kind =
        region == VECTORS_BROAD ? CASES_BROAD : CASES_TYPICAL;
    struct exact_case c = cases_random(s, kind, 0);
    c.delta_eta = 0.3;
    if (region == VECTORS_BOX)
        fill_box(&c, s);
    else if (region == VECTORS_CORNER)
        fill_corner(&c, s);
    else if (region == VECTORS_ROUND)
        fill_round(&c, s);
    else if (region == VECTORS_SEVERAL)
        for (int n = 2 + (int)flat(s, 0, 4); n > 0; n--)
            make_extreme(&c, s, (int)flat(s, VECTORS_FIRST, VECTORS_SEVERAL));
    else if (region >= VECTORS_FIRST)
        make_extreme(&c, s, (int)region);
    if (region >= VECTORS_FIRST && region < VECTORS_CORNER)
        meet(&c, s, region == VECTORS_GRAZING_LIGHT);
    round_to_floats(&c);
    return c;
}

double vectors_widened(const struct exact_case *c, uint64_t *s)
{
    double beta2 = 0;
    for (int t = 0; t < EXACT_MODES; t++)
        beta2 += c->beta[t] * c->beta[t] / 3;
    double n = coin(s) ? logarithmic(s, 1e-3, 50) : 0;
    return (double)(float)sqrt(c->lambda_j * c->lambda_j + 8 * n * beta2);
}
