// haste.c - a model of a draft's time: strands / stride + pixels / divisor^2 +
// what does not shrink.  Each of the three is what was measured last, so that
// another machine, groom or load corrects itself with the next draft.
#include "server/haste.h"

#include <math.h>
#include <string.h>

// The share of the budget that the strands' raster may take: what is left is
// for light, which decides how fine the picture is.
static const double raster_share = 0.3;
// A draft becomes finer only when it would stay below this share of the budget:
// another size is another set of buffers, and flickers.
static const double finer_below = 0.8;
enum { STRIDE_MOST = 16, ROWS_LEAST = 48 };

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
    const double wanted = fmin(
        fmax(ceil(h->visible / (raster_share * budget_ms)), 1), STRIDE_MOST);
    const int k = (int)wanted;
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
        sum += h->seen > 0 ? h->seen : h->visible / h->stride;
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
    choose_stride(h, budget_ms);
    int d = 2;
    while (d < most) {
        const double limit =
            d < k->divisor ? finer_below * budget_ms : budget_ms;
        if (draft_ms(h, forecast, pixels, d) <= limit)
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
    const double area = how->divisor * how->divisor;
    k->divisor = how->divisor;
    k->pixels =
        area * (ran(stage_ms[RENDERER_SHADOW]) + ran(stage_ms[RENDERER_SHADE]));
    if (stage_ms[RENDERER_VISIBLE] >= 0)
        h->seen = stage_ms[RENDERER_VISIBLE];
    if (stage_ms[RENDERER_CROSSINGS] >= 0)
        h->field = stage_ms[RENDERER_CROSSINGS];
}
