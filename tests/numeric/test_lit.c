// The tables of each light, cells and all: what passes and shaders make of a
// cell against the same in double precision; errors against the tables of
// modes, of which cells are made, and against the direct evaluation in double
// precision.
// GLINT_LONG=1: more cases, and docs/METHODS.md's table of errors.
#include "renderer/egl.h"
#include "tests/check.h"
#include "tests/numeric/lit_cases.h"
#include "tests/numeric/lit_double.h"

#include <stdlib.h>

static const double pi = 3.14159265358979323846;
enum { IN = PROBE_LIT_INPUTS, OUT = PROBE_LIT_OUTPUTS, C = LIT_CHANNELS };

static bool put(struct probe_lit *p, const struct lit_sky *sky)
{
    struct error err = {0};
    probe_lit_fibre(p, &sky->fibre);
    if (CHECK(probe_lit_lights(p, &sky->lights, &err)))
        return true;
    printf("  %s\n", err.text);
    return false;
}

static bool run(struct probe_lit *p, const float *in, size_t count, float *out)
{
    struct error err = {0};
    if (CHECK(probe_lit_run(p, in, count, out, &err)))
        return true;
    printf("  %s\n", err.text);
    return false;
}

// --- a cell, in double precision --------------------------------------------
// theta_o at which a place of the tables, 0 to 1, stands; and back.
static double view_of(double theta)
{
    const double x = 2 / pi * theta;
    return 0.5 + x * (0.5 + 0.3 * x * x) / 1.6;
}

static double theta_of(double view)
{
    double lo = -pi / 2, hi = pi / 2;
    for (int i = 0; i < 60; i++) {
        const double mid = (lo + hi) / 2;
        *(view_of(mid) < view ? &lo : &hi) = mid;
    }
    return (lo + hi) / 2;
}

enum {
    SIDE = LIT_DOUBLE_SIDE,
    PHIS = LIT_DOUBLE_PHIS,
    ROUND = SIDE * SIDE * PHIS
};

struct cell { // of one table
    int s, d, phi, rows, views, phis;
    double size; // of s
    bool even;   // at Phi = 0
};

static int clamped(int i, int count)
{
    return i < 0 ? 0 : i < count ? i : count - 1;
}

// The places whose values make it: middles of the cells round it.
static void surround(const struct cell *c, float light, double sigma, float *in)
{
    for (int i = 0; i < ROUND; i++, in += IN) {
        const int s = clamped(c->s + i / (SIDE * PHIS) - 1, c->rows);
        const int d = clamped(c->d + i / PHIS % SIDE - 1, c->views);
        int phi = c->phi + i % PHIS - PHIS / 2;
        if (phi < 0 && c->even)
            phi = -phi - 1;
        phi = clamped(phi, c->phis);
        const double theta_o = theta_of((d + 0.5) / c->views);
        const double theta_j = (s + 0.5) * c->size - pi - theta_o;
        in[0] = light;
        in[1] = (float)fmin(fmax(theta_j, -1.5706), 1.5706);
        // 1e-6: middles lie on borders of the modes' cells, on whose far side
        // the passes are exactly
        in[2] = (float)(pi * ((phi + 0.5) / c->phis + 1e-6));
        in[3] = (float)theta_o;
        for (int k = 0; k < C; k++)
            in[4 + k] = (float)sigma;
    }
}

static void take(const float *out, int from, struct lit_double_values *v)
{
    for (int i = 0; i < ROUND; i++)
        for (int k = 0; k < C; k++)
            v->at[i / (SIDE * PHIS)][i / PHIS % SIDE][i % PHIS][k] =
                (double)out[OUT * i + from + k];
}

static struct lit_double_at at_of(const struct cell *c, const float *in)
{
    const double s = (double)in[3] + (double)in[1];
    const double across = fabs(remainder((double)in[2], 2 * pi)) / pi;
    struct lit_double_at at = {
        .x = {(s + pi) / c->size - c->s - 0.5,
              view_of((double)in[3]) * c->views - c->d - 0.5,
              across * c->phis - c->phi - 0.5},
        .edge = c->d == 0 || c->d == c->views - 1,
        .phi = c->phi,
        .phis = c->phis};
    return at;
}

struct tally { // how far the shaders are from the copy, in parts of its bound
    long cells, far, plain, full;
    double most;
};

static void compare(struct lit_double_result want, const float *got,
                    const double *plain, struct tally *t)
{
    for (int k = 0; k < C; k++) {
        const double off = fabs((double)got[k] - want.value[k]);
        const double loose = want.packing[k] + 1e-12;
        t->most = fmax(t->most, off / loose);
        // .80 of the bound was measured.
        if (!CHECK(off <= loose))
            printf("  got %.6g, want %.6g +- %.2g\n", (double)got[k],
                   want.value[k], loose);
        t->plain += fabs(plain[k] - want.value[k]) > loose;
    }
    t->full += want.full;
    t->cells += C;
}

static void near_cell(struct probe_lit *p, const struct lit_plan *plan,
                      const float *in, const float *got, struct tally *t)
{
    const int light = (int)in[0];
    const float *i = got + PROBE_LIT_NEAR_AT;
    const uint32_t *row = plan->block.light[light];
    const struct cell c = {.s = (int)i[0],
                           .d = (int)i[1],
                           .phi = (int)i[2],
                           .rows = (int)(row[1] >> 16),
                           .views = LIT_PLAN_D,
                           .phis = (int)(row[1] & 0xffff),
                           .size = (double)got[PROBE_LIT_NEAR_SIZE],
                           .even = true};
    static float round[ROUND * IN], out[ROUND * OUT];
    struct lit_double_values v;
    surround(&c, in[0], 1, round);
    if (!run(p, round, ROUND, out))
        return;
    take(out, PROBE_LIT_NEAR_MODES, &v);
    const struct lit_double_at at = at_of(&c, in);
    compare(lit_double_near(&v, &at), got + PROBE_LIT_NEAR, v.at[1][1][2], t);
}

static void far_cell(struct probe_lit *p, const struct lit_plan *plan,
                     const float *in, const float *got, struct tally *t)
{
    const float *i = got + PROBE_LIT_FAR_AT;
    const double size = (double)got[PROBE_LIT_FAR_SIZE + 1];
    const struct cell c = {.s = (int)i[1],
                           .d = (int)i[2],
                           .phi = (int)i[3],
                           .rows = (int)(2 * pi / size) + 1,
                           .views = LIT_PLAN_FAR_D,
                           .phis = LIT_PLAN_FAR_P,
                           .size = size};
    static float round[ROUND * IN], out[ROUND * OUT];
    struct lit_double_values v[3];
    double w[C];
    const double first = (double)plan->block.far[0];
    for (int y = -1; y <= 1; y++) {
        const double log_sigma = first + ((double)i[0] + 0.5 + y) / 2;
        surround(&c, in[0], exp(log_sigma), round);
        if (!run(p, round, ROUND, out))
            return;
        take(out, PROBE_LIT_FAR_MODES, &v[y + 1]);
    }
    for (int k = 0; k < C; k++)
        w[k] = 2 * (log((double)in[4 + k]) - first) - (double)i[0] - 0.5;
    const struct lit_double_at at = at_of(&c, in);
    compare(lit_double_far(v, &at, w), got + PROBE_LIT_FAR, v[1].at[1][1][2],
            t);
}

static void cells(struct probe_lit *p)
{
    enum { PLACES = 48 };
    uint64_t state = 5;
    struct tally near = {0}, far = {0};
    static float in[PLACES * IN], out[PLACES * OUT];
    for (int i = 0; i < LIT_SHARED; i++) { // then cells are of another width
        const struct lit_sky sky = lit_cases_sky(&state, (enum lit_region)i, 2);
        struct lit_plan plan;
        if (!put(p, &sky))
            return;
        lit_cases_plan(&sky, &plan);
        for (int k = 0; k < PLACES; k++) {
            lit_cases_place(&sky, &state, in + IN * k);
            if (k % 3 == 0) // where cells end otherwise than within
                in[IN * k + 2] = (float)cases_uniform(&state, pi - 0.2, pi);
        }
        if (!run(p, in, PLACES, out))
            return;
        for (int k = 0; k < PLACES; k++) {
            const float *o = out + OUT * k;
            if (o[PROBE_LIT_NEAR_AT] >= 0)
                near_cell(p, &plan, in + IN * k, o, &near);
            if (sky.fibre.multiple)
                far_cell(p, &plan, in + IN * k, o, &far);
        }
    }
    printf(
        "  lights' tables: %ld, of their bound %.2f; %ld would be off as one "
        "value; %ld full\n  far table: %ld, %.2f, %ld; %ld\n",
        near.cells, near.most, near.plain, near.full, far.cells, far.most,
        far.plain, far.full);
    CHECK(near.cells > 1800 && far.cells > 1800);
    CHECK(near.plain > near.cells / 2 && far.plain > far.cells / 2);
    CHECK(near.full > 0 && far.full > 0);
}

// --- errors ------------------------------------------------------------------
// Of cells against the tables of modes; of these, and of cells, against the
// direct evaluation.
enum { CELLS, MODES, WHOLE, KINDS };
enum { NEAR, FAR, SUMS };
enum { AROUND = 16 }; // places round Phi, for the mean

struct errors {
    struct cases_errors of[SUMS][KINDS];
    long places, read; // read: whose light has a table
};

// What a light sends to the view of place i at most, by the tables of modes:
// the mean over Phi where it stands at the centre of one lobe or another.
static bool means(struct probe_lit *p, const struct lit_sky *sky,
                  const float *in, int places, double (*mean)[2][C])
{
    enum { ALL = EXACT_MODES * AROUND };
    static float round[ALL * IN], out[ALL * OUT];
    for (int i = 0; i < places; i++, in += IN) {
        memset(mean[i], 0, sizeof mean[i]);
        for (int k = 0; k < ALL; k++) {
            float *r = round + IN * k;
            const double at = 2 * sky->grey.alpha[k / AROUND] - (double)in[3];
            memcpy(r, in, IN * sizeof *in);
            r[1] = (float)fmin(fmax(at, -1.57), 1.57);
            r[2] = (float)(pi * (k % AROUND + 0.45) / AROUND);
        }
        if (!run(p, round, ALL, out))
            return false;
        for (int t = 0; t < EXACT_MODES; t++)
            for (int c = 0; c < C; c++) {
                double sum[2] = {0};
                for (int k = 0; k < AROUND; k++) {
                    const float *o = out + OUT * (AROUND * t + k) + c;
                    sum[0] += (double)o[PROBE_LIT_NEAR_MODES] / AROUND;
                    sum[1] += (double)o[PROBE_LIT_FAR_MODES] / AROUND;
                }
                mean[i][0][c] = fmax(mean[i][0][c], sum[0]);
                mean[i][1][c] = fmax(mean[i][1][c], sum[1]);
            }
    }
    return true;
}

static void put_errors(const struct lit_sky *sky, const float *got,
                       double (*mean)[C], struct errors *e)
{
    for (int k = 0; k < (sky->fibre.multiple ? SUMS : FAR); k++)
        for (int c = 0; c < C; c++) {
            const float *o = got + 3 * k + c;
            if (k == FAR || got[PROBE_LIT_NEAR_AT] >= 0)
                cases_add(&e->of[k][CELLS],
                          cases_error((double)*o,
                                      (double)o[PROBE_LIT_NEAR_MODES],
                                      mean[k][c]));
        }
    e->places++;
    e->read += got[PROBE_LIT_NEAR_AT] >= 0;
}

// One channel: it takes five milliseconds.
static void put_direct(const struct lit_sky *sky,
                       const struct dual_tables *dual, const float *in,
                       const float *got, double (*mean)[C], struct errors *e)
{
    const int c = (int)e->places % C;
    double want[SUMS];
    lit_cases_direct(sky, dual, in, c, want);
    for (int k = 0; k < (sky->fibre.multiple ? SUMS : FAR); k++) {
        const float *o = got + 3 * k + c;
        cases_add(&e->of[k][WHOLE],
                  cases_error((double)*o, want[k], mean[k][c]));
        cases_add(&e->of[k][MODES], cases_error((double)o[PROBE_LIT_NEAR_MODES],
                                                want[k], mean[k][c]));
    }
}

struct amount {
    int fibres, lights, places, direct; // direct: of the places
};

static void measure(struct probe_lit *p, enum lit_region region,
                    const struct amount *n, struct errors *e)
{
    enum { MOST = 160 };
    static float in[MOST * IN], out[MOST * OUT];
    static double mean[MOST][2][C];
    uint64_t state = 40 + (uint64_t)region;
    struct dual_tables *dual = dual_tables_create();
    for (int i = 0; i < n->fibres; i++) {
        const struct lit_sky sky = lit_cases_sky(&state, region, n->lights);
        dual_tables_update(dual, &sky.fibre.fibre, DUAL_SCHEME_BEST);
        for (int k = 0; k < n->places; k++)
            lit_cases_place(&sky, &state, in + IN * k);
        if (!put(p, &sky) || !run(p, in, (size_t)n->places, out) ||
            !means(p, &sky, in, n->places, mean))
            break;
        for (int k = 0; k < n->places; k++) {
            put_errors(&sky, out + OUT * k, mean[k], e);
            if (k < n->direct)
                put_direct(&sky, dual, in + IN * k, out + OUT * k, mean[k], e);
        }
    }
    dual_tables_destroy(dual);
}

// A row of docs/METHODS.md's table.
static void print_row(const char *name, struct cases_errors of[KINDS])
{
    printf("| %s", name);
    for (int k = 0; k < KINDS; k++)
        printf(" | %.1e / %.1e / %.1e / %.1e", cases_quantile(&of[k], 0.5),
               cases_quantile(&of[k], 0.9), cases_quantile(&of[k], 0.99),
               cases_quantile(&of[k], 1));
    printf(" |\n");
}

// 1.4 times what is measured of these cases, for another driver's rounding: of
// cells against modes the median and p90, of the whole the p90.  Other cases
// are looked at with GLINT_LONG: up to 1.2 times these limits.
static const double limits[LIT_REGIONS][SUMS][3] = {
    [LIT_TYPICAL] = {{0.0094, 0.036, 0.045}, {0.021, 0.081, 0.07}},
    [LIT_BROAD] = {{0.014, 0.049, 0.073}, {0.031, 0.11, 0.13}},
    [LIT_SHARP] = {{0.012, 0.049, 0.057}, {0.032, 0.13, 0.17}},
    [LIT_WIDE] = {{0.014, 0.083, 0.14}, {0.029, 0.1, 0.11}},
    [LIT_NARROW] = {{0.0088, 0.046, 0.097}, {0.017, 0.062, 0.062}},
    [LIT_BRIGHT] = {{0.0055, 0.015, 0.025}, {0.028, 0.09, 0.087}},
    [LIT_VIEW_60] = {{0.011, 0.036, 0.045}, {0.031, 0.14, 0.14}},
    [LIT_VIEW_75] = {{0.015, 0.052, 0.071}, {0.1, 0.32, 0.29}},
    [LIT_VIEW_85] = {{0.06, 0.21, 0.25}, {0.2, 0.67, 0.69}},
    [LIT_LOW] = {{0.029, 0.1, 0.097}, {0.091, 0.31, 0.21}},
    [LIT_CLEAR] = {{0.01, 0.038, 0.027}, {0.02, 0.071, 0.05}},
    [LIT_DARK] = {{0.0094, 0.035, 0.025}, {0.025, 0.087, 0.071}},
    [LIT_OPAQUE] = {{0.013, 0.039, 0.039}, {0.025, 0.084, 0.069}},
    [LIT_SINGLE] = {{0.011, 0.039, 0.041}},
    [LIT_SHARED] = {{0.0088, 0.042, 0.052}, {0.021, 0.085, 0.046}},
};

static void judge_row(enum lit_region region, int sum,
                      struct cases_errors of[KINDS])
{
    const double *limit = limits[region][sum];
    const double room = getenv("GLINT_LONG") ? 1.3 : 1;
    print_row(lit_region_names[region], of);
    CHECK_ATMOST(cases_quantile(&of[CELLS], 0.5), room * limit[0]);
    CHECK_ATMOST(cases_quantile(&of[CELLS], 0.9), room * limit[1]);
    CHECK_ATMOST(cases_quantile(&of[WHOLE], 0.9), room * limit[2]);
}

static void errors(struct probe_lit *p)
{
    static struct errors e[LIT_REGIONS];
    const bool at_length = getenv("GLINT_LONG") != NULL;
    const struct amount n = at_length ? (struct amount){24, 8, 160, 20}
                                      : (struct amount){3, 3, 60, 12};
    for (int i = 0; i < LIT_REGIONS; i++)
        measure(p, (enum lit_region)i, &n, &e[i]);
    for (int k = 0; k < SUMS; k++) {
        printf("%s\n", k == FAR ? "forward" : "directly");
        for (int i = 0; i < LIT_REGIONS; i++)
            if (e[i].of[k][CELLS].count > 0)
                judge_row((enum lit_region)i, k, e[i].of[k]);
    }
    for (int i = 0; i < LIT_REGIONS; i++)
        for (int k = 0; k < SUMS * KINDS; k++)
            cases_finish(&e[i].of[k / KINDS][k % KINDS]);
}

int main(void)
{
    struct error err = {0};
    struct egl *egl = egl_create(&err);
    struct probe_lit *p = egl ? probe_lit_create(&err) : NULL;
    check_case("the probe starts");
    if (CHECK(p != NULL)) {
        check_case("cells are what double precision makes of them");
        cells(p);
        check_case("errors");
        errors(p);
    } else {
        printf("  %s\n", err.text);
    }
    probe_lit_destroy(p);
    egl_destroy(egl);
    return check_end();
}
