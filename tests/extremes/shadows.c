// shadows.c - see the header.
#include "tests/extremes/shadows.h"

#include <math.h>
#include <string.h>

#include "renderer/crossings_probe.h"
#include "tests/check.h"

enum { STEPS = 4096, TIMES = 4 };

static const struct shadows_row empty[SHADOWS_REGIONS] = {
    {.what = "none to a tenth", .from = 0, .to = 0.1},
    {.what = "a tenth to one", .from = 0.1, .to = 1},
    {.what = "one to five", .from = 1, .to = 5},
    {.what = "five to ten", .from = 5, .to = 10},
    {.what = "ten to thirty", .from = 10, .to = 30},
    {.what = "thirty to three hundred", .from = 30, .to = 300}};

static uint32_t unorm(double v)
{
    return (uint32_t)lrint(65535 * v);
}

static void put_nodes(struct crossings_place *at, double n, double open)
{
    const uint32_t bits[2] = {unorm(open * exp(-n)) |
                                  unorm(open * exp(-0.3 * n)) << 16,
                              unorm(open * exp(-0.05 * n)) | unorm(open) << 16};
    memcpy(at->p, bits, sizeof bits);
}

static void judge(const struct crossings_result *r, const float *a, double n,
                  double open, struct shadows_row *row)
{
    row->places++;
    for (int k = 0; k < TIMES; k++) {
        double t = (double)r->forward[k];
        double want = open * exp(-n * (1 - (double)a[k]));
        bool sane = isfinite(t) && t >= 0 && t <= open + 1e-4 &&
                    t >= (double)r->clear - 1e-6 && isfinite(r->crossings[k]) &&
                    r->crossings[k] >= 0;
        row->bad += !sane;
        row->error = fmax(row->error, fabs(t - want));
    }
    for (int g = 0; g < 32; g++)
        row->hits[g] += r->guards >> g & 1;
}

static void sweep(struct shadows_row *row, double open, const float *a)
{
    static struct crossings_place at[STEPS];
    static struct crossings_result got[STEPS];
    struct crossings_probe_run run = {.given_nodes = true, .note_guards = true};
    struct error err = {0};
    double step = (row->to - row->from) / STEPS;
    memcpy(run.attenuation, a, sizeof run.attenuation);
    for (int i = 0; i < STEPS; i++)
        put_nodes(&at[i], row->from + step * i, open);
    if (!CHECK(crossings_probe(&run, at, STEPS, 1, got, &err))) {
        row->bad++;
        return;
    }
    for (int i = 0; i < STEPS; i++) {
        judge(&got[i], a, row->from + step * i, open, row);
        for (int k = 0; k < TIMES && i > 1; k++)
            row->jump = fmax(
                row->jump,
                fabs((double)(got[i].forward[k] - 2 * got[i - 1].forward[k] +
                              got[i - 2].forward[k])));
    }
}

void shadows_measure(struct shadows_row rows[SHADOWS_REGIONS])
{
    static const float dark[TIMES] = {0, 0.1f, 0.5f, 0.9f},
                       white[TIMES] = {0.95f, 0.99f, 0.999f, 1};
    static const double open[3] = {1, 0.5, 0.01};
    memcpy(rows, empty, sizeof empty);
    for (int r = 0; r < SHADOWS_REGIONS; r++)
        for (int k = 0; k < 3; k++) {
            sweep(&rows[r], open[k], dark);
            sweep(&rows[r], open[k], white);
        }
}
