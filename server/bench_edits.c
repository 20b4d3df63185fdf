// bench_edits.c - goes through the kinds of edits (bench_kinds.h), then through
// the same by paper-forward, then through the errors.
#include "server/bench_edits.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "protocol/bytes.h"
#include "protocol/edit.h"
#include "server/bench_cold.h"
#include "server/bench_measure.h"

enum { STATES_MAX = 24, JUDGED_AT = 5 };

struct judged {
    struct params params;
    struct bench_edits_error error;
};

struct known { // by paper-forward
    struct params params;
    int edit;
    struct bench_times time;
};

struct run {
    const struct bench_edits_ask *ask;
    struct bench_edits_scene *out;
    struct renderer *r;
    struct bench_kinds_scene scene;
    struct bench_truth truth; // of `true_of`
    struct params true_of;
    struct judged judged[STATES_MAX];
    int judged_count;
    struct known known[STATES_MAX];
    int known_count;
    // of each row: its parameters, the state that is judged, paper-forward's
    // edit
    struct params setting[BENCH_EDITS_ROWS_MAX], shown[BENCH_EDITS_ROWS_MAX];
    int forward[BENCH_EDITS_ROWS_MAX];
};

static void assign(struct params *p, const char *assignments)
{
    char word[80];
    struct error err = {0}; // constants of this program
    while (*(assignments += strspn(assignments, " "))) {
        const size_t n = strcspn(assignments, " ");
        snprintf(word, sizeof word, "%.*s", (int)n, assignments);
        edit_apply_text(p, word, &err);
        assignments += n;
    }
}

// --- times -------------------------------------------------------------------

static bool cold(struct run *run, const struct params *p,
                 struct bench_times *out, struct error *err)
{
    const struct bench_edits_ask *ask = run->ask;
    const struct bench_cold_ask how = {ask->hair, ask->env, p};
    struct bench_log log = {.n = 0};
    const struct bench_frame none = {.encode = false};
    double ms[BENCH_COLUMNS];
    for (int i = 0; i < BENCH_COLUMNS; i++)
        ms[i] = i < RENDERER_STAGES ? -1 : 0;
    for (int i = 0; i <= ask->cold; i++) { // the first one fills caches
        if (!bench_cold_start(&how, &ms[BENCH_WHOLE], err))
            return false;
        if (i > 0)
            bench_time_note(&log, &none, ms);
    }
    bench_time_take(&log, out);
    return true;
}

// Medians by fibre parameter of what each edit took.
static void by_parameter(const double *each, int edits, double *out)
{
    for (int i = 0; i < BENCH_KINDS_FIBRE; i++) {
        double of[BENCH_RUNS_MAX];
        size_t n = 0;
        for (int k = 0; k < edits; k++)
            if (bench_kinds_fibre_at(k) == i && !isnan(each[k]))
                of[n++] = each[k];
        out[i] = n > 0 ? metric_quantile(of, n, 0.5) : NAN;
    }
}

static bool edits(struct run *run, const struct bench_kind *kind,
                  const struct params *p, struct bench_edits_row *row,
                  struct error *err)
{
    double each[BENCH_RUNS_MAX + 2];
    const struct bench_series series = {
        .edit = kind->edit, .self = &run->scene, .encode = true, .each = each};
    for (int k = 0; k < BENCH_RUNS_MAX + 2; k++)
        each[k] = NAN;
    if (!bench_time_series(run->r, p, &series,
                           kind->flags & BENCH_KINDS_LONG ? &run->ask->slow
                                                          : &run->ask->effort,
                           &row->time, err))
        return false;
    if (kind->edit == bench_kinds_any_fibre)
        by_parameter(each, BENCH_RUNS_MAX + 2, row->each);
    return true;
}

static bool drag(struct run *run, const struct bench_kind *kind,
                 const struct params *p, struct bench_edits_row *row,
                 struct error *err)
{
    const struct bench_series series = {.edit = kind->edit,
                                        .self = &run->scene};
    struct bench_drag d;
    if (!bench_drag_run(run->r, p, &series, &run->ask->effort, &d, err))
        return false;
    row->time = d.time;
    row->first = d.first;
    row->blocks = d.blocks;
    row->how = d.how;
    row->drag = true;
    row->error.path.value = d.error;
    return true;
}

static struct bench_edits_row *new_row(struct run *run, const char *edit)
{
    struct bench_edits_row *row = &run->out->row[run->out->rows++];
    const struct metric_value none = {NAN, NAN, NAN};
    *row = (struct bench_edits_row){
        .first = NAN,
        .blocks = NAN,
        .target = NAN,
        .forward = NAN,
        .forward_cpu = NAN,
        .paper_fps = NAN,
        .error = {none, none, NAN, NAN, NAN},
    };
    for (int i = 0; i < BENCH_KINDS_FIBRE; i++)
        row->each[i] = NAN;
    snprintf(row->edit, sizeof row->edit, "%s", edit);
    return row;
}

static void note_state(const struct run *run, struct bench_edits_row *row)
{
    struct renderer_stats s;
    renderer_stats(run->r, &s);
    row->path = s.path;
    row->lights = s.lights_used;
    row->lights_asked = s.lights_fitted;
    row->tables = s.tables;
    row->tables_missing = s.tables_missing;
    row->points = s.visible_points;
}

static bool measure(struct run *run, const struct bench_kind *kind, int scene,
                    struct error *err)
{
    const int i = run->out->rows;
    struct bench_edits_row *row = new_row(run, kind->name);
    struct params *p = &run->setting[i];
    *p = *run->ask->base;
    assign(p, kind->with);
    run->shown[i] = *p;
    run->forward[i] = kind->forward;
    if (kind->flags & BENCH_KINDS_MOVED)
        kind->edit(&run->scene, &run->shown[i], JUDGED_AT);
    row->chief = kind->flags & BENCH_KINDS_CHIEF;
    if (scene >= 0)
        row->target = kind->target[scene];
    const bool ok = kind->way == BENCH_WAY_COLD ? cold(run, p, &row->time, err)
                    : kind->way == BENCH_WAY_DRAG
                        ? drag(run, kind, p, row, err)
                        : edits(run, kind, p, row, err);
    if (ok)
        note_state(run, row);
    return ok;
}

// --- Table 2 -----------------------------------------------------------------

// With the paper's number of lights: as it is drawn by default, and as the
// paper evaluates it with its four segments.
static bool table_2(struct run *run, const struct bench_paper_scene *paper,
                    struct error *err)
{
    static const struct {
        const char *name, *with;
    } ways[] = {{"Table 2, default path", ""},
                {"Table 2, paper's scheme, m = 4",
                 "render.path=direct render.scheme=paper render.m=4"}};
    for (int k = 0; k < 2; k++) {
        struct bench_kind kind = {
            .name = ways[k].name,
            .with = ways[k].with,
            .edit = bench_kinds_any_fibre,
            .forward = BENCH_EDIT_FIBRE,
        };
        struct bench_edits_ask ask = *run->ask;
        struct params base = *run->ask->base;
        base.sky.lights = paper->lights;
        ask.base = &base;
        const struct bench_edits_ask *kept = run->ask;
        run->ask = &ask;
        const bool ok = bench_time_finish(run->r, &base, NULL, err) &&
                        measure(run, &kind, -1, err);
        run->ask = kept;
        if (!ok)
            return false;
        run->out->row[run->out->rows - 1].paper_fps = paper->fps;
    }
    return true;
}

// --- by paper-forward --------------------------------------------------------

static struct params as_forward(const struct params *setting)
{
    struct params p = *setting;
    assign(&p, "render.path=forward render.scheme=paper render.m=4 "
               "shadow.rays=0");
    return p;
}

static bool is_plain_fibre(const struct run *run, int i)
{
    return run->forward[i] == BENCH_EDIT_FIBRE &&
           (params_changed(&run->setting[i], run->ask->base) &
            1u << GROUP_fibre) == 0;
}

static bool forward(struct run *run, int i, struct error *err)
{
    struct bench_edits_row *row = &run->out->row[i];
    const struct params p = as_forward(&run->setting[i]);
    const struct known *k = NULL;
    if (run->forward[i] < 0 || (run->ask->few && !is_plain_fibre(run, i)))
        return true;
    for (int j = 0; j < run->known_count && !k; j++)
        if (run->known[j].edit == run->forward[i] &&
            params_changed(&run->known[j].params, &p) == 0)
            k = &run->known[j];
    if (!k) {
        struct known *new = &run->known[run->known_count];
        *new = (struct known){.params = p, .edit = run->forward[i]};
        if (run->known_count < STATES_MAX - 1)
            run->known_count++;
        if (!bench_time(run->r, &p, (enum bench_edit) new->edit,
                        &run->ask->forward, &new->time, err))
            return false;
        k = new;
    }
    row->forward = k->time.median.value;
    row->forward_cpu = k->time.processor;
    row->forward_runs = k->time.runs;
    return true;
}

// --- errors ------------------------------------------------------------------

// The reference of a state; rays and paths do not bear upon it.
static bool truth(struct run *run, const struct params *p, struct error *err)
{
    struct params plain = *p;
    assign(&plain, "shadow.rays=0 render.path=direct render.scheme=best");
    const struct bench_truth_ask q = {
        .params = &plain,
        .places = (size_t)run->ask->places,
        // Exact integrals take long, of an eccentric fibre by far the longest:
        // once a scene.
        .exact = run->judged_count == 0 ? (size_t)run->ask->exact : 0,
        .paths = run->ask->paths,
        .no_lights = true,
        .hair_sha = run->out->loaded.hair_sha,
        .sky_sha = run->out->loaded.sky_sha,
        .cache = run->ask->cache,
    };
    if (run->truth.count > 0 && params_changed(&plain, &run->true_of) == 0)
        return true;
    bench_truth_finish(&run->truth);
    run->true_of = plain;
    return bench_time_finish(run->r, &plain, NULL, err) &&
           bench_truth_make(&run->truth, run->r, &q, err);
}

struct radiances { // by the path, by direct evaluation
    double *path, *direct;
};

static bool both(struct run *run, const struct params *p,
                 enum bench_measure_light light, size_t count,
                 struct radiances *out, struct error *err)
{
    const struct bench_view v = {.r = run->r, .base = p, .truth = &run->truth};
    struct params direct = *p;
    assign(&direct, "render.path=direct render.scheme=best");
    out->path = bench_measure_places(&v, p, light, count, err);
    out->direct =
        out->path ? bench_measure_places(&v, &direct, light, count, err) : NULL;
    return out->direct != NULL;
}

static void drop(struct radiances *x)
{
    free(x->path);
    free(x->direct);
}

static bool judge_whole(struct run *run, const struct params *p,
                        struct bench_edits_error *out, struct error *err)
{
    const struct bench_truth *t = &run->truth;
    struct radiances x = {NULL, NULL};
    const bool ok = both(run, p, BENCH_MEASURE_SHOWN, t->count, &x, err);
    if (ok) {
        struct metric_errors e;
        struct metric_pairs pairs = {t->count, x.path, t->whole, t->variance};
        metric_errors(&pairs, &e);
        out->path = e.rel_rmse;
        pairs.x = x.direct;
        metric_errors(&pairs, &e);
        out->direct = e.rel_rmse;
        pairs = (struct metric_pairs){t->count, x.path, x.direct, NULL};
        metric_errors(&pairs, &e);
        out->difference = e.rel_rmse.value;
    }
    drop(&x);
    return ok;
}

static bool judge_integral(struct run *run, const struct params *p,
                           struct bench_edits_error *out, struct error *err)
{
    const struct bench_truth *t = &run->truth;
    struct radiances x = {NULL, NULL};
    if (t->exact == 0)
        return true;
    const bool ok = both(run, p, BENCH_MEASURE_OPEN, t->exact, &x, err);
    if (ok) {
        struct metric_errors e;
        struct metric_pairs pairs = {t->exact, x.path, t->open, NULL};
        metric_errors(&pairs, &e);
        out->integral = e.rel_rmse.value;
        pairs.x = x.direct;
        metric_errors(&pairs, &e);
        out->integral_direct = e.rel_rmse.value;
    }
    drop(&x);
    return ok;
}

static bool judge(struct run *run, int i, struct error *err)
{
    struct bench_edits_row *row = &run->out->row[i];
    const struct params *p = &run->shown[i];
    if (row->drag)
        return true;
    for (int j = 0; j < run->judged_count; j++)
        if (params_changed(&run->judged[j].params, p) == 0) {
            row->error = run->judged[j].error;
            return true;
        }
    if (!truth(run, p, err) || !judge_whole(run, p, &row->error, err) ||
        !judge_integral(run, p, &row->error, err))
        return false;
    if (run->judged_count < STATES_MAX)
        run->judged[run->judged_count++] =
            (struct judged){.params = *p, .error = row->error};
    return true;
}

// --- a scene -----------------------------------------------------------------

static const char *plain(const char *hair)
{
    static const char prefix[] = "builtin:";
    const size_t n = sizeof prefix - 1;
    return strncmp(hair, prefix, n) == 0 ? hair + n : "";
}

static bool rows(struct run *run, struct error *err)
{
    const struct bench_edits_ask *ask = run->ask;
    const char *name = plain(ask->hair);
    const struct bench_paper_scene *paper = bench_kinds_paper_of(name);
    int count = 0;
    const int scene = bench_kinds_scene(name);
    const struct bench_kind *kind =
        name[0] ? bench_kinds(&count) : bench_kinds_file(&count);
    bool ok = true;
    for (int i = 0; ok && !ask->brief && i < count; i++)
        ok = measure(run, &kind[i], scene, err);
    return ok && (!paper || table_2(run, paper, err));
}

static bool begin(struct run *run, struct error *err)
{
    const struct bench_edits_ask *ask = run->ask;
    struct renderer_stats s;
    run->r = renderer_create(ask->cache, err);
    if (!run->r ||
        !bench_scene_load(run->r, ask->hair, ask->env, ask->base,
                          &run->out->loaded, err) ||
        !bench_time_finish(run->r, ask->base, NULL, err))
        return false;
    snprintf(run->out->device, sizeof run->out->device, "%s",
             renderer_device(run->r));
    renderer_stats(run->r, &s);
    memcpy(run->scene.eye, s.eye, sizeof s.eye);
    memcpy(run->scene.target, s.target, sizeof s.target);
    return true;
}

bool bench_edits_run(struct bench_edits_scene *s,
                     const struct bench_edits_ask *ask, struct error *err)
{
    struct run *run = bytes_zalloc(1, sizeof *run);
    *s = (struct bench_edits_scene){.rows = 0};
    run->ask = ask;
    run->out = s;
    bool ok = begin(run, err) && rows(run, err);
    for (int i = 0; ok && i < s->rows; i++)
        ok = forward(run, i, err);
    for (int i = 0; ok && i < s->rows; i++)
        ok = judge(run, i, err);
    bench_truth_finish(&run->truth);
    renderer_destroy(run->r);
    free(run);
    return ok;
}
