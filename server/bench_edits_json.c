// bench_edits_json.c - one JSON line for each row.
#include "server/bench_edits_report.h"

#include <math.h>

#include "protocol/json.h"
#include "server/frame.h"
#include "server/stats.h"

static void put_error(struct json *j, const struct bench_edits_row *row)
{
    const struct bench_edits_error *e = &row->error;
    json_put_number(j, "error", e->path.value);
    json_put_string(j, "error_against", row->drag ? "full frame" : "reference");
    if (row->drag) {
        json_put_number(j, "error_blocks", row->blocks);
        return;
    }
    json_key(j, "error_ci95");
    json_open_array(j);
    json_number(j, e->path.low);
    json_number(j, e->path.high);
    json_close_array(j);
    json_put_number(j, "error_direct", e->direct.value);
    json_put_number(j, "difference_to_direct", e->difference);
    json_put_number(j, "integral", e->integral);
    json_put_number(j, "integral_direct", e->integral_direct);
}

static void put_parameters(struct json *j, const struct bench_edits_row *row)
{
    bool any = false;
    for (int i = 0; i < BENCH_KINDS_FIBRE; i++)
        any |= !isnan(row->each[i]);
    if (!any)
        return;
    json_key(j, "parameters");
    json_open_object(j);
    for (int i = 0; i < BENCH_KINDS_FIBRE; i++)
        if (!isnan(row->each[i]))
            json_put_number(j, bench_kinds_fibre[i], row->each[i]);
    json_close_object(j);
}

static void put_draft(struct json *j, const struct bench_edits_row *row)
{
    if (!row->drag)
        return;
    json_put_number(j, "first_ms", row->first);
    json_put_int(j, "divisor", row->how.divisor > 0 ? row->how.divisor : 1);
    json_put_int(j, "stride", row->how.stride > 0 ? row->how.stride : 1);
    json_put_bool(j, "coarse", row->how.coarse);
}

void bench_edits_json(const struct bench_edits_scene *s,
                      const struct bench_edits_row *row, struct buf *out)
{
    const struct bench_times *t = &row->time;
    struct json j = json_begin(out);
    json_open_object(&j);
    json_put_string(&j, "kind", "edit");
    json_put_string(&j, "scene", s->loaded.name);
    json_put_string(&j, "edit", row->edit);
    json_put_number(&j, "min_ms", t->least);
    json_put_number(&j, "median_ms", t->median.value);
    json_put_number(&j, "p95_ms", t->p95);
    json_put_int(&j, "edits", t->runs);
    json_put_number(&j, "target_ms", row->target);
    put_error(&j, row);
    json_put_number(&j, "paper_forward_ms", row->forward);
    json_put_number(&j, "ratio", row->forward / t->median.value);
    json_put_number(&j, "ratio_cpu", row->forward_cpu / t->processor);
    json_put_int(&j, "paper_forward_edits", row->forward_runs);
    json_key(&j, "stages");
    frame_put_stages(&j, t->stage);
    stats_put_work(&j, &t->work);
    json_put_string(&j, "path", row->path);
    json_put_int(&j, "lights", row->lights);
    json_put_int(&j, "tables", row->tables);
    json_put_int(&j, "tables_missing", row->tables_missing);
    json_put_int(&j, "points", row->points);
    json_put_number(&j, "cpu_ms", t->processor);
    json_put_number(&j, "encode_ms", t->encode);
    put_draft(&j, row);
    put_parameters(&j, row);
    if (!isnan(row->paper_fps)) {
        json_put_number(&j, "fps", 1e3 / t->median.value);
        json_put_number(&j, "paper_fps", row->paper_fps);
    }
    json_put_int(&j, "strands", s->loaded.strands);
    json_put_int(&j, "strand_points", s->loaded.points);
    json_put_string(&j, "device", s->device);
    json_close_object(&j);
    buf_byte(out, '\n');
}
