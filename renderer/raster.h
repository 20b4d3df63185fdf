// raster.h - which segment each pixel sees, by compute shaders: one thread
// walks the pixels of one segment.  Segments are a few pixels long and thinner
// than one, so a raster for triangles spends its time on their corners.
//
// What a pixel sees depends on nothing but strands, scene block and sample: the
// nearest segment that covers it and whose strand the sample keeps, of equally
// near ones that with the smallest number.  Which pixels a segment covers is
// stated in raster_walk.comp.
// Thread: render.
#ifndef RENDERER_RASTER_H
#define RENDERER_RASTER_H

#include <stdbool.h>
#include <stdint.h>

#include "protocol/error.h"
#include "renderer/camera.h"
#include "renderer/strands.h"
#include "renderer/watch.h"

// Nothing of it outlives a sample: pictures can share one.
struct raster {                              // zero-initialised is empty
    unsigned head, keep, walk[2], settle[2]; // programs; lines, ribbons
    unsigned depth, seen, work;              // buffers
    uint32_t pixels, room[3];                // that they are sized for
    bool opacity_variant;
    uint64_t bytes; // of GPU memory
};

bool raster_init(struct raster *r, struct error *err);
void raster_finish(struct raster *r);
void raster_drop(struct raster *r); // buffers: nobody needs them now
struct raster_view {
    const struct strands *strands;
    const struct camera *camera;
    int width, height;
    struct watch *watch; // NULL, or cuts it, which then is false
};

// What each pixel sees.  The scene block is bound, and the sample's part of a
// map of cells (cells.glsl), cleared: it gets to know where the head is.  False
// where a program or a buffer could not be had.
bool raster_see(struct raster *r, const struct raster_view *v,
                struct error *err);
// Then: runs a program that begins with raster_work.glsl for every pixel that
// sees a segment.
void raster_pixels(const struct raster *r, unsigned program);

#endif
