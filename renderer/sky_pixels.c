// sky_pixels.c - memory for the pixels of a sky file, and its limits.  What the
// pixels mean is left to the readers and to sky_clean.c.
#include "renderer/sky_pixels.h"

#include <stdlib.h>

bool sky_pixels_create(struct sky_pixels *p, int64_t width, int64_t height,
                       struct error *err)
{
    *p = (struct sky_pixels){0};
    if (width < 1 || height < 1 || width > SKY_SIDE_MAX ||
        height > SKY_SIDE_MAX)
        return error_set(err, "limit", "",
                         "the picture is %lld x %lld; a side must be within "
                         "[1, %d]",
                         (long long)width, (long long)height, SKY_SIDE_MAX);
    if (width * height > SKY_PIXELS_MAX)
        return error_set(err, "limit", "",
                         "the picture is %lld x %lld = %.1f megapixels; at "
                         "most %.1f are read",
                         (long long)width, (long long)height,
                         1e-6 * (double)(width * height),
                         1e-6 * SKY_PIXELS_MAX);
    if (width < height || width > 4 * height)
        return error_set(err, "file", "",
                         "the picture is %lld x %lld: a lat-long map is twice "
                         "as wide as high (accepted: 1 to 4 times); this may "
                         "be a cube map",
                         (long long)width, (long long)height);
    p->width = (int)width;
    p->height = (int)height;
    p->rgb = bytes_zalloc((size_t)(3 * width * height), sizeof *p->rgb);
    return true;
}

void sky_pixels_finish(struct sky_pixels *p)
{
    free(p->rgb);
    *p = (struct sky_pixels){0};
}
