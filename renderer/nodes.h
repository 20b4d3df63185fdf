// nodes.h - what of each light reaches each visible place, in a buffer that the
// shading reads ([light][place], shaders/nodes.glsl).  Two of them: the first
// sample's without rays, which edits of fibre and light colour find again, and
// one for whatever sample is at hand.
// Thread: render.
#ifndef RENDERER_NODES_H
#define RENDERER_NODES_H

#include <stdbool.h>
#include <stdint.h>

#include "protocol/error.h"
#include "renderer/picture.h"
#include "renderer/strands.h"

enum {
    NODES_BINDING = 15,
    NODES_UNIT = 17,
    NODES_STRIDE_LOCATION = 2,
    NODES_BEGIN_LOCATION = 4
};

struct nodes_store {
    unsigned buffer, texture; // one memory: written as a buffer, read as texels
    uint64_t bytes;
    uint32_t stride, begin; // places: how many, and the first of the sample's
};

struct nodes {
    struct nodes_store first, rest;
    bool first_valid;
    unsigned made;        // how often the first one was
    unsigned program[32]; // bits: see nodes.c; compiled when asked for
    unsigned now;         // that nodes_make bound
};

struct nodes_request {
    int part; // of the cells' list: the sample
    int rays; // for each place and light; 0: the smooth field
    bool map; // from depth maps instead; no rays then
    int lights;
    uint32_t places; // of those that this sample sees first: how many, and
    uint32_t begin;  // from which on
    uint64_t budget; // bytes for one of the two
    bool by_pixel;   // the list holds pixels whose ids are bound (forward.h)
    bool centres;    // of these: the middle of the cell that they see
};

void nodes_finish(struct nodes *n);

// For how many places budget and device have room at once: a multiple of 64, at
// least that many.
uint32_t nodes_room(const struct nodes_request *q);
// The store for what is asked for, at most as many places as there is room, and
// what makes it, bound beside the crossings and cells: nodes_run then, for all
// of its places, and nodes_made.  Or it is kept from before, which only the
// whole of the first sample is: nothing is left to do then.
bool nodes_make(struct nodes *n, const struct nodes_request *q,
                const struct strands *s, const struct nodes_store **out,
                struct error *err);
// Of these places `count` from `from` on, a multiple of 64; the last ones may
// be fewer than a multiple.
void nodes_run(const struct nodes *n, const struct nodes_request *q,
               const struct picture *p, uint32_t from, uint32_t count);
void nodes_made(struct nodes *n, const struct nodes_request *q);
// Would nodes_make find it kept?
bool nodes_kept(const struct nodes *n, int part, int rays);

#endif
