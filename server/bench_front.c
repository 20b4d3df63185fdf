// bench_front.c - which settings make a front, and what is measured of each.
// The clock and the reference are bench_time.c's and bench_measure.c's.
#include "server/bench_front.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "protocol/json.h"

enum { RAYS = 3 };
static const int rays[RAYS] = {0, 1, 4};

// Not every combination: lights and voxels decide most of time and error, and
// twice the lights at a distance from the default's voxels is beyond what
// anybody waits for.  `rays`: how many of the list above.
static const struct point {
    double knob[FRONT_RAYS]; // lights, light_bound, resolution, directions
    int rays;
} points[] = {
    {{40, .001, 96, 1}, 3},  {{20, .001, 96, 1}, 3},  {{10, .001, 96, 1}, 3},
    {{5, .001, 96, 1}, 3},   {{80, .001, 96, 1}, 2},  {{10, .001, 64, 1}, 2},
    {{5, .001, 64, 1}, 2},   {{40, .001, 192, 1}, 2}, {{20, .001, 192, 1}, 2},
    {{10, .001, 192, 1}, 2}, {{5, .001, 192, 1}, 2},  {{40, .02, 96, 1}, 2},
    {{40, .1, 96, 1}, 2},    {{40, .001, 96, 0}, 2},
};

static void knobs_of(const struct params *p, double knob[FRONT_KNOBS])
{
    for (int k = 0; k < FRONT_KNOBS; k++)
        knob[k] = front_knob(p, k);
}

static void name(struct bench_setting *s)
{
    double knob[FRONT_KNOBS], from[FRONT_KNOBS];
    struct buf text = {0};
    for (int k = 0; k < FRONT_KNOBS; k++)
        from[k] = front_knob_default(k);
    knobs_of(&s->params, knob);
    front_print_knobs(&text, knob, from);
    if (text.size == 0)
        buf_text(&text, "default");
    snprintf(s->text, sizeof s->text, "%.*s", (int)text.size,
             (const char *)text.data);
    buf_finish(&text);
}

int bench_front_list(const struct params *base, const char *only,
                     struct bench_setting *out)
{
    int n = 0;
    for (size_t i = 0; i < sizeof points / sizeof *points; i++)
        for (int r = 0; r < points[i].rays; r++) {
            struct bench_setting s = {
                .method = "front", .group = "front", .params = *base};
            for (int k = 0; k < FRONT_RAYS; k++)
                front_put(&s.params, k, points[i].knob[k]);
            front_put(&s.params, FRONT_RAYS, rays[r]);
            name(&s);
            if ((i == 0 && r < 2) || !only || bench_knobs_wanted(&s, only))
                out[n++] = s;
        }
    return n;
}

static bool has_rays(const struct bench_row *row)
{
    return front_knob(&row->setting->params, FRONT_RAYS) > 0;
}

bool bench_front_row(const struct bench_view *v, const struct bench_setting *s,
                     struct bench_row *out, struct error *err)
{
    // With rays an edit takes seconds, and little of that is chance.
    static const struct bench_effort by_rays = {1, 0.001}, few = {3, 1};
    static const enum bench_edit others[] = {BENCH_EDIT_SKY, BENCH_EDIT_CAMERA};
    const bool smooth = front_knob(&s->params, FRONT_RAYS) == 0;
    *out = (struct bench_row){.setting = s};
    if (!bench_time(v->r, &s->params, BENCH_EDIT_FIBRE,
                    smooth ? &v->effort : &by_rays,
                    &out->time[BENCH_EDIT_FIBRE], err))
        return false;
    for (size_t i = 0; smooth && i < sizeof others / sizeof *others; i++)
        if (!bench_time(v->r, &s->params, others[i], &few,
                        &out->time[others[i]], err))
            return false;
    return bench_measure_whole(v, &s->params, &out->whole, err);
}

void bench_front_json(const struct bench_result *b, const struct bench_row *row,
                      struct buf *out)
{
    const struct metric_value *e = &row->whole.rel_rmse;
    struct json j = json_begin(out);
    json_open_object(&j);
    json_put_string(&j, "kind", "front");
    json_put_string(&j, "scene", b->name);
    json_put_string(&j, "setting", row->setting->text);
    json_key(&j, "edits");
    json_open_object(&j);
    for (int i = 0; i < BENCH_EDITS; i++) {
        const struct bench_times *t = &row->time[i];
        if (t->runs == 0)
            continue;
        json_key(&j, bench_edit_names[i]);
        json_open_object(&j);
        json_put_number(&j, "least_ms", t->least);
        json_put_number(&j, "cpu_ms", t->cpu);
        json_put_number(&j, "crowd", t->crowd);
        json_close_object(&j);
    }
    json_close_object(&j);
    json_put_number(&j, "error", e->value);
    json_key(&j, "error_ci95");
    json_open_array(&j);
    json_number(&j, e->low);
    json_number(&j, e->high);
    json_close_array(&j);
    json_close_object(&j);
    buf_byte(out, '\n');
}

// Is it the processors that draw?
static bool by_processors(const char *device)
{
    static const char *const names[] = {"llvmpipe", "softpipe", "SwiftShader"};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++)
        if (strstr(device, names[i]))
            return true;
    return false;
}

// What an edit takes where nobody else wants the processors: their time, over
// as many of them as edits of its kind had at best in any row.  So rows compare
// even when they were measured on a busy machine.  crowd 0: the wall clock.
static double quiet_ms(double crowd, const struct bench_times *t)
{
    return crowd > 0 ? fmin(t->least, t->cpu / crowd) : t->least;
}

void bench_front_make(const struct bench_result *b,
                      const struct bench_front_scene *scene, struct front *out)
{
    static const enum bench_edit edits[FRONT_EDITS] = {
        BENCH_EDIT_FIBRE, BENCH_EDIT_SKY, BENCH_EDIT_CAMERA};
    const struct bench_row *first = NULL; // the newest without rays
    double crowd[FRONT_EDITS] = {0};
    for (int i = 0; i < b->rows && by_processors(b->device); i++)
        for (int e = 0; e < FRONT_EDITS; e++)
            crowd[e] = fmax(crowd[e], b->row[i].time[edits[e]].crowd);
    *out = (struct front){.cores = scene->cores, .strands = b->strands};
    snprintf(out->device, sizeof out->device, "%s", b->device);
    snprintf(out->scene, sizeof out->scene, "%s", b->name);
    snprintf(out->hair, sizeof out->hair, "%s", scene->hair_sha);
    snprintf(out->env, sizeof out->env, "%s", scene->env_sha);
    for (int i = 0; i < b->rows && out->rows < FRONT_ROWS_MAX; i++) {
        const struct bench_row *from = &b->row[i];
        struct front_row *row = &out->row[out->rows];
        if (!has_rays(from))
            first = from;
        // A black reference has no relative error.
        if (!first || !(from->whole.rel_rmse.value > 0))
            continue;
        knobs_of(&from->setting->params, row->knob);
        for (int e = 0; e < FRONT_EDITS; e++)
            row->first_ms[e] = quiet_ms(crowd[e], &first->time[edits[e]]);
        row->rest_ms =
            quiet_ms(crowd[FRONT_FIBRE], &from->time[BENCH_EDIT_FIBRE]);
        row->error = from->whole.rel_rmse.value;
        out->rows++;
    }
}
