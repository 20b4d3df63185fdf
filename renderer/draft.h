// draft.h - second, small pictures of the scene as it is while it is being
// edited: fewer pixels, fewer and wider strands, and where lights or hair moved
// a coarse field of crossings.  They are made by the same programs and the same
// code as the picture itself, which they never touch.
// There are a few of them, since a fibre is dragged with other sizes than a
// camera, and what one of them sees of a resting camera is kept.
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

struct draft_lights { // where lights stood
    bool known;
    int count;
    struct lights_place place[LIGHTS_MAX];
};

struct draft_view {            // zero-initialised is empty
    struct renderer_draft how; // what it is made for; divisor 0: nothing
    struct picture picture;    // its programs are lent by the renderer's
    struct nodes nodes;        // stores only
    struct display display;    // programs and sky are lent
    struct camera camera;
    bool seen; // cells of this camera and hair; else they are made anew
    struct draft_lights lit; // of what `nodes` hold; by a coarse field or not:
                             // how.coarse
    unsigned age;            // the oldest gives way
};

struct draft { // zero-initialised is empty
    struct draft_view view[RENDERER_DRAFT_VIEWS];
    struct draft_view *shown; // the newest picture of the renderer is this one
    struct draft_view *now;   // that is being made
    unsigned clock;
    // The hair as it is asked for: every so many-th strand, 0: not made.
    struct strands strands;
    int stride;
    // Their coarse field, of every so many-th strand, 0: not made; and the
    // lights that its tiles are of.
    struct crossings crossings;
    int gridded;
    struct draft_lights swept;
    bool shading;       // is as asked for, whatever its stage says, of strands
    bool coloured;      // with or without colours
    struct sky_fit fit; // of this sky, the one with most lights so far
    // What is made as if it had changed though it has not; STAGES: nothing.
    enum renderer_stage as_if;
};

void draft_finish(struct draft *d);
uint64_t draft_bytes(const struct draft *d); // in GPU memory
// The view of that size and stride, or else the one that it takes the place of:
// an empty one, or the oldest.
struct draft_view *draft_view_of(struct draft *d,
                                 const struct renderer_draft *how);
// From now on that is what it is made for.
void draft_view_take(struct draft *d, struct draft_view *v,
                     const struct renderer_draft *how);
bool draft_lights_same(const struct draft_lights *a, const struct lights *l);
void draft_lights_note(struct draft_lights *a, const struct lights *l);
// RGBA8, straight alpha, of one width and height into another at least as
// large: between the middles of the nearest four pixels.  Thread: any.
void draft_enlarge(const uint8_t *from, const int size[2], uint8_t *to,
                   const int wanted[2]);

#endif
