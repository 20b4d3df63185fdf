// switches_dual.c - see the header.
#include "tests/extremes/switches_dual.h"

#include <math.h>

#include "tests/check.h"

#define PI 3.14159265358979323846
enum { IN = PROBE_DUAL_INPUTS, OUT = PROBE_DUAL_OUTPUTS, POINTS = 4 };
enum { NOWHERE, QUARTER, BEHIND, CUT_LOW, CUT_HIGH, LAST, SPREAD, BESSEL };

const struct switches_row switches_dual_rows[SWITCHES_DUAL] = {
    {"none", "anywhere: what the measurement itself makes"},
    {"Phi = pi/2", "the light passes to the other half circle"},
    {"Phi = pi", "the ends of the circle meet"},
    {"theta_i = -90 deg at t = -1.985", "the five nodes are cut off (best)"},
    {"theta_i = 90 deg at t = 1.985", "the five nodes are cut off (best)"},
    {"theta_i = 90 deg at t = -.985", "the nodes keep one width (best)"},
    {"sigma_f = .04", "the least span of a mean over theta (paper)"},
    {"kappa = 4.5", "the two polynomials of I_0"},
};

struct case_at { // the light, the view and what the crossings made of it
    struct exact_case c;
    double sigma_f;
};

// Sets theta_o so that theta_i = edge falls on t of a mode's product with
// psi_f.
static bool put_edge(struct case_at *a, int mode, double edge, double t)
{
    struct exact_case *c = &a->c;
    double w2 = 8 * c->beta[mode] * c->beta[mode];
    double s2 = a->sigma_f * a->sigma_f, share = s2 / (s2 + w2);
    double apart = 2 * c->alpha[mode] - c->theta_o - c->theta_j;
    double mu = c->theta_j + apart * share, l = sqrt(w2 * share);
    c->theta_o += (mu - (edge - t * l)) / share;
    return fabs(c->theta_o) < PI / 2 - 0.01;
}

static bool place(int which, struct case_at *a, int mode, double **moved)
{
    struct exact_case *c = &a->c;
    *moved = &c->theta_o;
    switch (which) {
    case QUARTER:
    case BEHIND:
        c->phi_o = c->phi_j + (which == BEHIND ? PI : PI / 2);
        *moved = &c->phi_o;
        return true;
    case CUT_LOW:
        return put_edge(a, mode, -PI / 2, -1.985);
    case CUT_HIGH:
        return put_edge(a, mode, PI / 2, 1.985);
    case LAST:
        return put_edge(a, mode, PI / 2, -0.985);
    case SPREAD:
        c->lambda_j = 0.01;
        a->sigma_f = 0.04;
        *moved = &a->sigma_f;
        return true;
    case BESSEL:
        c->lambda_j = sqrt(2 / 4.5) * cos(c->theta_j);
        a->sigma_f = fmax(a->sigma_f, c->lambda_j);
        *moved = &c->lambda_j;
        return true;
    default:
        return true;
    }
}

static void add_jumps(const float *v, struct cases_errors *jumps)
{
    for (int k = 0; k < OUT; k += 3) {
        double f[POINTS], top = 1e-3;
        for (int i = 0; i < POINTS; i++) {
            f[i] = (double)v[OUT * i + k];
            top = fmax(top, f[i]);
        }
        double jump = f[2] - f[1] - 0.5 * (f[3] - f[2] + f[1] - f[0]);
        cases_add(jumps, fabs(jump) / top);
    }
}

void switches_dual_measure(int which, enum dual_scheme scheme, int count,
                           struct cases_errors *jumps)
{
    struct error err = {0};
    struct probe_dual *p = multiple_probe(scheme);
    uint64_t state = 60 + (uint64_t)which;
    int made = 0;
    if (p)
        probe_dual_note_guards(p, NULL);
    for (int tries = 0; p && made < count && tries < 200 * count; tries++) {
        struct case_at a = {cases_random(&state, CASES_TYPICAL, 0), 0};
        float in[POINTS * IN], out[POINTS * OUT];
        double *moved;
        a.sigma_f = sqrt(a.c.lambda_j * a.c.lambda_j + 0.1);
        if (!place(which, &a, tries % 3, &moved))
            continue;
        double centre = *moved;
        for (int k = 0; k < POINTS; k++) {
            *moved = centre + 1e-5 * (2 * k - 3);
            const double s = a.sigma_f,
                         v[IN] = {
                             a.c.lambda_j, a.c.theta_j, a.c.phi_j, a.c.theta_o,
                             a.c.phi_o,    s,           s,         s};
            for (int i = 0; i < IN; i++)
                in[IN * k + i] = (float)v[i];
        }
        struct dual_fibre f = {
            .eta = a.c.eta, .a = a.c.a, .w_c = a.c.w_c, .delta_eta = 0.3};
        for (int k = 0; k < 3; k++) {
            f.sigma_a[k] = a.c.sigma_a;
            f.alpha[k] = a.c.alpha[k];
            f.beta[k] = a.c.beta[k];
        }
        probe_dual_fibre(p, &f);
        if (CHECK(probe_dual_multiple(p, in, POINTS, out, &err)))
            add_jumps(out, jumps);
        made++;
    }
}
