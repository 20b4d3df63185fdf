// display.h - the 8-bit picture: hair over head over background, exposure and
// tone curve.  Nothing here touches the linear picture.
// Thread: render.
#ifndef RENDERER_DISPLAY_H
#define RENDERER_DISPLAY_H

#include <stdbool.h>
#include <stdint.h>

#include "protocol/bytes.h"
#include "protocol/error.h"
#include "protocol/params.h"
#include "renderer/sky.h"

struct display {
    unsigned program[3]; // by view.background's words; compiled when asked for
    unsigned pixels;     // buffer, RGBA8
    void *mapped;        // the same, for reading
    size_t size;
    unsigned sky;       // texture, uploaded when it is to be seen
    const void *sky_of; // the map it was made from
};

void display_init(struct display *d);
void display_finish(struct display *d);
void display_forget_sky(struct display *d);

struct display_input {
    const struct sky_map *map;
    int samples;       // in the sums
    const float *tint; // 3: what sums and lights have yet to be multiplied by
};
// Draws picture_*'s sums (already bound to 9 and 10).  The caller's scene,
// parameter and light blocks are bound.
bool display_draw(struct display *d, const struct params *p,
                  const struct display_input *in, struct error *err);
// After the GPU is done.
void display_read(const struct display *d, struct buf *out);

#endif
