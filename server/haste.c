// haste.c - a model of a draft's time: strands / stride + pixels / divisor^2 +
// what does not shrink.  Each of the three is what was measured last, so that
// another machine, groom or load corrects itself with the next draft.
#include "server/haste.h"

#include <math.h>
#include <string.h>

// The share of the budget that the strands' raster may take: what is left is
// for light, which decides how fine the picture is.
static const double raster_share = 0.3;
// All strands into a small picture, for what they take into a whole one: at
// 1/8 of its sides .13 of it for `animation`, as much for `straight`.
static const double raster_small = 0.13;
// Another size is another set of buffers, and flickers: coarser only where the
// budget would be missed by more than this, finer where it would be kept well.
static const double coarser_above = 1.15, finer_below = 0.8;
// So many drafts in a row that spend half of their time on the raster are too
// many; a single one may be another process' fault.  So may those many, so the
// strands come back: after more drafts in a row of which an eighth goes into
// the raster, since then twice the strands take a quarter.
enum { LATE = 3, EARLY = 8, STRIDE_MOST = 16, ROWS_LEAST = 48 };
static const double late_share = 0.5, early_share = 0.125;

static double ran(double ms)
{
    return ms > 0 ? ms : 0;
}

void haste_full(struct haste *h, const double *stage_ms)
{
    if (stage_ms[RENDERER_VISIBLE] >= 0)
        h->visible = stage_ms[RENDERER_VISIBLE];
}

void haste_full_tail(struct haste *h, double ms)
{
    h->tail = ms;
}

void haste_draft_tail(struct haste *h, double ms)
{
    h->own_tail = ms;
}

double haste_full_ms(const struct haste *h, const double *forecast)
{
    double sum = h->tail;
    for (int i = 0; i < RENDERER_DISPLAY; i++)
        sum += ran(forecast[i]);
    return sum;
}

static struct haste_kind *kind_of(struct haste *h, const double *forecast)
{
    return &h->kind[(forecast[RENDERER_VISIBLE] >= 0) +
                    2 * (forecast[RENDERER_CROSSINGS] >= 0)];
}

static void choose_stride(struct haste *h, double budget_ms)
{
    const double wanted =
        ceil(raster_small * h->visible / (raster_share * budget_ms));
    int k = (int)fmin(fmax(wanted, 1), STRIDE_MOST);
    if (h->late >= LATE && h->stride < STRIDE_MOST) {
        h->least = 2 * h->stride < STRIDE_MOST ? 2 * h->stride : STRIDE_MOST;
        h->late = 0;
    } else if (h->early >= EARLY) {
        h->least /= 2;
        h->early = 0;
    }
    k = k < h->least ? h->least : k;
    if (h->stride > 0 && k < 2 * h->stride && h->stride < 2 * k)
        return;
    h->stride = k;
    h->seen = 0;
}

static double draft_ms(const struct haste *h, const double *forecast,
                       double pixels, int divisor)
{
    double sum = h->own_tail + ran(forecast[RENDERER_LIGHT]) +
                 ran(forecast[RENDERER_TINT]) + ran(forecast[RENDERER_FIBRE]);
    if (forecast[RENDERER_VISIBLE] >= 0)
        sum += h->seen > 0 ? h->seen : raster_small * h->visible / h->stride;
    if (forecast[RENDERER_CROSSINGS] >= 0)
        sum += h->field;
    return sum + pixels / (divisor * divisor);
}

bool haste_choose(struct haste *h, const double *forecast, double budget_ms,
                  int height, struct renderer_draft *how)
{
    if (haste_full_ms(h, forecast) <= budget_ms)
        return false;
    const struct haste_kind *k = kind_of(h, forecast);
    const int rows = height / ROWS_LEAST;
    const int most = rows < 2                     ? 2
                     : rows > RENDERER_DRAFT_MOST ? RENDERER_DRAFT_MOST
                                                  : rows;
    const double pixels = k->divisor > 0 ? k->pixels
                                         : ran(forecast[RENDERER_SHADOW]) +
                                               ran(forecast[RENDERER_SHADE]);
    h->budget = budget_ms;
    choose_stride(h, budget_ms);
    int d = 2;
    while (d < most) {
        const double limit = k->divisor == 0  ? 1
                             : d < k->divisor ? finer_below
                                              : coarser_above;
        if (draft_ms(h, forecast, pixels, d) <= limit * budget_ms)
            break;
        d++;
    }
    *how = (struct renderer_draft){.divisor = d, .stride = h->stride};
    return true;
}

void haste_draft(struct haste *h, const double *forecast,
                 const struct renderer_draft *how, const double *stage_ms)
{
    struct haste_kind *k = kind_of(h, forecast);
    double ms = ran(stage_ms[RENDERER_SHADE]);
    if (forecast[RENDERER_SHADOW] >= 0) // else once, for a new size
        ms += ran(stage_ms[RENDERER_SHADOW]);
    ms *= how->divisor * how->divisor;
    k->pixels = k->divisor > 0 ? 0.5 * (k->pixels + ms) : ms;
    k->divisor = how->divisor;
    if (stage_ms[RENDERER_VISIBLE] >= 0)
        h->seen = stage_ms[RENDERER_VISIBLE];
    if (stage_ms[RENDERER_CROSSINGS] >= 0)
        h->field = stage_ms[RENDERER_CROSSINGS];
    if (forecast[RENDERER_VISIBLE] >= 0) {
        h->late = h->seen > late_share * h->budget ? h->late + 1 : 0;
        h->early = h->seen < early_share * h->budget ? h->early + 1 : 0;
    }
}
