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
#include "renderer/camera.h"
#include "renderer/lights.h"
#include "renderer/sky.h"
#include "renderer/strands.h"

// All that it depends on what a pixel shows behind the hair.
struct display_view {
    unsigned source; // which lights (lights.h: made), or which sky
    int width, height;
    float eye[3], right[3], up[3], forward[3], tan_half;
    float centre[3], radius[3]; // of the head, or 0
    float to_map[9];            // of the sky, or 0
};
struct display_kept { // ... kept pixel by pixel while it is the same
    unsigned buffer;
    uint64_t bytes;
    unsigned stamp; // of the pixels that are of `view`
    struct display_view view;
};

struct display {
    unsigned program[3]; // by view.background's words; compiled when asked for
    unsigned pixels;     // buffer, RGBA8
    void *mapped;        // the same, for reading
    size_t size;
    struct display_kept head, behind; // the lights on the head; the sky
    unsigned sky;                     // texture, uploaded when it is to be seen
    unsigned sky_number;              // no other one has had it
    const void *sky_of;               // the map it was made from
};

void display_init(struct display *d);
void display_finish(struct display *d);
void display_forget_sky(struct display *d);

struct display_input {
    const struct sky_map *map;
    int samples;                 // in the sums
    const struct lights *lights; // their tint is not in the sums yet
    const struct camera *camera;
    const struct strands *strands; // whose head
};
// Draws picture_*'s sums (already bound to 9 and 10).  The caller's scene,
// parameter and light blocks are bound.
bool display_draw(struct display *d, const struct params *p,
                  const struct display_input *in, struct error *err);
uint64_t display_bytes(const struct display *d); // on the device, but the sky
// After the GPU is done.
void display_read(const struct display *d, struct buf *out);

#endif
