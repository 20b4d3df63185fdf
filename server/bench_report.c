// bench_report.c - the report in Markdown and its plots.  Every number comes
// from a measurement of the same run.
#include "server/bench_report.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "protocol/edit.h"
#include "server/chart.h"

static const char *const plot_titles[] = {
    [BENCH_PLOT_WHOLE] = "error against texels, rays and paths",
    [BENCH_PLOT_INTEGRAL] =
        "error of the scattering integral alone (same lights, no shadows)"};

// Without the groups that are plain from the name.
static void shorten(const char *text, char *out, size_t room)
{
    size_t n = 0;
    while (*text && n + 1 < room) {
        if (strncmp(text, "render.", 7) == 0)
            text += 7;
        else if (strncmp(text, "quality.", 8) == 0)
            text += 8;
        else
            out[n++] = *text++;
    }
    out[n] = 0;
}

void bench_report_plot(const struct bench_result *b, enum bench_plot which,
                       bool *front, struct buf *out)
{
    struct chart_point *p = bytes_zalloc(CHART_POINTS_MAX, sizeof *p);
    char(*label)[64] = bytes_zalloc(CHART_POINTS_MAX, sizeof *label);
    char title[200], note[200];
    struct chart c = {.title = title,
                      .note = note,
                      .x_title = "an edit of fibre.sigma_a until the picture "
                                 "is there, median, ms",
                      .y_title = "RMSE / mean of the reference",
                      .point = p};
    for (int i = 0; i < b->rows && c.count < CHART_POINTS_MAX; i++, c.count++) {
        const struct bench_row *row = &b->row[i];
        const struct metric_value *e = which == BENCH_PLOT_WHOLE
                                           ? &row->whole.rel_rmse
                                           : &row->integral.rel_rmse;
        const bool shown = !(row->setting->flags & BENCH_KNOBS_PICTURE);
        if (i == 0)
            snprintf(label[i], sizeof label[i], "%s (default)",
                     row->setting->method);
        else
            shorten(row->setting->text, label[i], sizeof label[i]);
        p[i] = (struct chart_point){
            .x = row->time[BENCH_EDIT_FIBRE].median.value,
            .y = shown ? e->value : NAN,
            .low = e->low,
            .high = e->high,
            .label = label[i],
            .group = bench_knobs_group(row->setting->group)};
    }
    for (int g = 0; bench_knobs_groups[g]; g++)
        c.groups[g] = bench_knobs_groups[g];
    snprintf(title, sizeof title, "%s: %s", b->name, plot_titles[which]);
    snprintf(note, sizeof note, "%s; %zu places", b->device,
             which == BENCH_PLOT_WHOLE ? b->truth->count : b->truth->exact);
    chart_svg(&c, out);
    for (int i = 0; i < c.count && which == BENCH_PLOT_WHOLE; i++)
        front[i] = p[i].front;
    free(p);
    free(label);
}

// --- Markdown ----------------------------------------------------------------

static void percent(struct buf *out, const struct metric_value *v)
{
    if (isnan(v->value))
        buf_text(out, " | -");
    else
        buf_printf(out, " | %.3g (%.3g..%.3g)", 100 * v->value, 100 * v->low,
                   100 * v->high);
}

static void number(struct buf *out, const char *format, double v)
{
    buf_text(out, " | ");
    if (isnan(v))
        buf_text(out, "-");
    else
        buf_printf(out, format, v);
}

static void row_line(const struct bench_row *r, bool front, struct buf *out)
{
    const struct bench_times *t = &r->time[BENCH_EDIT_FIBRE];
    buf_printf(out, "| %s%s%s", front ? "**" : "", r->setting->text,
               front ? "**" : "");
    buf_printf(out, " | %.4g (%.4g..%.4g) | %.4g | %d", t->median.value,
               t->median.low, t->median.high, t->p95, t->runs);
    percent(out, &r->whole.rel_rmse);
    number(out, "%.3g", r->whole.rel_mse.value);
    number(out, "%+.3g", 100 * r->whole.mean_signed.value);
    number(out, "%.3g", 100 * r->whole.p99.value);
    number(out, "%.3g", 100 * r->single.rel_rmse.value);
    number(out, "%.3g", 100 * r->integral.rel_rmse.value);
    number(out, "%.3g", 100 * r->picture.rel_rmse.value);
    number(out, "%.1f", r->psnr);
    number(out, "%.4f", r->ssim);
    buf_text(out, " |\n");
}

static void edits(const struct bench_result *b, struct buf *out)
{
    buf_text(out, "\n| setting | edit | ms (95 %) | p95 | stages, ms |\n"
                  "|---|---|---|---|---|\n");
    for (int i = 0; i < b->rows; i++)
        for (int e = 0; e < BENCH_EDITS; e++) {
            const struct bench_times *t = &b->row[i].time[e];
            if (t->runs == 0 || (i > 0 && e == BENCH_EDIT_FIBRE))
                continue;
            buf_printf(out, "| %s | %s | %.4g (%.4g..%.4g) | %.4g |",
                       b->row[i].setting->text, bench_edit_names[e],
                       t->median.value, t->median.low, t->median.high, t->p95);
            for (int s = 0; s < RENDERER_STAGES; s++)
                if (t->stage[s] >= 0.05)
                    buf_printf(out, " %s %.3g", renderer_stage_names[s],
                               t->stage[s]);
            buf_text(out, " |\n");
        }
}

static void causes(const struct bench_result *b, struct buf *out)
{
    buf_printf(out,
               "\nWhere the default's error comes from (%zu places, in %% of "
               "the reference's mean):\n\n| cause | RMSE (95 %%) | mean "
               "(95 %%) | what is exchanged |\n|---|---|---|---|\n",
               b->truth->exact);
    for (int i = 0; i < BENCH_CAUSES; i++) {
        const struct bench_cause *c = &b->cause[i];
        buf_printf(out, "| %s", c->name);
        percent(out, &c->errors.rel_rmse);
        percent(out, &c->errors.mean_signed);
        buf_printf(out, " | %s |\n", c->what);
    }
}

void bench_report_scene(const struct bench_result *b, const char *const *plot,
                        const bool *front, struct buf *out)
{
    const struct bench_truth *t = b->truth;
    buf_printf(out,
               "\n## %s\n\n%u strands, %u points; %zu places with %d paths "
               "each, picture with %d paths a pixel (noise %.2g %%).\n\n",
               b->name, b->strands, b->points, t->count, b->paths,
               b->picture_paths, 100 * t->picture_noise);
    for (int i = 0; plot && i < 2; i++)
        buf_printf(out, "![%s: %s](%s)\n\n", b->name, plot_titles[i], plot[i]);
    buf_text(
        out,
        "| setting | ms (95 %) | p95 | n | error % (95 %) | relMSE | mean % "
        "| p99 % | once % | integral % | picture % | PSNR | SSIM |\n"
        "|---|---|---|---|---|---|---|---|---|---|---|---|---|\n");
    for (int i = 0; i < b->rows; i++)
        row_line(&b->row[i], front[i], out);
    if (b->causes)
        causes(b, out);
    edits(b, out);
}

// Milliseconds of the paper's own way of drawing in this scene, or NaN.
static double forward_ms(const struct bench_result *b)
{
    for (int i = 0; i < b->rows; i++)
        if (strcmp(b->row[i].setting->method, "paper-forward") == 0)
            return b->row[i].time[BENCH_EDIT_FIBRE].median.value;
    return NAN;
}

void bench_report_overview(const struct bench_result *b, bool first,
                           struct buf *out)
{
    if (first)
        buf_text(out, "| scene | setting | ms | p95 | times as fast as "
                      "paper-forward | error % (95 %) | mean % "
                      "| once % | PSNR | SSIM |\n"
                      "|---|---|---|---|---|---|---|---|---|---|\n");
    for (int i = 0; i < b->rows; i++) {
        const struct bench_row *r = &b->row[i];
        const char *group = r->setting->group;
        if (strcmp(group, "default") != 0 && strcmp(group, "path") != 0 &&
            strcmp(group, "scheme") != 0 && strcmp(group, "rays") != 0)
            continue;
        buf_printf(out, "| %s | %s | %.4g | %.4g", b->name, r->setting->text,
                   r->time[0].median.value, r->time[0].p95);
        number(out, "%.1f", forward_ms(b) / r->time[0].median.value);
        percent(out, &r->whole.rel_rmse);
        number(out, "%+.3g", 100 * r->whole.mean_signed.value);
        number(out, "%.3g", 100 * r->single.rel_rmse.value);
        number(out, "%.1f", r->psnr);
        number(out, "%.4f", r->ssim);
        buf_text(out, " |\n");
    }
}

void bench_report_head(const struct bench_head *h, const struct params *base,
                       struct buf *out)
{
    struct params usual;
    params_defaults(&usual);
    buf_printf(out,
               "# Error against run time\n\nMade by `%s` in %.0f s on %s, %d "
               "cores; load average at the end %.1f (a quiet machine shows "
               "about the number of cores; more means that others worked on "
               "it, and times are upper estimates).\n\n",
               h->command, h->seconds, h->device, h->cores, h->load);
    buf_printf(out, "Base: ");
    for (int i = 0; i < params_row_count; i++) {
        struct buf a = {0}, b = {0};
        edit_print(&a, base, &params_rows[i]);
        edit_print(&b, &usual, &params_rows[i]);
        if (a.size != b.size || memcmp(a.data, b.data, a.size) != 0)
            buf_printf(out, "`%s.%s=%.*s` ", params_rows[i].group_name,
                       params_rows[i].name, (int)a.size, (const char *)a.data);
        buf_finish(&a);
        buf_finish(&b);
    }
    buf_printf(
        out,
        "and the defaults of docs/PARAMETERS.md.\n\n"
        "- **ms**: an edit of `fibre.sigma_a` until the picture stands in "
        "memory as displayed, median of **n** (%d, fewer where that takes too "
        "long; with few edits p95 is the slowest and the interval their span) "
        "after warming up, with the 95 %% interval that order statistics give; "
        "no encoding, no network. With `shadow.rays` until the picture by "
        "rays.\n"
        "- **error**: RMSE / mean of the reference, linear radiance, at random "
        "visible places. The reference sums over the sky's 128 x 64 texels "
        "(not the lights), shoots rays for visibility and traces paths for "
        "light that several fibres scattered; exact fibre, double precision. "
        "Its own noise is taken off the squares. Intervals: 95 %%, bootstrap "
        "over places; all settings are judged at the same places, so their "
        "differences are surer than that. **relMSE** mean of (x - r)^2/(r^2 + "
        "0.01); **mean** "
        "signed; **p99** of |x - r| / mean r.\n"
        "- **once**: the same for once-scattered light alone; multiple "
        "scattering is excluded. **integral**: once-scattered light of the "
        "same lights without shadows, against exact integrals; the light fit, "
        "visibility and multiple scattering are excluded.\n"
        "- **picture**: the error of a whole picture at 160 x 107, over the "
        "pixels that the reference covers, edges and samples included; "
        "**PSNR, SSIM**: as displayed, "
        "against a path-traced one; also of `render.path=forward`, whose other "
        "errors are those of the same functions on path direct.\n"
        "- Bold: on the Pareto front of ms and error.\n\n",
        h->runs);
}
