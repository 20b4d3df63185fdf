// verb_bench.c - `glintd bench`: error against run time.  JSON lines on
// standard output as they come; a report and plots when all is done.
#include "server/verbs.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "protocol/bytes.h"
#include "renderer/groom.h"
#include "renderer/timer.h"
#include "server/bench_front.h"
#include "server/bench_edits_report.h"
#include "server/bench_report.h"
#include "server/bench_scene.h"
#include "server/cache.h"
#include "server/file.h"
#include "server/options.h"

enum { SCENES_MAX = 64 };

struct bench {
    struct options options;
    const char *scenes, *report, *plot, *only, *command, *front;
    bool quick, full, refined, no_cache, edits;
    double seconds;
    int runs, places, exact, paths, picture_paths, picture_samples;
    char hair[SCENES_MAX][512], env[SCENES_MAX][512];
    int count;
    struct buf overview, sections, fronts;
};

// --- scenes ------------------------------------------------------------------

static bool is_builtin(const char *name)
{
    for (int i = 0; groom_builtin_names[i]; i++)
        if (strcmp(groom_builtin_names[i], name) == 0)
            return true;
    return false;
}

static bool add_scene(struct bench *b, const char *text, size_t size)
{
    const char *at = memchr(text, '@', size);
    const size_t hair = at ? (size_t)(at - text) : size;
    char name[512];
    if (b->count == SCENES_MAX || hair == 0 || hair >= sizeof name - 8 ||
        size - hair >= sizeof b->env[0])
        return false;
    snprintf(name, sizeof name, "%.*s", (int)hair, text);
    snprintf(b->hair[b->count], sizeof b->hair[0], "%s%.500s",
             is_builtin(name) ? "builtin:" : "", name);
    if (at)
        snprintf(b->env[b->count], sizeof b->env[0], "%.*s",
                 (int)(size - hair - 1), at + 1);
    else
        snprintf(b->env[b->count], sizeof b->env[0], "%.500s", b->options.env);
    b->count++;
    return true;
}

static bool list_scenes(struct bench *b)
{
    const char *list = b->scenes;
    if (!list && b->options.hair_given)
        return add_scene(b, b->options.hair, strlen(b->options.hair));
    if (!list && b->edits)
        list = b->quick ? "animation,ponytail"
                        : "animation,straight,natural,ponytail,bob,dark";
    else if (!list && b->front) // strands: a few, some, many; straight, curly
        list = "ponytail,animation,straight,natural";
    else if (!list && b->quick)
        list = "ponytail";
    for (int i = 0; !list && groom_builtin_names[i]; i++)
        if (!add_scene(b, groom_builtin_names[i],
                       strlen(groom_builtin_names[i])))
            return false;
    while (list && *list) {
        const size_t n = strcspn(list, ",");
        if (!add_scene(b, list, n))
            return false;
        list += n + (list[n] == ',');
    }
    return b->count > 0;
}

// --- files -------------------------------------------------------------------

// The plot's file: --plot itself for one scene and kind, else with the scene's
// name and the kind before its end.
static void plot_path(const struct bench *b, const struct bench_result *r,
                      enum bench_plot which, struct buf *out)
{
    const char *folder = strrchr(b->plot, '/');
    const char *end = strrchr(folder ? folder : b->plot, '.');
    const size_t stem = end ? (size_t)(end - b->plot) : strlen(b->plot);
    buf_printf(out, "%.*s", (int)stem, b->plot);
    if (b->count > 1)
        buf_printf(out, "_%s", r->id);
    buf_printf(out, "%s%s%c", which == BENCH_PLOT_INTEGRAL ? "_integral" : "",
               end ? end : ".svg", 0);
}

// As the report names it: relative to its own folder where it lies below it.
static const char *seen_from(const char *report, const char *path)
{
    const char *slash = report ? strrchr(report, '/') : NULL;
    const size_t n = slash ? (size_t)(slash - report) + 1 : 0;
    return strncmp(path, report, n) == 0 ? path + n : path;
}

static bool write_scene(struct bench *b, const struct bench_result *r,
                        struct error *err)
{
    bool front[BENCH_KNOBS_MAX] = {false}, ok = true;
    struct buf path[2] = {{0}}, svg = {0};
    const char *shown[2] = {NULL, NULL};
    for (int k = 0; k < 2 && ok; k++) {
        buf_clear(&svg);
        bench_report_plot(r, (enum bench_plot)k, front, &svg);
        if (!b->plot)
            continue;
        plot_path(b, r, (enum bench_plot)k, &path[k]);
        ok = file_write((const char *)path[k].data, &svg, err);
        if (b->report)
            shown[k] = seen_from(b->report, (const char *)path[k].data);
    }
    bench_report_overview(r, b->overview.size == 0, &b->overview);
    bench_report_scene(r, shown[0] ? shown : NULL, front, &b->sections);
    buf_finish(&path[0]);
    buf_finish(&path[1]);
    buf_finish(&svg);
    return ok;
}

static bool write_report(struct bench *b, const char *device, double seconds,
                         struct error *err)
{
    struct buf out = {0};
    double load = 0;
    if (getloadavg(&load, 1) != 1)
        load = -1;
    const struct bench_head head = {
        .command = b->command ? b->command : "glintd bench",
        .device = device,
        .cores = (int)sysconf(_SC_NPROCESSORS_ONLN),
        .runs = b->runs,
        .scenes = b->count,
        .seconds = seconds,
        .load = load,
    };
    bench_report_head(&head, &b->options.params, &out);
    buf_append(&out, b->overview.data, b->overview.size);
    buf_append(&out, b->sections.data, b->sections.size);
    const bool ok = !b->report || file_write(b->report, &out, err);
    buf_finish(&out);
    return ok;
}

// All that there is so far: a long run that is broken off was not in vain.
static bool write_front(struct bench *b, const struct bench_scene *s,
                        struct error *err)
{
    const struct bench_front_scene scene = {s->loaded.hair_sha,
                                            s->loaded.sky_sha,
                                            (int)sysconf(_SC_NPROCESSORS_ONLN)};
    struct front *f = bytes_zalloc(1, sizeof *f);
    bench_front_make(&s->result, &scene, f);
    front_print(f, &b->fronts);
    free(f);
    char *own = strcmp(b->front, "cache") == 0 ? front_cache_path() : NULL;
    const bool ok =
        own || strcmp(b->front, "cache") != 0
            ? file_write(own ? own : b->front, &b->fronts, err)
            : error_set(err, "system", "", "--front cache: there is none");
    free(own);
    return ok;
}

// --- the run -----------------------------------------------------------------

static void tell(void *self, const struct buf *line)
{
    (void)self;
    fwrite(line->data, 1, line->size, stdout);
    fflush(stdout);
}

static int bench(struct bench *b)
{
    struct error err = {0};
    char *cache = b->no_cache ? NULL : cache_directory();
    const double began = timer_now();
    bool ok = true;
    buf_text(&b->fronts, front_magic);
    for (int i = 0; ok && i < b->count; i++) {
        struct bench_scene s;
        const struct bench_scene_ask ask = {
            .hair = b->hair[i],
            .env = b->env[i],
            .base = &b->options.params,
            // every knob in the first scene, the chief ones in all
            .choice = {.quick = b->quick || (i > 0 && !b->full),
                       .first = i == 0,
                       .only = b->only},
            .effort = {b->runs, b->seconds},
            .places = b->places,
            .exact = b->exact < b->places ? b->exact : b->places,
            .paths = b->paths,
            .picture_paths = b->picture_paths,
            .picture_samples = b->picture_samples,
            .cache = cache,
            .causes = !b->front,
            .front = b->front != NULL,
            .tell = tell,
        };
        ok = bench_scene_run(&s, &ask, &err) &&
             (b->front
                  ? write_front(b, &s, &err)
                  : write_scene(b, &s.result, &err) &&
                        write_report(b, s.device, timer_now() - began, &err));
        bench_scene_finish(&s);
    }
    buf_finish(&b->overview);
    buf_finish(&b->sections);
    buf_finish(&b->fronts);
    free(cache);
    return ok ? 0 : options_fail(&err);
}

// --- what an edit costs ------------------------------------------------------

static void tell_edits(const struct bench_edits_scene *s)
{
    struct buf line = {0};
    for (int i = 0; i < s->rows; i++)
        bench_edits_json(s, &s->row[i], &line);
    tell(NULL, &line);
    buf_finish(&line);
}

static bool edits_scene(struct bench *b, int i, const char *cache,
                        struct bench_edits_scene *out, struct error *err)
{
    static const char builtin[] = "builtin:";
    const size_t n = sizeof builtin - 1;
    const char *name = b->hair[i];
    const bool whole = strncmp(name, builtin, n) != 0 ||
                       bench_kinds_scene(name + n) >= 0 || b->count == 1;
    const struct bench_edits_ask ask = {
        .hair = name,
        .env = b->env[i],
        .base = &b->options.params,
        .effort = {b->runs, 0},
        .slow = {b->runs < 20 ? b->runs : 20, b->seconds},
        .forward = {b->quick ? 2 : 5, 4}, // of what is slow no more than 3
        .cold = b->quick ? 1 : 7,
        .places = b->places,
        .exact = b->exact < b->places ? b->exact : b->places,
        .paths = b->paths,
        .cache = cache,
        .brief = !whole,
        .few = b->quick,
    };
    if (!bench_edits_run(out, &ask, err))
        return false;
    tell_edits(out);
    return true;
}

static bool write_edits(struct bench *b, const struct bench_edits_head *head,
                        const struct bench_edits_scene *scene,
                        struct error *err)
{
    struct buf out = {0};
    bench_edits_page(head, scene, b->count, &out);
    bool ok = !b->report || file_write(b->report, &out, err);
    buf_clear(&out);
    bench_edits_plot(head, scene, b->count, &out);
    ok = ok && (!b->plot || file_write(b->plot, &out, err));
    buf_finish(&out);
    return ok;
}

static int edits(struct bench *b)
{
    struct error err = {0};
    struct bench_edits_scene *scene =
        bytes_zalloc((size_t)b->count, sizeof *scene);
    char *cache = b->no_cache ? NULL : cache_directory();
    const double began = timer_now();
    struct bench_edits_head head = {
        .command = b->command ? b->command : "glintd bench --edits",
        .cores = (int)sysconf(_SC_NPROCESSORS_ONLN),
        .runs = b->runs,
        .forward_runs = b->quick ? 2 : 5,
        .cold = b->quick ? 1 : 7,
        .places = b->places,
        .exact = b->exact,
        .paths = b->paths,
        .base = &b->options.params,
        .skipped = "a groom from a file, because none was named",
    };
    bool ok = true;
    getloadavg(&head.load[0], 1);
    for (int i = 0; ok && i < b->count; i++) {
        ok = edits_scene(b, i, cache, &scene[i], &err);
        if (strchr(b->hair[i], ':') == NULL)
            head.skipped = NULL;
    }
    getloadavg(&head.load[1], 1);
    head.seconds = timer_now() - began;
    head.device = scene[0].device;
    if (b->plot)
        head.plot = seen_from(b->report, b->plot);
    ok = ok && write_edits(b, &head, scene, &err);
    free(scene);
    free(cache);
    return ok ? 0 : options_fail(&err);
}

// What is not given is by the length of the run.
static void defaults(struct bench *b)
{
    const bool q = b->quick || b->front;
    if (b->edits) {
        b->runs = b->runs ? b->runs : q ? 5 : 24;
        b->seconds = b->seconds >= 0 ? b->seconds : q ? 3 : 12;
        b->places = b->places ? b->places : q ? 60 : 150;
        b->exact = b->exact >= 0 ? b->exact : q ? 0 : 20;
        b->paths = b->paths ? b->paths : q ? 16 : 32;
    }
    b->runs = b->runs ? b->runs : 10;
    b->seconds = b->seconds >= 0 ? b->seconds : q ? 3 : 8;
    b->places = b->places ? b->places : q ? 200 : 500;
    b->exact = b->exact >= 0 ? b->exact : b->front ? 0 : q ? 30 : 45;
    b->paths = b->paths ? b->paths : q ? 64 : 128;
    b->picture_paths = b->picture_paths ? b->picture_paths : q ? 4 : 16;
    b->picture_samples = b->picture_samples ? b->picture_samples : q ? 4 : 16;
    b->options.params.quality.samples = 1; // the first full frame
    if (!b->refined)
        b->options.params.shadow.rays = 0;
    b->options.params.render.components = 0;
}

int verb_bench_run(int argc, char **argv)
{
    struct bench *b = bytes_zalloc(1, sizeof *b);
    b->exact = -1;
    b->seconds = -1;
    const struct options_row rows[] = {
        {"scenes", OPTIONS_TEXT, &b->scenes, 0, 0, "HAIR[@ENV],...",
         "what is measured; the six built-in grooms unless --hair is given"},
        {"edits", OPTIONS_FLAG, &b->edits, 0, 0, NULL,
         "what an edit costs instead: every kind, beside paper-forward, with "
         "its error"},
        {"quick", OPTIONS_FLAG, &b->quick, 0, 0, NULL,
         "one scene, fewer settings, places and paths: two minutes"},
        {"report", OPTIONS_TEXT, &b->report, 0, 0, "FILE.md",
         "write tables as Markdown"},
        {"plot", OPTIONS_TEXT, &b->plot, 0, 0, "FILE.svg",
         "write plots; with several scenes FILE_SCENE.svg"},
        {"front", OPTIONS_TEXT, &b->front, 0, 0, "FILE",
         "measure what a governor chooses among, for `serve --front FILE`; the "
         "word cache: for every serve of this user"},
        {"only", OPTIONS_TEXT, &b->only, 0, 0, "WORD,...",
         "only settings whose group or text has one of the words"},
        {"runs", OPTIONS_INT, &b->runs, 1, BENCH_RUNS_MAX, "N",
         "edits that are timed of each kind (10)"},
        {"seconds", OPTIONS_REAL, &b->seconds, 0, 3600, "S",
         "after so many no more than 3 edits of a kind; 0 for ever (8, quick "
         "3)"},
        {"refined", OPTIONS_FLAG, &b->refined, 0, 0, NULL,
         "everything with shadow.rays as it is set: the picture at rest, not "
         "the first"},
        {"full", OPTIONS_FLAG, &b->full, 0, 0, NULL,
         "every setting in every scene, not in the first alone"},
        {"places", OPTIONS_INT, &b->places, 2, 20000, "N",
         "visible places at which errors are measured (500, quick 200)"},
        {"exact", OPTIONS_INT, &b->exact, 0, 20000, "N",
         "of these, places at which causes are separated (60, quick 30)"},
        {"paths", OPTIONS_INT, &b->paths, 2, 1000000, "N",
         "paths of the reference for each place (128, quick 64)"},
        {"picture-paths", OPTIONS_INT, &b->picture_paths, 1, 65536, "N",
         "paths for each pixel of the reference picture (16, quick 4)"},
        {"picture-samples", OPTIONS_INT, &b->picture_samples, 1, 4096, "N",
         "samples of pictures that are compared with it (16, quick 4)"},
        {"no-cache", OPTIONS_FLAG, &b->no_cache, 0, 0, NULL,
         "neither use nor keep references and fits on disk"},
        {"command", OPTIONS_TEXT, &b->command, 0, 0, "TEXT",
         "what the report calls the command that made it"},
        {0}};
    const struct options_verb verb = {
        .name = "bench",
        .about = "error against run time of every setting, as JSON lines; "
                 "quality.samples is 1 and\nshadow.rays 0 but where they are "
                 "what is compared, or --refined",
        .takes = OPTIONS_SCENE,
        .rows = rows,
    };
    int status = options_parse(&b->options, &verb, argc, argv);
    if (status < 0) {
        defaults(b);
        if (list_scenes(b)) {
            status = b->edits ? edits(b) : bench(b);
        } else {
            fprintf(stderr,
                    "glintd: bench: --scenes: HAIR or HAIR@ENV, joined "
                    "by commas, at most %d\n",
                    SCENES_MAX);
            status = 2;
        }
    }
    options_finish(&b->options);
    free(b);
    return status;
}
