// sky_pixels.h - the pixels of a sky file before cleaning, and the limits that
// a file's header must keep before anything is allocated for it.
// Thread: any; values only.
#ifndef RENDERER_SKY_PIXELS_H
#define RENDERER_SKY_PIXELS_H

#include <stdbool.h>
#include <stdint.h>

#include "protocol/bytes.h"
#include "protocol/error.h"

enum {
    SKY_PIXELS_MAX = 8192 * 4096, // "8K", the largest size that skies come in
    SKY_SIDE_MAX = 32768
};

struct sky_pixels { // zero-initialised is empty
    int width, height;
    float *rgb; // [3 * width * height], top row first; any bit pattern
};

// Allocates zeroed pixels, or refuses the size: 1..SKY_SIDE_MAX a side,
// SKY_PIXELS_MAX in all, width / height within [1, 4] (a lat-long map is 2:1;
// crosses and strips of cube faces lie outside or are 4:3).
bool sky_pixels_create(struct sky_pixels *p, int64_t width, int64_t height,
                       struct error *err);
void sky_pixels_finish(struct sky_pixels *p);

// The readers.  On failure *out is empty.  They run in the helper process;
// nothing in them trusts the file, but the libraries below may crash on it.
// path names the same bytes as file: one interface of OpenEXR reads paths only.
bool sky_exr_read(struct span file, const char *path, struct sky_pixels *out,
                  struct error *err);
bool sky_rgbe_read(struct span file, struct sky_pixels *out, struct error *err);

#endif
