// lit_sweep.c - see the header.
#include "tests/extremes/lit_sweep.h"

#include <math.h>

#include "renderer/fast_tables.h"
#include "renderer/probe_lit.h"
#include "tests/check.h"

#define PI 3.14159265358979323846
enum { IN = PROBE_LIT_INPUTS, OUT = PROBE_LIT_OUTPUTS, CHANNELS = 3 };
enum { VECTORS = LIT_SWEEP_VECTORS, WORDS = PROBE_GUARD_WORDS };

// A fibre, its lights and what is asked of them.
struct job {
    struct lit_fibre fibre;
    float lambda[LIT_SWEEP_LIGHTS];
    float in[VECTORS * IN], out[VECTORS * OUT];
    uint32_t hits[VECTORS * WORDS];
};

static struct probe_lit *kept;

static struct lit_fibre fibre_of(const struct exact_case *c, int number)
{
    static const double more[CHANNELS] = {1, 1.6, 3};
    struct lit_fibre f = {.fibre = {.eta = c->eta,
                                    .a = 1,
                                    .w_c = c->w_c,
                                    .delta_eta = c->delta_eta},
                          .opaque = number % 5 == 4,
                          .multiple = number % 7 != 6,
                          .d_b = 0.7f};
    for (int k = 0; k < CHANNELS; k++) {
        // Typical hair stays typical in its darkest channel.
        f.fibre.sigma_a[k] =
            fmin(c->sigma_a * more[k], c->sigma_a > 1.2 ? 1000 : 1.2);
        f.fibre.alpha[k] = c->alpha[k];
        f.fibre.beta[k] = c->beta[k];
    }
    return f;
}

static void fill(struct job *j, struct exact_case fibre,
                 enum vectors_region region, uint64_t *state)
{
    static const double share[2][CHANNELS] = {{1, 0.8, 0.5}, {1, 0.9, 0.8}};
    const bool usual = region == VECTORS_TYPICAL;
    for (int k = 0; k < VECTORS; k++) {
        const struct exact_case c = vectors_case(state, region);
        const int light = k % LIT_SWEEP_LIGHTS;
        if (k < LIT_SWEEP_LIGHTS)
            j->lambda[k] = (float)c.lambda_j;
        fibre.lambda_j = (double)j->lambda[light];
        const double s = vectors_widened(&fibre, state);
        const double l2 = fibre.lambda_j * fibre.lambda_j;
        const double more = fmin(s * s - l2, usual ? 0.3 : 1e30);
        float *in = j->in + IN * k;
        in[0] = (float)light;
        in[1] = (float)c.theta_j;
        in[2] = (float)(c.phi_o - c.phi_j);
        in[3] = (float)c.theta_o;
        for (int i = 0; i < CHANNELS; i++)
            in[4 + i] = (float)sqrt(l2 + share[usual][i] * fmax(more, 0));
    }
}

// What one light of L = 1 sends at most wherever it stands (docs/EXTREMES.md):
// a cell is a parabola of neighbours, so bounds that fall off along a lobe are
// not asked of it.  One cell of theta_o aside.
static void bounds(const struct job *j, int k, double out[2])
{
    static const double energy[EXACT_MODES] = {1, 1, 4.0 / 27};
    const float *in = j->in + IN * k;
    const double size = (double)j->out[OUT * k + PROBE_LIT_FAR_SIZE + 2];
    const double lambda = PI / 2 * (double)j->lambda[(int)in[0]];
    const double sigma =
        fmin(fmin((double)in[4], (double)in[5]), (double)in[6]);
    const double fall =
        1 / fmax(cos(fmin(fabs((double)in[3]) + size, PI / 2)), 1e-2);
    out[0] = 0.7 * 2 * fall;
    out[1] = 0.7 * 2 * fall / PI / (sqrt(PI) * sigma);
    for (int t = 0; t < EXACT_MODES; t++) {
        const double w = sqrt(8) * j->fibre.fibre.beta[t];
        out[0] += 4 * 1.175 * energy[t] * lambda / hypot(lambda, w);
        out[1] += 8 * fall * energy[t] / PI / sqrt(PI) / hypot(sigma, w);
    }
}

static void print_vector(const struct job *j, int k, int output, double bound)
{
    const struct dual_fibre *f = &j->fibre.fibre;
    printf("  lights' tables, output %d: %g, bound %g: %.9g %.9g", output,
           (double)j->out[OUT * k + output], bound, f->eta, f->sigma_a[0]);
    for (int t = 0; t < EXACT_MODES; t++)
        printf(" %.9g %.9g", f->alpha[t], f->beta[t]);
    printf(" %.9g; lambda %.9g;", f->w_c,
           (double)j->lambda[(int)j->in[IN * k]]);
    for (int i = 1; i < IN; i++)
        printf(" %.9g", (double)j->in[IN * k + i]);
    printf("\n");
}

// Guards of a light's table, of the far one: GUARD_LIT_* of guard.glsl.
static const uint32_t guards_of[2] = {0x1f0000, 0xfe00000};

// What a vector that hit a guard is off.
static void judge_guarded(const struct job *j, int k, struct lit_sweep_law *law)
{
    for (int sum = 0; sum < 2; sum++) {
        const float *o = j->out + OUT * k + CHANNELS * sum;
        double got = 0, want = 0;
        if (!(j->hits[WORDS * k + 2] & guards_of[sum]))
            continue;
        for (int i = 0; i < CHANNELS; i++) {
            got += (double)o[i];
            want += (double)o[PROBE_LIT_NEAR_MODES + i];
        }
        cases_add(&law->error, fabs(got / want - 1));
    }
}

static void judge(const struct job *j, struct lit_sweep_law *law)
{
    for (int k = 0; k < VECTORS; k++) {
        double bound[2];
        bool guarded = false;
        bounds(j, k, bound);
        for (int i = 0; i < 2 * CHANNELS; i++) {
            const double v = (double)j->out[OUT * k + i];
            const double part = v / bound[i / CHANNELS];
            law->top[i / CHANNELS] = fmax(law->top[i / CHANNELS], part);
            if (!(v >= 0 && isfinite(v) && part <= 1) && law->bad++ < 3)
                print_vector(j, k, i, bound[i / CHANNELS]);
        }
        for (int i = 0; i < WORDS; i++)
            guarded = guarded || j->hits[WORDS * k + i];
        law->guarded += guarded;
        judge_guarded(j, k, law);
        law->narrow += j->out[OUT * k + PROBE_LIT_NEAR_AT] < 0;
    }
    law->vectors += VECTORS;
    guards_count(j->hits, VECTORS, law->hits);
}

struct lit_sweep_law lit_sweep(enum vectors_region region, int fibres)
{
    struct lit_sweep_law law = {0};
    struct error err = {0};
    uint64_t state = 1100 + (uint64_t)region;
    static struct job j;
    if (!kept)
        kept = probe_lit_create(&err);
    if (!CHECK(kept != NULL)) {
        printf("  %s\n", err.text);
        law.bad++;
        return law;
    }
    for (int i = 0; i < fibres; i++) {
        const struct exact_case c = vectors_case(&state, region);
        j.fibre = fibre_of(&c, i);
        fill(&j, c, region, &state);
        if (fast_tables_refuse(&j.fibre.fibre)) {
            law.refused++;
            continue;
        }
        probe_lit_fibre(kept, &j.fibre);
        probe_lit_note_guards(kept, j.hits);
        const struct lit_lights sky =
            lit_plan_apart(j.lambda, LIT_SWEEP_LIGHTS);
        if (CHECK(probe_lit_lights(kept, &sky, &err) &&
                  probe_lit_run(kept, j.in, VECTORS, j.out, &err)))
            judge(&j, &law);
    }
    return law;
}

void lit_sweep_close(void)
{
    probe_lit_destroy(kept);
    kept = NULL;
}
