// verb_probe.c - `glintd probe`: single integrals for whoever wants to check
// them.  Reads lines of numbers, checks each against the parameter table and
// prints what the renderer's shader (or the brute-force reference) makes of
// it.  The integrals themselves live in renderer/probe.c and renderer/exact.c.
#include "server/verbs.h"

#include <math.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "protocol/bytes.h"
#include "protocol/params.h"
#include "renderer/egl.h"
#include "renderer/exact.h"
#include "renderer/probe.h"
#include "server/options.h"

static const double pi = 3.14159265358979323846;

enum { COLUMNS = PROBE_INPUTS, LINE_MAX_BYTES = 4096, SLOW_BATCH = 128 };

enum scheme { SCHEME_PAPER, SCHEME_EXACT };

static const struct {
    const char *name;
    const char *row; // of the parameter table, which has the range
    double min, max; // where there is no row
} columns[COLUMNS] = {
    {"eta", "fibre.eta", 0, 0},
    {"sigma_a", "fibre.sigma_a", 0, 0},
    {"alpha_R", "fibre.alpha_r", 0, 0},
    {"alpha_TT", "fibre.alpha_tt", 0, 0},
    {"alpha_TRT", "fibre.alpha_trt", 0, 0},
    {"beta_R", "fibre.beta_r", 0, 0},
    {"beta_TT", "fibre.beta_tt", 0, 0},
    {"beta_TRT", "fibre.beta_trt", 0, 0},
    {"w_c", "fibre.w_c", 0, 0},
    {"a", "fibre.a", 0, 0},
    {"lambda_j", NULL, 1e-3, 2},
    {"theta_j", NULL, -1.5707963267948966, 1.5707963267948966},
    {"phi_j", NULL, -6.283185307179586, 6.283185307179586},
    {"theta_o", NULL, -1.5707963267948966, 1.5707963267948966},
    {"phi_o", NULL, -6.283185307179586, 6.283185307179586},
};

struct batch {
    enum scheme scheme;
    struct egl *egl;
    struct probe *probe;
    double delta_eta;
    size_t count, limit;
    double value[PROBE_BATCH][COLUMNS];
};

// --- one line ---------------------------------------------------------------
static void range_of(int column, double *min, double *max)
{
    const char *name = columns[column].row;
    *min = columns[column].min;
    *max = columns[column].max;
    if (!name)
        return;
    const struct params_row *row = params_find(name, strlen(name));
    double unit = strcmp(row->unit, "deg") == 0 ? pi / 180 : 1;
    *min = row->min * unit;
    *max = row->max * unit;
}

// A bound may come rounded to a few digits (1.5708 for pi/2): up to a part in
// 10^4 beyond counts as the bound.
static bool within(int column, double *value)
{
    double min, max;
    range_of(column, &min, &max);
    double lo = min - 1e-4 * fabs(min), hi = max + 1e-4 * fabs(max);
    if (!(*value >= lo && *value <= hi))
        return false;
    *value = fmin(fmax(*value, min), max);
    return true;
}

static bool range_error(int column, double value, long line, struct error *err)
{
    double min, max;
    range_of(column, &min, &max);
    return error_set(err, "range", columns[column].name,
                     "line %ld: %s: %.9g is not within [%.9g, %.9g]", line,
                     columns[column].name, value, min, max);
}

// Decimal only, but as loosely as tools print it: "1." and ".5" will do.
static bool parse_number(const char *text, size_t size, double *out)
{
    char *end;
    if (strspn(text, "0123456789+-.eE") < size)
        return false;
    *out = strtod(text, &end);
    return end == text + size && isfinite(*out);
}

static bool parse_line(const char *text, long line, double out[COLUMNS],
                       struct error *err)
{
    static const char blanks[] = " \t\r\n\v\f";
    int count = 0;
    for (;;) {
        text += strspn(text, blanks);
        size_t size = strcspn(text, blanks);
        if (size == 0)
            break;
        if (count < COLUMNS) {
            const char *name = columns[count].name;
            if (!parse_number(text, size, &out[count]))
                return error_set(err, "syntax", name,
                                 "line %ld: %s: \"%.*s\" is not a finite "
                                 "number",
                                 line, name, size > 40 ? 40 : (int)size, text);
            if (!within(count, &out[count]))
                return range_error(count, out[count], line, err);
        }
        count++;
        text += size;
    }
    if (count != COLUMNS)
        return error_set(err, "syntax", "line",
                         "line %ld: %d numbers, %d are wanted: eta sigma_a "
                         "alpha_R alpha_TT alpha_TRT beta_R beta_TT beta_TRT "
                         "w_c a lambda_j theta_j phi_j theta_o phi_o",
                         line, count, COLUMNS);
    return true;
}

// --- batches ----------------------------------------------------------------
// The reference takes milliseconds a case: one thread a processor, each taking
// the next case that nobody has.
struct crew {
    const struct batch *batch;
    atomic_size_t next;
    double out[SLOW_BATCH][EXACT_MODES];
};

static void *work(void *arg)
{
    struct crew *crew = arg;
    const struct batch *b = crew->batch;
    for (;;) {
        size_t i = atomic_fetch_add(&crew->next, 1);
        if (i >= b->count)
            return NULL;
        const double *v = b->value[i];
        struct exact_case c = {.eta = v[0],
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
                               .delta_eta = b->delta_eta};
        exact_modes(&c, crew->out[i]);
    }
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
        printf("%.9g %.9g %.9g\n", crew.out[i][EXACT_R], crew.out[i][EXACT_TT],
               crew.out[i][EXACT_TRT]);
}

static bool run_batch(struct batch *b, struct error *err)
{
    static float cases[PROBE_BATCH * PROBE_INPUTS];
    static float results[PROBE_BATCH * PROBE_OUTPUTS];
    if (b->scheme == SCHEME_EXACT)
        run_exact(b);
    if (b->scheme == SCHEME_PAPER && b->count > 0) {
        for (size_t i = 0; i < b->count * COLUMNS; i++)
            cases[i] = (float)b->value[i / COLUMNS][i % COLUMNS];
        if (!probe_run(b->probe, cases, b->count, results, err))
            return false;
        for (size_t i = 0; i < b->count; i++)
            printf("%.9g %.9g %.9g\n", (double)results[3 * i],
                   (double)results[3 * i + 1], (double)results[3 * i + 2]);
    }
    b->count = 0;
    if (fflush(stdout) != 0)
        return error_set(err, "file", "stdout", "stdout: cannot write");
    return true;
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
            good = parse_line(text, line, b->value[b->count], &bad);
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
// Index of `word` among `words`, or -1 with a line on stderr.
static int choose(const char *option, const char *word,
                  const char *const words[2])
{
    for (int i = 0; i < 2; i++)
        if (strcmp(word, words[i]) == 0)
            return i;
    struct error err;
    error_set(&err, "range", option, "--%s: %s is not one of %s, %s", option,
              word, words[0], words[1]);
    options_fail(&err);
    return -1;
}

static bool run(struct batch *b, const struct probe_setup *setup,
                struct error *err)
{
    if (b->scheme == SCHEME_EXACT)
        return run_input(b, err);
    b->egl = egl_create(err);
    if (!b->egl)
        return false;
    b->probe = probe_create(setup, err);
    bool ok = b->probe && run_input(b, err);
    probe_destroy(b->probe);
    egl_destroy(b->egl);
    return ok;
}

int verb_probe_run(int argc, char **argv)
{
    static const char *const schemes[2] = {"paper", "exact"};
    static const char *const layouts[2] = {"paper", "fine"};
    static struct batch b;
    const char *scheme = schemes[0], *nodes = layouts[0];
    struct probe_setup setup = {.m = 4, .tables = 1};
    const struct options_row rows[] = {
        {"scheme", OPTIONS_TEXT, &scheme, 0, 0, "paper|exact",
         "the renderer's shader, or brute force in double precision"},
        {"m", OPTIONS_INT, &setup.m, 2, 256, "N",
         "segments of the outer integral (Xu 2011, section 4.2.2)"},
        {"nodes", OPTIONS_TEXT, &nodes, 0, 0, "paper|fine",
         "node layout: as printed, or one that converges with m"},
        {"tables", OPTIONS_INT, &setup.tables, 1, 8, "N",
         "table resolution in multiples of 128 x 64"},
        {0}};
    const struct options_verb verb = {
        "probe",
        "single scattering integrals: lines of fifteen numbers on stdin (eta "
        "sigma_a alpha_R alpha_TT alpha_TRT beta_R beta_TT beta_TRT w_c a "
        "lambda_j theta_j phi_j theta_o phi_o; radians), M_R M_TT M_TRT out",
        0, rows, NULL};
    struct options o;
    struct error err;
    int status = options_parse(&o, &verb, argc, argv);
    options_finish(&o);
    if (status >= 0)
        return status;
    int which = choose("scheme", scheme, schemes);
    int layout = which < 0 ? -1 : choose("nodes", nodes, layouts);
    if (layout < 0)
        return 2;
    b.scheme = (enum scheme)which;
    b.limit = which == SCHEME_EXACT ? SLOW_BATCH : PROBE_BATCH;
    b.delta_eta = params_find("fibre.delta_eta", 15)->def[0];
    setup.fine_nodes = layout == 1;
    setup.delta_eta = b.delta_eta;
    return run(&b, &setup, &err) ? 0 : options_fail(&err);
}
