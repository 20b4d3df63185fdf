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
