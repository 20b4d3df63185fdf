// sky_exr_library.h - pixels through the C interface of the OpenEXR library,
// which reads what OpenEXRCore cannot yet (3.1: DWAA, DWAB) and luminance and
// chroma, as half floats: a value above 65,504 arrives as infinity.
// Thread: any; runs in the helper process.
#ifndef RENDERER_SKY_EXR_LIBRARY_H
#define RENDERER_SKY_EXR_LIBRARY_H

#include "renderer/sky_pixels.h"

struct sky_exr_window { // inclusive, as in the file
    int x0, y0, x1, y1;
};

// Fills the part of out that `data` covers when out's first pixel is
// (origin_x, origin_y).  data must be the file's data window.
bool sky_exr_library_read(const char *path, const struct sky_exr_window *data,
                          int origin_x, int origin_y, struct sky_pixels *out,
                          struct error *err);

#endif
