// bench_json.c - one JSON line for each thing measured.
#include "server/bench_report.h"

#include <math.h>

#include "protocol/json.h"
#include "server/frame.h"

static void put_interval(struct json *j, const char *key,
                         const struct metric_value *v)
{
    json_key(j, key);
    json_open_array(j);
    json_number(j, v->low);
    json_number(j, v->high);
    json_close_array(j);
}

static void put_errors(struct json *j, const struct metric_errors *e)
{
    json_put_number(j, "rel_rmse", e->rel_rmse.value);
    json_put_number(j, "rel_mse", e->rel_mse.value);
    json_put_number(j, "mean_signed", e->mean_signed.value);
    json_put_number(j, "p99", e->p99.value);
    put_interval(j, "rel_rmse_ci95", &e->rel_rmse);
    put_interval(j, "rel_mse_ci95", &e->rel_mse);
    put_interval(j, "mean_signed_ci95", &e->mean_signed);
    put_interval(j, "p99_ci95", &e->p99);
    json_put_number(j, "noise", e->noise);
}

static void put_nested(struct json *j, const char *key,
                       const struct metric_errors *e)
{
    if (isnan(e->rel_rmse.value))
        return;
    json_key(j, key);
    json_open_object(j);
    put_errors(j, e);
    json_close_object(j);
}

static void put_times(struct json *j, const struct bench_times *t)
{
    json_put_number(j, "median_ms", t->median.value);
    json_put_number(j, "p95_ms", t->p95);
    put_interval(j, "median_ms_ci95", &t->median);
    json_put_int(j, "runs", t->runs);
    json_key(j, "stages");
    frame_put_stages(j, t->stage);
}

static struct json begin(const struct bench_result *b, const char *kind,
                         struct buf *out)
{
    struct json j = json_begin(out);
    json_open_object(&j);
    json_put_string(&j, "kind", kind);
    json_put_string(&j, "scene", b->name);
    return j;
}

static void end(struct json *j)
{
    json_close_object(j);
    buf_byte(j->out, '\n');
}

void bench_report_json_scene(const struct bench_result *b, struct buf *out)
{
    const struct bench_truth *t = b->truth;
    struct json j = begin(b, "scene", out);
    json_put_string(&j, "device", b->device);
    json_put_int(&j, "strands", b->strands);
    json_put_int(&j, "points", b->points);
    json_put_int(&j, "places", (int64_t)t->count);
    json_put_int(&j, "places_exact", (int64_t)t->exact);
    json_put_int(&j, "paths_per_place", b->paths);
    json_put_int(&j, "paths_per_pixel", b->picture_paths);
    json_put_int(&j, "picture_samples", b->picture_samples);
    json_put_number(&j, "picture_noise", t->picture_noise);
    json_put_number(&j, "reference_s", t->seconds);
    json_put_int(&j, "reference_made", t->made);
    json_put_int(&j, "reference_kept", t->kept);
    end(&j);
}

void bench_report_json_row(const struct bench_result *b,
                           const struct bench_row *row, struct buf *out)
{
    struct json j = begin(b, "setting", out);
    json_put_string(&j, "method", row->setting->method);
    json_put_string(&j, "group", row->setting->group);
    json_put_string(&j, "setting", row->setting->text);
    put_times(&j, &row->time[BENCH_EDIT_FIBRE]);
    put_errors(&j, &row->whole);
    json_put_number(&j, "psnr", row->psnr);
    json_put_number(&j, "ssim", row->ssim);
    put_nested(&j, "picture", &row->picture);
    put_nested(&j, "single", &row->single);
    put_nested(&j, "integral", &row->integral);
    json_key(&j, "edits");
    json_open_object(&j);
    for (int e = 0; e < BENCH_EDITS; e++) {
        if (row->time[e].runs == 0)
            continue;
        json_key(&j, bench_edit_names[e]);
        json_open_object(&j);
        put_times(&j, &row->time[e]);
        json_close_object(&j);
    }
    json_close_object(&j);
    end(&j);
}

void bench_report_json_cause(const struct bench_result *b,
                             const struct bench_cause *c, struct buf *out)
{
    struct json j = begin(b, "cause", out);
    json_put_string(&j, "cause", c->name);
    json_put_string(&j, "what", c->what);
    put_errors(&j, &c->errors);
    end(&j);
}
