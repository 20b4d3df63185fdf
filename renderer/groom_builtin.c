// groom_builtin.c - grooms for a user who has no file: places the roots, grows
// the locks, then strand after strand.  Everything comes from integers hashed
// by strand, so the same name always gives the same bytes.
#include "renderer/groom.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "renderer/groom_builtin.h"
#include "renderer/groom_private.h"
#include "renderer/shoot_threads.h"

enum { CHUNK = 256 }; // strands that a thread dresses at a time

const char *const groom_builtin_names[] = {
    "ponytail", "animation", "bob", "dark", "straight", "natural", NULL};

static const struct groom_style *find_style(const char *name)
{
    for (int i = 0; i < groom_builtin_styles_count; i++)
        if (strcmp(groom_builtin_styles[i].name, name) == 0)
            return &groom_builtin_styles[i];
    return NULL;
}

// Strand i begins at i/strands of all points, rounded down: the strands whose
// share is not whole get one more, evenly spread.
static void share_points(struct groom *g)
{
    for (uint32_t i = 0; i <= g->strands; i++)
        g->first[i] = (uint32_t)((uint64_t)i * g->points / g->strands);
}

static void set_head(struct groom_head *head)
{
    head->present = true;
    head->radius[0] = groom_builtin_head_radius.x;
    head->radius[1] = groom_builtin_head_radius.y;
    head->radius[2] = groom_builtin_head_radius.z;
}

struct dressing {
    struct groom *g;
    const struct groom_dress *dress;
    const struct groom_root *roots;
};

// Strands do not know of each other, so the order is no matter.
static void dress_chunk(void *context, size_t chunk)
{
    const struct dressing *d = context;
    const struct groom *g = d->g;
    const uint32_t begin = (uint32_t)chunk * CHUNK;
    for (uint32_t i = begin; i < g->strands && i < begin + CHUNK; i++)
        groom_builtin_dress_strand(d->dress, &d->roots[i],
                                   g->position + 3 * (size_t)g->first[i],
                                   g->first[i + 1] - g->first[i]);
}

struct groom *groom_builtin(const char *name, struct error *err)
{
    const struct groom_style *style = find_style(name);
    if (!style) {
        error_set(err, "unknown", "builtin",
                  "builtin:%s is not one of ponytail, animation, bob, dark, "
                  "straight, natural",
                  name);
        return NULL;
    }
    char full[64];
    snprintf(full, sizeof full, "builtin:%s", style->name);
    struct groom *g = groom_private_new(full, style->strands, style->points);
    share_points(g);
    set_head(&g->head);
    struct groom_root *roots = bytes_alloc(style->strands * sizeof *roots);
    uint32_t cursor = 0;
    for (uint32_t i = 0; i < style->strands; i++)
        roots[i] = groom_builtin_head_root(style, i, &cursor);
    struct groom_dress *dress = groom_builtin_dress_create(style, roots);
    struct dressing all = {g, dress, roots};
    shoot_threads((style->strands + CHUNK - 1) / CHUNK, dress_chunk, &all);
    groom_builtin_dress_destroy(dress);
    free(roots);
    groom_private_measure(g, false);
    return g;
}
