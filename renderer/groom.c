// groom.c - what every groom has, wherever it came from: memory, box, up axis,
// automatic diameter.  Files are read in groom_file.c, built-in grooms are
// grown in groom_builtin.c.
#include "renderer/groom.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "renderer/groom_private.h"

struct groom *groom_private_new(const char *name, uint32_t strands,
                                uint32_t points)
{
    struct groom *g = bytes_zalloc(1, sizeof *g);
    snprintf(g->name, sizeof g->name, "%s", name);
    g->strands = strands;
    g->points = points;
    g->first = bytes_alloc(((size_t)strands + 1) * sizeof *g->first);
    g->position = bytes_alloc((size_t)points * 3 * sizeof *g->position);
    g->default_opacity = 1;
    for (int c = 0; c < 3; c++)
        g->default_colour[c] = 1;
    g->up = 2;
    return g;
}

void groom_destroy(struct groom *g)
{
    if (!g)
        return;
    free(g->first);
    free(g->position);
    free(g->diameter);
    free(g->opacity);
    free(g->colour);
    free(g);
}

static void measure_box(struct groom *g)
{
    for (int c = 0; c < 3; c++)
        g->box_min[c] = g->box_max[c] = g->position[c];
    for (size_t i = 1; i < g->points; i++)
        for (int c = 0; c < 3; c++) {
            float x = g->position[3 * i + (size_t)c];
            if (x < g->box_min[c])
                g->box_min[c] = x;
            if (x > g->box_max[c])
                g->box_max[c] = x;
        }
}

// How far the points of a strand lie below its root on average, per axis,
// summed over the strands.  All points and not the tips alone: a lock that
// curls up at its end still hangs.
static void measure_hang(const struct groom *g, double hang[3])
{
    for (int c = 0; c < 3; c++)
        hang[c] = 0;
    for (uint32_t s = 0; s < g->strands; s++) {
        const float *root = g->position + 3 * (size_t)g->first[s];
        uint32_t n = g->first[s + 1] - g->first[s];
        for (int c = 0; c < 3; c++) {
            double sum = 0;
            for (uint32_t i = 1; i < n; i++)
                sum +=
                    (double)root[c] - (double)root[3 * (size_t)i + (size_t)c];
            hang[c] += sum / (n - 1);
        }
    }
}

// The convention knows +x, +y and +z only.  Hair that falls by less than a
// quarter of what it rises along another axis stands on end: the axis of the
// rise is up.  Hair that does neither (fur all around) is taken as z up.
static int up_from_hang(const double hang[3], double strands, double diagonal)
{
    int low = 0, high = 0;
    for (int c = 1; c < 3; c++) {
        if (hang[c] > hang[low])
            low = c;
        if (hang[c] < hang[high])
            high = c;
    }
    double fall = fmax(0, hang[low]), rise = fmax(0, -hang[high]);
    if (fmax(fall, rise) <= 1e-3 * diagonal * strands)
        return 2;
    return fall < 0.25 * rise ? high : low;
}

static double box_diagonal(const struct groom *g)
{
    double sum = 0;
    for (int c = 0; c < 3; c++) {
        double d = (double)g->box_max[c] - (double)g->box_min[c];
        sum += d * d;
    }
    return sqrt(sum);
}

void groom_private_measure(struct groom *g, bool find_up)
{
    measure_box(g);
    if (!find_up)
        return;
    double hang[3];
    measure_hang(g, hang);
    g->up = up_from_hang(hang, g->strands, box_diagonal(g));
}

float groom_auto_diameter(const struct groom *g)
{
    return (float)(0.0004 * box_diagonal(g) * sqrt(100000.0 / g->strands));
}

struct groom *groom_open(const char *source, struct error *err)
{
    static const char prefix[] = "builtin:";
    if (strncmp(source, prefix, sizeof prefix - 1) == 0)
        return groom_builtin(source + sizeof prefix - 1, err);
    return groom_load(source, err);
}
