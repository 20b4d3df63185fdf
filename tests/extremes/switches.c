// switches.c - see the header.  A switch is a place on a line through the
// inputs.  Values at -3, -1, 1 and 3 steps from it tell the jump from the
// slope: f(1) - f(-1), less what the slopes of both sides make of these two
// steps.
#include "tests/extremes/switches.h"

#include <math.h>
#include <stdlib.h>

#include "tests/check.h"

#define PI 3.14159265358979323846

enum {
    NOWHERE,
    MERGE,
    SIDE_ROOTS,
    MERGED,
    LOW_EDGE,
    LOW_CENTRE,
    LOW_LAST,
    HIGH_EDGE,
    HIGH_CENTRE,
    HIGH_LAST,
    BRIEF,
    BESSEL,
    CIRCLE,
    BEHIND,
    BEFORE,
    LEVEL,
    TABLE_END
};

const struct switches_row switches_rows[SWITCHES] = {
    {"none", "anywhere: what the measurement itself makes"},
    {"eta' = 2", "three lobes of TRT become one (eq 20, 23)"},
    {"eta' = sqrt 2", "two more roots of N_TRT(0)"},
    {"eta' = 2 + delta_eta", "the caustic's width has merged"},
    {"theta_i = -90 deg at t = -1", "a node leaves the range"},
    {"theta_i = -90 deg at t = 0", "the middle node leaves"},
    {"theta_i = -90 deg at t = 1", "the last node leaves"},
    {"theta_i = 90 deg at t = 1", "a node leaves the range"},
    {"theta_i = 90 deg at t = 0", "the middle node leaves"},
    {"theta_i = 90 deg at t = -1", "the last node leaves"},
    {"end segment half a width long", "a sum in place of erf (fine nodes)"},
    {"kappa' = 4.5", "the two polynomials of I_0"},
    {"a = 1", "circular and eccentric variant"},
    {"Phi = pi", "the ends of the circle meet"},
    {"Phi = 0", "tables of Phi are mirrored"},
    {"theta_d = 0", "tables of theta_d are mirrored"},
    {"lambda' = 10", "the tables' end"},
};

// The Gaussian of mode t: centre and width as scheme `paper` has them.
static void product(const struct exact_case *c, int t, double *mu, double *l)
{
    double w = 2 * sqrt(2) * c->beta[t], l2 = c->lambda_j * c->lambda_j;
    double both = w * w + l2, apart = 2 * c->alpha[t] - c->theta_o - c->theta_j;
    *mu = c->theta_j + apart * l2 / both;
    *l = w * c->lambda_j / sqrt(both);
}

// Sets theta_o so that theta_i = edge falls on t of mode `mode`.
static bool put_edge(struct exact_case *c, int mode, double edge, double t)
{
    double mu, l, w = 2 * sqrt(2) * c->beta[mode];
    product(c, mode, &mu, &l);
    double share =
        c->lambda_j * c->lambda_j / (w * w + c->lambda_j * c->lambda_j);
    c->theta_o += (mu - (edge - t * l)) / share; // d mu / d theta_o = -share
    return fabs(c->theta_o) < PI / 2 - 0.01;
}

static void put_eta(struct exact_case *c, int mode, double want)
{
    double mu, l;
    product(c, mode, &mu, &l);
    double x = cos(0.5 * (c->theta_o - mu));
    c->eta = sqrt(1 + (want * want - 1) * x * x);
}

// Brings a typical case to the switch; *moved is what crosses it, *step how far
// a step goes.  False when this case cannot.
static bool place(int which, struct exact_case *c, int mode, double **moved,
                  double *step)
{
    static const double at[] = {
        [LOW_EDGE] = -1, [LOW_CENTRE] = 0,  [LOW_LAST] = 1,
        [HIGH_EDGE] = 1, [HIGH_CENTRE] = 0, [HIGH_LAST] = -1};
    double mu, l;
    *moved = &c->theta_o;
    *step = 1e-5;
    switch (which) {
    case MERGE:
    case SIDE_ROOTS:
    case MERGED:
        put_eta(c, EXACT_TRT,
                which == MERGE        ? 2
                : which == SIDE_ROOTS ? sqrt(2)
                                      : 2 + c->delta_eta);
        *moved = &c->eta;
        return c->eta > 1.06 && c->eta < 2.9;
    case LOW_EDGE:
    case LOW_CENTRE:
    case LOW_LAST:
        return put_edge(c, mode, -PI / 2, at[which]);
    case HIGH_EDGE:
    case HIGH_CENTRE:
    case HIGH_LAST:
        return put_edge(c, mode, PI / 2, at[which]);
    case BRIEF: // the outermost fine node of m = 16 stands at sqrt 7 widths
        return put_edge(c, mode, PI / 2, sqrt(7) + 0.5);
    case BESSEL:
    case TABLE_END:
        if (which == TABLE_END)
            c->lambda_j = 8;
        product(c, EXACT_R, &mu, &l);
        c->lambda_j = sqrt(2 * cos(c->theta_j) * fmax(cos(mu), 0) /
                           (which == BESSEL ? 4.5 : 0.02));
        *moved = &c->lambda_j;
        return c->lambda_j > 0.01 && c->lambda_j < 10;
    case CIRCLE:
        *moved = &c->a;
        return true;
    case BEHIND:
    case BEFORE:
        c->phi_o = c->phi_j + (which == BEHIND ? PI : 0);
        *moved = &c->phi_o;
        return true;
    case LEVEL:
        product(c, mode, &mu, &l);
        c->theta_o = c->theta_j;
        return true;
    default:
        return true;
    }
}

enum { POINTS = 4 };

static void add_jumps(const float *v, int mode, struct cases_errors *jumps)
{
    double f[POINTS], top = 0;
    for (int k = 0; k < POINTS; k++) {
        f[k] = (double)v[PROBE_OUTPUTS * k + mode];
        top = fmax(top, f[k]);
    }
    double jump = f[2] - f[1] - 0.5 * (f[3] - f[2] + f[1] - f[0]);
    // Modes are of order 1e-2: what is below 1e-3 is judged by that.
    cases_add(jumps, fabs(jump) / fmax(top, 1e-3));
}

void switches_measure(int which, const struct single_way *way, int count,
                      struct cases_errors *jumps)
{
    uint64_t state = 40 + (uint64_t)which;
    size_t size = (size_t)count * POINTS;
    float *in = calloc(size * PROBE_INPUTS, sizeof *in);
    float *out = calloc(size * PROBE_OUTPUTS, sizeof *out);
    if (!in || !out)
        abort();
    int made = 0;
    for (int tries = 0; made < count && tries < 400 * count; tries++) {
        struct exact_case c = cases_random(&state, CASES_TYPICAL, 0);
        double *moved, step;
        c.delta_eta = 0.3;
        if (which >= LOW_EDGE && which <= BRIEF) // a light that reaches there
            c.lambda_j = cases_uniform(&state, 0.3, 1.5);
        if (!place(which, &c, tries % EXACT_MODES, &moved, &step))
            continue;
        double centre = *moved;
        for (int k = 0; k < POINTS; k++) {
            *moved = centre + step * (2 * k - 3);
            cases_to_floats(&c, in + PROBE_INPUTS * (POINTS * made + k));
        }
        made++;
    }
    struct error err = {0};
    struct probe *p = single_probe(way);
    if (p)
        probe_note_guards(p, NULL);
    if (CHECK(p) && CHECK(probe_run(p, in, (size_t)(made * POINTS), out, &err)))
        for (int i = 0; i < made; i++)
            for (int t = 0; t < EXACT_MODES; t++)
                add_jumps(out + PROBE_OUTPUTS * POINTS * i, t, jumps);
    free(in);
    free(out);
}
