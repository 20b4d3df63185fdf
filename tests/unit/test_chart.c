// The chart: which points are on the front, that no label lies on another or
// on a point, whatever is thrown at it, and that the SVG is well formed enough
// to count its parts.
#include "server/chart.h"

#include <stdlib.h>

#include "server/chart_rows.h"

#include "tests/check.h"

static struct chart_point points[CHART_POINTS_MAX];
static char names[CHART_POINTS_MAX][40];

static unsigned state = 3;
static double uniform(void)
{
    state = state * 1664525u + 1013904223u;
    return (double)(state >> 8) / 16777216.0;
}

static void front(void)
{
    // times, errors; the front by eye: 0, 2, 5 and 6 (equal to 5)
    const double xy[][2] = {{10, 0.5}, {20, 0.6},  {20, 0.3}, {30, 0.3},
                            {15, 0.5}, {80, 0.01}, {80, 0.01}};
    const bool want[] = {true, false, true, false, false, true, true};
    struct chart_point p[8] = {0};
    check_case("the front of seven points");
    for (int i = 0; i < 7; i++)
        p[i] = (struct chart_point){.x = xy[i][0], .y = xy[i][1]};
    p[7] = (struct chart_point){.x = 1, .y = NAN}; // says nothing, stops nobody
    chart_front(p, 8);
    for (int i = 0; i < 7; i++)
        CHECK(p[i].front == want[i]);
    CHECK(!p[7].front);
}

struct box {
    double x0, y0, x1, y1;
};

static bool apart(const struct box *a, const struct box *b)
{
    return a->x0 >= b->x1 || b->x0 >= a->x1 || a->y0 >= b->y1 || b->y0 >= a->y1;
}

// Boxes of the labels: 6.02 a character, 8 above and 2 below the base line.
static int labels_of(const char *svg, struct box *out)
{
    int n = 0;
    const char *at = svg;
    while ((at = strstr(at, "<text class=\"label\""))) {
        double x = 0, y = 0;
        CHECK(sscanf(at, "<text class=\"label\" x=\"%lf\" y=\"%lf\"", &x, &y) ==
              2);
        const char *from = strchr(at, '>') + 1, *to = strchr(from, '<');
        int length = 0;
        for (const char *c = from; c < to; c++, length++)
            if (*c == '&')
                c = strchr(c, ';');
        out[n++] = (struct box){x, y - 8, x + 6.02 * length, y + 2};
        at = to;
    }
    return n;
}

static int count(const char *text, const char *what)
{
    int n = 0;
    for (; (text = strstr(text, what)); text++)
        n++;
    return n;
}

static void draw(int n, double spread, struct buf *out)
{
    for (int i = 0; i < n; i++) {
        snprintf(names[i], sizeof names[i], "render.knob=%d", i * i * 37);
        points[i] = (struct chart_point){.x = 150 * exp(spread * uniform()),
                                         .y = 0.1 * exp(spread * uniform()),
                                         .low = 0.09,
                                         .high = 0.12,
                                         .label = names[i],
                                         .group = i % 7};
    }
    struct chart c = {.title = "a < b & c",
                      .x_title = "ms",
                      .y_title = "error",
                      .groups = {"one", "two"},
                      .point = points,
                      .count = n};
    buf_clear(out);
    chart_svg(&c, out);
    buf_byte(out, 0);
}

static void labels(void)
{
    static struct box box[CHART_POINTS_MAX];
    struct buf out = {0};
    check_case("labels stand apart: scattered, crowded, all in one place");
    for (int round = 0; round < 60; round++) {
        const int n = 1 + round * 40 / 59; // as many as the column holds
        draw(n, round % 3 == 0 ? 3 : round % 3 == 1 ? 0.2 : 0, &out);
        const char *svg = (const char *)out.data;
        CHECK(labels_of(svg, box) == n);
        for (int i = 0; i < n; i++) {
            CHECK(box[i].x0 >= 64 && box[i].x1 <= 1000);
            CHECK(box[i].y0 >= 40 && box[i].y1 <= 580);
            for (int k = 0; k < i; k++)
                CHECK(apart(&box[i], &box[k]));
        }
    }
    check_case("texts are escaped; every element is closed");
    const char *svg = (const char *)out.data;
    CHECK(strstr(svg, "a &lt; b &amp; c") && !strstr(svg, "a < b"));
    CHECK(count(svg, "<text") == count(svg, "</text>"));
    CHECK(count(svg, "<svg") == 1 && count(svg, "</svg>") == 1);
    CHECK(!strstr(svg, "nan") && !strstr(svg, "inf"));
    check_case("an interval's bar ends at the frame");
    points[0] = (struct chart_point){
        .x = 1, .y = 1, .low = 1e-9, .high = 1e9, .label = "wide"};
    struct chart wide = {.point = points, .count = 1};
    buf_clear(&out);
    chart_svg(&wide, &out);
    buf_byte(&out, 0);
    CHECK(strstr((const char *)out.data, " 572.0V48.0\""));
    check_case("no point, and points that cannot be drawn");
    draw(0, 1, &out);
    CHECK(count((const char *)out.data, "class=\"label\"") == 0);
    points[0] = (struct chart_point){.x = 0, .y = 1, .label = "zero"};
    points[1] = (struct chart_point){.x = 1, .y = INFINITY, .label = "far"};
    struct chart c = {.point = points, .count = 2};
    buf_clear(&out);
    chart_svg(&c, &out);
    buf_byte(&out, 0);
    svg = (const char *)out.data;
    CHECK(count(svg, "class=\"label\"") == 0 && !strstr(svg, "inf"));
    buf_finish(&out);
}

// Growth: one line a group, through its points, and no front.
static void series(void)
{
    struct buf out = {0};
    struct chart_point p[6];
    check_case("series are joined, without front and labels");
    for (int i = 0; i < 6; i++)
        p[i] = (struct chart_point){.x = 1 + i % 3,
                                    .y = i == 4 ? (double)NAN : 1 + i,
                                    .low = NAN,
                                    .high = NAN,
                                    .label = "",
                                    .group = i / 3};
    struct chart c = {
        .groups = {"a", "b"}, .point = p, .count = 6, .series = true};
    chart_svg(&c, &out);
    buf_byte(&out, 0);
    const char *svg = (const char *)out.data;
    CHECK(count(svg, "fill=\"none\" stroke=\"#1b6ca8\"") == 1);
    CHECK(count(svg, "fill=\"none\" stroke=\"#c2410c\"") == 1);
    CHECK(!strstr(svg, "Pareto") && !strstr(svg, "nan"));
    CHECK(count(svg, "class=\"label\"") == 0);
    buf_finish(&out);
}

// x of the first number after `what`.
static double number_after(const char *svg, const char *what)
{
    const char *at = strstr(svg, what);
    return at ? strtod(at + strlen(what), NULL) : NAN;
}

static void rows(void)
{
    struct buf out = {0};
    const struct chart_row row[] = {
        {"edit < & one", 0, 10, 20, 40, 15, 2000},
        {NULL, 1, 100, 200, 400, NAN, NAN},
        {"not measured", 1, NAN, NAN, NAN, 33, NAN},
    };
    const struct chart_rows c = {.title = "t",
                                 .note = "n",
                                 .x_title = "ms",
                                 .groups = {"a", "b"},
                                 .target = "target",
                                 .other = "other",
                                 .row = row,
                                 .count = 3};
    check_case("rows: a dot for each median, targets where there are any");
    chart_rows_svg(&c, &out);
    buf_byte(&out, 0);
    const char *svg = (const char *)out.data;
    CHECK(count(svg, "<circle") == 2 + 2);                  // and the legend's
    CHECK(count(svg, "stroke-width=\"3\"/>") == 2 + 2 + 1); // bars, targets
    CHECK(strstr(svg, "edit &lt; &amp; one") && strstr(svg, "not measured"));
    CHECK(count(svg, "<text") == count(svg, "</text>"));
    CHECK(!strstr(svg, "nan") && !strstr(svg, "inf"));
    check_case("... and time is logarithmic");
    const char *bar = strstr(svg, "stroke-opacity");
    const double a = number_after(bar, "<circle cx=\"");
    const double b =
        number_after(strstr(bar + 1, "stroke-opacity"), "<circle cx=\"");
    const double x = number_after(svg, "<path d=\"M"); // ticks: 10, 20, 50, ...
    CHECK(strstr(svg, ">10</text>") && strstr(svg, ">1000</text>"));
    CHECK_NEAR(a - x, 0.30103 * (b - a), 0.2); // 20/10 and 200/20; rounded
    buf_finish(&out);
}

int main(void)
{
    front();
    labels();
    series();
    rows();
    return check_end();
}
