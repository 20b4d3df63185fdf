// The tables of each light where one cell ends and the next begins, and what
// the 16 bits do through which theta_j and |Phi| go on their way to a place
// (shaders/lit_record.glsl): by how much the light of a place changes there.
// Ends of the tables; lights and cases apart.
#include "renderer/egl.h"
#include "tests/check.h"
#include "tests/numeric/lit_cases.h"

static const double pi = 3.14159265358979323846;
enum { IN = PROBE_LIT_INPUTS, OUT = PROBE_LIT_OUTPUTS, C = LIT_CHANNELS };
enum { THETA_J = 1, PHI, THETA_O, SIGMA };
enum { FIBRES = 16, PLACES = 60, LIGHTS = 6 };

// To either side of a border, radians: a float's place is good to 1e-6.
static const double beside = 2e-5;

enum axis { S, ALONG, ROUND, FAR_S, FAR_ALONG, FAR_ROUND, FAR_SIGMA, AXES };
static const struct {
    const char *name;
    double limits[2]; // 1.4 times what is measured: median, p99
} axes[AXES] = {
    {"s", {.023, .21}},
    {"theta_o", {.0053, .081}},
    {"Phi", {.012, .16}},
    {"s, far table", {.05, .35}},
    {"theta_o, far table", {.017, .41}},
    {"Phi, far table", {.013, .14}},
    {"ln sigma_f", {.038, .3}},
};

static bool run(struct probe_lit *p, const float *in, size_t count, float *out)
{
    struct error err = {0};
    return CHECK(probe_lit_run(p, in, count, out, &err));
}

static bool put(struct probe_lit *p, const struct lit_sky *sky)
{
    struct error err = {0};
    probe_lit_fibre(p, &sky->fibre);
    return CHECK(probe_lit_lights(p, &sky->lights, &err));
}

static double total(const float *v)
{
    return (double)v[0] + (double)v[1] + (double)v[2];
}

// What the light sends to this view at most, about, directly and forward.
static bool brightest(struct probe_lit *p, const struct lit_sky *sky,
                      const float *place, double most[2])
{
    enum { AT = 3 * EXACT_MODES };
    float in[AT * IN], out[AT * OUT];
    most[0] = most[1] = 0;
    for (int k = 0; k < AT; k++) {
        const double at = 2 * sky->grey.alpha[k / 3] - (double)place[THETA_O];
        memcpy(in + IN * k, place, IN * sizeof *in);
        in[IN * k + THETA_J] = (float)fmin(fmax(at, -1.57), 1.57);
        in[IN * k + PHI] = (float)(pi / 2 * (k % 3));
    }
    if (!run(p, in, AT, out))
        return false;
    for (int k = 0; k < AT; k++)
        for (int far = 0; far < 2; far++)
            most[far] = fmax(most[far], total(out + OUT * k +
                                              PROBE_LIT_NEAR_MODES + C * far));
    return true;
}

// theta_o at a place of the tables, 0 to 1.
static double theta_of(double view)
{
    double lo = -pi / 2, hi = pi / 2;
    for (int i = 0; i < 60; i++) {
        const double mid = (lo + hi) / 2, x = 2 / pi * mid;
        *(0.5 + x * (0.5 + 0.3 * x * x) / 1.6 < view ? &lo : &hi) = mid;
    }
    return (lo + hi) / 2;
}

// The light moved to a border of the cell above, and on by `on`.  False where
// there is none.
static bool move(const struct lit_plan *plan, enum axis axis, const float *got,
                 double on, float *in)
{
    const bool far = axis >= FAR_S;
    const float *cell = got + (far ? PROBE_LIT_FAR_AT + 1 : PROBE_LIT_NEAR_AT);
    const float *size =
        got + (far ? PROBE_LIT_FAR_SIZE + 1 : PROBE_LIT_NEAR_SIZE);
    const double theta_o = (double)in[THETA_O];
    const double s = theta_o + (double)in[THETA_J];
    const double first = (double)plan->block.far[0];
    double mean = 0, to;
    switch (axis) {
    case S:
    case FAR_S:
        to = ((double)cell[0] + 1) * (double)size[0] - pi - theta_o;
        in[THETA_J] = (float)(to + on);
        break;
    case ALONG:
    case FAR_ALONG:
        to = theta_of(((double)cell[1] + 1) /
                      (far ? LIT_PLAN_FAR_D : LIT_PLAN_D));
        in[THETA_O] = (float)(to + on);
        in[THETA_J] = (float)(s - to - on);
        return fabs((double)in[THETA_J]) < 1.57 && fabs(to) < 1.57;
    case ROUND:
    case FAR_ROUND:
        to = ((double)cell[2] + 1) * (double)size[2];
        in[PHI] = (float)(to + on);
        return to < pi - 1e-3;
    default:
        for (int c = 0; c < C; c++)
            mean += log((double)in[SIGMA + c]) / C;
        to = first + ((double)got[PROBE_LIT_FAR_AT] + 1) / 2;
        for (int c = 0; c < C; c++)
            in[SIGMA + c] *= (float)exp(to - mean + on);
    }
    return fabs((double)in[THETA_J]) < 1.57;
}

struct found {
    struct cases_errors jump[AXES], bits[2];
};

static void measure(struct probe_lit *p, const struct lit_plan *plan,
                    const float *place, const double most[2], struct found *f)
{
    float in[3 * IN], out[3 * OUT], got[OUT];
    if (!run(p, place, 1, got) ||
        total(got + PROBE_LIT_NEAR_MODES) < .01 * most[0])
        return;
    for (int axis = 0; axis < AXES; axis++) {
        const int from = axis < FAR_S ? PROBE_LIT_NEAR : PROBE_LIT_FAR;
        memcpy(in, place, IN * sizeof *in);
        memcpy(in + IN, place, IN * sizeof *in);
        if (!move(plan, (enum axis)axis, got, -beside, in) ||
            !move(plan, (enum axis)axis, got, beside, in + IN) ||
            !run(p, in, 2, out))
            continue;
        const double a = total(out + from), b = total(out + OUT + from);
        cases_add(&f->jump[axis],
                  fabs(b - a) / fmax(a, .01 * most[axis >= FAR_S]));
    }
    const double across = fabs(remainder((double)place[PHI], 2 * pi)) / pi;
    const double at = (double)place[THETA_J] / pi + 0.5;
    memcpy(in, place, IN * sizeof *in);
    in[THETA_J] = (float)((round(at * 65535) / 65535 - 0.5) * pi);
    in[PHI] = (float)(round(across * 65535) / 65535 * pi);
    if (run(p, in, 1, out))
        for (int far = 0; far < 2; far++)
            cases_add(&f->bits[far],
                      fabs(total(out + C * far) / total(got + C * far) - 1));
}

static void sweep(struct probe_lit *p, struct found *f)
{
    uint64_t state = 77;
    for (int i = 0; i < FIBRES; i++) {
        const struct lit_sky sky = lit_cases_sky(&state, LIT_TYPICAL, LIGHTS);
        struct lit_plan plan;
        if (!put(p, &sky))
            return;
        lit_cases_plan(&sky, &plan);
        for (int k = 0; k < PLACES; k++) {
            float place[IN];
            double most[2];
            lit_cases_place(&sky, &state, place);
            if (brightest(p, &sky, place, most))
                measure(p, &plan, place, most, f);
        }
    }
}

static void judge(struct found *f)
{
    for (int i = 0; i < AXES; i++) {
        struct cases_errors *e = &f->jump[i];
        printf("  %s: %zu, median %.1e, p90 %.1e, p99 %.1e\n", axes[i].name,
               e->count, cases_quantile(e, .5), cases_quantile(e, .9),
               cases_quantile(e, .99));
        CHECK(e->count > FIBRES * PLACES / 2);
        CHECK_ATMOST(cases_quantile(e, .5), axes[i].limits[0]);
        CHECK_ATMOST(cases_quantile(e, .99), axes[i].limits[1]);
        cases_finish(e);
    }
    check_case("theta_j and Phi in 16 bits");
    for (int far = 0; far < 2; far++) {
        struct cases_errors *e = &f->bits[far];
        printf("  median %.1e, most %.1e\n", cases_quantile(e, .5),
               cases_quantile(e, 1));
        // 2.4e-5 radians at most, of lobes of 3 degrees or more: 3e-4 measured
        CHECK(cases_quantile(e, .5) > 0);
        CHECK_ATMOST(cases_quantile(e, 1), 6e-4);
        cases_finish(e);
    }
}

// --- ends, neighbours --------------------------------------------------------
// Whatever is legal, at both ends of every axis: finite, not negative, no more
// than a light has, from a cell within the table.
static void ends(struct probe_lit *p)
{
    static const double sigma[] = {.002, .03, .3, 3, 11.9, 12.1, 100};
    static const double theta[] = {-90, -89.9, -60, 0, 68, 89.9, 90};
    static const double phi[] = {0, 1e-6, 90, 180, 360};
    enum { MOST = 7 * 7 * 5 * 7 };
    static float in[MOST * IN], out[MOST * OUT];
    uint64_t state = 9;
    check_case("ends of the tables");
    for (int i = 0; i < LIT_REGIONS; i++) {
        struct lit_sky sky = lit_cases_sky(&state, (enum lit_region)i, 6);
        struct lit_plan plan;
        if (i % 2)
            sky.lights.least = sky.lights.lambda[5] = 0.002f; // a sun
        if (!put(p, &sky))
            return;
        lit_cases_plan(&sky, &plan);
        for (int k = 0; k < MOST; k++) {
            float *c = in + IN * k;
            c[0] = (float)(k % sky.lights.count);
            c[1] = (float)(pi / 180 * theta[k % 7]);
            c[2] = (float)(pi / 180 * phi[k / 49 % 5]);
            c[3] = (float)(pi / 180 * theta[k / 7 % 7]);
            for (int n = 0; n < C; n++)
                c[4 + n] = (float)sigma[(k / 245 + n * (i % 3)) % 7];
        }
        if (!run(p, in, MOST, out))
            return;
        for (int k = 0; k < MOST; k++) {
            const float *o = out + OUT * k, *n = o + PROBE_LIT_NEAR_AT;
            const uint32_t *row = plan.block.light[(int)in[IN * k]];
            for (int c = 0; c < 4 * C; c++) {
                CHECK(o[c] >= 0 && isfinite(o[c]));
                // cos^2 theta_i / cos^2 theta_d <= 4 of three modes, d_b; eq 27
                // has 1/cos^2 theta_d, which fast.glsl ends at 1e4
                CHECK(o[c] <= (c / C % 2 ? 1e4F : 16));
            }
            CHECK((n[0] < 0) == (row[1] == 0));
            CHECK(n[0] < (float)(row[1] >> 16) && n[1] < LIT_PLAN_D &&
                  (n[0] < 0 || n[2] < (float)(row[1] & 0xffff)));
            if (!sky.fibre.multiple)
                continue;
            const float *f = o + PROBE_LIT_FAR_AT, *a = o + PROBE_LIT_FAR_SIZE;
            CHECK(f[0] >= 0 && f[0] < plan.block.far[1] && f[2] >= 0 &&
                  f[2] < LIT_PLAN_FAR_D && f[3] >= 0 && f[3] < LIT_PLAN_FAR_P);
            CHECK(f[1] >= 0 && f[1] <= (float)(2 * pi) / a[1] &&
                  f[1] < plan.block.far[2]);
        }
    }
}

// A light's table is the same alone and among others, a case's result the same
// in whatever batch.
static void neighbours(struct probe_lit *p)
{
    enum { MANY = 20000, APART = 40 };
    static float in[MANY * IN], out[MANY * OUT], alone[OUT];
    uint64_t state = 21;
    check_case("lights and cases apart");
    struct lit_sky sky = lit_cases_sky(&state, LIT_TYPICAL, 16);
    for (int k = 0; k < MANY; k++)
        lit_cases_place(&sky, &state, in + IN * k);
    if (!put(p, &sky) || !run(p, in, MANY, out))
        return;
    const int at[3] = {3, 8192, MANY - 1};
    for (int k = 0; k < 3; k++)
        CHECK(run(p, in + IN * at[k], 1, alone) &&
              memcmp(alone, out + OUT * at[k], sizeof alone) == 0);
    for (int k = 0; k < APART; k++) {
        float *c = in + IN * k;
        struct lit_sky one = sky;
        one.lights = lit_plan_apart(&sky.lights.lambda[(int)c[0]], 1);
        c[0] = 0;
        if (!put(p, &one) || !run(p, c, 1, alone))
            return;
        CHECK(memcmp(alone, out + OUT * k, C * sizeof *out) == 0);
        CHECK(memcmp(alone + PROBE_LIT_NEAR_AT,
                     out + OUT * k + PROBE_LIT_NEAR_AT, 3 * sizeof *out) == 0);
    }
}

int main(void)
{
    struct error err = {0};
    struct egl *egl = egl_create(&err);
    struct probe_lit *p = egl ? probe_lit_create(&err) : NULL;
    struct found f = {0};
    check_case("from one cell to the next");
    if (CHECK(p != NULL)) {
        sweep(p, &f);
        judge(&f);
        ends(p);
        neighbours(p);
    } else {
        printf("  %s\n", err.text);
    }
    probe_lit_destroy(p);
    egl_destroy(egl);
    return check_end();
}
