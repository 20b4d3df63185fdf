// places.h - random visible places of a renderer's picture with the light that
// it gave them, so that an error can be formed place by place, without
// antialiasing in between.
// Thread: the renderer's.
#ifndef RENDERER_PLACES_H
#define RENDERER_PLACES_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "protocol/error.h"

struct renderer;

struct places_item {
    uint32_t segment; // number of its first point
    double along;     // 0..1 on it
    double position[3];
    double tangent[3]; // u: unit, root to tip, as the shading has it
    double across[3];  // v: unit, across; the major axis of an eccentric fibre,
                       // else towards the eye
    double to_eye[3];  // unit
    float radiance[3]; // as the renderer has it, colour of the hair included
    int x, y;          // a pixel that sees it, top row first
};

// At most `want` of the cells that sample 0 of the picture sees, each at most
// once, drawn through pixels (so a place counts as often as it is seen), into
// item[]; *got is how many.  The same picture and seed give the same places in
// the same order.  Their radiance is that of the newest sample's state:
// shadow.rays refines it.
// Fails when nothing is rendered of the present state, when the store of cells
// has been emptied since sample 0 (quality.cache_mb), or for
// render.path=forward.
bool renderer_places(struct renderer *r, size_t want, uint64_t seed,
                     struct places_item *item, size_t *got, struct error *err);

#endif
