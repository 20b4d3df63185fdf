// draft.h - a second, small picture of the scene as it is while it is being
// edited: fewer pixels, fewer and wider strands, and where the lights moved a
// coarse field of crossings.  It is made by the same programs and the same code
// as the picture itself, which it never touches.
// Nothing is allocated before the first draft.
// Thread: render.
#ifndef RENDERER_DRAFT_H
#define RENDERER_DRAFT_H

#include <stdbool.h>
#include <stdint.h>

#include "renderer/camera.h"
#include "renderer/crossings.h"
#include "renderer/display.h"
#include "renderer/lights.h"
#include "renderer/nodes.h"
#include "renderer/picture.h"
#include "renderer/renderer.h"
#include "renderer/strands.h"

struct draft {                 // zero-initialised is empty
    struct renderer_draft how; // what `strands` and `picture` are made for
    struct picture picture;    // its programs are lent by the renderer's
    struct nodes nodes;        // stores only
    struct display display;    // programs and sky are lent
    struct strands strands;    // every how.stride-th; empty where that is 1
    struct crossings crossings;
    struct camera camera;
    // Strands and grid of the hair as it is, cells of this camera, shadows of
    // these lights: what is not is made anew for the next draft.
    bool shared, gridded, seen, lit;
    bool coarse; // lit by `crossings`, else by the renderer's own
    struct lights_place place[LIGHTS_MAX]; // where lights stood then
    int lights;
    bool shown; // the newest picture of the renderer is this one
};

void draft_finish(struct draft *d);
uint64_t draft_bytes(const struct draft *d); // in GPU memory
// RGBA8, straight alpha, of one width and height into another at least as
// large: between the middles of the nearest four pixels.  Thread: any.
void draft_enlarge(const uint8_t *from, const int size[2], uint8_t *to,
                   const int wanted[2]);

#endif
