// bench_drag.c - plays the daemon's part in a drag: haste.c chooses, the
// renderer drafts.  When a drag ends is studio.c's affair and left out.
#include "server/bench_drag.h"

#include <math.h>
#include <string.h>

#include "protocol/bytes.h"
#include "server/haste.h"
#include "server/rehearsal.h"

enum { LENGTH = 8, DRAGS_MAX = 32, REHEARSALS_MAX = 16, BLOCK = 32 };

struct drag {
    struct renderer *r;
    const struct params *base;
    const struct bench_series *series;
    struct haste haste;
    struct renderer_draft how;
    double ms[BENCH_COLUMNS];
    int k; // edits so far
};

static double tail_of(const double *ms)
{
    return ms[RENDERER_DISPLAY] + ms[RENDERER_READ] + ms[BENCH_ENCODE];
}

static bool full(struct drag *d, struct bench_frame *f, struct error *err)
{
    f->how = NULL;
    if (!bench_time_frame(d->r, f, d->ms, err))
        return false;
    haste_full(&d->haste, d->ms);
    haste_full_tail(&d->haste, tail_of(d->ms));
    return true;
}

// The next frame of the drag; a draft where the full frame would take too long.
static bool next(struct drag *d, struct bench_frame *f, struct error *err)
{
    double forecast[RENDERER_STAGES];
    struct haste_ask ask;
    renderer_set_params(d->r, f->params);
    rehearsal_ask(d->r, f->params, &ask);
    if (!renderer_forecast(d->r, forecast) ||
        !haste_choose(&d->haste, forecast, &ask, &d->how)) {
        d->how = (struct renderer_draft){0};
        return full(d, f, err);
    }
    f->how = &d->how;
    if (!bench_time_frame(d->r, f, d->ms, err))
        return false;
    haste_draft(&d->haste, forecast, &d->how, d->ms);
    haste_draft_tail(&d->haste, tail_of(d->ms));
    return true;
}

// As the daemon does while the picture rests.
static void rest(struct drag *d, const struct params *p)
{
    for (int k = 0; k < REHEARSALS_MAX; k++)
        if (!rehearsal_next(&d->haste, d->r, p))
            break;
}

static struct params edited(struct drag *d)
{
    struct params p = *d->base;
    d->series->edit(d->series->self, &p, d->k++);
    return p;
}

// IEC 61966-2-1
static double linear(unsigned char v)
{
    const double x = v / 255.0;
    return x <= 0.04045 ? x / 12.92 : pow((x + 0.055) / 1.055, 2.4);
}

// Means over blocks of side x side pixels, of hair alone.
static double compare(const struct buf *draft, const struct buf *whole,
                      const struct buf *covered, const struct params *p,
                      int side)
{
    const float *a = (const float *)(const void *)covered->data;
    double squares = 0, sum = 0;
    size_t n = 0;
    for (int y = 0; y + side <= p->image.height; y += side)
        for (int x = 0; x + side <= p->image.width; x += side)
            for (size_t c = 0; c < 3; c++) {
                double is = 0, want = 0;
                bool hair = false;
                for (int k = 0; k < side * side; k++) {
                    const size_t i =
                        (size_t)(y + k / side) * (size_t)p->image.width +
                        (size_t)(x + k % side);
                    hair |= a[4 * i + 3] > 0;
                    is += linear(draft->data[4 * i + c]);
                    want += linear(whole->data[4 * i + c]);
                }
                squares += hair ? (is - want) * (is - want) : 0;
                sum += hair ? want : 0;
                n += hair;
            }
    return sqrt(squares / (double)n) / (sum / (double)n);
}

// The newest frame of a drag against the full one of the same state.
static bool judge(struct drag *d, struct bench_frame *f, double error[2],
                  struct error *err)
{
    struct buf draft = f->pixels, covered = {0};
    f->pixels = (struct buf){0};
    f->how = NULL;
    double ms[BENCH_COLUMNS];
    const bool ok = bench_time_frame(d->r, f, ms, err) &&
                    renderer_read_linear(d->r, &covered, err);
    for (int k = 0; ok && k < 2; k++)
        error[k] =
            compare(&draft, &f->pixels, &covered, f->params, k ? BLOCK : 1);
    buf_finish(&draft);
    buf_finish(&covered);
    return ok;
}

static bool one_drag(struct drag *d, struct bench_frame *f,
                     struct bench_log *log, double *first, double error[2],
                     struct error *err)
{
    struct params p = edited(d);
    f->params = &p;
    if (!full(d, f, err))
        return false;
    rest(d, &p);
    for (int i = 0; i < LENGTH; i++) {
        p = edited(d);
        if (!next(d, f, err))
            return false;
        if (i == 0)
            *first = d->ms[BENCH_WHOLE];
        bench_time_note(log, f, d->ms);
    }
    return judge(d, f, error, err);
}

bool bench_drag_run(struct renderer *r, const struct params *base,
                    const struct bench_series *series,
                    const struct bench_effort *effort, struct bench_drag *out,
                    struct error *err)
{
    struct drag d = {.r = r, .base = base, .series = series};
    struct bench_frame f = {.encode = true};
    struct bench_log log = {.n = 0};
    double first[DRAGS_MAX], pixel[DRAGS_MAX], block[DRAGS_MAX], error[2];
    size_t n = 0;
    bool ok = true;
    for (int i = 0;
         ok && i < DRAGS_MAX && (i == 0 || (int)log.n < effort->runs); i++) {
        ok = one_drag(&d, &f, &log, &first[n], error, err);
        pixel[n] = error[0];
        block[n] = error[1];
        if (i == 0)
            log.n = 0;
        else
            n++;
    }
    buf_finish(&f.pixels);
    *out = (struct bench_drag){
        .how = d.how, .error = NAN, .blocks = NAN, .first = NAN};
    bench_time_take(&log, &out->time);
    if (n > 0) {
        out->first = metric_quantile(first, n, 0.5);
        out->error = metric_quantile(pixel, n, 0.5);
        out->blocks = metric_quantile(block, n, 0.5);
    }
    return ok && bench_time_finish(r, base, NULL, err);
}
