// Fronts as text and back, damaged ones, which is the nearest, and how one
// comes out of what was measured.
#include "server/bench_front.h"
#include "server/front.h"
#include "tests/check.h"

#include <math.h>
#include <stdlib.h>
#include <unistd.h>

#define MAGIC "glint.front 1\n"
#define FRONT(hair, env, device, strands) \
    "front device=\"" device "\" cores=2 scene=\"s, t\" hair=\"" hair \
    "\" env=\"" env "\" strands=" strands "\n"
#define TIMES " fibre_ms=10 sky_ms=100 camera_ms=50 rest_ms=90 error=0.5\n"

static struct span span_of(const char *text)
{
    return (struct span){(const unsigned char *)text, strlen(text)};
}

// --- text --------------------------------------------------------------------

static void round_trip(void)
{
    static const char text[] =
        FRONT("ab", "cd", "a \\\"b\\\\",
              "6000") "row shadow.rays=0 fibre_ms=10 sky_ms=100 camera_ms=50 "
                      "rest_ms=10 "
                      "error=0.75\n"
                      "row sky.lights=5 quality.light_bound=0.02 "
                      "shadow.resolution=64 "
                      "shadow.directions=coarse fibre_ms=1.5 sky_ms=2 "
                      "camera_ms=3 rest_ms=4 "
                      "error=1.25\n";
    struct buf whole = {0}, again = {0};
    struct fronts f = {0};
    struct error err = {0};
    buf_printf(&whole, "%s# a remark\n\n%s", MAGIC, text);
    CHECK(fronts_parse(&f, (struct span){whole.data, whole.size}, "x", &err));
    CHECK(f.count == 1 && f.item[0].rows == 2);
    CHECK_STR(f.item[0].device, "a \"b\\");
    CHECK(f.item[0].strands == 6000 && f.item[0].cores == 2);
    const struct front_row *r = &f.item[0].row[1];
    CHECK(r->knob[FRONT_LIGHTS] == 5 && r->knob[FRONT_RESOLUTION] == 64 &&
          r->knob[FRONT_DIRECTIONS] == 0 && r->knob[FRONT_RAYS] == 1);
    CHECK(r->first_ms[FRONT_CAMERA] == 3 && r->rest_ms == 4 &&
          r->error == 1.25);
    front_print(&f.item[0], &again);
    buf_byte(&again, 0);
    CHECK_STR((const char *)again.data, text);
    buf_finish(&whole);
    buf_finish(&again);
    fronts_finish(&f);
}

static void refused(const char *text, const char *why)
{
    struct fronts f = {0};
    struct error err = {0};
    CHECK(!fronts_parse(&f, span_of(text), "file", &err));
    CHECK(f.count == 0 && f.item == NULL);
    CHECK(strstr(err.text, why) != NULL);
    if (!strstr(err.text, why))
        printf("  %s\n", err.text);
}

#define ONE MAGIC FRONT("ab", "cd", "d", "6000")
static void damaged(void)
{
    refused("", "file:1:");
    refused("glint.front 9\n", "this version");
    refused(MAGIC "row" TIMES, "file:2: a row before");
    refused(ONE, "without a row");
    refused(ONE "row" TIMES "row fibre_ms=1", "no end");
    refused(ONE "row fibre_ms=1 sky_ms=1 camera_ms=1 error=1\n", "rest_ms");
    refused(ONE "row sky.lights=4000" TIMES, "file:3: sky.lights: 4000");
    refused(ONE "row fibre.eta=1.5" TIMES, "'fibre.eta' belongs to no");
    refused(ONE "row shadow.directions=fast" TIMES, "shadow.directions");
    refused(ONE "row fibre_ms=0 sky_ms=1 camera_ms=1 rest_ms=1 error=1\n",
            "fibre_ms is not");
    refused(ONE "row fibre_ms=nan sky_ms=1 camera_ms=1 rest_ms=1 error=1\n",
            "fibre_ms is not");
    refused(ONE "row fibre_ms=1 sky_ms=1 camera_ms=1 rest_ms=1 error=1e9\n",
            "error is not");
    refused(ONE "stone" TIMES, "neither front nor row");
    refused(ONE "row loose" TIMES, "no pair");
    refused(MAGIC "front device=d cores=2\n", "there is no scene=");
    struct buf many = {0};
    buf_text(&many, ONE);
    for (int i = 0; i <= FRONT_ROWS_MAX; i++)
        buf_text(&many, "row" TIMES);
    buf_byte(&many, 0);
    refused((const char *)many.data, "more rows");
    buf_finish(&many);
}

static void files(void)
{
    char path[] = "/tmp/glint-front-XXXXXX";
    struct fronts f = {0};
    struct error err = {0};
    const int fd = mkstemp(path);
    CHECK(fd >= 0 && ftruncate(fd, FRONT_BYTES_MAX + 1) == 0);
    CHECK(!fronts_load(&f, path, &err) && strcmp(err.code, "limit") == 0);
    CHECK(ftruncate(fd, 0) == 0 && !fronts_load(&f, path, &err));
    CHECK(strcmp(err.code, "front") == 0 && strstr(err.text, path));
    CHECK(!fronts_open(&f, path, &err)); // one that was asked for
    CHECK(write(fd, ONE "row" TIMES, strlen(ONE "row" TIMES)) > 0);
    fronts_finish(&f);
    CHECK(fronts_open(&f, path, &err) && f.count > 0 && !f.item[0].shipped);
    close(fd);
    unlink(path);
    fronts_finish(&f);
    CHECK(!fronts_load(&f, path, &err) && strcmp(err.code, "file") == 0);
}

static void nearest(void)
{
    static const char text[] = MAGIC                           //
        FRONT("h1", "e1", "here", "1000") "row" TIMES          //
            FRONT("h2", "e1", "here", "8000") "row" TIMES      //
                FRONT("h2", "e1", "there", "8000") "row" TIMES //
                    FRONT("h2", "e2", "there", "8000") "row" TIMES;
    struct fronts f = {0};
    CHECK(fronts_nearest(&f, &(struct front_scene){"d", "h", "e", 1}) == NULL);
    CHECK(fronts_parse(&f, span_of(text), "x", NULL));
    const struct {
        struct front_scene scene;
        int is;
    } cases[] = {
        {{"here", "h1", "e1", 1000}, 0},  // the very scene
        {{"else", "h1", "e1", 90000}, 0}, // on another machine
        {{"here", "h9", "e1", 1500}, 0},  // strands
        {{"here", "h9", "e1", 5000}, 1},
        {{"there", "h9", "e1", 90000}, 2}, // the machine, all else alike
        {{"here", "h2", "e2", 8000}, 3},   // the sky before the machine
        {{"here", "h9", "e1", 0}, 0},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
        CHECK(fronts_nearest(&f, &cases[i].scene) == f.item + cases[i].is);
    fronts_finish(&f);
}

// --- out of what was measured ------------------------------------------------

static void settings(void)
{
    static struct bench_setting list[BENCH_KNOBS_MAX];
    struct params base;
    params_defaults(&base);
    base.fibre.eta = 1.7f; // not a knob's: it stays
    base.sky.lights = 7;   // a knob's: it does not
    const int n = bench_front_list(&base, NULL, list);
    CHECK(n > 20 && n <= FRONT_ROWS_MAX && n <= BENCH_KNOBS_MAX);
    CHECK_STR(list[0].text, "shadow.rays=0");
    CHECK_STR(list[1].text, "default");
    for (int i = 0; i < n; i++) {
        struct params *p = &list[i].params;
        CHECK(p->fibre.eta == 1.7f && p->sky.lights != 7);
        for (int k = 0; k < i; k++)
            CHECK(params_changed(&list[k].params, p) != 0);
        // after its own without rays
        for (int k = 0; k < FRONT_RAYS && p->shadow.rays > 0; k++)
            CHECK(front_knob(p, k) == front_knob(&list[i - 1].params, k));
    }
    const int few = bench_front_list(&base, "shadow.directions", list);
    CHECK(few == 4 && strstr(list[3].text, "shadow.directions=coarse"));
}

static struct bench_times times(double least, double cpu, double crowd)
{
    return (struct bench_times){
        .runs = 3, .least = least, .cpu = cpu, .crowd = crowd};
}

// Two settings without rays, one with; a row whose error is not known.
static void measured(void)
{
    static struct bench_setting list[BENCH_KNOBS_MAX];
    struct bench_row row[4] = {0};
    struct params base;
    params_defaults(&base);
    bench_front_list(&base, NULL, list);
    const int from[] = {0, 1, 3, 4};
    for (int i = 0; i < 4; i++) {
        row[i].setting = &list[from[i]];
        row[i].whole.rel_rmse.value = i == 3 ? (double)NAN : 0.5 + i;
        row[i].time[BENCH_EDIT_FIBRE] = times(100 + i, 90 + i, 0.5);
        if (i % 2 == 0) {
            row[i].time[BENCH_EDIT_SKY] = times(300, 100, 0.1);
            row[i].time[BENCH_EDIT_CAMERA] = times(200, 150, 1.5);
        }
    }
    row[2].time[BENCH_EDIT_FIBRE].crowd = 1.8;
    struct bench_result b = {.name = "a, b",
                             .strands = 9,
                             .row = row,
                             .rows = 4,
                             .device = "some llvmpipe"};
    const struct bench_front_scene scene = {"h", "e", 2};
    struct front *f = bytes_zalloc(1, sizeof *f);
    bench_front_make(&b, &scene, f);
    CHECK(f->rows == 3 && f->cores == 2 && f->strands == 9);
    // processor time over the 1.8 processors of the best run of that kind
    CHECK(fabs(f->row[0].first_ms[FRONT_FIBRE] - 90 / 1.8) < 1e-9);
    CHECK(fabs(f->row[1].rest_ms - 91 / 1.8) < 1e-9);
    CHECK(f->row[1].first_ms[FRONT_FIBRE] == f->row[0].rest_ms);
    CHECK(f->row[1].first_ms[FRONT_SKY] == 300); // no more than the clock's
    CHECK(fabs(f->row[2].first_ms[FRONT_CAMERA] - 100) < 1e-9);
    CHECK(f->row[2].knob[FRONT_LIGHTS] == 20 && f->row[2].error == 2.5);
    b.device = "a card"; // there processors' time says nothing
    bench_front_make(&b, &scene, f);
    CHECK(f->row[0].first_ms[FRONT_FIBRE] == 100 && f->row[1].rest_ms == 101);
    free(f);
}

int main(void)
{
    check_case("a front as text and back");
    round_trip();
    check_case("damaged fronts are refused with the line, nothing is taken");
    damaged();
    check_case("files: missing, too large, empty, good");
    files();
    check_case("the nearest front");
    nearest();
    check_case("the settings that are measured");
    settings();
    check_case("a front out of what was measured");
    measured();
    return check_end();
}
