// test_edit.c - the parameter table and its values as text: every bound of
// every row at, above and below; what is refused; and that what is printed
// reads back as the same value.
#include <math.h>
#include <string.h>

#include "protocol/edit.h"
#include "protocol/number.h"
#include "tests/check.h"

static struct span text(const char *s)
{
    return (struct span){(const unsigned char *)s, strlen(s)};
}

// Applies name=value to *p.
static bool set(struct params *p, const char *name, const char *value,
                struct error *err)
{
    struct line_pair pair = {.name = text(name), .value = text(value)};
    *err = (struct error){0};
    return edit_apply(p, &pair, 1, err);
}

static const char *row_name(const struct params_row *row)
{
    static char name[128];
    snprintf(name, sizeof name, "%s.%s", row->group_name, row->name);
    return name;
}

// The value as text; a static buffer.
static const char *get(const struct params *p, const struct params_row *row)
{
    static char out[128];
    struct buf b = {0};
    edit_print(&b, p, row);
    snprintf(out, sizeof out, "%.*s", (int)b.size, (const char *)b.data);
    buf_finish(&b);
    return out;
}

static bool same(const struct params *a, const struct params *b)
{
    return params_changed(a, b) == 0;
}

// A number as text, next to `v` on the side of `toward`.
static const char *beside(const struct params_row *row, double v, double toward)
{
    static char out[NUMBER_BUFFER];
    double step = row->type == PARAMS_INT ? v + (toward > v ? 1 : -1)
                                          : nextafter(v, toward);
    number_print(out, step);
    return out;
}

static bool numeric(const struct params_row *row)
{
    return row->type != PARAMS_BOOL && row->type != PARAMS_CHOICE;
}

// `value` for a row of one or three components.
static const char *spread(const struct params_row *row, const char *value)
{
    static char out[128];
    if (row->type == PARAMS_VEC3)
        snprintf(out, sizeof out, "%s,%s,%s", value, value, value);
    else
        snprintf(out, sizeof out, "%s", value);
    return out;
}

static void at_bound(const struct params_row *row, double bound, double beyond)
{
    struct params p, before;
    struct error err;
    char value[NUMBER_BUFFER];
    params_defaults(&p);
    if (row->group == GROUP_image) // both sides at once would be too much
        p.image.width = p.image.height = 1;
    before = p;
    number_print(value, bound);
    if (!CHECK(set(&p, row_name(row), spread(row, value), &err)))
        printf("  %s\n", err.text);
    CHECK((float)params_get(&p, row, 0) == (float)bound);
    for (int i = 1; i < row->count; i++)
        CHECK((float)params_get(&p, row, i) == (float)bound);
    if (row->count == 1)
        CHECK_STR(get(&p, row), value);
    p = before;
    const char *outside = beside(row, bound, beyond);
    if (!CHECK(!set(&p, row_name(row), spread(row, outside), &err)))
        printf("  %s=%s was accepted\n", row_name(row), outside);
    CHECK_STR(err.code, "range");
    CHECK_STR(err.name, row_name(row));
    CHECK(strstr(err.text, outside) != NULL);
    CHECK(same(&p, &before));
}

static void test_bounds(void)
{
    check_case("edit: every bound of every row, at it and beyond it");
    for (int r = 0; r < params_row_count; r++) {
        const struct params_row *row = &params_rows[r];
        if (!numeric(row))
            continue;
        at_bound(row, row->min, -INFINITY);
        at_bound(row, row->max, INFINITY);
    }
}

static void test_table(void)
{
    struct params p;
    params_defaults(&p);
    check_case("edit: the table is consistent with itself");
    for (int r = 0; r < params_row_count; r++) {
        const struct params_row *row = &params_rows[r];
        CHECK(params_find(row_name(row), strlen(row_name(row))) == row);
        CHECK(strlen(row_name(row)) <= LINE_NAME_MAX);
        CHECK(row->doc[0] != 0 && strlen(row->doc) < 200);
        CHECK(row->group < PARAMS_GROUPS);
        for (int i = 0; numeric(row) && i < row->count; i++)
            CHECK(isnan(row->def[i])
                      ? row->has_auto
                      : row->min <= row->def[i] && row->def[i] <= row->max);
        if (row->type == PARAMS_CHOICE)
            CHECK(edit_choice(row, (int)row->def[0]).size > 0);
    }
    CHECK(edit_choice(&params_rows[0], -1).size == 0);
    CHECK(PARAMS_GROUPS <= 32); // a mask of groups is 32 bits
}

static void test_round_trip(void)
{
    static const double parts[] = {0, 1. / 3, 0.5, 0.7071067811865476, 1};
    check_case("edit: what is printed reads back as the same value");
    for (int r = 0; r < params_row_count; r++) {
        const struct params_row *row = &params_rows[r];
        struct params p, back;
        struct error err;
        params_defaults(&p);
        params_defaults(&back);
        if (!CHECK(set(&back, row_name(row), get(&p, row), &err)))
            printf("  %s\n", err.text);
        CHECK(same(&p, &back));
        int choices = 0;
        while (edit_choice(row, choices).size > 0)
            choices++;
        int count = row->type == PARAMS_CHOICE ? choices
                    : row->type == PARAMS_BOOL ? 2
                                               : 5;
        for (int k = 0; k < count; k++) {
            for (int i = 0; i < row->count; i++) {
                double t = parts[(k + i) % 5];
                double v = row->min + (row->max - row->min) * t;
                params_put(&p, row, i, numeric(row) ? v : k);
            }
            if (row->group == GROUP_image && k > 0)
                continue; // beyond the limit of pixels
            char value[128];
            snprintf(value, sizeof value, "%s", get(&p, row));
            if (!CHECK(set(&back, row_name(row), value, &err)) ||
                !CHECK(same(&p, &back)))
                printf("  %s=%s: %s\n", row_name(row), value, err.text);
        }
        if (!row->has_auto)
            continue;
        CHECK(set(&back, row_name(row), "auto", &err));
        CHECK(isnan(params_get(&back, row, row->count - 1)));
        CHECK_STR(get(&back, row), "auto");
    }
}

static void test_refused(void)
{
    static const struct {
        const char *name, *value, *code, *text;
    } bad[] = {
        {"fibre.beta_r", "200", "range",
         "fibre.beta_r: 200 is not within [0.1, 60] deg"},
        {"fibre.eta", "1.0", "range", "fibre.eta: 1.0 is not within [1.05, 3]"},
        {"fibre.sigma_a", "1,-0.5,2", "range",
         "fibre.sigma_a: -0.5 is not within [0, 1000] 1/radius"},
        {"fibre.eta", "x", "type", "fibre.eta: \"x\" is not a number"},
        {"fibre.eta", "", "type", "fibre.eta: \"\" is not a number"},
        {"fibre.eta", "nan", "type", "fibre.eta: \"nan\" is not a number"},
        {"fibre.eta", "inf", "type", "fibre.eta: \"inf\" is not a number"},
        {"fibre.eta", "auto", "type", "fibre.eta: \"auto\" is not a number"},
        {"fibre.eta", "1,2,3", "type", "fibre.eta: \"1,2,3\" is not a number"},
        {"fibre.alpha_tt", "x", "type",
         "fibre.alpha_tt: \"x\" is not a number or auto"},
        {"fibre.sigma_a", "1,2", "type",
         "fibre.sigma_a: \"1,2\" is not a number, or three joined by commas,"},
        {"fibre.sigma_a", "1,2,3,4", "type",
         "fibre.sigma_a: \"1,2,3,4\" is not a number, or three joined by "
         "commas,"},
        {"fibre.sigma_a", "1,,3", "type", NULL},
        {"fibre.sigma_a", ",", "type", NULL},
        {"fibre.sigma_a", "1,2,", "type", NULL},
        {"fibre.sigma_a", "auto", "type", NULL},
        {"camera.eye", "1", "type",
         "camera.eye: 1 is not three numbers joined by commas or auto"},
        {"camera.eye", "auto,auto,auto", "type", NULL},
        {"camera.eye", "1, 2, 3", "type", NULL},
        {"image.width", "1.5", "type",
         "image.width: 1.5 is not a whole number"},
        {"image.width", "wide", "type",
         "image.width: \"wide\" is not a whole number"},
        {"image.width", "1e300", "range",
         "image.width: 1e300 is not within [1, 8192] pixels"},
        {"view.head", "yes", "type", "view.head: \"yes\" is not on or off"},
        {"view.head", "2", "type", "view.head: 2 is not on or off"},
        {"output.format", "gif", "type",
         "output.format: \"gif\" is not one of jpeg, png, exr"},
        {"output.format", "JPEG", "type", NULL},
        {"output.format", "jpe", "type", NULL},
        {"output.format", "", "type", NULL},
        {"output.format", "jpeg|png", "type", NULL},
        {"fibre.beta_q", "1", "unknown",
         "fibre.beta_q: no such parameter; did you mean fibre.beta_r?"},
        {"sigma_a", "1", "unknown",
         "sigma_a: no such parameter; did you mean fibre.sigma_a?"},
        {"fiber.eta", "1.5", "unknown",
         "fiber.eta: no such parameter; did you mean fibre.eta?"},
        {"wholly.different", "1", "unknown",
         "wholly.different: no such parameter; `schema` lists them all"},
        {"fibre", "1", "unknown", NULL},
        {"fibre.", "1", "unknown", NULL},
        {".eta", "1", "unknown", NULL},
        {"", "1", "unknown", NULL},
    };
    check_case("edit: refusals name the thing, the value and what is legal");
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        struct params p, before;
        struct error err;
        params_defaults(&p);
        before = p;
        if (!CHECK(!set(&p, bad[i].name, bad[i].value, &err)))
            printf("  %s=%s was accepted\n", bad[i].name, bad[i].value);
        CHECK_STR(err.code, bad[i].code);
        CHECK_STR(err.name, bad[i].name);
        if (bad[i].text)
            CHECK_STR(err.text, bad[i].text);
        CHECK(same(&p, &before));
    }
}

static void test_long_values(void)
{
    struct params p;
    struct error err;
    char value[2000];
    check_case("edit: an endless value or name makes a short error");
    params_defaults(&p);
    memset(value, 'x', sizeof value);
    value[sizeof value - 1] = 0;
    CHECK(!set(&p, "fibre.eta", value, &err));
    CHECK(strlen(err.text) < 100 && strstr(err.text, "x...\" is not a number"));
    CHECK(!set(&p, value, "1", &err));
    CHECK_STR(err.code, "unknown");
    // Cut between characters: U+20AC has three bytes, 40 is not a multiple.
    for (size_t i = 0; i + 3 < sizeof value; i += 3)
        memcpy(value + i, "\xe2\x82\xac", 4);
    CHECK(!set(&p, "fibre.eta", value, &err));
    CHECK(strstr(err.text, "\xac...\" is not") != NULL);
}

static void test_accepted(void)
{
    struct params p;
    struct error err;
    params_defaults(&p);
    check_case("edit: forms of a value");
    CHECK(set(&p, "fibre.sigma_a", "2", &err));
    CHECK(p.fibre.sigma_a[0] == 2 && p.fibre.sigma_a[1] == 2 &&
          p.fibre.sigma_a[2] == 2);
    CHECK(set(&p, "fibre.sigma_a", "0.2,0.3,0.5", &err));
    CHECK(p.fibre.sigma_a[0] == 0.2f && p.fibre.sigma_a[1] == 0.3f &&
          p.fibre.sigma_a[2] == 0.5f);
    CHECK(set(&p, "camera.eye", "-1e2,0,+2.5", &err));
    CHECK(p.camera.eye[0] == -100 && p.camera.eye[1] == 0 &&
          p.camera.eye[2] == 2.5f);
    CHECK(set(&p, "image.width", "1e2", &err) && p.image.width == 100);
    CHECK(set(&p, "image.width", "64.0", &err) && p.image.width == 64);
    static const char *const on[] = {"on", "true", "1"};
    static const char *const off[] = {"off", "false", "0"};
    for (int i = 0; i < 3; i++) {
        CHECK(set(&p, "view.head", off[i], &err) && p.view.head == 0);
        CHECK(set(&p, "view.head", on[i], &err) && p.view.head == 1);
    }
    CHECK(set(&p, "output.format", "exr", &err) && p.output.format == 2);
    CHECK(edit_apply_text(&p, "light.yaw=-360", &err) && p.light.yaw == -360);
    CHECK(!edit_apply_text(&p, "light.yaw", &err));
    CHECK_STR(err.text, "\"light.yaw\" is not of the form group.name=value");
    CHECK(!edit_apply_text(&p, "light.yaw=\x80", &err));
    CHECK(!edit_apply_text(&p, "=", &err));
    CHECK(edit_apply(&p, NULL, 0, &err));
}

static void test_all_or_none(void)
{
    struct params p, before;
    struct error err;
    check_case("edit: all pairs or none");
    params_defaults(&p);
    before = p;
    struct line_pair pairs[] = {
        {.name = text("fibre.eta"), .value = text("1.6")},
        {.name = text("light.yaw"), .value = text("30")},
        {.name = text("fibre.beta_r"), .value = text("200")},
    };
    CHECK(!edit_apply(&p, pairs, 3, &err) && same(&p, &before));
    CHECK(edit_apply(&p, pairs, 2, &err));
    CHECK(p.fibre.eta == 1.6f && p.light.yaw == 30);
    CHECK(params_changed(&p, &before) ==
          (1u << GROUP_fibre | 1u << GROUP_light));
    CHECK(!edit_apply(&p, pairs, 3, NULL));
}

static void test_pixels(void)
{
    struct params p;
    struct error err = {0};
    check_case("edit: the limit of pixels holds for both sides together");
    params_defaults(&p);
    struct line_pair pairs[] = {
        {.name = text("image.width"), .value = text("8192")},
        {.name = text("image.height"), .value = text("4028")},
    };
    CHECK(edit_apply(&p, pairs, 2, &err)); // 32,997,376
    CHECK(!set(&p, "image.height", "4029", &err));
    CHECK_STR(err.code, "range");
    CHECK_STR(err.text, "image: 8192 x 4029 is 33.0 megapixels, more than the "
                        "33 that a picture may have");
    CHECK(p.image.height == 4028);
    // In one line the order of the two does not matter.
    struct line_pair swap[] = {
        {.name = text("image.height"), .value = text("8192")},
        {.name = text("image.width"), .value = text("4028")},
    };
    CHECK(edit_apply(&p, swap, 2, &err));
    CHECK(p.image.width == 4028 && p.image.height == 8192);
}

static void test_size(void)
{
    static const struct {
        const char *text, *code;
    } bad[] = {
        {"", "type"},        {"720", "type"},        {"720x", "type"},
        {"x480", "type"},    {"720X480", "type"},    {"720x480x3", "type"},
        {"7.5x4", "type"},   {"-720x480", "type"},   {" 720x480", "type"},
        {"0x480", "range"},  {"720x0", "range"},     {"8193x1", "range"},
        {"1x8193", "range"}, {"8192x8192", "range"}, {"99999999999x1", "type"},
    };
    int w = 0, h = 0;
    struct error err = {0};
    check_case("edit: sizes");
    CHECK(edit_size(text("720x480"), "size", &w, &h, &err));
    CHECK(w == 720 && h == 480);
    CHECK(edit_size(text("1x1"), "size", &w, &h, &err) && w == 1 && h == 1);
    CHECK(edit_size(text("8192x4028"), "size", &w, &h, &err) && w == 8192);
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        CHECK(!edit_size(text(bad[i].text), "size", &w, &h, &err));
        CHECK_STR(err.code, bad[i].code);
        CHECK_STR(err.name, "size");
    }
    CHECK(w == 8192 && h == 4028);
}

static void test_linked(void)
{
    struct params p;
    struct error err;
    check_case("params: linked fibre values follow until they are set");
    params_defaults(&p);
    CHECK(set(&p, "fibre.alpha_r", "-6", &err));
    CHECK(set(&p, "fibre.beta_r", "50", &err));
    CHECK(set(&p, "fibre.alpha_trt", "4", &err));
    params_fibre_resolve(&p);
    CHECK(p.fibre.alpha_tt == 3 && p.fibre.alpha_trt == 4);
    CHECK(p.fibre.beta_tt == 25 && p.fibre.beta_trt == 60);
    check_case("params: auto equals auto");
    struct params a, b;
    params_defaults(&a);
    params_defaults(&b);
    CHECK(params_changed(&a, &b) == 0);
    CHECK(set(&b, "camera.eye", "0,0,0", &err));
    CHECK(params_changed(&a, &b) == 1u << GROUP_camera);
}

int main(void)
{
    test_table();
    test_bounds();
    test_round_trip();
    test_refused();
    test_long_values();
    test_accepted();
    test_all_or_none();
    test_pixels();
    test_size();
    test_linked();
    return check_end();
}
