// sets.c - see the header.
#include "tests/numeric/sets.h"

#include <math.h>
#include <stdlib.h>

#include "tests/check.h"

void *sets_array(size_t count, size_t size)
{
    void *p = calloc(count, size);
    if (!p)
        abort();
    return p;
}

struct set sets_create(size_t count)
{
    struct set s = {.count = count};
    s.c = sets_array(count, sizeof *s.c);
    s.in = sets_array(count * PROBE_INPUTS, sizeof *s.in);
    s.out = sets_array(count * PROBE_OUTPUTS, sizeof *s.out);
    s.want = sets_array(count, sizeof *s.want);
    s.mean = sets_array(count, sizeof *s.mean);
    return s;
}

void sets_destroy(struct set *s)
{
    free(s->c);
    free(s->in);
    free(s->out);
    free(s->want);
    free(s->mean);
}

bool sets_on_gpu(struct set *s, struct probe_setup setup)
{
    struct error err = {0};
    setup.delta_eta = 0.3;
    struct probe *p = probe_create(&setup, &err);
    for (size_t i = 0; i < s->count; i++)
        cases_to_floats(&s->c[i], s->in + PROBE_INPUTS * i);
    bool ok = p && probe_run(p, s->in, s->count, s->out, &err);
    if (!ok)
        printf("  %s\n", err.text);
    probe_destroy(p);
    return CHECK(ok);
}

void sets_compare(struct set *s, struct cases_errors *e)
{
    for (size_t i = 0; i < s->count; i++) {
        const double *mean = s->mean[i];
        double top = fmax(mean[0], fmax(mean[1], mean[2]));
        for (int t = 0; t < EXACT_MODES; t++)
            if (mean[t] > 1e-5 * top && top > 1e-30)
                cases_add(e, cases_error((double)s->out[3 * i + (size_t)t],
                                         s->want[i][t], mean[t]));
    }
}

bool sets_sane(const struct set *s)
{
    long bad = 0;
    for (size_t i = 0; i < 3 * s->count; i++)
        if (!(s->out[i] >= 0 && s->out[i] < 1e6f) && bad++ < 5) {
            const float *v = s->in + PROBE_INPUTS * (i / 3);
            printf("  mode %zu is %g for", i % 3, (double)s->out[i]);
            for (int k = 0; k < PROBE_INPUTS; k++)
                printf(" %.9g", (double)v[k]);
            printf("\n");
        }
    return bad == 0;
}

struct set sets_wild(size_t count)
{
    struct set s = sets_create(count);
    uint64_t state = 7;
    for (size_t i = 0; i < count; i++) {
        double v[PROBE_INPUTS];
        v[0] = cases_uniform(&state, 1.05, 3);
        v[1] = exp(cases_uniform(&state, -7, 6.9));
        for (int t = 0; t < 3; t++) {
            v[2 + t] = cases_uniform(&state, -.52, .52);
            v[5 + t] = exp(cases_uniform(&state, -6.3, 0));
        }
        v[8] = exp(cases_uniform(&state, -4.7, 0));
        v[9] = i % 3 ? 1 : cases_uniform(&state, 0.71, 1.41);
        v[10] = exp(cases_uniform(&state, -6.9, 0.69));
        v[11] = cases_uniform(&state, -1.5707, 1.5707);
        v[12] = cases_uniform(&state, -6, 6);
        v[13] = cases_uniform(&state, -1.5707, 1.5707);
        v[14] = cases_uniform(&state, -6, 6);
        if (i % 4 == 0) { // theta_d ~ 0, eta = eta' = 2 +- 10^-x
            double off = exp(cases_uniform(&state, -17, -2));
            v[0] = i % 8 ? 2 + off : 2 - off;
            v[11] = v[13] = cases_uniform(&state, -1e-3, 1e-3);
            v[2] = v[3] = v[4] = 0;
        }
        s.c[i] = cases_from_doubles(v);
    }
    return s;
}
