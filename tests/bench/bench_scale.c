// How an edit's time and memory grow with visible places, lights, strands,
// points a strand and pixels.
//   bench_scale [--quick] [--only WORD] [--report FILE.md --pictures DIR]
// One JSON line for each measurement; see docs/SCALE.md.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "renderer/renderer.h"
#include "renderer/timer.h"
#include "server/bench_time.h"
#include "server/cache.h"
#include "server/file.h"
#include "tests/bench/grown.h"
#include "tests/bench/scale.h"

enum { STRAND_POINTS = 25, STRANDS = 10000, SWEEPS = 5 };

struct bench {
    const char *only, *report, *pictures;
    bool quick;
    char *cache;
    char device[160];
    struct scale_sweep sweep[SWEEPS];
};

static void must(bool ok, const struct error *err)
{
    if (!ok) {
        fprintf(stderr, "bench_scale: %s\n", err->text);
        exit(1);
    }
}

// --- one measurement ---------------------------------------------------------

static void note(struct renderer *r, struct scale_row *row)
{
    struct renderer_stats s;
    renderer_stats(r, &s);
    row->points = s.visible_points;
    row->lights = s.lights_used;
    row->light_tables = s.tables;
    row->missing = s.tables_missing;
    row->path = s.path;
    row->strands = s.memory_strands;
    row->shadow = s.memory_shadow;
    row->cache = s.memory_cache;
    row->targets = s.memory_targets;
    row->tables = s.memory_tables;
}

static void measure(const struct bench *b, struct renderer *r,
                    const struct params *p, struct scale_row *row)
{
    static const enum bench_edit edits[SCALE_EDITS] = {
        BENCH_EDIT_FIBRE, BENCH_EDIT_COLOUR, BENCH_EDIT_CAMERA};
    const struct bench_effort effort = {b->quick ? 3 : 7, 15};
    struct error err = {0};
    if (!bench_time_finish(r, p, NULL, &err)) {
        snprintf(row->refused, sizeof row->refused, "%s", err.text);
        return;
    }
    for (int i = 0; i < SCALE_EDITS; i++) {
        struct bench_times t;
        must(bench_time(r, p, edits[i], &effort, &t, &err), &err);
        row->ms[i] = t.median.value;
        row->cpu[i] = t.processor;
    }
    note(r, row);
}

static void tell(const struct scale_sweep *s, const struct scale_row *r)
{
    struct buf line = {0};
    scale_json(s, r, &line);
    fwrite(line.data, 1, line.size, stdout);
    fflush(stdout);
    buf_finish(&line);
}

static void base(struct params *p)
{
    params_defaults(p);
    p->quality.samples = 1;
    p->shadow.rays = 0;
}

// Takes the groom.
static struct renderer *renderer(struct bench *b, struct groom *g,
                                 const struct params *p)
{
    struct error err = {0};
    must(g != NULL, &err);
    struct renderer *r = renderer_create(b->cache, &err);
    must(r != NULL, &err);
    snprintf(b->device, sizeof b->device, "%s", renderer_device(r));
    renderer_set_params(r, p);
    must(renderer_set_groom(r, g, &err), &err);
    must(renderer_set_sky(r, sky_open("builtin:studio", &err), &err), &err);
    return r;
}

static struct groom *animation(void)
{
    struct error err = {0};
    struct groom *g = groom_builtin("animation", &err);
    must(g != NULL, &err);
    return g;
}

// --- sweeps ------------------------------------------------------------------

static struct scale_row *next(struct scale_sweep *s, double x)
{
    struct scale_row *row = &s->row[s->rows++];
    *row = (struct scale_row){.x = x};
    return row;
}

// The camera's angle is widened where it stands, so that the same hair covers
// less.
static void places(struct bench *b, struct scale_sweep *s)
{
    static const double wider[] = {6, 4.2, 3, 2.1, 1.5, 1, 0.75};
    struct params p;
    struct renderer_stats at;
    struct error err = {0};
    base(&p);
    struct renderer *r = renderer(b, animation(), &p);
    must(bench_time_finish(r, &p, NULL, &err), &err);
    renderer_stats(r, &at);
    memcpy(p.camera.eye, at.eye, sizeof at.eye);
    memcpy(p.camera.target, at.target, sizeof at.target);
    for (int i = 0; i < 7; i += b->quick ? 3 : 1) {
        const double tangent = wider[i] * tan(15 * M_PI / 180);
        p.camera.fov = (float)(2 * atan(tangent) * 180 / M_PI);
        struct scale_row *row = next(s, 0);
        measure(b, r, &p, row);
        row->x = row->points;
        tell(s, row);
    }
    renderer_destroy(r);
}

static void lights(struct bench *b, struct scale_sweep *s)
{
    static const int counts[] = {5, 10, 20, 40, 80, 120, 160, 200};
    struct params p;
    base(&p);
    struct renderer *r = renderer(b, animation(), &p);
    for (int i = 0; i < 8; i += b->quick ? 3 : 1) {
        p.sky.lights = counts[i];
        struct scale_row *row = next(s, counts[i]);
        measure(b, r, &p, row);
        tell(s, row);
    }
    renderer_destroy(r);
}

static void grown(struct bench *b, struct scale_sweep *s, uint32_t strands,
                  uint32_t points, double x)
{
    struct params p;
    struct error err = {0};
    base(&p);
    struct groom *g = grown_groom(strands, points, &err);
    must(g != NULL, &err);
    struct renderer *r = renderer(b, g, &p);
    struct scale_row *row = next(s, x);
    measure(b, r, &p, row);
    row->strand_points = strands * points;
    tell(s, row);
    renderer_destroy(r);
}

static void strands(struct bench *b, struct scale_sweep *s)
{
    static const uint32_t counts[] = {1000, 4000, 16000, 50000, 100000, 200000};
    for (int i = 0; i < (b->quick ? 4 : 6); i += b->quick ? 3 : 1)
        grown(b, s, counts[i], STRAND_POINTS, counts[i]);
}

static void points(struct bench *b, struct scale_sweep *s)
{
    static const uint32_t counts[] = {4, 8, 16, 32, 64, 128};
    for (int i = 0; i < 6; i += b->quick ? 4 : 1)
        grown(b, s, STRANDS, counts[i], counts[i]);
}

static void pixels(struct bench *b, struct scale_sweep *s)
{
    static const int sizes[][2] = {{640, 360},   {960, 540},   {1280, 720},
                                   {1920, 1080}, {2560, 1440}, {2720, 1530},
                                   {3840, 2160}};
    struct params p;
    base(&p);
    struct renderer *r = renderer(b, animation(), &p);
    for (int i = 0; i < 7; i += b->quick ? 3 : 1) {
        p.image.width = sizes[i][0];
        p.image.height = sizes[i][1];
        struct scale_row *row = next(s, (double)sizes[i][0] * sizes[i][1]);
        snprintf(row->label, sizeof row->label, "%d x %d", sizes[i][0],
                 sizes[i][1]);
        measure(b, r, &p, row);
        tell(s, row);
    }
    renderer_destroy(r);
}

static const struct {
    struct scale_sweep about;
    void (*run)(struct bench *b, struct scale_sweep *s);
} sweeps[SWEEPS] = {
    {{.name = "Visible places",
      .id = "visible-places",
      .x = "visible places",
      .about = "`builtin:animation`, 720 x 480, the same view of a wider "
               "angle."},
     places},
    {{.name = "Lights",
      .id = "lights",
      .x = "sky.lights",
      .about = "`builtin:animation`, 720 x 480. Lights in use: without those "
               "that `quality.light_bound` leaves out."},
     lights},
    {{.name = "Strands",
      .id = "strands",
      .x = "strands of 25 points",
      .about = "Those of `builtin:straight`, thinned or multiplied; strands "
               "become thinner as they become more, so that they cover as "
               "much."},
     strands},
    {{.name = "Points a strand",
      .id = "points-a-strand",
      .x = "points of each of 10000 strands",
      .about = "10000 strands of `builtin:straight`, each of so many points."},
     points},
    {{.name = "Pixels",
      .id = "pixels",
      .x = "pixels",
      .about = "`builtin:animation`, the same view."},
     pixels},
};

// --- the report --------------------------------------------------------------

static void plot_of(const struct bench *b, const struct scale_sweep *s,
                    struct buf *path)
{
    buf_clear(path);
    buf_printf(path, "%s/scale_%s.svg%c", b->pictures, s->id, 0);
}

static void head(struct bench *b, double seconds, struct buf *out)
{
    double load = 0;
    getloadavg(&load, 1);
    buf_printf(
        out,
        "# How an edit's cost grows\n\nMade by `make bench-scale%s` in %.0f s "
        "on "
        "%s, %ld cores; load average at the end %.1f (above the number of "
        "cores times are upper estimates). 40 lights unless they are what "
        "grows; medians, one sample, no encoding. Beside each time, in "
        "brackets, "
        "that of all processors together, which other work on the machine "
        "changes least.\n\n"
        "Exponents k of x^k, fitted to the processors' time and to memory, "
        "over all and, in brackets, over the upper half of what was "
        "measured:\n\n"
        "| what grows | from, to | fibre | light colour | camera | memory |\n"
        "|---|---|---|---|---|---|\n",
        b->quick ? " ARGS=--quick" : "", seconds, b->device,
        sysconf(_SC_NPROCESSORS_ONLN), load);
    for (int i = 0; i < SWEEPS; i++)
        if (b->sweep[i].rows > 0)
            scale_summary(&b->sweep[i], out);
}

static void remarks(const struct bench *b, struct buf *out)
{
    for (int i = 0; i < SWEEPS; i++)
        for (int k = 0; k < b->sweep[i].rows; k++) {
            const struct scale_row *r = &b->sweep[i].row[k];
            if (r->refused[0])
                buf_printf(out, "\nIt ends at %s: %s.\n",
                           r->label[0] ? r->label : b->sweep[i].x, r->refused);
            if (r->strand_points >= 1000000 && !r->refused[0])
                buf_printf(out,
                           "\n%.3g million strand points: %.0f bytes of GPU "
                           "memory a point for the strands, %.4g MB in all.\n",
                           (double)r->strand_points / 1e6,
                           (double)r->strands / (double)r->strand_points,
                           (double)scale_memory(r) / 1e6);
        }
}

static void report(struct bench *b, double seconds)
{
    struct buf page = {0}, plot = {0}, path = {0};
    struct error err = {0};
    head(b, seconds, &page);
    remarks(b, &page);
    for (int i = 0; i < SWEEPS; i++) {
        const struct scale_sweep *s = &b->sweep[i];
        if (s->rows == 0)
            continue;
        buf_clear(&plot);
        scale_plot(s, b->device, &plot);
        plot_of(b, s, &path);
        must(file_write((const char *)path.data, &plot, &err), &err);
        char shown[80];
        snprintf(shown, sizeof shown, "pictures/scale_%s.svg", s->id);
        scale_section(s, shown, &page);
    }
    must(file_write(b->report, &page, &err), &err);
    buf_finish(&page);
    buf_finish(&plot);
    buf_finish(&path);
}

static bool parse(struct bench *b, int argc, char **argv)
{
    for (int i = 1; i < argc; i++) {
        const char **to = strcmp(argv[i], "--only") == 0       ? &b->only
                          : strcmp(argv[i], "--report") == 0   ? &b->report
                          : strcmp(argv[i], "--pictures") == 0 ? &b->pictures
                                                               : NULL;
        if (strcmp(argv[i], "--quick") == 0)
            b->quick = true;
        else if (to && i + 1 < argc)
            *to = argv[++i];
        else
            return false;
    }
    return !b->report == !b->pictures;
}

int main(int argc, char **argv)
{
    struct bench *b = bytes_zalloc(1, sizeof *b);
    sky_helper_main(argc, argv);
    if (!parse(b, argc, argv)) {
        fprintf(stderr, "bench_scale: [--quick] [--only WORD] [--report FILE "
                        "--pictures DIR]\n");
        return 2;
    }
    b->cache = cache_directory(); // of fits
    const double began = timer_now();
    for (int i = 0; i < SWEEPS; i++) {
        b->sweep[i] = sweeps[i].about;
        if (!b->only || strstr(sweeps[i].about.id, b->only))
            sweeps[i].run(b, &b->sweep[i]);
    }
    if (b->report)
        report(b, timer_now() - began);
    free(b->cache);
    free(b);
    return 0;
}
