// verb_probe.c - `glintd probe`: single integrals for whoever wants to check
// them.  Reads lines of numbers and prints what the renderer's shaders and
// tables (or the brute-force reference) make of each.  The integrals live in
// renderer/{probe,probe_dual,probe_fast,exact,exact_dual}.c, the lines in
// probe_line.c, sums over modes in verb_probe_lit.c.
#include "server/verbs.h"

#include <pthread.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "protocol/params.h"
#include "renderer/egl.h"
#include "renderer/exact_dual.h"
#include "renderer/probe_dual.h"
#include "renderer/probe_fast.h"
#include "server/options.h"
#include "server/probe_line.h"
#include "server/verb_probe_lit.h"

enum { LINE_MAX_BYTES = 4096, SLOW_BATCH = 128, OUTPUTS_MAX = 9, FIBRE = 9 };

enum scheme { SCHEME_BEST, SCHEME_PAPER, SCHEME_EXACT, SCHEME_FAST, SCHEMES };
static const char *const scheme_names[SCHEMES] = {"best", "paper", "exact",
                                                  "fast"};
static const char *const form_names[PROBE_LINE_FORMS] = {
    "single", "fibre", "half", "multiple", "lit"};
static const int outputs[PROBE_LINE_FORMS] = {3, 9, 3, 4, VERB_PROBE_LIT_SUMS};

struct batch {
    enum probe_line_form form;
    enum scheme scheme;
    struct egl *egl;
    struct probe *single;
    struct probe_dual *dual;
    struct probe_fast *fast;
    struct verb_probe_lit *lit;
    double delta_eta, d_b;
    size_t count, limit;
    double value[PROBE_BATCH][PROBE_LINE_MAX];
};

// --- what a line says -------------------------------------------------------
// Of the fifteen, not of the fibre alone?
static bool has_light(const struct batch *b)
{
    return probe_line_count(b->form) >= PROBE_INPUTS;
}

static struct exact_case case_of(const struct batch *b, size_t i)
{
    const double *v = b->value[i];
    struct exact_case c = {.eta = v[0],
                           .sigma_a = v[1],
                           .alpha = {v[2], v[3], v[4]},
                           .beta = {v[5], v[6], v[7]},
                           .w_c = v[8],
                           .a = 1,
                           .delta_eta = b->delta_eta};
    if (has_light(b)) {
        c.a = v[9];
        c.lambda_j = v[10];
        c.theta_j = v[11];
        c.phi_j = v[12];
        c.theta_o = v[13];
        c.phi_o = v[14];
    }
    return c;
}

static bool same_fibre(const struct batch *b, size_t i, size_t j)
{
    int count = has_light(b) ? FIBRE + 1 : FIBRE; // and a
    return memcmp(b->value[i], b->value[j],
                  (size_t)count * sizeof b->value[i][0]) == 0;
}

static struct verb_probe_lit_line lit_line(const struct batch *b, size_t i)
{
    return (struct verb_probe_lit_line){case_of(b, i),
                                        b->value[i][PROBE_INPUTS]};
}

static void print_numbers(const double *v, int count)
{
    for (int i = 0; i < count; i++)
        printf(i + 1 < count ? "%.9g " : "%.9g\n", v[i]);
}

// --- the reference ----------------------------------------------------------
// It takes milliseconds a case: one thread a processor, each taking the next
// case that nobody has.
struct crew {
    const struct batch *batch;
    atomic_size_t next;
    double out[SLOW_BATCH][OUTPUTS_MAX];
};

static void exact_one(const struct batch *b, size_t i,
                      const struct exact_dual *e, double *out)
{
    struct exact_case c = case_of(b, i);
    struct exact_dual_mean m;
    double all[EXACT_DUAL_OUTPUTS];
    switch (b->form) {
    case PROBE_LINE_FIBRE:
        exact_dual_mean(e, b->value[i][FIBRE], &m);
        memcpy(out,
               (double[9]){m.a_f, m.a_b, m.alpha_f, m.alpha_b, m.beta2_f,
                           m.beta2_b, m.A_b, m.delta_b, m.sigma_b},
               9 * sizeof *out);
        break;
    case PROBE_LINE_HALF:
        exact_dual_half(e, b->value[i][FIBRE], b->value[i][FIBRE + 1], out);
        break;
    case PROBE_LINE_MULTIPLE:
        exact_dual_multiple(e, &c, b->value[i][PROBE_INPUTS], false, all);
        memcpy(out, all, 4 * sizeof *out);
        break;
    case PROBE_LINE_LIT:;
        const struct verb_probe_lit_line line = lit_line(b, i);
        verb_probe_lit_exact(e, &line, b->d_b, out);
        break;
    default:
        exact_modes(&c, out);
    }
}

static void *work(void *arg)
{
    struct crew *crew = arg;
    const struct batch *b = crew->batch;
    struct exact_dual *e = NULL;
    size_t made_for = 0;
    for (;;) {
        size_t i = atomic_fetch_add(&crew->next, 1);
        if (i >= b->count)
            break;
        if (b->form != PROBE_LINE_SINGLE &&
            !(e && same_fibre(b, i, made_for))) {
            struct exact_case c = case_of(b, i);
            exact_dual_destroy(e);
            e = exact_dual_create(&c);
            made_for = i;
        }
        exact_one(b, i, e, crew->out[i]);
    }
    exact_dual_destroy(e);
    return NULL;
}

static void run_exact(const struct batch *b)
{
    enum { THREADS_MAX = 64 };
    struct crew crew = {.batch = b};
    pthread_t thread[THREADS_MAX];
    long wanted = sysconf(_SC_NPROCESSORS_ONLN) - 1; // this one works too
    int made = 0;
    while (made < wanted && made < THREADS_MAX && (size_t)made + 1 < b->count &&
           pthread_create(&thread[made], NULL, work, &crew) == 0)
        made++;
    work(&crew);
    while (made > 0)
        pthread_join(thread[--made], NULL);
    for (size_t i = 0; i < b->count; i++)
        print_numbers(crew.out[i], outputs[b->form]);
}

// --- the renderer -----------------------------------------------------------
static bool run_single(struct batch *b, struct error *err)
{
    static float cases[PROBE_BATCH * PROBE_INPUTS];
    static float results[PROBE_BATCH * PROBE_OUTPUTS];
    for (size_t i = 0; i < b->count * PROBE_INPUTS; i++)
        cases[i] = (float)b->value[i / PROBE_INPUTS][i % PROBE_INPUTS];
    if (!probe_run(b->single, cases, b->count, results, err))
        return false;
    for (size_t i = 0; i < b->count; i++)
        print_numbers((double[3]){(double)results[3 * i],
                                  (double)results[3 * i + 1],
                                  (double)results[3 * i + 2]},
                      3);
    return true;
}

// Line i from tables, or where these refuse its fibre by `best`, as a picture
// is lit.
static bool run_fast_line(struct batch *b, size_t i, float out[3],
                          struct error *err)
{
    const double *v = b->value[i];
    float in[PROBE_INPUTS], all[PROBE_FAST_OUTPUTS];
    struct exact_case c = case_of(b, i);
    struct dual_fibre f = probe_dual_grey(&c);
    for (int k = 0; k < PROBE_INPUTS; k++)
        in[k] = (float)v[k];
    if (fast_tables_refuse(&f))
        return probe_run(b->single, in, 1, out, err);
    if (i == 0 || !same_fibre(b, i - 1, i) || v[9] != b->value[i - 1][9])
        probe_fast_fibre(b->fast, &f);
    float light[PROBE_FAST_INPUTS] = {in[10], in[11], in[12], in[13],
                                      in[14], 1,      1,      1};
    if (!probe_fast_run(b->fast, light, 1, all, err))
        return false;
    for (int t = 0; t < 3; t++)
        out[t] = all[3 * t];
    return true;
}

static bool run_fast(struct batch *b, struct error *err)
{
    for (size_t i = 0; i < b->count; i++) {
        float out[3];
        if (!run_fast_line(b, i, out, err))
            return false;
        print_numbers(
            (double[3]){(double)out[0], (double)out[1], (double)out[2]}, 3);
    }
    return true;
}

// Lines first .. end - 1, which are of one fibre.
static bool run_fibre(struct batch *b, size_t first, size_t end,
                      struct error *err)
{
    static float cases[PROBE_BATCH * PROBE_DUAL_INPUTS];
    static float results[PROBE_BATCH * PROBE_DUAL_OUTPUTS];
    size_t count = end - first;
    bool half = b->form == PROBE_LINE_HALF;
    for (size_t i = 0; i < count; i++) {
        const double *v = b->value[first + i];
        float *to = cases + i * (half ? 2 : PROBE_DUAL_INPUTS);
        for (int k = 0; k < (half ? 2 : 5); k++)
            to[k] = (float)v[FIBRE + k + !half];
        for (int k = 5; k < PROBE_DUAL_INPUTS && !half; k++)
            to[k] = (float)v[PROBE_INPUTS];
    }
    if (!(half ? probe_dual_half : probe_dual_multiple)(b->dual, cases, count,
                                                        results, err))
        return false;
    for (size_t i = 0; i < count; i++) {
        double out[4];
        for (size_t k = 0; k < (half ? 3 : 4); k++)
            out[k] = (double)(half ? results[3 * i + k]
                                   : results[PROBE_DUAL_OUTPUTS * i + 3 * k]);
        print_numbers(out, half ? 3 : 4);
    }
    return true;
}

static void print_mean(const struct dual_tables *t, double theta)
{
    struct dual_mean m;
    dual_tables_mean(t, theta, 0, &m);
    print_numbers((double[9]){m.a_f, m.a_b, m.alpha_f, m.alpha_b, m.beta2_f,
                              m.beta2_b, m.A_b, m.delta_b, m.sigma_b},
                  9);
}

// `fibre` needs no GL: the tables are made and read on this side.
static bool run_dual(struct batch *b, struct dual_tables *means,
                     struct error *err)
{
    for (size_t i = 0, end; i < b->count; i = end) {
        struct exact_case c = case_of(b, i);
        const struct dual_fibre f = probe_dual_grey(&c);
        for (end = i + 1; end < b->count && same_fibre(b, i, end);)
            end++;
        if (means) {
            dual_tables_update(means, &f,
                               b->scheme == SCHEME_PAPER ? DUAL_SCHEME_PAPER
                                                         : DUAL_SCHEME_BEST);
            for (size_t k = i; k < end; k++)
                print_mean(means, b->value[k][FIBRE]);
            continue;
        }
        probe_dual_fibre(b->dual, &f);
        if (!run_fibre(b, i, end, err))
            return false;
    }
    return true;
}

static bool run_lit(struct batch *b, struct error *err)
{
    static struct verb_probe_lit_line line[PROBE_BATCH];
    static double out[PROBE_BATCH][VERB_PROBE_LIT_CELLS];
    for (size_t i = 0; i < b->count; i++)
        line[i] = lit_line(b, i);
    if (!verb_probe_lit_run(b->lit, line, b->count, out, err))
        return false;
    for (size_t i = 0; i < b->count; i++)
        print_numbers(out[i], b->scheme == SCHEME_FAST ? VERB_PROBE_LIT_CELLS
                                                       : VERB_PROBE_LIT_SUMS);
    return true;
}

// --- batches ----------------------------------------------------------------
static bool run_batch(struct batch *b, struct error *err)
{
    bool ok = true;
    if (b->scheme == SCHEME_EXACT) {
        run_exact(b);
    } else if (b->form == PROBE_LINE_FIBRE) {
        struct dual_tables *means = dual_tables_create();
        ok = run_dual(b, means, err);
        dual_tables_destroy(means);
    } else if (b->form == PROBE_LINE_LIT) {
        ok = run_lit(b, err);
    } else if (b->scheme == SCHEME_FAST) {
        ok = run_fast(b, err);
    } else if (b->count > 0) {
        ok = b->form == PROBE_LINE_SINGLE ? run_single(b, err)
                                          : run_dual(b, NULL, err);
    }
    b->count = 0;
    if (ok && fflush(stdout) != 0)
        return error_set(err, "file", "stdout", "stdout: cannot write");
    return ok;
}

static bool run_input(struct batch *b, struct error *err)
{
    char text[LINE_MAX_BYTES];
    for (long line = 1; fgets(text, sizeof text, stdin); line++) {
        size_t size = strlen(text), first = strspn(text, " \t\r\n\v\f");
        struct error bad;
        bool good = true, whole = size > 0 && text[size - 1] == '\n';
        if (!whole && !feof(stdin))
            good = error_set(&bad, "limit", "line",
                             "line %ld: longer than %d bytes, or holds a zero "
                             "byte",
                             line, LINE_MAX_BYTES - 2);
        else if (text[first] == 0 || text[first] == '#')
            continue;
        else
            good =
                probe_line_parse(b->form, text, line, b->value[b->count], &bad);
        b->count += good;
        if ((!good || b->count == b->limit) && !run_batch(b, err))
            return false;
        if (!good) { // what came before it has been answered
            *err = bad;
            return false;
        }
    }
    if (ferror(stdin))
        return error_set(err, "file", "stdin", "stdin: cannot read");
    return run_batch(b, err);
}

// --- the verb ---------------------------------------------------------------
static bool make_probes(struct batch *b, const struct probe_setup *setup,
                        struct error *err)
{
    const bool fast = b->scheme == SCHEME_FAST;
    const enum dual_scheme dual =
        b->scheme == SCHEME_PAPER ? DUAL_SCHEME_PAPER : DUAL_SCHEME_BEST;
    if (b->form == PROBE_LINE_LIT)
        return (b->lit = verb_probe_lit_create(setup, fast, b->d_b, err));
    if (b->form != PROBE_LINE_SINGLE)
        return (b->dual = probe_dual_create(setup, dual, err));
    b->single = probe_create(setup, err);
    return b->single && (!fast || (b->fast = probe_fast_create(err)));
}

static bool run(struct batch *b, const struct probe_setup *setup,
                struct error *err)
{
    if (b->scheme == SCHEME_EXACT || b->form == PROBE_LINE_FIBRE)
        return run_input(b, err);
    b->egl = egl_create(err);
    if (!b->egl)
        return false;
    bool ok = make_probes(b, setup, err) && run_input(b, err);
    probe_destroy(b->single);
    probe_fast_destroy(b->fast);
    probe_dual_destroy(b->dual);
    verb_probe_lit_destroy(b->lit);
    egl_destroy(b->egl);
    return ok;
}

// Index of `word` among count words, or -1 with a line on stderr.
static int choose(const char *option, const char *word,
                  const char *const *words, int count)
{
    char list[80] = "";
    for (int i = 0; i < count; i++) {
        if (strcmp(word, words[i]) == 0)
            return i;
        size_t n = strlen(list);
        snprintf(list + n, sizeof list - n, "%s%s", i ? ", " : "", words[i]);
    }
    struct error err;
    error_set(&err, "range", option, "--%s: %s is not one of %s", option, word,
              list);
    options_fail(&err);
    return -1;
}

// False when a word is none of those wanted; said on stderr.
static bool choose_all(struct batch *b, const char *what, const char *scheme,
                       const char *nodes, struct probe_setup *setup)
{
    static const char *const layouts[2] = {"paper", "fine"};
    int form = choose("what", what, form_names, PROBE_LINE_FORMS);
    if (form < 0)
        return false;
    if (!*scheme)
        scheme = scheme_names[SCHEME_BEST];
    int chosen = choose("scheme", scheme, scheme_names, SCHEMES);
    int layout = chosen < 0 ? -1 : choose("nodes", nodes, layouts, 2);
    if (layout < 0)
        return false;
    if (chosen == SCHEME_FAST && form != PROBE_LINE_SINGLE &&
        form != PROBE_LINE_LIT) {
        struct error err;
        error_set(&err, "range", "scheme",
                  "--scheme: fast has no --what %s, only single and lit", what);
        options_fail(&err);
        return false;
    }
    b->form = (enum probe_line_form)form;
    b->scheme = (enum scheme)chosen;
    setup->best = b->scheme == SCHEME_BEST || b->scheme == SCHEME_FAST;
    b->limit = b->scheme == SCHEME_EXACT ? SLOW_BATCH : PROBE_BATCH;
    b->delta_eta = setup->delta_eta =
        params_find("fibre.delta_eta", 15)->def[0];
    setup->fine_nodes = layout == 1;
    return true;
}

int verb_probe_run(int argc, char **argv)
{
    static struct batch b;
    const char *what = form_names[0], *scheme = "", *nodes = "paper";
    struct probe_setup setup = {.m = 4, .tables = 1};
    b.d_b = params_find("fibre.d_b", 9)->def[0];
    const struct options_row rows[] = {
        {"what", OPTIONS_TEXT, &what, 0, 0, "single|fibre|half|multiple|lit",
         "single: M_R M_TT M_TRT; fibre, for theta_i: abar_f abar_b alphabar_f "
         "alphabar_b betabar2_f betabar2_b A_b Delta_b sigma_b; half, for "
         "theta_i Phi: NG_R NG_TT NG_TRT; multiple, for sigma_f: MG_R MG_TT "
         "MG_TRT ML; lit, for sigma_f: all modes and glow of the light, all "
         "of light scattered forward"},
        {"scheme", OPTIONS_TEXT, &scheme, 0, 0, "best|paper|exact|fast",
         "the renderer's tables and shaders, or brute force in double "
         "precision; fast: as render.path=table lights a place: single from "
         "tables of modes; lit from those of the light, then both sums from "
         "tables of modes, cells (s theta_o Phi; ln sigma_f s theta_o Phi) and "
         "their sizes"},
        {"d-b", OPTIONS_REAL, &b.d_b, 0, 1, "X",
         "lit: density factor of light scattered back (fibre.d_b)"},
        {"m", OPTIONS_INT, &setup.m, 2, 256, "N",
         "segments of the outer integral (Xu 2011, section 4.2.2)"},
        {"nodes", OPTIONS_TEXT, &nodes, 0, 0, "paper|fine",
         "node layout: as printed, or one that converges with m"},
        {"tables", OPTIONS_INT, &setup.tables, 1, 8, "N",
         "table resolution in multiples of 128 x 64"},
        {0}};
    const struct options_verb verb = {
        "probe",
        "single integrals: lines of numbers on stdin (eta sigma_a alpha_R "
        "alpha_TT alpha_TRT beta_R beta_TT beta_TRT w_c; then a lambda_j "
        "theta_j phi_j theta_o phi_o; radians), a line of numbers out for each",
        0, rows, NULL};
    struct options o;
    struct error err;
    int status = options_parse(&o, &verb, argc, argv);
    options_finish(&o);
    if (status >= 0)
        return status;
    if (!choose_all(&b, what, scheme, nodes, &setup))
        return 2;
    return run(&b, &setup, &err) ? 0 : options_fail(&err);
}
