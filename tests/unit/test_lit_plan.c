// Which lights share a table, how large the tables are, and that they stay
// within the memory they are given.
#include "tests/check.h"

#include <stdlib.h>

#include "renderer/lit_plan.h"

static const double pi = 3.14159265358979323846;

static uint32_t next(uint64_t *state)
{
    *state = *state * 6364136223846793005u + 1442695040888963407u;
    return (uint32_t)(*state >> 33);
}

static double uniform(uint64_t *state)
{
    return next(state) / 2147483648.0;
}

static struct lit_fibre fibre_of(double beta_r, double w_c)
{
    const double deg = pi / 180;
    return (struct lit_fibre){
        .fibre = {.eta = 1.55,
                  .a = 1,
                  .beta = {beta_r * deg, beta_r / 2 * deg, beta_r * 2 * deg},
                  .w_c = w_c * deg},
        .multiple = true,
        .d_b = 0.7f};
}

// As fits have them: widths to 2.2 / sqrt(count), many as wide as that; shares
// over three decades.
static struct lit_lights lights_of(int count, uint64_t *state)
{
    struct lit_lights l;
    memset(&l, 0, sizeof l);
    const double widest = 2.2 / sqrt(count);
    double sum = 0;
    l.count = count;
    l.bytes = 128u << 20;
    for (int j = 0; j < count; j++) {
        const double part = fmin(1.4 * uniform(state), 1);
        l.lambda[j] = (float)fmax(part * widest, 0.02);
        l.share[j] = (float)exp(-7 * uniform(state));
        sum += (double)l.share[j];
    }
    for (int j = 0; j < count; j++)
        l.share[j] *= (float)(count / sum);
    return l;
}

static double number(uint32_t bits)
{
    float f;
    memcpy(&f, &bits, sizeof f);
    return (double)f;
}

static bool is_rest(const struct lit_plan *p, int j)
{
    for (uint32_t i = 0; i < p->rest; i++)
        if (p->block.rest[i / 4][i % 4] == (uint32_t)j)
            return true;
    return false;
}

// The table that a light reads, -1: none.
static int table_of(const struct lit_plan *p, int j)
{
    for (uint32_t i = 0; i < p->tables; i++)
        if (p->block.light[j][1] != 0 &&
            memcmp(p->block.light[j], p->block.table[i], 12) == 0)
            return (int)i;
    return -1;
}

// Every light has one of the tables or is listed as having none; tables fill
// what there is, one after the other.
static void sound(const struct lit_plan *p, const struct lit_lights *l)
{
    uint32_t at = 0;
    for (uint32_t i = 0; i < p->tables; i++) {
        const uint32_t *t = p->block.table[i];
        const uint32_t rows = t[1] >> 16, phis = t[1] & 0xffff;
        CHECK(t[2] == at && rows >= 16 && phis >= 8 && phis % 4 == 0);
        CHECK(rows * LIT_PLAN_D <= p->columns);
        CHECK(fabs(number(t[0]) * 2 * pi / rows - 1) < 2e-6);
        at += rows * phis * LIT_PLAN_D;
    }
    CHECK(at == p->cells && p->block.from[1] == p->rest);
    CHECK(p->block.from[0] == 2 * p->cells && p->narrow <= p->rest);
    for (int j = 0; j < l->count; j++) {
        CHECK((table_of(p, j) < 0) == is_rest(p, j));
        CHECK(number(p->block.light[j][3]) == (double)l->lambda[j]);
    }
}

static void one_width(void)
{
    check_case("lights of one width have one table, of that very width");
    struct lit_lights l;
    memset(&l, 0, sizeof l);
    l.count = 103;
    l.bytes = 128u << 20;
    for (int j = 0; j < l.count; j++) {
        l.lambda[j] = j < 100 ? 0.1571f : 0.002f; // three suns
        l.share[j] = 0.1f * (float)(1 + j % 7);
    }
    const struct lit_fibre f = fibre_of(7.5, 10);
    struct lit_plan p, q;
    lit_plan_make(&p, &f, &l);
    sound(&p, &l);
    CHECK(p.tables == 2 && p.rest == 0 && p.coarser == 0);
    CHECK(number(p.block.table[table_of(&p, 5)][3]) == (double)0.1571f);
    CHECK(number(p.block.table[table_of(&p, 101)][3]) == (double)0.002f);
    lit_plan_make(&q, &f, &l);
    CHECK(memcmp(&p, &q, sizeof p) == 0);
    l = lit_plan_apart(l.lambda, l.count);
    lit_plan_make(&q, &f, &l);
    CHECK(q.tables == 103);
}

// ln of the peak of a light spread by the narrowest lobe and the caustic.
static double peak(const struct lit_fibre *f, double lambda)
{
    const double w = 2.82842712 * f->fibre.beta[1], c = f->fibre.w_c;
    return -0.5 * log((w * w + lambda * lambda) * (c * c + lambda * lambda));
}

static void near_enough(void)
{
    check_case("a table is of nearly the width of all that read it");
    uint64_t state = 3;
    int shared = 0, tables = 0;
    for (int i = 0; i < 200; i++) {
        const struct lit_fibre f =
            fibre_of(1 + 19 * uniform(&state), 2 + 28 * uniform(&state));
        const struct lit_lights l =
            lights_of(1 + (int)(next(&state) % 200), &state);
        struct lit_plan p;
        lit_plan_make(&p, &f, &l);
        sound(&p, &l);
        shared += l.count - (int)p.rest;
        tables += (int)p.tables;
        const double more = exp2(0.25 * p.coarser);
        for (int j = 0; j < l.count; j++) {
            const int t = table_of(&p, j);
            if (t < 0)
                continue;
            const double lambda = number(p.block.table[t][3]);
            const double dim = 1 / sqrt(fmax((double)l.share[j], 1 / 16.0));
            const double most = 0.003 * more * fmax(dim, 1);
            const double off =
                fabs(peak(&f, lambda) - peak(&f, (double)l.lambda[j]));
            if (!CHECK(off <= most + 1e-6)) // widths are single precision
                printf("  %d of %d: %g > %g\n", j, l.count, off, most);
        }
    }
    printf("  %d lights, %d tables\n", shared, tables);
    CHECK(2 * tables < shared);
}

static void bounded(void)
{
    check_case("tables stay within the memory that they are given");
    uint64_t state = 11;
    bool fine = false, coarse = false, missing = false;
    for (int i = 0; i < 300; i++) {
        const struct lit_fibre f =
            fibre_of(0.3 * exp(4 * uniform(&state)), 2 + 28 * uniform(&state));
        struct lit_lights l = lights_of(1 + (int)(next(&state) % 200), &state);
        l.bytes = (uint64_t)1 << (20 + next(&state) % 10);
        struct lit_plan p;
        lit_plan_make(&p, &f, &l);
        sound(&p, &l);
        CHECK(p.coarser <= LIT_PLAN_COARSER);
        CHECK(p.tables == 0 || lit_plan_bytes(&p) <= l.bytes);
        // one buffer: 128 MiB are sure
        CHECK((uint64_t)p.cells * LIT_PLAN_NEAR_BYTES +
                  (uint64_t)p.far_cells * LIT_PLAN_FAR_BYTES <=
              128u << 20);
        // who could have one goes without only where larger cells do not help
        CHECK(p.rest == p.narrow || p.coarser == LIT_PLAN_COARSER);
        fine = fine || p.coarser == 0;
        coarse = coarse || (p.coarser > 0 && p.rest == 0);
        missing = missing || p.rest > p.narrow;
    }
    CHECK(fine && coarse && missing);
}

static void many(void)
{
    check_case("200 lights have tables, with the default memory");
    uint64_t state = 21;
    for (int count = 40; count <= 200; count += 40) {
        const struct lit_fibre f = fibre_of(7.5, 10);
        struct lit_lights l = lights_of(count, &state);
        struct lit_plan p;
        lit_plan_make(&p, &f, &l);
        printf("  %d lights: %u tables, %.1f MB, %u steps coarser\n", count,
               p.tables, (double)lit_plan_bytes(&p) / 1e6, p.coarser);
        CHECK(p.rest == 0 && p.coarser <= 2 && (int)p.tables < count);
    }
}

// A hand that moves a width by hundredths: cells' sizes are on a ladder, so
// that what was marked mostly holds.
static void steady(void)
{
    check_case("a width moved a little mostly leaves the tables' shape alone");
    uint64_t state = 5;
    const struct lit_lights l = lights_of(40, &state);
    struct lit_plan p, q;
    struct lit_fibre f = fibre_of(4, 10);
    int changed = 0, steps = 0;
    lit_plan_make(&p, &f, &l);
    for (double beta = 4; beta < 16; beta *= 1.002, steps++) {
        f = fibre_of(beta, 10);
        lit_plan_make(&q, &f, &l);
        changed +=
            memcmp(p.block.light, q.block.light, sizeof p.block.light) != 0;
        p = q;
    }
    printf("  %d of %d steps changed it\n", changed, steps);
    CHECK(changed * 3 < steps);
}

int main(void)
{
    one_width();
    near_enough();
    bounded();
    many();
    steady();
    return check_end();
}
