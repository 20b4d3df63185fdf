// bench_edits_report.c - the page in Markdown and its plot.  Every number comes
// from a measurement of the same run.
#include "server/bench_edits_report.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "server/chart_rows.h"

static void number(struct buf *out, const char *format, double v)
{
    if (isnan(v))
        buf_text(out, " - |");
    else
        buf_printf(out, format, v);
}

static const struct bench_edits_row *find(const struct bench_edits_scene *s,
                                          const char *edit)
{
    for (int i = 0; i < s->rows; i++)
        if (strcmp(s->row[i].edit, edit) == 0)
            return &s->row[i];
    return NULL;
}

// A scene of which there is more than Table 2's rows.
static bool is_whole(const struct bench_edits_scene *s)
{
    return s->rows > 0 && isnan(s->row[0].paper_fps);
}

// Three figures, without exponents.
static void figures(struct buf *out, double v)
{
    buf_printf(out, v >= 100 ? "%.0f" : v >= 10 ? "%.1f" : "%.2g", v);
}

// --- the short table ---------------------------------------------------------

static void short_cell(const struct bench_edits_row *row, struct buf *out)
{
    if (!row) {
        buf_text(out, " - |");
        return;
    }
    const bool met = row->time.median.value <= row->target;
    buf_text(out, met ? " **" : " ");
    figures(out, row->time.median.value);
    buf_text(out, met ? " ms**" : " ms");
    if (!isnan(row->target))
        buf_printf(out, " of %g", row->target);
    if (!isnan(row->forward))
        buf_printf(out, ", %.0fx", row->forward / row->time.median.value);
    buf_text(out, " |");
}

static void short_table(const struct bench_edits_scene *scene, int count,
                        struct buf *out)
{
    int widest = -1;
    for (int i = 0; i < count; i++)
        if (is_whole(&scene[i]) &&
            (widest < 0 || scene[i].rows > scene[widest].rows))
            widest = i;
    if (widest < 0)
        return;
    buf_text(out, "| edit |");
    for (int i = 0; i < count; i++)
        if (is_whole(&scene[i]))
            buf_printf(out, " %s, %uk points |", scene[i].loaded.name,
                       scene[i].loaded.points / 1000);
    buf_text(out, "\n|---|");
    for (int i = 0; i < count; i++)
        if (is_whole(&scene[i]))
            buf_text(out, "---|");
    for (int k = 0; k < scene[widest].rows; k++) {
        const struct bench_edits_row *row = &scene[widest].row[k];
        if (!row->chief)
            continue;
        buf_printf(out, "\n| %s |", row->edit);
        for (int i = 0; i < count; i++)
            if (is_whole(&scene[i]))
                short_cell(find(&scene[i], row->edit), out);
    }
    buf_text(out, "\n");
}

// --- all rows ----------------------------------------------------------------

static void stages(const struct bench_times *t, struct buf *out)
{
    for (int i = 0; i < RENDERER_STAGES; i++)
        if (t->stage[i] >= 0.05)
            buf_printf(out, " %s %.3g", renderer_stage_names[i], t->stage[i]);
    buf_text(out, " |");
}

static void errors(const struct bench_edits_row *row, struct buf *out)
{
    const struct bench_edits_error *e = &row->error;
    if (row->drag) {
        buf_printf(out, " %.3g, blocks %.3g | | | |", 100 * e->path.value,
                   100 * row->blocks);
        return;
    }
    number(out, " %.3g |", 100 * e->path.value);
    number(out, " %.3g |", 100 * e->direct.value);
    number(out, " %.3g |", 100 * e->difference);
    number(out, " %.3g", 100 * e->integral);
    if (!isnan(e->integral))
        buf_printf(out, " / %.3g |", 100 * e->integral_direct);
}

static void line(const struct bench_edits_row *row, struct buf *out)
{
    const struct bench_times *t = &row->time;
    const bool met = t->median.value <= row->target;
    buf_printf(out, "| %s | %.4g | %s%.4g%s | %.4g |", row->edit, t->least,
               met ? "**" : "", t->median.value, met ? "**" : "", t->p95);
    number(out, " %g |", row->target);
    buf_printf(out, " %d |", t->runs);
    number(out, " %.4g |", row->forward);
    number(out, " %.1f", row->forward / t->median.value);
    if (!isnan(row->forward))
        buf_printf(out, " (%.1f) |", row->forward_cpu / t->processor);
    errors(row, out);
    buf_printf(out, " %s", row->path);
    if (row->drag && row->how.divisor > 0)
        buf_printf(out, ", draft of 1/%d, every %d. strand%s; first %.3g ms",
                   row->how.divisor, row->how.stride,
                   row->how.coarse ? ", coarse shadows" : "", row->first);
    else if (row->drag)
        buf_printf(out, ", full frames; first %.3g ms", row->first);
    buf_printf(out, " | %.4g | %.3g | %llu, %.1f |", t->processor, t->encode,
               (unsigned long long)(t->work.dispatches + t->work.draws),
               (double)t->work.upload_bytes / 1e3);
    stages(t, out);
    buf_text(out, "\n");
}

static void parameters(const struct bench_edits_scene *s, struct buf *out)
{
    const struct bench_edits_row *row = &s->row[0];
    buf_text(out, "\nFibre parameters, ms:");
    for (int i = 0; i < BENCH_KINDS_FIBRE; i++)
        if (!isnan(row->each[i]))
            buf_printf(out, " %s %.3g", bench_kinds_fibre[i], row->each[i]);
    buf_text(out, ".\n");
}

static void whole(const struct bench_edits_scene *s, struct buf *out)
{
    buf_printf(out,
               "\n## %s\n\n%u strands, %u points; %u visible places, %d "
               "lights in use.\n\n",
               s->loaded.name, s->loaded.strands, s->loaded.points,
               s->row[0].points, s->row[0].lights);
    buf_text(
        out,
        "| edit | min | median ms | p95 | target | n | paper-forward ms | "
        "times | error % | direct % | path - direct % | integral / direct % | "
        "path | CPU ms | encode | dispatches, kB up | stages, ms |\n"
        "|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|"
        "\n");
    for (int i = 0; i < s->rows; i++)
        if (isnan(s->row[i].paper_fps))
            line(&s->row[i], out);
    parameters(s, out);
}

// --- Table 2 -----------------------------------------------------------------

static void rate(double ms, struct buf *out)
{
    if (isnan(ms))
        buf_text(out, " - |");
    else
        buf_printf(out, " %.1f (%.4g ms) |", 1e3 / ms, ms);
}

static void table_2(const struct bench_edits_scene *scene, int count,
                    struct buf *out)
{
    buf_text(out, "\n## The scenes of Xu 2011, Table 2\n\nFrames per second "
                  "of fibre edits at 720x480 with the paper's numbers of "
                  "lights; the built-in groom of the same name, strands and "
                  "points stands for the paper's. The last column is what the "
                  "paper reports for its own hair on a GTX 580.\n\n"
                  "| scene | strands | points | lights | default path | "
                  "paper's scheme, m = 4, this program's cells | "
                  "paper-forward, m = 4 | Xu 2011 | error %, default | "
                  "error %, paper's scheme |\n"
                  "|---|---|---|---|---|---|---|---|---|---|\n");
    for (int i = 0; i < count; i++) {
        const struct bench_edits_scene *s = &scene[i];
        for (int k = 0; k + 1 < s->rows; k++) {
            const struct bench_edits_row *row = &s->row[k];
            if (isnan(row->paper_fps))
                continue;
            buf_printf(out, "| %s | %u | %u | %d |", s->loaded.name,
                       s->loaded.strands, s->loaded.points, row->lights_asked);
            rate(row[0].time.median.value, out);
            rate(row[1].time.median.value, out);
            rate(row[0].forward, out);
            buf_printf(out, " %.1f |", row->paper_fps);
            number(out, " %.3g |", 100 * row[0].error.path.value);
            number(out, " %.3g |", 100 * row[1].error.path.value);
            buf_text(out, "\n");
            break;
        }
    }
}

// --- the page ----------------------------------------------------------------

static void how(const struct bench_edits_head *h, struct buf *out)
{
    buf_printf(
        out,
        "- **ms**: from the edit until the picture stands in memory as "
        "displayed, wall clock, n edits after warming up; p95 by nearest rank. "
        "**encode**: JPEG 85 4:2:0 of it, not in that time. **CPU**: of all "
        "threads. **times**: as fast as paper-forward, and in brackets by CPU "
        "time, which other work on the machine changes least. **Bold**: the "
        "target is met.\n"
        "- **fibre parameter**: twelve parameters in random order (a fixed "
        "seed), each by 1 to 7 %%. **camera**: an orbit. **while dragging, "
        "first usable frame**: drags of eight edits, a full frame before each; "
        "where the full frame would take longer than `quality.draft_ms`, "
        "drafts as the daemon chooses them. **at rest by rays**: until the "
        "picture with shadow.rays=1, which has no target of its own: the full "
        "frame's stands there. **cold start**: `glintd serve` in a process of "
        "its own until its first frame is in a client's hands, caches warm, "
        "%d starts.\n"
        "- **paper-forward**: the same kind of edit in the same process by "
        "`render.path=forward render.scheme=paper`, medians of %d or fewer; "
        "strands drawn once for every 16 lights, as the paper does. It has no "
        "rays and no drafts: rows that have are compared with its full "
        "frame.\n"
        "- **error**: RMSE / mean of the reference (texels, rays, path-traced "
        "multiple scattering; double precision) at %d visible places, %d paths "
        "each, of the path that ran; **direct**: of `render.path=direct` at "
        "the same places; **path - direct**: RMSE of their difference / mean. "
        "**integral**: once-scattered light of the same lights without "
        "shadows, against exact integrals at %d places, path / direct. At the "
        "state that edits are made around; for sky and camera at an edited "
        "one. Of drafts: RMSE of the display in linear light against the full "
        "frame of the same state, over its hair, by pixels, whose detail a "
        "draft lacks, and by means over 32 x 32 pixels.\n",
        h->cold, h->forward_runs, h->places, h->paths, h->exact);
}

void bench_edits_page(const struct bench_edits_head *h,
                      const struct bench_edits_scene *scene, int count,
                      struct buf *out)
{
    buf_printf(out,
               "# What an edit costs\n\nMade by `%s` in %.0f s on %s, %d "
               "cores, %d x %d, %d lights; load average %.1f before and %.1f "
               "after (a quiet machine shows at most the number of cores; "
               "above that times are upper estimates).\n\n<!-- short -->\n",
               h->command, h->seconds, h->device, h->cores,
               h->base->image.width, h->base->image.height, h->base->sky.lights,
               h->load[0], h->load[1]);
    short_table(scene, count, out);
    buf_text(out, "<!-- end -->\n\nMedians, of the target where there is one; "
                  "how many times as fast as paper-forward. Bold: the target "
                  "is met.\n\n");
    if (h->plot)
        buf_printf(out, "![what an edit costs](%s)\n\n", h->plot);
    how(h, out);
    if (h->skipped)
        buf_printf(out, "- Not measured: %s.\n", h->skipped);
    for (int i = 0; i < count; i++)
        if (is_whole(&scene[i]))
            whole(&scene[i], out);
    table_2(scene, count, out);
}

// --- the plot ----------------------------------------------------------------

struct plot {
    struct chart_row row[CHART_ROWS_MAX];
    int count;
};

static void add(struct plot *p, const char *label, int group,
                const struct bench_edits_row *row)
{
    if (p->count == CHART_ROWS_MAX)
        return;
    p->row[p->count++] = (struct chart_row){
        .label = label,
        .group = group,
        .least = row->time.least,
        .median = row->time.median.value,
        .p95 = row->time.p95,
        .target = isnan(row->paper_fps) ? row->target : 1e3 / row->paper_fps,
        .other = row->forward,
    };
}

// The rows of all scenes that have the name of row k of scene i, unless an
// earlier scene had it.
static void add_kind(struct plot *p, const struct bench_edits_scene *scene,
                     int count, int i, const struct bench_edits_row *row)
{
    for (int e = 0; e < i; e++)
        if (find(&scene[e], row->edit))
            return;
    const char *label = row->edit;
    for (int e = i; e < count; e++) {
        const struct bench_edits_row *same = find(&scene[e], row->edit);
        if (!same)
            continue;
        add(p, label, e, same);
        label = NULL;
    }
}

void bench_edits_plot(const struct bench_edits_head *h,
                      const struct bench_edits_scene *scene, int count,
                      struct buf *out)
{
    struct plot *p = bytes_zalloc(1, sizeof *p);
    char note[240];
    struct chart_rows c = {.title = "what an edit costs",
                           .note = note,
                           .x_title = "ms: least to 95th percentile, median",
                           .target = "target (Table 2: the paper's frame)",
                           .other = "paper-forward",
                           .row = p->row};
    snprintf(note, sizeof note, "%s, %d cores, load average %.1f", h->device,
             h->cores, h->load[1]);
    for (int i = 0; i < count; i++) {
        if (i < CHART_GROUPS_MAX)
            c.groups[i] = scene[i].loaded.name;
        for (int k = 0; k < scene[i].rows; k++)
            add_kind(p, scene, count, i, &scene[i].row[k]);
    }
    c.count = p->count;
    chart_rows_svg(&c, out);
    free(p);
}
