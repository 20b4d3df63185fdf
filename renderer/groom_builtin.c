// groom_builtin.c - grooms for a user who has no file: places the roots, grows
// the locks, then strand after strand.  Everything comes from integers hashed
// by strand, so the same name always gives the same bytes.
#include "renderer/groom.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "renderer/groom_builtin.h"
#include "renderer/groom_private.h"

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
    for (uint32_t i = 0; i < style->strands; i++)
        groom_builtin_dress_strand(dress, &roots[i],
                                   g->position + 3 * (size_t)g->first[i],
                                   g->first[i + 1] - g->first[i]);
    groom_builtin_dress_destroy(dress);
    free(roots);
    groom_private_measure(g, false);
    return g;
}
