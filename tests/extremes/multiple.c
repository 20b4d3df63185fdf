// multiple.c - see the header.
#include "tests/extremes/multiple.h"

#include <math.h>
#include <stdlib.h>

#include "renderer/exact_dual.h"
#include "renderer/probe_dual.h"
#include "renderer/shoot_threads.h"
#include "tests/check.h"

#define PI 3.14159265358979323846
enum { IN = PROBE_DUAL_INPUTS, OUT = PROBE_DUAL_OUTPUTS };
enum { LIGHTS = MULTIPLE_LIGHTS, WORDS = PROBE_GUARD_WORDS };
enum { ML = 9, MLD = 12 }; // in a result: three channels each

static const struct probe_setup setup = {.m = 4, .tables = 1, .delta_eta = 0.3};

// A fibre with the lights and views that it is asked for.
struct job {
    struct exact_case c[LIGHTS];
    double sigma_f[LIGHTS];
    float in[LIGHTS * IN], out[LIGHTS * OUT];
    uint32_t hits[LIGHTS * WORDS];
};

static void fill(struct job *j, enum vectors_region region, uint64_t *state)
{
    struct exact_case first = vectors_case(state, region);
    for (int k = 0; k < LIGHTS; k++) {
        struct exact_case c = vectors_case(state, region);
        j->c[k] = first;
        j->c[k].lambda_j = c.lambda_j;
        j->c[k].theta_j = c.theta_j;
        j->c[k].theta_o = c.theta_o;
        j->c[k].phi_j = c.phi_j;
        j->c[k].phi_o = c.phi_o;
        double s = j->sigma_f[k] = vectors_widened(&j->c[k], state);
        double l2 = c.lambda_j * c.lambda_j, more = s * s - l2;
        // Dark channels are crossed less often by what is left of them: little
        // less in hair that is in use.
        bool usual = region == VECTORS_TYPICAL;
        if (usual)
            s = j->sigma_f[k] = sqrt(l2 + (more = fmin(more, 0.3)));
        const double v[IN] = {c.lambda_j,
                              c.theta_j,
                              c.phi_j,
                              c.theta_o,
                              c.phi_o,
                              s,
                              sqrt(l2 + (usual ? 0.9 : 0.8) * more),
                              sqrt(l2 + (usual ? 0.8 : 0.5) * more)};
        for (int i = 0; i < IN; i++)
            j->in[IN * k + i] = (float)v[i];
    }
}

static struct dual_fibre fibre_of(const struct exact_case *c, bool grey)
{
    const double more[3] = {1, grey ? 1 : 1.6, grey ? 1 : 3};
    struct dual_fibre f = {
        .eta = c->eta, .a = c->a, .w_c = c->w_c, .delta_eta = c->delta_eta};
    for (int k = 0; k < 3; k++) {
        // Typical hair stays typical in its darkest channel.
        f.sigma_a[k] =
            fmin(c->sigma_a * more[k], c->sigma_a > 1.2 ? 1000 : 1.2);
        f.alpha[k] = c->alpha[k];
        f.beta[k] = c->beta[k];
    }
    return f;
}

static void print_job(const struct job *j, int k)
{
    float v[PROBE_INPUTS];
    cases_to_floats(&j->c[k], v);
    for (int i = 0; i < PROBE_INPUTS; i++)
        printf(" %.9g", (double)v[i]);
    printf(" %.9g\n", j->sigma_f[k]);
}

static struct probe_dual *kept[MULTIPLE_SCHEMES];

struct probe_dual *multiple_probe(enum dual_scheme scheme)
{
    struct error err = {0};
    if (!kept[scheme])
        kept[scheme] = probe_dual_create(&setup, scheme, &err);
    if (!CHECK(kept[scheme]))
        printf("  %s\n", err.text);
    return kept[scheme];
}

void multiple_close(void)
{
    for (int s = 0; s < MULTIPLE_SCHEMES; s++) {
        probe_dual_destroy(kept[s]);
        kept[s] = NULL;
    }
}

// --- laws -------------------------------------------------------------------
static void judge_fibre(const struct dual_tables *t, const struct job *j,
                        struct multiple_law *law)
{
    for (int k = 0; k < LIGHTS; k++) {
        struct dual_mean m;
        dual_tables_mean(t, j->c[k].theta_j, k % 3, &m);
        double sum = m.a_f + m.a_b;
        law->energy = fmax(law->energy, sum);
        law->top = fmax(law->top, fmax(sum, m.A_b + m.a_b));
        // alpha_f is a mean of the three shifts, sigma_b^2 a sum of at most
        // what the longest path in use gathers.
        bool ok = m.a_f >= 0 && m.a_b >= 0 && m.A_b >= 0 && sum <= 1 &&
                  m.A_b + m.a_b <= 1 && m.a_f < 1 && m.beta2_f >= 0 &&
                  m.beta2_b >= 0 && fabs(m.alpha_f) < 0.6 &&
                  fabs(m.alpha_b) < 0.6 && isfinite(m.delta_b) &&
                  m.sigma_b >= 0 && isfinite(m.sigma_b);
        if (!ok && law->bad++ < 3) {
            printf("  fibre: a %.9g %.9g A_b %.9g delta %g sigma %g:", m.a_f,
                   m.a_b, m.A_b, m.delta_b, m.sigma_b);
            print_job(j, k);
        }
    }
    law->vectors += LIGHTS;
}

// The most of M^G_t, M^L and M^L of the light itself, red (docs/EXTREMES.md).
static void bounds(enum dual_scheme scheme, const struct exact_case *c,
                   double sigma, double out[5])
{
    static const double energy[3] = {1, 1, 4.0 / 27};
    double cos_o = fmax(cos(c->theta_o), 1e-4), fall = 1 / cos_o;
    double over = 1 / fmax(cos(c->theta_j), 1e-3);
    // Channels share nodes: shift and width corrected by up to one and two
    // widths weigh a node by at most 8.
    double most = scheme == DUAL_SCHEME_PAPER ? 4 * 1.175 * over : 8 * fall;
    for (int t = 0; t < 3; t++) {
        double w = 2 * sqrt(2) * c->beta[t], both = sigma * sigma + w * w;
        double away = 2 * c->alpha[t] - c->theta_o - c->theta_j;
        double peak = exp(-away * away / both) / sqrt(PI * both);
        out[t] = most * energy[t] / PI * peak;
    }
    out[3] = (scheme == DUAL_SCHEME_PAPER ? 4 * over : 2 * fall) / PI /
             (sqrt(PI) * sigma);
    out[4] = scheme == DUAL_SCHEME_PAPER ? 4 * 1.175 : 2 * fall;
}

static void judge_multiple(const struct job *j, enum dual_scheme scheme,
                           struct multiple_law *law)
{
    for (int k = 0; k < LIGHTS; k++) {
        double bound[5];
        bounds(scheme, &j->c[k], j->sigma_f[k], bound);
        const float *v = j->out + OUT * k;
        bool guarded = false;
        for (int i = 0; i < WORDS; i++)
            guarded = guarded || j->hits[WORDS * k + i];
        law->guarded += guarded;
        for (int i = 0; i < OUT; i++) {
            bool sane = v[i] >= 0 && isfinite(v[i]);
            // Bounds are written down for the first channel.
            double part = i % 3 ? 0 : (double)v[i] / fmax(bound[i / 3], 1e-30);
            law->top = fmax(law->top, part);
            if (!(sane && part <= 1 + 1e-3) && law->bad++ < 3) {
                printf("  scheme %d, output %d: %g, bound %g:", (int)scheme, i,
                       (double)v[i], bound[i / 3]);
                print_job(j, k);
            }
        }
    }
    law->vectors += LIGHTS;
    guards_count(j->hits, LIGHTS, law->hits);
}

struct multiple_laws multiple_sweep(enum dual_scheme scheme,
                                    enum vectors_region region, int fibres)
{
    struct multiple_laws laws = {0};
    struct error err = {0};
    struct probe_dual *p = multiple_probe(scheme);
    uint64_t state = 300 + (uint64_t)region;
    static struct job j;
    laws.multiple.bad += !p;
    for (int i = 0; p && i < fibres; i++) {
        fill(&j, region, &state);
        struct dual_fibre f = fibre_of(&j.c[0], false);
        probe_dual_fibre(p, &f);
        judge_fibre(probe_dual_tables(p), &j, &laws.fibre);
        probe_dual_note_guards(p, j.hits);
        if (CHECK(probe_dual_multiple(p, j.in, LIGHTS, j.out, &err)))
            judge_multiple(&j, scheme, &laws.multiple);
    }
    return laws;
}

// The channels' lobes stand apart, a narrow light grazes: what its circular
// Gaussian has more than the plain one where the mean lobe stands, times red's
// share there, was 1e8.
long multiple_seen(void)
{
    const double deg = PI / 180;
    struct multiple_law law = {0};
    struct error err = {0};
    struct probe_dual *p = multiple_probe(DUAL_SCHEME_BEST);
    static struct job j;
    const struct exact_case c = {.eta = 3,
                                 .sigma_a = 0.25,
                                 .alpha = {30 * deg, -15 * deg, -30 * deg},
                                 .beta = {2 * deg, deg, 4 * deg},
                                 .w_c = 5 * deg,
                                 .a = 0.71,
                                 .lambda_j = 2 * deg,
                                 .theta_j = -90 * deg,
                                 .phi_j = 90 * deg,
                                 .theta_o = 30 * deg,
                                 .delta_eta = 0.3};
    struct dual_fibre f = fibre_of(&c, false);
    for (int k = 0; k < LIGHTS; k++) {
        const double turn = 360 * deg * k / LIGHTS;
        const double v[IN] = {c.lambda_j, c.theta_j,  turn,       c.theta_o,
                              0,          c.lambda_j, c.lambda_j, c.lambda_j};
        for (int i = 0; i < IN; i++)
            j.in[IN * k + i] = (float)v[i];
        j.c[k] = c;
        j.sigma_f[k] = c.lambda_j;
    }
    if (!p)
        return 1;
    probe_dual_fibre(p, &f);
    probe_dual_note_guards(p, j.hits);
    if (CHECK(probe_dual_multiple(p, j.in, LIGHTS, j.out, &err)))
        judge_multiple(&j, DUAL_SCHEME_BEST, &law);
    return law.bad;
}

// --- brute force ------------------------------------------------------------
enum { TRUTHS = 6 }; // lights of a fibre that are compared
struct answer {
    struct exact_dual_mean mean[TRUTHS];
    double want[TRUTHS][EXACT_DUAL_OUTPUTS], scale[TRUTHS][EXACT_DUAL_OUTPUTS];
};
struct crew {
    const struct job *job;
    struct answer *answer;
};

static void answer_one(void *crew, size_t i)
{
    const struct job *j = &((struct crew *)crew)->job[i];
    struct answer *a = &((struct crew *)crew)->answer[i];
    struct exact_dual *e = exact_dual_create(&j->c[0]);
    for (int k = 0; k < TRUTHS; k++) {
        exact_dual_mean(e, j->c[k].theta_j, &a->mean[k]);
        exact_dual_multiple(e, &j->c[k], j->sigma_f[k], false, a->want[k]);
        exact_dual_multiple(e, &j->c[k], j->sigma_f[k], true, a->scale[k]);
    }
    exact_dual_destroy(e);
}

static void compare_one(struct probe_dual *p, struct job *j,
                        const struct answer *a, enum dual_scheme scheme,
                        struct multiple_truth *out)
{
    struct error err = {0};
    struct dual_fibre f = fibre_of(&j->c[0], true);
    probe_dual_fibre(p, &f);
    probe_dual_note_guards(p, NULL);
    for (int k = 0; k < TRUTHS; k++) // one sigma_f for all channels
        j->in[IN * k + 6] = j->in[IN * k + 7] = j->in[IN * k + 5];
    if (!CHECK(probe_dual_multiple(p, j->in, TRUTHS, j->out, &err)))
        return;
    for (int k = 0; k < TRUTHS; k++) {
        struct dual_mean m;
        const float *v = j->out + OUT * k;
        const double *want = a->want[k], *scale = a->scale[k];
        dual_tables_mean(probe_dual_tables(p), j->c[k].theta_j, 0, &m);
        cases_add(&out->fibre[scheme], fabs(m.a_f - a->mean[k].a_f));
        double all = scale[0] + scale[1] + scale[2];
        if (all > 1e-9)
            cases_add(&out->global[scheme],
                      cases_error((double)(v[0] + v[3] + v[6]),
                                  want[0] + want[1] + want[2], all));
        if (scale[EXACT_DUAL_ML] > 1e-9)
            cases_add(&out->local[scheme],
                      cases_error((double)v[ML], want[EXACT_DUAL_ML],
                                  scale[EXACT_DUAL_ML]));
    }
}

void multiple_compare(enum vectors_region region, int fibres,
                      struct multiple_truth *out)
{
    *out = (struct multiple_truth){0};
    struct job *jobs = calloc((size_t)fibres, sizeof *jobs);
    struct answer *answers = calloc((size_t)fibres, sizeof *answers);
    if (!jobs || !answers)
        abort();
    uint64_t state = 700 + (uint64_t)region;
    for (int i = 0; i < fibres; i++)
        fill(&jobs[i], region, &state);
    struct crew crew = {.job = jobs, .answer = answers};
    shoot_threads((size_t)fibres, answer_one, &crew);
    for (enum dual_scheme s = DUAL_SCHEME_BEST; s <= DUAL_SCHEME_PAPER; s++) {
        struct probe_dual *p = multiple_probe(s);
        for (int i = 0; p && i < fibres; i++)
            compare_one(p, &jobs[i], &answers[i], s, out);
    }
    free(jobs);
    free(answers);
}

void multiple_finish(struct multiple_truth *t)
{
    for (int s = 0; s < MULTIPLE_SCHEMES; s++) {
        cases_finish(&t->fibre[s]);
        cases_finish(&t->global[s]);
        cases_finish(&t->local[s]);
    }
}
