// test_needs.c - what params.def says that parameters need: without it they
// move not one bit of the picture, with it they do.
#include <stdlib.h>

#include "protocol/edit.h"
#include "tests/check.h"
#include "tests/render/scene.h"

// One of the things needed: "render.scheme=paper|best" up to " or ".
struct need {
    const struct params_row *row; // NULL: an option, which no edit gives
    const char *words;            // NULL: not 0
};

static const char *next_need(const char *at, struct need *n)
{
    const size_t name = strcspn(at, "= "), all = name + strcspn(at + name, " ");
    n->row = params_find(at, name);
    n->words = at[name] == '=' ? at + name + 1 : NULL;
    CHECK(n->row || strncmp(at, "--", 2) == 0);
    return strncmp(at + all, " or ", 4) == 0 ? at + all + 4 : NULL;
}

static bool is_word(const struct need *n, struct span word)
{
    for (const char *w = n->words; w; w += *w == '|') {
        const size_t size = strcspn(w, "| ");
        if (size == word.size && memcmp(w, word.data, size) == 0)
            return true;
        w += size;
        if (*w != '|')
            break;
    }
    return false;
}

// Makes it hold, in the way of that number, or not hold (< 0); false: there is
// no such way.
static bool settle(struct params *p, const struct need *n, int way)
{
    if (!n->row)
        return way < 0;
    if (!n->words) {
        params_put(p, n->row, 0, way < 0 ? 0 : 2);
        return way < 1;
    }
    for (int i = 0; edit_choice(n->row, i).size > 0; i++) {
        const bool holds = is_word(n, edit_choice(n->row, i));
        if (holds != (way >= 0) || (holds && way-- > 0))
            continue;
        params_put(p, n->row, 0, i);
        return true;
    }
    return false;
}

static void picture(struct renderer *r, const struct params *p,
                    struct buf out[2])
{
    renderer_set_params(r, p);
    out[0] = scene_linear(r);
    out[1] = scene_display(r);
}

// Does another value of the parameter make another picture?
static bool moves(struct renderer *r, const struct params *p,
                  const struct params_row *row)
{
    struct buf was[2], is[2];
    bool moved = false;
    picture(r, p, was);
    const bool words = row->type == PARAMS_CHOICE;
    for (int k = 0; !moved && (words ? edit_choice(row, k).size > 0 : k < 2);
         k++) {
        struct params q = *p;
        const double v = words ? k : k ? row->max : row->min;
        params_put(&q, row, 0, fmin(v, 24)); // of a resolution, quick enough
        picture(r, &q, is);
        moved = !scene_same(&was[0], &is[0]) || !scene_same(&was[1], &is[1]);
        buf_finish(&is[0]);
        buf_finish(&is[1]);
    }
    buf_finish(&was[0]);
    buf_finish(&was[1]);
    return moved;
}

static void test_row(struct renderer *r, const struct params *base,
                     const struct params_row *row)
{
    char name[100];
    struct params p = *base;
    struct need n;
    snprintf(name, sizeof name, "%s.%s needs %s", row->group_name, row->name,
             params_needs(row));
    check_case(name);
    for (const char *at = params_needs(row); at;) {
        at = next_need(at, &n);
        CHECK(settle(&p, &n, -1));
    }
    CHECK(!moves(r, &p, row));
    for (const char *at = params_needs(row); at;) {
        struct params q = p;
        at = next_need(at, &n);
        for (int way = 0; settle(&q, &n, way); way++, q = p)
            if (!CHECK(moves(r, &q, row)))
                printf("  with way %d of %s\n", way, params_needs(row));
    }
}

int main(int argc, char **argv)
{
    struct params p;
    sky_helper_main(argc, argv);
    scene_shadowed(&p, 2, 0, 40);
    p.sky.lights = 6;
    struct renderer *r =
        scene_renderer(scene_lock(60, 12), scene_two_lamps(), &p);
    for (int i = 0; i < params_row_count; i++)
        if (params_needs(&params_rows[i]))
            test_row(r, &p, &params_rows[i]);
    renderer_destroy(r);
    return check_end();
}
