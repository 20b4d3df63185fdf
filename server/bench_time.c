// bench_time.c - edits against the clock.  Encoding and sending are the
// server's, not the renderer's, and are left out.
#include "server/bench_time.h"

#include <math.h>

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

// One edit; ms[RENDERER_STAGES] by stage, then the whole.
static bool one(struct renderer *r, const struct params *p, double *ms,
                struct error *err)
{
    struct renderer_stats s;
    struct buf pixels = {0};
    const double began = timer_now();
    bool ok = bench_time_finish(r, p, ms, err) &&
              renderer_read_display(r, &pixels, err);
    ms[RENDERER_STAGES] = 1e3 * (timer_now() - began);
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
    double ms[RENDERER_STAGES + 1][BENCH_RUNS_MAX],
        now[RENDERER_STAGES + 1] = {0};
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
        for (int i = 0; k >= warm_up && i <= RENDERER_STAGES; i++)
            ms[i][n] = now[i];
        n += k >= warm_up;
    }
    *out = (struct bench_times){.runs = (int)n};
    for (int i = 0; i < RENDERER_STAGES; i++)
        out->stage[i] = metric_quantile(ms[i], n, 0.5);
    out->median = metric_median(ms[RENDERER_STAGES], n);
    out->least = metric_quantile(ms[RENDERER_STAGES], n, 0);
    out->p95 = metric_quantile(ms[RENDERER_STAGES], n, 0.95);
    return bench_time_finish(r, p, NULL, err);
}
