// verb_probe_lit.c - puts the sums together from the probes of renderer/. Lines
// and what is printed of them are verb_probe.c's.
#include "server/verb_probe_lit.h"

#include <stdlib.h>
#include <string.h>

#include "protocol/bytes.h"
#include "renderer/exact_dual.h"
#include "renderer/fast_tables.h"
#include "renderer/probe_dual.h"
#include "renderer/probe_lit.h"

struct verb_probe_lit {
    struct probe *single;
    struct probe_dual *dual;
    struct probe_lit *lit; // NULL: directly
    double d_b;
};

struct verb_probe_lit *verb_probe_lit_create(const struct probe_setup *setup,
                                             bool cells, double d_b,
                                             struct error *err)
{
    struct verb_probe_lit *v = bytes_zalloc(1, sizeof *v);
    v->d_b = d_b;
    v->single = probe_create(setup, err);
    if (v->single)
        v->dual = probe_dual_create(
            setup, setup->best ? DUAL_SCHEME_BEST : DUAL_SCHEME_PAPER, err);
    if (v->dual && cells)
        v->lit = probe_lit_create(err);
    if (v->dual && (v->lit || !cells))
        return v;
    verb_probe_lit_destroy(v);
    return NULL;
}

void verb_probe_lit_destroy(struct verb_probe_lit *v)
{
    if (!v)
        return;
    probe_destroy(v->single);
    probe_dual_destroy(v->dual);
    probe_lit_destroy(v->lit);
    free(v);
}

static double phi_of(const struct exact_case *c)
{
    return c->phi_o - c->phi_j;
}

// As `scheme` of the setup has it, without tables of lights.
static bool run_direct(struct verb_probe_lit *v,
                       const struct verb_probe_lit_line *line, double out[2],
                       struct error *err)
{
    const struct exact_case *c = &line->c;
    const struct dual_fibre f = probe_dual_grey(c);
    const double all[PROBE_INPUTS] = {
        c->eta,      c->sigma_a, c->alpha[0], c->alpha[1], c->alpha[2],
        c->beta[0],  c->beta[1], c->beta[2],  c->w_c,      c->a,
        c->lambda_j, c->theta_j, c->phi_j,    c->theta_o,  c->phi_o};
    float in[PROBE_INPUTS], light[PROBE_DUAL_INPUTS], m[PROBE_OUTPUTS];
    float d[PROBE_DUAL_OUTPUTS];
    for (int i = 0; i < PROBE_INPUTS; i++)
        in[i] = (float)all[i];
    memcpy(light, in + PROBE_INPUTS - 5, 5 * sizeof *in);
    for (int k = 0; k < 3; k++)
        light[5 + k] = (float)line->sigma_f;
    probe_dual_fibre(v->dual, &f);
    if (!probe_run(v->single, in, 1, m, err) ||
        !probe_dual_multiple(v->dual, light, 1, d, err))
        return false;
    out[0] =
        (double)m[0] + (double)m[1] + (double)m[2] + v->d_b * (double)d[12];
    out[1] = (double)d[0] + (double)d[3] + (double)d[6] + v->d_b * (double)d[9];
    return true;
}

// Of a fibre that tables refuse.
static bool run_refused(struct verb_probe_lit *v,
                        const struct verb_probe_lit_line *line,
                        double out[VERB_PROBE_LIT_CELLS], struct error *err)
{
    if (!run_direct(v, line, out, err))
        return false;
    out[2] = out[0];
    out[3] = out[1];
    for (int i = 4; i < VERB_PROBE_LIT_CELLS; i++)
        out[i] = i < 11 ? -1 : 0;
    return true;
}

static bool same_tables(const struct verb_probe_lit_line *a,
                        const struct verb_probe_lit_line *b)
{
    const struct dual_fibre f = probe_dual_grey(&a->c),
                            g = probe_dual_grey(&b->c);
    return memcmp(&f, &g, sizeof f) == 0 && a->c.lambda_j == b->c.lambda_j;
}

// Lines of one fibre and one light's width.
static bool run_cells(struct verb_probe_lit *v,
                      const struct verb_probe_lit_line *line, size_t count,
                      double (*out)[VERB_PROBE_LIT_CELLS], struct error *err)
{
    const float lambda = (float)line->c.lambda_j;
    const struct lit_fibre f = {probe_dual_grey(&line->c), false, true,
                                (float)v->d_b};
    probe_lit_fibre(v->lit, &f);
    const struct lit_lights one = lit_plan_apart(&lambda, 1);
    if (!probe_lit_lights(v->lit, &one, err))
        return false;
    for (size_t i = 0; i < count; i++) {
        const struct exact_case *c = &line[i].c;
        const float s = (float)line[i].sigma_f;
        const float in[PROBE_LIT_INPUTS] = {
            0, (float)c->theta_j, (float)phi_of(c), (float)c->theta_o, s, s, s};
        float got[PROBE_LIT_OUTPUTS];
        if (!probe_lit_run(v->lit, in, 1, got, err))
            return false;
        for (int k = 0; k < 4; k++)
            out[i][k] = (double)got[3 * k];
        for (int k = 4; k < VERB_PROBE_LIT_CELLS; k++)
            out[i][k] = (double)got[PROBE_LIT_NEAR_AT + k - 4];
    }
    return true;
}

bool verb_probe_lit_run(struct verb_probe_lit *v,
                        const struct verb_probe_lit_line *line, size_t count,
                        double (*out)[VERB_PROBE_LIT_CELLS], struct error *err)
{
    for (size_t i = 0, end; i < count; i = end) {
        const struct dual_fibre f = probe_dual_grey(&line[i].c);
        end = i + 1;
        if (!v->lit || fast_tables_refuse(&f)) {
            if (!(v->lit ? run_refused : run_direct)(v, line + i, out[i], err))
                return false;
            continue;
        }
        while (end < count && same_tables(line + i, line + end))
            end++;
        if (!run_cells(v, line + i, end - i, out + i, err))
            return false;
    }
    return true;
}

void verb_probe_lit_exact(const struct exact_dual *e,
                          const struct verb_probe_lit_line *line, double d_b,
                          double out[VERB_PROBE_LIT_SUMS])
{
    double m[EXACT_MODES], d[EXACT_DUAL_OUTPUTS];
    exact_modes(&line->c, m);
    exact_dual_multiple(e, &line->c, line->sigma_f, false, d);
    out[0] = m[0] + m[1] + m[2] + d_b * d[EXACT_DUAL_MLD];
    out[1] = d[0] + d[1] + d[2] + d_b * d[EXACT_DUAL_ML];
}
