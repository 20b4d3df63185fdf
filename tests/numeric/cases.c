// cases.c - see the header.
#include "tests/numeric/cases.h"

#include <math.h>
#include <stdlib.h>

static const double deg = 3.14159265358979323846 / 180;

double cases_uniform(uint64_t *state, double lo, double hi)
{
    *state += 0x9e3779b97f4a7c15u; // splitmix64
    uint64_t x = *state;
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
    x ^= x >> 31;
    return lo + (hi - lo) * ((double)(x >> 11) * 0x1p-53);
}

static double logarithmic(uint64_t *state, double lo, double hi)
{
    return exp(cases_uniform(state, log(lo), log(hi)));
}

static void fill_typical(struct exact_case *c, uint64_t *s)
{
    c->eta = cases_uniform(s, 1.45, 1.65);
    c->sigma_a = logarithmic(s, 0.03, 1.2);
    c->alpha[0] = -cases_uniform(s, 5, 10) * deg;
    c->beta[0] = cases_uniform(s, 5, 10) * deg;
    c->beta[1] = c->beta[0] / 2;
    c->beta[2] = c->beta[0] * 2;
    c->w_c = cases_uniform(s, 0.1, 0.4);
    c->lambda_j = logarithmic(s, 0.1, 1);
    c->theta_j = cases_uniform(s, -60, 60) * deg;
    c->theta_o = cases_uniform(s, -60, 60) * deg;
}

static void fill_broad(struct exact_case *c, uint64_t *s)
{
    c->eta = cases_uniform(s, 1.3, 2);
    c->sigma_a = cases_uniform(s, 0, 2);
    c->alpha[0] = -cases_uniform(s, 0, 10) * deg;
    for (int t = 0; t < EXACT_MODES; t++)
        c->beta[t] = cases_uniform(s, 2, 20) * deg;
    c->w_c = cases_uniform(s, 0.05, 0.5);
    c->lambda_j = logarithmic(s, 0.02, 2);
    c->theta_j = cases_uniform(s, -85, 85) * deg;
    c->theta_o = cases_uniform(s, -85, 85) * deg;
}

struct exact_case cases_random(uint64_t *state, enum cases_kind kind,
                               int eccentric)
{
    struct exact_case c = {.a = 1};
    if (kind == CASES_TYPICAL)
        fill_typical(&c, state);
    else
        fill_broad(&c, state);
    c.alpha[1] = -c.alpha[0] / 2;
    c.alpha[2] = -1.5 * c.alpha[0];
    c.phi_j = cases_uniform(state, -180, 180) * deg;
    c.phi_o = cases_uniform(state, -180, 180) * deg;
    double turn = cases_uniform(state, 0, 7),
           a = cases_uniform(state, .8, 1.25);
    if (eccentric && turn < 1)
        c.a = a;
    float f[PROBE_INPUTS];
    double d[PROBE_INPUTS];
    cases_to_floats(&c, f);
    for (int i = 0; i < PROBE_INPUTS; i++)
        d[i] = (double)f[i];
    return cases_from_doubles(d);
}

void cases_to_floats(const struct exact_case *c, float out[PROBE_INPUTS])
{
    const double v[PROBE_INPUTS] = {
        c->eta,      c->sigma_a, c->alpha[0], c->alpha[1], c->alpha[2],
        c->beta[0],  c->beta[1], c->beta[2],  c->w_c,      c->a,
        c->lambda_j, c->theta_j, c->phi_j,    c->theta_o,  c->phi_o};
    for (int i = 0; i < PROBE_INPUTS; i++)
        out[i] = (float)v[i];
}

struct exact_case cases_from_doubles(const double v[PROBE_INPUTS])
{
    return (struct exact_case){.eta = v[0],
                               .sigma_a = v[1],
                               .alpha = {v[2], v[3], v[4]},
                               .beta = {v[5], v[6], v[7]},
                               .w_c = v[8],
                               .a = v[9],
                               .lambda_j = v[10],
                               .theta_j = v[11],
                               .phi_j = v[12],
                               .theta_o = v[13],
                               .phi_o = v[14],
                               .delta_eta = 0.3};
}

double cases_error(double got, double want, double mean)
{
    return fabs(got - want) / fmax(fabs(want), 0.05 * mean);
}

void cases_add(struct cases_errors *e, double error)
{
    if (e->count == e->cap) {
        e->cap = e->cap ? 2 * e->cap : 1024;
        e->error = realloc(e->error, e->cap * sizeof *e->error);
        if (!e->error)
            abort();
    }
    e->error[e->count++] = isnan(error) ? INFINITY : error;
}

static int ascending(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

double cases_quantile(struct cases_errors *e, double share)
{
    if (e->count == 0)
        return INFINITY;
    qsort(e->error, e->count, sizeof *e->error, ascending);
    return e->error[(size_t)(share * (double)(e->count - 1))];
}

void cases_finish(struct cases_errors *e)
{
    free(e->error);
    *e = (struct cases_errors){0};
}

struct exact_case cases_mirror(struct exact_case c, int kind)
{
    if (kind == 0) {
        c.theta_j = -c.theta_j;
        c.theta_o = -c.theta_o;
        for (int t = 0; t < EXACT_MODES; t++)
            c.alpha[t] = -c.alpha[t];
    } else if (kind == 1) {
        c.phi_j = -c.phi_j;
        c.phi_o = -c.phi_o;
    } else {
        c.a = 1 / c.a;
        c.phi_j += M_PI / 2;
        c.phi_o += M_PI / 2;
    }
    return c;
}
