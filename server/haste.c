// haste.c - a model of a draft's time: strands / stride + pixels / divisor^2 +
// what does not shrink.  Each of them is what was measured last, so that
// another machine, groom or load corrects itself with the next draft.
#include "server/haste.h"

#include <math.h>
#include <string.h>

// Times vary: aimed at this share of the budget, half of the drafts are well
// within it and nearly all within 1.2 of it.
static const double aim = 0.8;
// The share of the budget that the strands' raster may take: what is left is
// for light, which decides how fine the picture is.
static const double raster_share = 0.3;
// ... and making them, where it is the hair that is dragged.
static const double strands_share = 0.15;
// All strands into a small picture, for what they take into a whole one: at
// 1/8 of its sides .13 of it for `animation`, as much for `straight`.
static const double raster_small = 0.13;
// A coarse field that was never made: ms.
static const double field_guess = 10;
// Another size is another set of buffers, and flickers: coarser only where the
// aim would be missed by more than this, finer where it would be kept well.
static const double coarser_above = 1.15, finer_below = 0.8;
// Strands that stand for others are at most this wide in a draft's own pixels:
// wider ones look like what they are, leaves.
static const double widest = 2;
// So many drafts in a row that spend half of their time on the raster are too
// many; a single one may be another process' fault.  So may those many, so the
// strands come back: after more drafts in a row of which an eighth goes into
// the raster, since then twice the strands take a quarter.
enum { LATE = 3, EARLY = 8, STRIDE_MOST = 16, ROWS_LEAST = 48, SETTLED = 2 };
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

static int number_of(const double *forecast)
{
    return (forecast[RENDERER_VISIBLE] >= 0) +
           2 * (forecast[RENDERER_CROSSINGS] >= 0) +
           4 * (forecast[RENDERER_STRANDS] >= 0);
}

// Does such a draft need a raster of its own, whatever was seen before?
static bool rasters(const double *forecast)
{
    return forecast[RENDERER_VISIBLE] >= 0 || forecast[RENDERER_STRANDS] >= 0;
}

static void choose_stride(struct haste *h)
{
    const double wanted =
        ceil(raster_small * h->visible / (raster_share * h->budget));
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

// ms of making all strands.
static double strands_ms(const struct haste *h, const double *forecast)
{
    const struct haste_kind *k = &h->kind[number_of(forecast)];
    return forecast[RENDERER_STRANDS] < 0 ? 0
           : k->divisor > 0               ? k->strands
                                          : forecast[RENDERER_STRANDS];
}

// How many strands one has to stand for, and may at this size.
static int stride_of(const struct haste *h, const double *forecast,
                     const struct haste_ask *ask, int divisor)
{
    const double most = ask->width_pixels > 0
                            ? widest * divisor / ask->width_pixels
                            : STRIDE_MOST;
    int k = h->stride;
    while (k < STRIDE_MOST &&
           strands_ms(h, forecast) / k > strands_share * h->budget)
        k = 2 * k < STRIDE_MOST ? 2 * k : STRIDE_MOST;
    return most < 1 ? 1 : most < k ? (int)most : k;
}

static double raster_ms(const struct haste *h, int stride)
{
    return h->seen > 0 ? h->seen * h->stride / stride
                       : raster_small * h->visible / stride;
}

static double draft_ms(const struct haste *h, const double *forecast,
                       int divisor, int stride)
{
    const struct haste_kind *k = &h->kind[number_of(forecast)];
    const double pixels = k->divisor > 0 ? k->pixels
                                         : ran(forecast[RENDERER_SHADOW]) +
                                               ran(forecast[RENDERER_SHADE]);
    double sum = (h->own_tail > 0 ? h->own_tail : h->tail) +
                 ran(forecast[RENDERER_LIGHT]) + ran(forecast[RENDERER_TINT]) +
                 ran(forecast[RENDERER_FIBRE]);
    sum += strands_ms(h, forecast) / stride;
    if (forecast[RENDERER_CROSSINGS] >= 0)
        sum += k->divisor > 0 ? k->field : field_guess;
    return sum + pixels / (divisor * divisor);
}

// The finest one within the time that `before` leaves.
static int choose_divisor(const struct haste *h, const double *forecast,
                          const struct haste_ask *ask, bool raster)
{
    const struct haste_kind *k = &h->kind[number_of(forecast)];
    const int rows = ask->height / ROWS_LEAST;
    const int most = rows < 2                     ? 2
                     : rows > RENDERER_DRAFT_MOST ? RENDERER_DRAFT_MOST
                                                  : rows;
    int d = 2;
    for (; d < most; d++) {
        const int stride = stride_of(h, forecast, ask, d);
        const double limit = k->divisor == 0  ? 1
                             : d < k->divisor ? finer_below
                                              : coarser_above;
        if (draft_ms(h, forecast, d, stride) +
                (raster ? raster_ms(h, stride) : 0) <=
            limit * aim * h->budget)
            break;
    }
    return d;
}

// Of what is seen already the one that is next to the size wanted, if it can be
// in time and is not much coarser.
static bool choose_seen(const struct haste *h, const double *forecast,
                        const struct haste_ask *ask, int wanted,
                        struct renderer_draft *how)
{
    const struct renderer_draft *best = NULL;
    for (int i = 0; i < ask->seen_count; i++) {
        const struct renderer_draft *s = &ask->seen[i];
        const bool late =
            s->divisor < wanted && draft_ms(h, forecast, s->divisor, 1) >
                                       coarser_above * aim * h->budget;
        if (late || s->divisor > 2 * wanted)
            continue;
        if (!best || s->divisor < best->divisor ||
            (s->divisor == best->divisor && s->stride < best->stride))
            best = s;
    }
    if (best)
        *how = (struct renderer_draft){.divisor = best->divisor,
                                       .stride = best->stride};
    return best != NULL;
}

bool haste_choose(struct haste *h, const double *forecast,
                  const struct haste_ask *ask, struct renderer_draft *how)
{
    if (haste_full_ms(h, forecast) <= ask->budget_ms)
        return false;
    h->budget = ask->budget_ms;
    choose_stride(h);
    if (!rasters(forecast)) {
        const int d = choose_divisor(h, forecast, ask, false);
        *how = (struct renderer_draft){.divisor = d, .stride = 1};
        if (ask->resting || choose_seen(h, forecast, ask, d, how))
            return true;
    }
    const int d = choose_divisor(h, forecast, ask, true);
    *how = (struct renderer_draft){.divisor = d,
                                   .stride = stride_of(h, forecast, ask, d)};
    return true;
}

bool haste_settled(const struct haste *h, const double *forecast,
                   const struct renderer_draft *how)
{
    const struct haste_kind *k = &h->kind[number_of(forecast)];
    return k->divisor == how->divisor && k->times >= SETTLED;
}

void haste_draft(struct haste *h, const double *forecast,
                 const struct renderer_draft *how, const double *stage_ms)
{
    struct haste_kind *k = &h->kind[number_of(forecast)];
    double ms = ran(stage_ms[RENDERER_SHADE]);
    if (forecast[RENDERER_SHADOW] >= 0) // else once, for a new size
        ms += ran(stage_ms[RENDERER_SHADOW]);
    ms *= how->divisor * how->divisor;
    k->pixels = k->divisor > 0 ? 0.5 * (k->pixels + ms) : ms;
    if (stage_ms[RENDERER_CROSSINGS] >= 0)
        k->field = stage_ms[RENDERER_CROSSINGS];
    if (stage_ms[RENDERER_STRANDS] >= 0) {
        const double all = stage_ms[RENDERER_STRANDS] * how->stride;
        k->strands = k->divisor > 0 ? 0.5 * (k->strands + all) : all;
    }
    k->times = k->divisor != how->divisor ? 1 : k->times + (k->times < 255);
    k->divisor = how->divisor;
    if (!rasters(forecast) || how->stride != h->stride)
        return;
    if (stage_ms[RENDERER_VISIBLE] >= 0)
        h->seen = stage_ms[RENDERER_VISIBLE];
    h->late = h->seen > late_share * h->budget ? h->late + 1 : 0;
    h->early = h->seen < early_share * h->budget ? h->early + 1 : 0;
}
