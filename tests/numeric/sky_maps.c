// sky_maps.c - see the header.
#include "tests/numeric/sky_maps.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "protocol/bytes.h"

static const double pi = 3.14159265358979323846;

struct sky_map *sky_maps_new(int width, int height, float value)
{
    struct sky_map *m = bytes_zalloc(1, sizeof *m);
    strcpy(m->name, "test");
    m->width = width;
    m->height = height;
    size_t count = 3 * (size_t)width * (size_t)height;
    m->rgb = bytes_alloc(count * sizeof *m->rgb);
    for (size_t i = 0; i < count; i++)
        m->rgb[i] = value;
    return m;
}

bool sky_maps_fit(const struct sky_map *m, int lights, struct sky_fit *fit)
{
    struct error err = {0};
    if (sky_fit_run(m, lights, SKY_FIT_HAIR, NULL, fit, &err))
        return true;
    printf("  %s\n", err.text);
    return false;
}

double sky_maps_angle(const double a[3], const double b[3]) // degrees
{
    double c[3], dot = a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    for (int k = 0; k < 3; k++)
        c[k] =
            a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
    return atan2(sqrt(c[0] * c[0] + c[1] * c[1] + c[2] * c[2]), dot) * 180 / pi;
}
