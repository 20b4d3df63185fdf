// dual_bench.h - the probes of multiple scattering as the numeric tests hold
// them, one for each variant, and their questions and answers.  All in the
// header, since a check counts for the file that it stands in.
#ifndef TESTS_NUMERIC_DUAL_BENCH_H
#define TESTS_NUMERIC_DUAL_BENCH_H

#include <math.h>

#include "renderer/egl.h"
#include "renderer/probe_dual.h"
#include "tests/check.h"
#include "tests/numeric/cases.h"
#include "tests/numeric/dual_double.h"

enum { DUAL_IN = PROBE_DUAL_INPUTS, DUAL_OUT = PROBE_DUAL_OUTPUTS };
// In a result: three channels each.
enum { DUAL_MG, DUAL_ML = 9, DUAL_MLD = 12 };

struct dual_bench {
    struct egl *gl;
    struct probe_dual *best, *paper, *opaque;
};

// Begins the case `name`; false when there is no GL (the case is skipped) or no
// program (it fails).  dual_bench_close in any case.
static inline bool dual_bench_open(struct dual_bench *b, const char *name)
{
    struct error err = {0};
    struct probe_setup setup = {.m = 4, .tables = 1, .delta_eta = 0.3};
    *b = (struct dual_bench){.gl = egl_create(&err)};
    check_case(name);
    if (!b->gl) {
        check_skip(err.text);
        return false;
    }
    b->best = probe_dual_create(&setup, DUAL_SCHEME_BEST, &err);
    b->paper = probe_dual_create(&setup, DUAL_SCHEME_PAPER, &err);
    setup.opaque = true;
    b->opaque = probe_dual_create(&setup, DUAL_SCHEME_BEST, &err);
    return CHECK(b->best && b->paper && b->opaque);
}

static inline void dual_bench_close(struct dual_bench *b)
{
    if (!b->gl)
        return;
    probe_dual_destroy(b->best);
    probe_dual_destroy(b->paper);
    probe_dual_destroy(b->opaque);
    egl_destroy(b->gl);
}

static inline struct probe_dual *dual_bench_of(const struct dual_bench *b,
                                               enum dual_scheme scheme)
{
    return scheme == DUAL_SCHEME_BEST ? b->best : b->paper;
}

static inline void dual_bench_fibre(struct probe_dual *p,
                                    const struct exact_case *c)
{
    struct dual_fibre f = probe_dual_grey(c);
    probe_dual_fibre(p, &f);
}

// One case as the probe takes it, sigma_f for all channels.
static inline void dual_bench_put(float *in, const struct exact_case *c,
                                  double sigma_f)
{
    const double v[DUAL_IN] = {c->lambda_j, c->theta_j, c->phi_j, c->theta_o,
                               c->phi_o,    sigma_f,    sigma_f,  sigma_f};
    for (int k = 0; k < DUAL_IN; k++)
        in[k] = (float)v[k];
}

// Both check that they were answered.
static inline bool dual_bench_ask(struct probe_dual *p, const float *in,
                                  size_t count, float *out)
{
    struct error err = {0};
    bool ok = probe_dual_multiple(p, in, count, out, &err);
    if (!ok)
        printf("  %s\n", err.text);
    return CHECK(ok);
}

static inline bool dual_bench_half(struct probe_dual *p, const float *in,
                                   size_t count, float *out)
{
    struct error err = {0};
    bool ok = probe_dual_half(p, in, count, out, &err);
    if (!ok)
        printf("  %s\n", err.text);
    return CHECK(ok);
}

// The width that .2 to 5 crossings give a light.
static inline double dual_bench_widened(const struct exact_case *c,
                                        uint64_t *state)
{
    double beta2 = 0;
    for (int t = 0; t < 3; t++)
        beta2 += c->beta[t] * c->beta[t] / 3;
    double n = exp(cases_uniform(state, log(0.2), log(5)));
    return (double)(float)sqrt(c->lambda_j * c->lambda_j + 8 * n * beta2);
}

static inline void dual_bench_report(const char *what, struct cases_errors *e)
{
    printf("  %-7s median %.1e, p90 %.1e, p99 %.1e\n", what,
           cases_quantile(e, 0.5), cases_quantile(e, 0.9),
           cases_quantile(e, 0.99));
}

#endif
