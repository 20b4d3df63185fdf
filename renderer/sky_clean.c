// sky_clean.c - see the header.
#include "renderer/sky_clean.h"

#include <math.h>

static const float infinite = 65504, highest = 1e8f;

double sky_clean_solid_angle(int y, int width, int height)
{
    const double pi = 3.14159265358979323846;
    return 2 * pi / width * (cos(pi * y / height) - cos(pi * (y + 1) / height));
}

// Mends one value; returns the size of the change, as far as it has one.
static double mend(float *v, struct sky_cleaned *c)
{
    if (isnan(*v)) {
        c->nan++;
        *v = 0;
        return 0;
    }
    if (*v < 0) {
        c->negative++;
        double was = isinf(*v) ? 0 : -(double)*v;
        *v = 0;
        return was;
    }
    if (*v > highest) {
        c->infinite++;
        *v = isinf(*v) ? infinite : highest;
        return (double)*v;
    }
    return 0;
}

void sky_clean_run(float *rgb, int width, int height,
                   struct sky_cleaned *cleaned)
{
    *cleaned = (struct sky_cleaned){0};
    double changed[3] = {0}, energy[3] = {0};
    for (int y = 0; y < height; y++) {
        double q = sky_clean_solid_angle(y, width, height);
        for (int x = 0; x < width; x++, rgb += 3)
            for (int k = 0; k < 3; k++) {
                changed[k] += q * mend(&rgb[k], cleaned);
                energy[k] += q * (double)rgb[k];
            }
    }
    // A channel that is empty after all counts as wholly changed.
    for (int k = 0; k < 3; k++)
        if (changed[k] > 0)
            cleaned->energy_share +=
                (energy[k] > 0 ? changed[k] / energy[k] : 1) / 3;
}
