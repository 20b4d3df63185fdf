// The list of settings that `glintd bench` compares, and the arrays that it
// keeps on disk.
#include "server/bench_keep.h"
#include "server/bench_kinds.h"
#include "server/bench_knobs.h"

#include <stdlib.h>
#include <sys/stat.h>
#include <unistd.h>

#include "protocol/bytes.h"
#include "tests/check.h"

static struct bench_setting list[BENCH_KNOBS_MAX];

static const struct bench_setting *find(int n, const char *text)
{
    for (int i = 0; i < n; i++)
        if (strcmp(list[i].text, text) == 0)
            return &list[i];
    return NULL;
}

static void settings(void)
{
    struct params base;
    struct bench_choice all = {.first = true};
    params_defaults(&base);
    base.quality.samples = 1;
    base.shadow.rays = 0;
    const int n = bench_knobs_list(&base, &all, list);
    check_case("every knob that there is becomes settings");
    CHECK(n > 25 && n < BENCH_KNOBS_MAX);
    CHECK_STR(list[0].text, "default");
    CHECK(params_changed(&list[0].params, &base) == 0);
    const struct bench_setting *s = find(n, "sky.lights=5");
    CHECK(s && s->params.sky.lights == 5 && s->flags & BENCH_KNOBS_SKY);
    s = find(n, "shadow.method=off");
    CHECK(s && s->params.shadow.method == 0);
    s = find(n, "shadow.rays=16");
    CHECK(s && s->params.shadow.rays == 16 && s->params.quality.samples == 1);
    s = find(n, "render.multiple=off");
    CHECK(s && s->params.render.multiple == 0);
    s = find(n, "quality.samples=64");
    CHECK(s && s->flags & BENCH_KNOBS_PICTURE);
    int segments = 0;
    for (int i = 0; i < n; i++)
        segments += strcmp(list[i].group, "segments") == 0 &&
                    list[i].params.render.m == 200;
    CHECK(segments == 2);
    check_case(
        "no setting twice; each differs from the base; groups are known");
    for (int i = 1; i < n; i++) {
        CHECK(params_changed(&list[i].params, &base) != 0);
        CHECK(bench_knobs_group(list[i].group) > 0);
        for (int k = 0; k < i; k++)
            CHECK(params_changed(&list[i].params, &list[k].params) != 0);
    }
    check_case("quick, not first, only");
    struct bench_choice quick = {.quick = true, .first = true};
    const int few = bench_knobs_list(&base, &quick, list);
    CHECK(few > 5 && few < n && find(few, "sky.lights=5"));
    struct bench_choice later = {.first = false};
    CHECK(bench_knobs_list(&base, &later, list) == n - 2); // m = 200, twice
    struct bench_choice only = {.first = true, .only = "shadow.method,rays"};
    const int some = bench_knobs_list(&base, &only, list);
    CHECK(some >= 5 && some < n && find(some, "shadow.method=off") &&
          find(some, "shadow.rays=4") && find(some, "default"));
    for (int i = 1; i < some; i++)
        CHECK(strstr(list[i].text, "rays") || strstr(list[i].text, "method"));
}

static struct bench_keep keep(const char *directory, const char *key)
{
    struct bench_keep k = {.directory = directory};
    digest_begin(&k.key);
    digest_add(&k.key, (struct span){(const unsigned char *)key, strlen(key)});
    return k;
}

static void keeping(void)
{
    char directory[] = "/tmp/glint-keep-XXXXXX", command[240];
    const double values[4] = {1, -2, 1e300, 0.1};
    double back[4] = {0};
    check_case("arrays are found again by their key, and whole or not at all");
    if (!mkdtemp(directory)) {
        check_skip("no temporary directory");
        return;
    }
    struct bench_keep a = keep(directory, "a"), b = keep(directory, "b");
    CHECK(!bench_keep_load(&a, back, 4));
    bench_keep_save(&a, values, 4);
    CHECK(bench_keep_load(&a, back, 4) && memcmp(back, values, 32) == 0);
    CHECK(!bench_keep_load(&b, back, 4));
    CHECK(!bench_keep_load(&a, back, 3)); // of another size
    snprintf(command, sizeof command,
             "printf X | dd of=$(echo %s/*) seek=9 "
             "bs=1 conv=notrunc 2>/dev/null",
             directory);
    CHECK(system(command) == 0);
    CHECK(!bench_keep_load(&a, back, 4)); // a byte was changed
    snprintf(command, sizeof command, "truncate -s 40 %s/*", directory);
    CHECK(system(command) == 0);
    CHECK(!bench_keep_load(&a, back, 4));
    bench_keep_save(&a, values, 4);
    CHECK(bench_keep_load(&a, back, 4));
    check_case("no directory keeps nothing and fails nothing");
    struct bench_keep none = keep(NULL, "a"), gone = keep("/proc/nowhere", "a");
    bench_keep_save(&none, values, 4);
    bench_keep_save(&gone, values, 4);
    CHECK(!bench_keep_load(&none, back, 4) && !bench_keep_load(&gone, back, 4));
    snprintf(command, sizeof command, "rm -r %s", directory);
    CHECK(system(command) == 0);
}

static bool within(const struct params *p)
{
    for (int i = 0; i < params_row_count; i++)
        for (int c = 0; c < params_rows[i].count; c++) {
            const double v = params_get(p, &params_rows[i], c);
            if (params_rows[i].max > params_rows[i].min &&
                (v < params_rows[i].min || v > params_rows[i].max))
                return false;
        }
    return true;
}

// The edits that --edits times.
static void kinds(void)
{
    struct params base;
    int count = 0, targets = 0;
    const struct bench_kind *kind = bench_kinds(&count);
    const struct bench_kinds_scene scene = {{0, -10, 2}, {0, 0, 1}};
    params_defaults(&base);
    check_case("every round of fibre edits has each parameter once, shuffled");
    bool sorted = true;
    for (int round = 0; round < 4; round++) {
        int seen[BENCH_KINDS_FIBRE] = {0};
        for (int i = 0; i < BENCH_KINDS_FIBRE; i++) {
            const int at = bench_kinds_fibre_at(round * BENCH_KINDS_FIBRE + i);
            seen[at]++;
            sorted &= at == i;
        }
        for (int i = 0; i < BENCH_KINDS_FIBRE; i++)
            CHECK(seen[i] == 1);
    }
    CHECK(!sorted);
    check_case("an edit is legal, no other than the one before, of its group");
    for (int k = 0; k < count; k++) {
        struct params before = base;
        targets += !isnan(kind[k].target[0]);
        for (int i = 0; kind[k].edit && i < 60; i++) {
            struct params p = base;
            kind[k].edit(&scene, &p, i);
            const uint32_t groups = params_changed(&p, &base);
            CHECK(within(&p) && (groups & (groups - 1)) == 0);
            CHECK(params_changed(&p, &before) != 0);
            before = p;
        }
    }
    CHECK(targets == count && count > 15);
    check_case("the paper's scenes are built-in grooms");
    for (int i = 0; i < 6; i++)
        CHECK(bench_kinds_paper_of(bench_kinds_paper[i].hair) ==
              &bench_kinds_paper[i]);
    CHECK(bench_kinds_scene("straight") == 1 && bench_kinds_scene("bob") < 0);
}

int main(void)
{
    settings();
    kinds();
    keeping();
    return check_end();
}
