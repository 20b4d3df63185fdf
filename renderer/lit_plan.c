// lit_plan.c - sizes of the tables of lights, and who shares which.
#include "renderer/lit_plan.h"

#include <math.h>
#include <string.h>

static const double pi = 3.14159265358979323846;

enum {
    LIGHTS = LIT_PLAN_LIGHTS,
    ROWS_MAX = 512, // of s: half a turn each way
    FAR_ROWS_MAX = 160,
    PHIS_MAX = 48,       // over |Phi|
    CELLS_MAX = 3500000, // 112 MB: some drivers' buffers end at 128 MiB
    COARSER_MAX = LIT_PLAN_COARSER
};
// A cell of s over the width of light and narrowest lobe together, one of |Phi|
// over that of light and caustic: what they cost and err is in docs/METHODS.md.
static const double step_s = 0.5, step_p = 0.8;
// ln sigma_f of the far table: from here or the narrowest light to there.
static const double far_least = 0.03, far_most = 12, far_log = 2.0;
static const double far_widths = .45;
// How much ln of the peak of what a light does may differ from its table's:
// 2^(1/2) times as much where it holds half the light of others, to this.
static const double tolerance = 0.003, dim_most = 4;

struct group { // lights of one table, by rising width
    int first, count;
    double low, high;   // what their peaks' logarithms have in common
    double share, most; // of all its lights, of the one that holds most
    float lambda;
};

struct widths {
    double w, w_c;           // of the narrowest lobe, of the caustic
    double steady, steady_c; // their squares, or less: see steady_of
};

struct draw { // what one turn of planning works on
    const struct lit_lights *lights;
    struct widths widths;
    int order[LIGHTS]; // lights by rising width
    struct group group[LIGHTS];
    int groups, coarser;
};

// The next of 16, 19, 23, 27, 32 ...: a hand that moves a width does not
// change the tables' shape with every step, and marks hold.
static uint32_t rows_for(double cells)
{
    double rows = 16;
    while (rows < cells - 1e-6)
        rows *= 1.189207115;
    return (uint32_t)lrint(rows);
}

// As steady, for who shares a table with whom: the power of two below.
static double steady_of(double width)
{
    const double low = exp2(floor(log2(width) + 1e-9));
    return low * low;
}

double lit_plan_narrowest(const struct lit_fibre *f)
{
    const double *b = f->fibre.beta;
    return 2.82842712 * (f->opaque ? b[0] : fmin(b[0], fmin(b[1], b[2])));
}

static uint32_t phis_for(double cells)
{
    uint32_t n = 4 * (uint32_t)ceil(cells / 4 - 1e-6);
    return n < 8 ? 8 : n > PHIS_MAX ? PHIS_MAX : n;
}

// --- who shares a table ------------------------------------------------------

// A light of width lambda, its energy given, is spread by a lobe to
// hypot(lambda, w) along the fibre and hypot(lambda, w_c) around it at least:
// minus ln of the peak.  And back: lambda^2.
static double spread_of(const struct widths *w, double lambda2)
{
    return 0.5 * log((w->steady + lambda2) * (w->steady_c + lambda2));
}

static double unspread(const struct widths *w, double spread)
{
    const double half = 0.5 * (w->steady - w->steady_c);
    return sqrt(half * half + exp(2 * spread)) -
           0.5 * (w->steady + w->steady_c);
}

static void sort_lights(struct draw *d)
{
    const float *lambda = d->lights->lambda;
    for (int i = 0; i < d->lights->count; i++) {
        int at = i;
        for (; at > 0 && lambda[d->order[at - 1]] > lambda[i]; at--)
            d->order[at] = d->order[at - 1];
        d->order[at] = i;
    }
}

// The width of a group's table: of its lights' mean by the square of what they
// hold, as near to it as all allow.
static float width_of(const struct draw *d, const struct group *g)
{
    const struct lit_lights *l = d->lights;
    const int first = d->order[g->first];
    double sum = 0, weights = 0;
    bool same = true;
    for (int i = g->first; i < g->first + g->count; i++) {
        const int j = d->order[i];
        const double lambda = (double)l->lambda[j];
        const double weight = fmax((double)l->share[j], 1e-6);
        sum += weight * weight * lambda * lambda;
        weights += weight * weight;
        same = same && l->lambda[j] == l->lambda[first];
    }
    if (same)
        return l->lambda[first];
    const double low = unspread(&d->widths, g->low);
    const double high = unspread(&d->widths, g->high);
    return (float)sqrt(fmin(fmax(sum / weights, low), high));
}

static void share_tables(struct draw *d)
{
    const struct lit_lights *l = d->lights;
    struct group *g = NULL;
    d->groups = 0;
    for (int i = 0; i < l->count; i++) {
        const int j = d->order[i];
        const double lambda = (double)l->lambda[j], share = (double)l->share[j];
        const double at = spread_of(&d->widths, lambda * lambda);
        const double dim = fmin(1 / sqrt(fmax(share, 1e-6)), dim_most);
        const double off = tolerance * exp2(0.25 * d->coarser) * fmax(dim, 1);
        if (!g || l->apart ||
            fmax(g->low, at - off) > fmin(g->high, at + off)) {
            g = &d->group[d->groups++];
            *g = (struct group){i, 0, at - off, at + off, 0, 0, 0};
        }
        g->low = fmax(g->low, at - off);
        g->high = fmin(g->high, at + off);
        g->share += share;
        g->most = fmax(g->most, share);
        g->count++;
    }
    for (int i = 0; i < d->groups; i++)
        d->group[i].lambda = width_of(d, &d->group[i]);
}

// By falling share, so that who has no table matters least.
static void sort_groups(struct draw *d)
{
    for (int i = 1; i < d->groups; i++) {
        const struct group g = d->group[i];
        int at = i;
        for (; at > 0 && d->group[at - 1].share < g.share; at--)
            d->group[at] = d->group[at - 1];
        d->group[at] = g;
    }
}

// --- sizes -------------------------------------------------------------------

static void leave_out(struct lit_plan *plan, const struct draw *d,
                      const struct group *g, bool narrow)
{
    for (int i = g->first; i < g->first + g->count; i++) {
        plan->block.rest[plan->rest / 4][plan->rest % 4] =
            (uint32_t)d->order[i];
        plan->rest++;
        plan->narrow += narrow;
    }
}

// Cells of a light that holds little may be larger.  An error that grows as h^3
// while cells become fewer as h^-2 is least for its sort where h goes by
// share^(-1/4).  But dim lights are all that some places see: half of that.
static double by_share(double share)
{
    return fmin(fmax(pow(fmax(share, 1e-6), -0.125), 0.84), 1.19);
}

static void place_table(struct lit_plan *plan, const struct draw *d,
                        const struct group *g, uint32_t most)
{
    const double lambda = (double)g->lambda;
    const double larger = exp2(0.125 * d->coarser) * by_share(g->most);
    const double s = larger * step_s * hypot(d->widths.w, lambda);
    const double p = larger * step_p * hypot(lambda, d->widths.w_c);
    const uint32_t rows = rows_for(2 * pi / s), phis = phis_for(pi / p);
    const uint32_t cells = rows * LIT_PLAN_D * phis;
    const float per_s = (float)(rows / (2 * pi) * (1 - 1e-6));
    uint32_t *const t = plan->block.table[plan->tables];
    if (rows > ROWS_MAX || plan->cells + cells > most) {
        leave_out(plan, d, g, rows > ROWS_MAX);
        return;
    }
    memcpy(&t[0], &per_s, sizeof per_s);
    t[1] = rows << 16 | phis;
    t[2] = plan->cells;
    memcpy(&t[3], &g->lambda, sizeof g->lambda);
    for (int i = g->first; i < g->first + g->count; i++)
        memcpy(plan->block.light[d->order[i]], t, 3 * sizeof *t);
    plan->tables++;
    plan->cells += cells;
    if (rows * LIT_PLAN_D > plan->columns)
        plan->columns = rows * LIT_PLAN_D;
}

static void plan_far(struct lit_plan *plan, const struct lit_fibre *f,
                     const struct lit_lights *l)
{
    struct lit_block *const b = &plan->block;
    const double w = lit_plan_narrowest(f);
    const double least = fmin(fmax((double)l->least, far_least), 1);
    const double first = log(least);
    const double slices = ceil((log(far_most) - first) * far_log);
    const double finest = hypot(w, exp(first + 0.5 / far_log));
    const uint32_t rows = rows_for(2 * pi / (far_widths * finest));
    b->far[0] = (float)first;
    b->far[1] = (float)slices;
    b->far[2] = (float)(rows < FAR_ROWS_MAX ? rows : FAR_ROWS_MAX);
    b->far[3] = (float)(w * w);
    plan->far_cells = f->multiple ? (uint32_t)(b->far[1] * b->far[2]) *
                                        LIT_PLAN_FAR_D * LIT_PLAN_FAR_P
                                  : 0;
}

static uint64_t bytes_of(uint64_t near, uint64_t far)
{
    const uint64_t values =
        LIT_PLAN_FAR_VALUES * far > near ? LIT_PLAN_FAR_VALUES * far : near;
    return near * (LIT_PLAN_NEAR_BYTES + LIT_PLAN_MARK_BYTES) +
           far * LIT_PLAN_FAR_BYTES + values * LIT_PLAN_VALUE_BYTES;
}

uint64_t lit_plan_bytes(const struct lit_plan *plan)
{
    return bytes_of(plan->cells, plan->far_cells);
}

// How many cells lights may have; buffers take up to a quarter more than is
// needed at first.
static uint32_t cells_for(uint64_t bytes, uint64_t far)
{
    uint32_t low = 0, high = CELLS_MAX;
    while (low < high) {
        const uint32_t mid = low + (high - low + 1) / 2;
        if (bytes_of(mid, far) <= bytes / 5 * 4)
            low = mid;
        else
            high = mid - 1;
    }
    return low;
}

static void plan_near(struct lit_plan *plan, struct draw *d)
{
    const uint32_t most = cells_for(d->lights->bytes, plan->far_cells);
    const struct lit_plan empty = *plan;
    for (d->coarser = 0;; d->coarser++) {
        *plan = empty;
        plan->coarser = (uint32_t)d->coarser;
        share_tables(d);
        sort_groups(d);
        for (int i = 0; i < d->groups; i++)
            place_table(plan, d, &d->group[i], most);
        if (plan->rest == plan->narrow || d->coarser == COARSER_MAX)
            return;
    }
}

struct lit_lights lit_plan_apart(const float *lambda, int count)
{
    struct lit_lights l;
    memset(&l, 0, sizeof l);
    l.count = count;
    l.bytes = UINT64_MAX;
    l.apart = true;
    l.least = 1;
    for (int j = 0; j < count; j++) {
        l.lambda[j] = lambda[j];
        l.least = fminf(l.least, lambda[j]);
        l.share[j] = 1;
    }
    return l;
}

void lit_plan_make(struct lit_plan *plan, const struct lit_fibre *f,
                   const struct lit_lights *lights)
{
    struct draw d;
    memset(plan, 0, sizeof *plan);
    d.lights = lights;
    d.widths = (struct widths){lit_plan_narrowest(f), f->fibre.w_c, 0, 0};
    d.widths.steady = steady_of(d.widths.w);
    d.widths.steady_c = steady_of(d.widths.w_c);
    sort_lights(&d);
    plan_far(plan, f, lights);
    plan_near(plan, &d);
    for (int j = 0; j < lights->count; j++)
        memcpy(&plan->block.light[j][3], &lights->lambda[j],
               sizeof lights->lambda[j]);
    plan->block.from[0] = plan->cells * (LIT_PLAN_NEAR_BYTES / 16);
    plan->block.from[1] = plan->rest;
    plan->block.from[2] = plan->columns;
}
