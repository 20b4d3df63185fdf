// single.c - see the header.
#include "tests/extremes/single.h"

#include <stdlib.h>

#include "renderer/shoot_threads.h"
#include "tests/check.h"
#include "tests/numeric/xu_double.h"

#define PI 3.14159265358979323846
enum { WORDS = PROBE_GUARD_WORDS };

const struct single_way single_ways[] = {
    {"paper", {.m = 4, .tables = 1, .delta_eta = 0.3}},
    {"paper, fine 16",
     {.m = 16, .fine_nodes = true, .tables = 1, .delta_eta = 0.3}},
    {"best", {.m = 4, .tables = 1, .delta_eta = 0.3, .best = true}},
};
const int single_way_count = sizeof single_ways / sizeof *single_ways;
// Against the double-precision copy: tables that add nothing.
static const struct single_way copy_way = {
    "copy", {.m = 4, .tables = 8, .delta_eta = 0.3}};

struct set {
    size_t count;
    struct exact_case *c;
    float *in, *out;
    uint32_t *hits;
};

static void *array(size_t count, size_t size)
{
    void *p = calloc(count ? count : 1, size);
    if (!p)
        abort();
    return p;
}

// Lights and views that share a fibre, where a probe makes lobes for each; of
// round values there are few.
enum { SHARED = 8, SHARED_ROUND = 64 };

// group: so many vectors one after the other are of one fibre.
static struct set set_create(enum vectors_region region, size_t count,
                             uint64_t state, size_t group)
{
    struct set s = {.count = count};
    s.c = array(count, sizeof *s.c);
    s.in = array(count * PROBE_INPUTS, sizeof *s.in);
    s.out = array(count * PROBE_OUTPUTS, sizeof *s.out);
    s.hits = array(count * WORDS, sizeof *s.hits);
    for (size_t i = 0; i < count; i++) {
        s.c[i] = vectors_case(&state, region);
        if (i % group && region != VECTORS_MERGE) {
            struct exact_case light = s.c[i];
            s.c[i] = s.c[i - 1];
            s.c[i].lambda_j = light.lambda_j;
            s.c[i].theta_j = light.theta_j;
            s.c[i].phi_j = light.phi_j;
            s.c[i].theta_o = light.theta_o;
            s.c[i].phi_o = light.phi_o;
        }
        cases_to_floats(&s.c[i], s.in + PROBE_INPUTS * i);
    }
    return s;
}

static void set_destroy(struct set *s)
{
    free(s->c);
    free(s->in);
    free(s->out);
    free(s->hits);
}

static struct {
    const struct single_way *way;
    struct probe *probe;
} kept[SINGLE_WAYS_MAX];

struct probe *single_probe(const struct single_way *way)
{
    struct error err = {0};
    int i = 0;
    while (i < SINGLE_WAYS_MAX - 1 && kept[i].way && kept[i].way != way)
        i++;
    kept[i].way = way;
    if (!kept[i].probe)
        kept[i].probe = probe_create(&way->setup, &err);
    if (!kept[i].probe)
        printf("  %s\n", err.text);
    return kept[i].probe;
}

void single_close(void)
{
    for (int i = 0; i < SINGLE_WAYS_MAX; i++)
        probe_destroy(kept[i].probe);
    memset(kept, 0, sizeof kept);
}

static bool on_gpu(struct set *s, const struct single_way *way, bool guards)
{
    struct error err = {0};
    struct probe *p = single_probe(way);
    if (p)
        probe_note_guards(p, guards ? s->hits : NULL);
    bool ok = p && probe_run(p, s->in, s->count, s->out, &err);
    if (!ok)
        printf("  %s\n", err.text);
    return CHECK(ok);
}

// exp(-4 sin^2(x/2)/l^2) <= exp(-x^2/(pi l/2)^2): a circular Gaussian is below
// the plain one pi/2 times as wide, whose overlap with M_t has a closed form.
// cos^2 theta_i / cos^2 theta_d <= 4.  What reaches a mode is at most 1 for R
// and TT, (1-F)^2 F <= 4/27 for TRT.  Scheme `paper` takes sqrt(pi) lambda for
// the integral of a circular Gaussian, too little by up to 17.5 % (at lambda
// 1.6).
void single_bound(const struct exact_case *c, double out[EXACT_MODES])
{
    static const double energy[EXACT_MODES] = {1, 1, 4.0 / 27};
    for (int t = 0; t < EXACT_MODES; t++) {
        double l = PI / 2 * c->lambda_j, w = 2 * sqrt(2) * c->beta[t];
        double away = 2 * c->alpha[t] - c->theta_o - c->theta_j;
        double both = l * l + w * w;
        out[t] =
            4 * 1.175 * energy[t] * l / sqrt(both) * exp(-away * away / both);
    }
}

// value / bound; a bound that float cannot hold asks for nothing but 0.
static double of_bound(double value, double bound)
{
    return value / fmax(bound, 1e-37);
}

static void print_case(const struct exact_case *c)
{
    float v[PROBE_INPUTS];
    cases_to_floats(c, v);
    for (int k = 0; k < PROBE_INPUTS; k++)
        printf(" %.9g", (double)v[k]);
    printf("\n");
}

static void judge(const struct set *s, const char *name, struct single_law *law)
{
    for (size_t i = 0; i < s->count; i++) {
        double bound[EXACT_MODES];
        single_bound(&s->c[i], bound);
        bool guarded = false;
        for (int k = 0; k < WORDS; k++)
            guarded = guarded || s->hits[WORDS * i + (size_t)k];
        law->guarded += guarded;
        for (int t = 0; t < EXACT_MODES; t++) {
            double v = (double)s->out[3 * i + (size_t)t];
            double part = of_bound(v, bound[t]);
            if (part > law->top) {
                law->top = part;
                law->worst = s->c[i];
            }
            // 1e-4: an exponent of 200 that a float holds to 1e-5.
            if (!(v >= 0 && isfinite(v) && part <= 1 + 1e-4) &&
                law->bad++ < 3) {
                printf("  %s, mode %d: %g, bound %g:", name, t, v, bound[t]);
                print_case(&s->c[i]);
            }
        }
    }
    law->vectors += (long)s->count;
    guards_count(s->hits, s->count, law->hits);
}

struct single_law single_sweep(const struct single_way *way,
                               enum vectors_region region, long count)
{
    struct single_law law = {0};
    size_t shared = region == VECTORS_ROUND ? SHARED_ROUND : SHARED;
    struct set s = set_create(region, (size_t)count, 1000 + (uint64_t)region,
                              way->setup.best ? shared : 1);
    if (on_gpu(&s, way, true))
        judge(&s, way->name, &law);
    else
        law.bad++;
    set_destroy(&s);
    return law;
}

// --- brute force ------------------------------------------------------------
struct crew {
    const struct set *set;
    double (*want)[EXACT_MODES], (*mean)[EXACT_MODES], (*copy)[EXACT_MODES];
};

static void answer_one(void *all, size_t i)
{
    struct crew *crew = all;
    const struct exact_case *c = &crew->set->c[i];
    exact_modes(c, crew->want[i]);
    exact_means(c, crew->mean[i]);
    xu_double_modes(c, copy_way.setup.m, false, crew->copy[i]);
}

// Error of the sum of the modes whose cone the light meets (its amplitude more
// than a thousandth); < 0 where there is none.
static double error_of(const struct exact_case *c, const float *got,
                       const double *want, const double *mean)
{
    double g = 0, w = 0, m = 0;
    for (int t = 0; t < EXACT_MODES; t++) {
        double width = 2 * sqrt(2) * c->beta[t], l = c->lambda_j;
        double away = 2 * c->alpha[t] - c->theta_o - c->theta_j;
        if (away * away > 6.9 * (width * width + l * l))
            continue;
        g += (double)got[t];
        w += want[t];
        m += mean[t];
    }
    // Below this a float picture of a sky of 1e6 is black.
    return m > 1e-16 ? cases_error(g, w, m) : -1;
}

static void collect(const struct set *s, const struct crew *crew, int way,
                    struct single_truth *out)
{
    for (size_t i = 0; i < s->count; i++) {
        double e =
            error_of(&s->c[i], s->out + 3 * i,
                     way < 0 ? crew->copy[i] : crew->want[i], crew->mean[i]);
        if (!(e < 0))
            cases_add(way < 0 ? &out->copy : &out->way[way], e);
        if (!(e < 0) && way >= 0 && s->hits[WORDS * i])
            cases_add(&out->guarded[way], e);
    }
}

void single_compare(enum vectors_region region, long count,
                    struct single_truth *out)
{
    *out = (struct single_truth){0};
    struct set s =
        set_create(region, (size_t)count, 5000 + (uint64_t)region, 1);
    // A flat fibre's third integral takes seconds: it has a region of its own.
    for (size_t i = 0; region != VECTORS_FLAT && i < s.count; i++)
        if (s.c[i].a != 1) {
            s.c[i].a = 1;
            cases_to_floats(&s.c[i], s.in + PROBE_INPUTS * i);
        }
    struct crew crew = {.set = &s};
    crew.want = array(s.count, sizeof *crew.want);
    crew.mean = array(s.count, sizeof *crew.mean);
    crew.copy = array(s.count, sizeof *crew.copy);
    shoot_threads(s.count, answer_one, &crew);
    for (size_t i = 0; i < s.count; i++) {
        double bound[EXACT_MODES];
        single_bound(&s.c[i], bound);
        for (int t = 0; t < EXACT_MODES; t++) {
            double v = crew.want[i][t], part = of_bound(v, bound[t]);
            out->top = fmax(out->top, part);
            if (!(v >= 0 && isfinite(v) && part <= 1 + 1e-6) &&
                out->bad++ < 3) {
                printf("  exact, mode %d: %g, bound %g:", t, v, bound[t]);
                print_case(&s.c[i]);
            }
        }
    }
    out->vectors = (long)s.count;
    if (on_gpu(&s, &copy_way, false))
        collect(&s, &crew, -1, out);
    for (int w = 0; w < single_way_count; w++)
        if (on_gpu(&s, &single_ways[w], true))
            collect(&s, &crew, w, out);
    free(crew.want);
    free(crew.mean);
    free(crew.copy);
    set_destroy(&s);
}

void single_finish(struct single_truth *t)
{
    cases_finish(&t->copy);
    for (int w = 0; w < SINGLE_WAYS_MAX; w++) {
        cases_finish(&t->way[w]);
        cases_finish(&t->guarded[w]);
    }
}
