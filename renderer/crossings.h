// crossings.h - how many fibres light crosses on its way to a point: the
// expected number n(x, w) from any point of the hair in any direction, and from
// it what every light's lobe lets through.
//
// Built of three things, each kept until what it depends on changes:
//   grid   the hair as a density of fibre area and a tensor of directions, in
//          voxels                                     (hair)
//   ways   for each light a few directions, and along each of them n summed up
//          from the far side through all voxels       (lights' places, widths)
//   lists  the segments near each voxel, for rays that count real fibres close
//          to the point before the voxels take over   (hair)
// Nothing here depends on a fibre's parameters, on a light's colour or on the
// camera.  The head is no part of the grid: it is tested where n is looked up.
//
// For comparison there is another source of the same numbers, as the papers
// have it: optical depth maps, one along each light's centre, filtered over the
// lobe by summed-area tables with a kernel that depends on depth, and forward
// transmittance from sparse samples of them (Xu 2011, section 5, after Ren
// 2010).  It takes the place of grid and ways.
//
// Shaders include "shadow.glsl"; crossings_bind gives them what it reads.
// Method: fibres as randomly placed pieces of known density and direction, so
// that crossings are Poisson (docs/METHODS.md).
// Thread: render, with the GL context current.
#ifndef RENDERER_CROSSINGS_H
#define RENDERER_CROSSINGS_H

#include <stdbool.h>
#include <stdint.h>

#include "protocol/error.h"
#include "protocol/params.h"
#include "renderer/groom.h"
#include "renderer/strands.h"
#include "renderer/watch.h"

enum {
    CROSSINGS_LIGHTS_MAX = 200,
    CROSSINGS_WAYS_MAX = 1024, // directions of all lights together, and slots
                               // of tiles
    CROSSINGS_RESOLUTION_MIN = 32,
    CROSSINGS_RESOLUTION_MAX = 192,
    CROSSINGS_RAYS_MAX = 16,
    // What crossings_bind binds, for shaders that include shadow.glsl.
    CROSSINGS_UNIFORM_BINDING = 5, // uniform block
    CROSSINGS_MAP_BINDING = 7,     // another, with SHADOW_MAP defined
    CROSSINGS_TEXTURE_UNIT = 8,
    CROSSINGS_TEXTURE_UNITS = 6, // and those after it, for rays
};

struct crossings_light {
    float direction[3]; // world, unit, towards the light
    float lambda;       // width; 0 is a sun
    int dim; // 0, 1, 2: how little of all light it is (lights.h); fewer
             // directions are enough then
};

enum crossings_quality {
    CROSSINGS_COARSE, // 1, 1, 3, 6 directions for lambda up to .16, .4, .75,
                      // more
    CROSSINGS_FINE,   // 1, 3, 6, 12
};

struct crossings_options {
    int resolution;  // voxels along the longest side; outside
                     // CROSSINGS_RESOLUTION_* is brought into it
    uint64_t budget; // bytes for grid and directions, and as many again for
                     // lists; 0: no limit
    int ways;        // directions that the budget should hold; 0: 120, which is
                     // 40 lights of lambda up to .4 at CROSSINGS_FINE
    int most;        // directions a light at most; 0: as many as the quality
                     // says
    const struct strands *map; // depth maps of this hair, half as many cells
                               // more along a side as `resolution`, fewer where
                               // the budget ends; borrowed until the next grid.
                               // NULL: the field
};

struct crossings_stats {
    int resolution; // in use; below what was asked where memory ends
    int size[3];    // voxels
    int lights, ways;
    float ways_per_light; // share of what the quality asks for: < 1 where the
                          // budget made it coarser
    double grid_ms, lists_ms; // wall time of the last build
    double sweep_ms;          // on the GPU, of the last update
    uint64_t grid_bytes, ways_bytes, lists_bytes, map_bytes, scratch_bytes;
};

struct crossings { // zero-initialised is empty; all fields are private
    struct crossings_options options;
    struct crossings_stats stats;
    struct crossings_block *block; // what the uniform block holds
    float box_min[3], voxel;       // world
    float hair_min[3], hair_max[3];
    int size[3];        // voxels, multiples of 4
    unsigned tensor[2]; // 3-D textures: rho, rho A_xx, A_yy, A_zz; rho A_yz,
                        // A_zx, A_xy
    unsigned field, field_texture; // a buffer, as a texture too: shadow.glsl
    uint64_t field_size;           // bytes
    unsigned uniform;              // buffer
    struct {                       // for rays; 0 until crossings_build_lists
        unsigned list[2];    // buffers: where a cell's pieces start, the pieces
        unsigned texture[5]; // these, and the strands' points, indices and
                             // opacities, as texture buffers
        unsigned of[3];      // the strands' buffers that these look into
    } rays;
    struct crossings_map { // 0 until it is asked for
        struct crossings_map_block *block;
        unsigned uniform, texture, cells; // cells: scratch
        int side, layers, slices;         // slices: layers of all lights
        uint64_t cells_size;
        unsigned program[4];
    } map;
    // Directions that follow the same axis the same way, along x, y, z, each
    // down and up: slots from a first one on, a multiple of 4.
    struct {
        int first, count;
    } swept[6];
    int slots_way[CROSSINGS_WAYS_MAX]; // of block->way
    unsigned ways, state; // scratch: directions, the slices at hand
    unsigned before;      // `state` as a texture
    uint64_t state_size;
    unsigned sweep; // program
    bool borrowed;  // it is another's
    unsigned query[4];
    bool timed;          // the queries hold a sweep that was not read yet
    struct watch *watch; // NULL, or cuts what takes long, which then is false
};

bool crossings_init(struct crossings *c, struct error *err);
// A second field, without maps and rays, with the programs of `of`, which
// outlives it.
bool crossings_init_beside(struct crossings *c, const struct crossings *of,
                           struct error *err);
void crossings_finish(struct crossings *c); // a zeroed one is allowed

// When the hair (group hair) changed.  Everything else is forgotten with it.
// Fails when the memory limits of the device or the budget leave no room for a
// grid of the least resolution.
bool crossings_build_grid(struct crossings *c, const struct groom *g,
                          const struct params *p,
                          const struct crossings_options *o, struct error *err);

// When the lights' places or widths changed (not their colours).  Storage
// blocks 0 and 1, uniform block 1 and textures 0 to 2 are bound anew.  At most
// CROSSINGS_LIGHTS_MAX; the quality says nothing to maps.  Takes fewer
// directions where the budget or the device
// has no room for all; fails where not even one a light fits.
bool crossings_update(struct crossings *c, const struct crossings_light *lights,
                      int count, enum crossings_quality quality,
                      struct error *err);

// For rays: lists of the segments near every place.  Once a grid, any time
// before the first use of shadow_nodes_rays.  Fails with the code "limit" where
// they are longer than budget or device allow; the smooth field stays usable.
bool crossings_build_lists(struct crossings *c, const struct groom *g,
                           const struct params *p, struct error *err);

bool crossings_has_lists(const struct crossings *c);

// Binds what shadow.glsl reads; `s` is the same hair, only looked at when there
// are lists.
void crossings_bind(struct crossings *c, const struct strands *s);

// Waits for the sweeps of the last update.
void crossings_read_stats(struct crossings *c, struct crossings_stats *out);

#endif
