// bench_time.c - edits against the clock.  Encoding and sending are the
// server's, not the renderer's, and are left out.
#include "server/bench_time.h"

#include <math.h>
#include <time.h>

#include "protocol/bytes.h"
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

// Behind the stages: the whole, and what this process had of all processors.
enum { WHOLE = RENDERER_STAGES, CPU, COLUMNS };

static double cpu_ms(void)
{
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return 1e3 * (double)t.tv_sec + (double)t.tv_nsec / 1e6;
}

// One edit; ms[COLUMNS].
static bool one(struct renderer *r, const struct params *p, double *ms,
                struct error *err)
{
    struct renderer_stats s;
    struct buf pixels = {0};
    const double began = timer_now(), cpu = cpu_ms();
    bool ok = bench_time_finish(r, p, ms, err) &&
              renderer_read_display(r, &pixels, err);
    ms[WHOLE] = 1e3 * (timer_now() - began);
    ms[CPU] = cpu_ms() - cpu;
    buf_finish(&pixels);
    if (!ok)
        return false;
    renderer_stats(r, &s);
    ms[RENDERER_DISPLAY] = s.stage_ms[RENDERER_DISPLAY];
    ms[RENDERER_READ] = s.stage_ms[RENDERER_READ];
    return true;
}

static bool enough(const struct bench_effort *e, double began, int runs)
{
    const double spent = timer_now() - began;
    return runs >= e->runs ||
           (e->seconds > 0 && spent > e->seconds && runs >= BENCH_RUNS_LEAST);
}

bool bench_time(struct renderer *r, const struct params *p,
                enum bench_edit edit, const struct bench_effort *effort,
                struct bench_times *out, struct error *err)
{
    double ms[COLUMNS][BENCH_RUNS_MAX], now[COLUMNS] = {0}, crowd = 0;
    const double began = timer_now();
    size_t n = 0;
    for (int k = 0, warm_up = 2; !enough(effort, began, (int)n); k++) {
        struct params edited = *p;
        make_edit(&edited, edit, k);
        if (!one(r, &edited, now, err))
            return false;
        if (k == 0 && effort->seconds > 0 &&
            timer_now() - began > effort->seconds / 4)
            warm_up = 1;
        for (int i = 0; k >= warm_up && i < COLUMNS; i++)
            ms[i][n] = now[i];
        if (k >= warm_up)
            crowd = fmax(crowd, now[CPU] / now[WHOLE]);
        n += k >= warm_up;
    }
    *out = (struct bench_times){.runs = (int)n, .crowd = crowd};
    for (int i = 0; i < RENDERER_STAGES; i++)
        out->stage[i] = metric_quantile(ms[i], n, 0.5);
    out->median = metric_median(ms[WHOLE], n);
    out->least = metric_quantile(ms[WHOLE], n, 0);
    out->cpu = metric_quantile(ms[CPU], n, 0);
    out->p95 = metric_quantile(ms[WHOLE], n, 0.95);
    return bench_time_finish(r, p, NULL, err);
}
