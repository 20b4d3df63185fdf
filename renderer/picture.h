// picture.h - which point of which strand each pixel sees, and the samples'
// sum: ids by raster, ids to cells, cells to a picture.
//
// A cell is about a pixel of a segment.  It is shaded once, whichever samples
// see it, and its radiance depends on nothing but the cell: so the order of
// threads does not matter, and a refined picture equals a fresh one bit for
// bit.  Which cells a sample sees (its map) is kept as long as memory allows;
// an edit of fibre or light then needs no raster at all.
// Thread: render.
#ifndef RENDERER_PICTURE_H
#define RENDERER_PICTURE_H

#include <stdbool.h>
#include <stdint.h>

#include "protocol/error.h"
#include "protocol/params.h"
#include "renderer/camera.h"
#include "renderer/picture_gl.h"
#include "renderer/raster.h"
#include "renderer/strands.h"

enum { PICTURE_SCENE_BINDING = 1, PICTURE_SAMPLES_MAX = 4096 };
enum { PICTURE_GROUP_PIXELS = 512 }; // of accumulate.comp, cells_number.comp

struct picture {
    int width, height;
    unsigned keys, radiance, list, counts, map; // cells.glsl
    unsigned numbers;                           // cells.comp
    unsigned sum, saw;                          // accumulate.comp, seen.glsl
    unsigned scene;                             // uniform block
    unsigned cells, cells_drawn, number, count, add; // programs
    struct raster raster;
    struct picture_gl drawn;         // the other raster, where it is used
    struct picture_gl_target target; // the same
    bool always_drawn;               // set by tests
    uint32_t slots;                  // of the hash table, a power of two
    int maps;                        // samples whose map is kept
    struct watch *watch; // NULL, or cuts picture_see, which then is false
    int cache_mb;        // quality.cache_mb that all this was sized for
    int seen;            // samples whose cells are listed
    bool flushed;        // the list no longer begins with sample 0
    uint32_t listed;     // entries of the list, as last read
    uint32_t lost;       // pixels without a place in the table: 0
    uint64_t target_bytes, cache_bytes;
};

struct picture_scene { // what the scene block is made of
    const struct camera *camera;
    const struct strands *strands;
    const float *to_map; // 9, row-major
    const float *mask;   // 3: R, TT, TRT
    const float *share;  // 2: global, local multiple scattering
};

bool picture_init(struct picture *p, struct error *err);
void picture_finish(struct picture *p);

// Sizes everything for image.* and quality.*; forgets all cells.  False when
// the device's buffers are too small for such a picture.
bool picture_resize(struct picture *p, const struct params *params,
                    struct error *err);
void picture_forget(struct picture *p);  // camera or strands changed
void picture_restart(struct picture *p); // sample 0 comes next; cells stay

// Does sample k still have to be rastered?
bool picture_must_see(const struct picture *p, int k);
// Uploads the scene block for sample k.
void picture_scene(struct picture *p, const struct picture_scene *s, int k);
// Raster and cells of sample k, from the camera of the scene block.
bool picture_see(struct picture *p, const struct strands *s,
                 const struct camera *c, int k, struct error *err);
// Is that by the driver's raster, because the other cannot be had for these?
bool picture_draws(const struct picture *p, const struct strands *s);
// Binds the cells and counts those that sample k sees first; the caller then
// binds its program and calls one of these: a thread for each of them, one for
// each of `cells` of them, or one for each of those and each light.
void picture_prepare(struct picture *p, int k);
void picture_dispatch(const struct picture *p);
void picture_dispatch_some(const struct picture *p, uint32_t cells);
void picture_dispatch_lights(const struct picture *p, uint32_t cells,
                             int lights);
// For a list of something else than cells: empties it and makes picture_prepare
// close it as the part of sample k.
void picture_list(struct picture *p, int k);
void picture_add(struct picture *p); // adds sample k, as prepared
// The same by another program that is in use: accumulate.comp with LAYER.
void picture_dispatch_add(const struct picture *p);
// Binds the sums for display_draw.
void picture_bind(const struct picture *p);
// After the GPU is done: reads the counters; returns how many cells the last
// sample shaded.
uint32_t picture_counters(struct picture *p);
// Premultiplied linear RGBA, the mean over `samples`; 4 * width * height.
void picture_read_sum(const struct picture *p, float *rgba, int samples);

#endif
