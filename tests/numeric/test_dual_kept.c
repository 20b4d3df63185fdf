// What an update of the dual tables makes anew, and that it is what a fresh one
// makes, to the bit, from any number of threads.  No GL.
#include <stdlib.h>
#include <string.h>

#include "renderer/crew.h"
#include "renderer/dual_tables.h"
#include "tests/check.h"
#include "tests/numeric/cases.h"

static bool same_bytes(const struct dual_tables *a, const struct dual_tables *b)
{
    struct buf x = {0}, y = {0};
    dual_tables_bytes(a, &x);
    dual_tables_bytes(b, &y);
    const bool same = x.size == y.size && memcmp(x.data, y.data, x.size) == 0;
    buf_finish(&x);
    buf_finish(&y);
    return same;
}

// Of one fibre, by threads at most so many, from nothing.
static struct dual_tables *fresh_tables(const struct dual_fibre *f, int threads)
{
    struct dual_tables *t = dual_tables_create();
    crew_limit(threads);
    dual_tables_update(t, f, DUAL_SCHEME_BEST);
    crew_limit(0);
    return t;
}

static struct dual_tables_work since(const struct dual_tables *t,
                                     struct dual_tables_work from)
{
    const struct dual_tables_work now = dual_tables_work(t);
    return (struct dual_tables_work){now.sections - from.sections,
                                     now.lobes - from.lobes,
                                     now.means - from.means};
}

enum { EDITED = 14 };

// A value of the fibre, what its edit makes anew: sections, lobes, means.
static double *edited(struct dual_fibre *f, int i, struct dual_tables_work *w)
{
    double *const at[EDITED] = {&f->eta,        &f->sigma_a[0],
                                &f->sigma_a[1], &f->sigma_a[2],
                                &f->a,          &f->w_c,
                                &f->alpha[0],   &f->alpha[1],
                                &f->alpha[2],   &f->beta[0],
                                &f->beta[1],    &f->beta[2],
                                &f->delta_eta,  NULL};
    *w = i < 6    ? (struct dual_tables_work){1, 0, 1}
         : i < 12 ? (struct dual_tables_work){0, 1, 1}
                  : (struct dual_tables_work){0, 0, 0};
    return at[i];
}

static void test_kept(void)
{
    struct dual_fibre f = {
        1.55, {.15, .25, .45}, 1.1, {-.13, .07, .2}, {.13, .07, .26}, .17, .3};
    struct dual_tables *t = fresh_tables(&f, 0);
    uint64_t state = 11;
    check_case("dual_an_edit_makes_what_it_touches");
    for (int k = 0; k < 150; k++) {
        const int i = (int)cases_uniform(&state, 0, EDITED);
        struct dual_tables_work want, from = dual_tables_work(t);
        double *value = edited(&f, i, &want);
        if (value)
            *value *= cases_uniform(&state, 0.96, 1.03);
        crew_limit(k % 3); // as many as there are, one, two
        dual_tables_update(t, &f, DUAL_SCHEME_BEST);
        crew_limit(0);
        const struct dual_tables_work got = since(t, from);
        CHECK(got.sections == want.sections && got.lobes == want.lobes &&
              got.means == want.means);
        struct dual_tables *all = fresh_tables(&f, 1);
        CHECK(same_bytes(t, all));
        dual_tables_destroy(all);
        if (k % 20 == 19) { // what the paper makes is not taken for it
            dual_tables_update(t, &f, DUAL_SCHEME_PAPER);
            CHECK(since(t, from).means == want.means + 1);
            from = dual_tables_work(t);
            dual_tables_update(t, &f, DUAL_SCHEME_BEST);
            CHECK(since(t, from).means == 1 && since(t, from).sections == 0);
        }
    }
    dual_tables_destroy(t);
}

int main(void)
{
    test_kept();
    return check_end();
}
