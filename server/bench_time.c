// bench_time.c - edits against the clock.  Encoding and sending are the
// server's, not the renderer's, and are not in an edit's time.
#include "server/bench_time.h"

#include <math.h>
#include <string.h>
#include <time.h>

#include "protocol/bytes.h"
#include "renderer/encode.h"
#include "renderer/timer.h"

const char *const bench_edit_names[BENCH_EDITS] = {
    "fibre.sigma_a", "tint.colour", "light.yaw", "camera.fov"};

// Edit number k >= 0 of a kind: by little, to and fro, never the same twice
// running, never *p itself.
static void make_edit(struct params *p, enum bench_edit edit, int k)
{
    const float by = 0.01f * (float)(1 + k % 7) * (k % 2 ? -1.0f : 1.0f);
    switch (edit) {
    case BENCH_EDIT_FIBRE:
        for (int c = 0; c < 3; c++)
            p->fibre.sigma_a[c] *= 1 + by;
        p->fibre.sigma_a[0] += p->fibre.sigma_a[0] == 0 ? 0.01f * fabsf(by) : 0;
        break;
    case BENCH_EDIT_COLOUR:
        p->tint.colour[1] *= 1 + by;
        break;
    case BENCH_EDIT_SKY:
        p->light.yaw += 100 * by * (p->light.yaw > 0 ? -1.0f : 1.0f);
        break;
    default:
        p->camera.fov *= 1 + by;
    }
}

bool bench_time_finish(struct renderer *r, const struct params *p,
                       double *stage_ms, struct error *err)
{
    struct renderer_stats s;
    bool done = false;
    for (int i = 0; stage_ms && i < RENDERER_STAGES; i++)
        stage_ms[i] = -1;
    renderer_set_params(r, p);
    while (!done) {
        if (!renderer_step(r, &done, err))
            return false;
        renderer_stats(r, &s);
        for (int i = 0; stage_ms && i < RENDERER_STAGES; i++)
            if (s.stage_ms[i] >= 0)
                stage_ms[i] = fmax(0, stage_ms[i]) + s.stage_ms[i];
    }
    return true;
}

static double processor_ms(void)
{
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return 1e3 * (double)t.tv_sec + 1e-6 * (double)t.tv_nsec;
}

static double encode(const struct buf *pixels, const struct params *p)
{
    struct buf jpeg = {0};
    const double began = timer_now();
    encode_jpeg(&jpeg, pixels->data, p->image.width, p->image.height, 85,
                ENCODE_420);
    buf_finish(&jpeg);
    return 1e3 * (timer_now() - began);
}

static bool draft(struct renderer *r, struct bench_frame *f, double *ms,
                  struct error *err)
{
    struct renderer_stats s;
    renderer_set_params(r, f->params);
    if (!renderer_draft(r, f->how, err))
        return false;
    renderer_stats(r, &s);
    memcpy(ms, s.stage_ms, sizeof s.stage_ms);
    return true;
}

bool bench_time_frame(struct renderer *r, struct bench_frame *f, double *ms,
                      struct error *err)
{
    struct renderer_stats s;
    const double began = timer_now(), used = processor_ms();
    const struct gl_counts from = gl_count_now();
    bool ok = (f->how ? draft(r, f, ms, err)
                      : bench_time_finish(r, f->params, ms, err)) &&
              renderer_read_display(r, &f->pixels, err);
    ms[BENCH_WHOLE] = 1e3 * (timer_now() - began);
    ms[BENCH_PROCESSOR] = processor_ms() - used;
    ms[BENCH_ENCODE] = ok && f->encode ? encode(&f->pixels, f->params) : 0;
    if (!ok)
        return false;
    renderer_stats(r, &s);
    f->work = gl_count_since(&from);
    ms[RENDERER_DISPLAY] = s.stage_ms[RENDERER_DISPLAY];
    ms[RENDERER_READ] = s.stage_ms[RENDERER_READ];
    return true;
}

void bench_time_note(struct bench_log *log, const struct bench_frame *f,
                     const double *ms)
{
    if (log->n == BENCH_RUNS_MAX)
        return;
    log->work = f->work;
    for (int i = 0; i < BENCH_COLUMNS; i++)
        log->ms[i][log->n] = ms[i];
    log->n++;
}

void bench_time_take(const struct bench_log *log, struct bench_times *out)
{
    const size_t n = log->n;
    *out = (struct bench_times){.runs = (int)n, .work = log->work};
    if (n == 0)
        return;
    for (int i = 0; i < RENDERER_STAGES; i++)
        out->stage[i] = metric_quantile(log->ms[i], n, 0.5);
    out->median = metric_median(log->ms[BENCH_WHOLE], n);
    out->least = metric_quantile(log->ms[BENCH_WHOLE], n, 0);
    out->p95 = metric_quantile(log->ms[BENCH_WHOLE], n, 0.95);
    out->cpu = metric_quantile(log->ms[BENCH_PROCESSOR], n, 0);
    for (size_t i = 0; i < n; i++)
        out->crowd = fmax(out->crowd, log->ms[BENCH_PROCESSOR][i] /
                                          log->ms[BENCH_WHOLE][i]);
    out->processor = metric_quantile(log->ms[BENCH_PROCESSOR], n, 0.5);
    out->encode = metric_quantile(log->ms[BENCH_ENCODE], n, 0.5);
}

static bool enough(const struct bench_effort *e, double began, int runs)
{
    const double spent = timer_now() - began;
    return runs >= e->runs ||
           (e->seconds > 0 && spent > e->seconds && runs >= BENCH_RUNS_LEAST);
}

bool bench_time_series(struct renderer *r, const struct params *p,
                       const struct bench_series *series,
                       const struct bench_effort *effort,
                       struct bench_times *out, struct error *err)
{
    struct bench_log log = {.n = 0};
    struct bench_frame frame = {.encode = series->encode};
    double now[BENCH_COLUMNS] = {0};
    const double began = timer_now();
    bool ok = true;
    for (int k = 0, warm_up = 2; ok && !enough(effort, began, (int)log.n);
         k++) {
        struct params edited = *p;
        series->edit(series->self, &edited, k);
        frame.params = &edited;
        ok = bench_time_frame(r, &frame, now, err);
        if (k == 0 && effort->seconds > 0 &&
            timer_now() - began > effort->seconds / 4)
            warm_up = 1;
        if (series->each)
            series->each[k] = k >= warm_up ? now[BENCH_WHOLE] : NAN;
        if (k >= warm_up)
            bench_time_note(&log, &frame, now);
    }
    buf_finish(&frame.pixels);
    bench_time_take(&log, out);
    return ok && bench_time_finish(r, p, NULL, err);
}

static void usual(const void *self, struct params *p, int k)
{
    make_edit(p, *(const enum bench_edit *)self, k);
}

bool bench_time(struct renderer *r, const struct params *p,
                enum bench_edit edit, const struct bench_effort *effort,
                struct bench_times *out, struct error *err)
{
    const struct bench_series series = {.edit = usual, .self = &edit};
    return bench_time_series(r, p, &series, effort, out, err);
}
