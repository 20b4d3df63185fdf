// lit_plan.c - sizes of the tables of lights.
#include "renderer/lit_plan.h"

#include <math.h>
#include <string.h>

static const double pi = 3.14159265358979323846;

enum {
    ROWS_MAX = 160,      // of s: half a turn each way
    PHIS_MAX = 48,       // over |Phi|
    CELLS_MAX = 3500000, // of all lights: 112 MB
};
// A cell of s over the width of light and narrowest lobe together, one of |Phi|
// over that of light and caustic: what they cost and err is in docs/METHODS.md.
static const double step_s = 0.5, step_p = 0.8;
// ln sigma_f of the far table: from here or the narrowest light to there.
static const double far_least = 0.03, far_most = 12, far_log = 2.0;
static const double far_widths = .45;

// The next of 16, 19, 23, 27, 32 ...: a hand that moves a width does not
// change the tables' shape with every step, and marks hold.
static uint32_t rows_for(double cells)
{
    double rows = 16;
    while (rows < cells - 1e-6)
        rows *= 1.189207115;
    return (uint32_t)lrint(rows);
}

static double narrowest(const struct lit_fibre *f)
{
    const double *b = f->fibre.beta;
    return 2.82842712 * (f->opaque ? b[0] : fmin(b[0], fmin(b[1], b[2])));
}

static uint32_t phis_for(double cells)
{
    uint32_t n = 4 * (uint32_t)ceil(cells / 4 - 1e-6);
    return n < 8 ? 8 : n > PHIS_MAX ? PHIS_MAX : n;
}

static void plan_near(struct lit_plan *plan, const struct lit_fibre *f,
                      const float *lambdas, int count)
{
    struct lit_block *const b = &plan->block;
    const double w = narrowest(f), w_c = f->fibre.w_c;
    uint32_t rest = 0;
    for (int j = 0; j < count; j++) {
        const double lambda = (double)lambdas[j];
        memcpy(&b->light[j][3], &lambdas[j], sizeof lambdas[j]);
        const uint32_t rows = rows_for(2 * pi / (step_s * hypot(w, lambda)));
        const uint32_t phis = phis_for(pi / (step_p * hypot(lambda, w_c)));
        const float per_s = (float)(rows / (2 * pi) * (1 - 1e-6));
        const uint32_t cells = rows * LIT_PLAN_D * phis;
        if (rows > ROWS_MAX || plan->cells + cells > CELLS_MAX) {
            b->rest[rest / 4][rest % 4] = (uint32_t)j;
            rest++;
            continue;
        }
        memcpy(&b->light[j][0], &per_s, sizeof per_s);
        b->light[j][1] = rows << 16 | phis;
        b->light[j][2] = plan->cells;
        plan->cells += cells;
        if (rows * LIT_PLAN_D > plan->columns)
            plan->columns = rows * LIT_PLAN_D;
    }
    b->from[1] = rest;
    b->from[2] = plan->columns;
}

static void plan_far(struct lit_plan *plan, const struct lit_fibre *f,
                     const float *lambdas, int count)
{
    struct lit_block *const b = &plan->block;
    const double w = narrowest(f);
    double least = 1;
    for (int j = 0; j < count; j++)
        least = fmin(least, (double)lambdas[j]);
    const double first = log(fmax(least, far_least));
    const double slices = ceil((log(far_most) - first) * far_log);
    const double finest = hypot(w, exp(first + 0.5 / far_log));
    const uint32_t rows = rows_for(2 * pi / (far_widths * finest));
    b->far[0] = (float)first;
    b->far[1] = (float)slices;
    b->far[2] = (float)(rows < ROWS_MAX ? rows : ROWS_MAX);
    b->far[3] = (float)(w * w);
    b->from[0] = plan->cells * (LIT_PLAN_NEAR_BYTES / 16);
    plan->far_cells = f->multiple ? (uint32_t)(b->far[1] * b->far[2]) *
                                        LIT_PLAN_FAR_D * LIT_PLAN_FAR_P
                                  : 0;
}

void lit_plan_make(struct lit_plan *plan, const struct lit_fibre *f,
                   const float *lambda, int count)
{
    memset(plan, 0, sizeof *plan);
    plan_near(plan, f, lambda, count);
    plan_far(plan, f, lambda, count);
}
