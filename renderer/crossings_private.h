// crossings_private.h - what crossings*.c share.
// Thread: as crossings.h.
#ifndef RENDERER_CROSSINGS_PRIVATE_H
#define RENDERER_CROSSINGS_PRIVATE_H

#include "renderer/crossings.h"

// The uniform block of shadow.glsl, std140.
struct crossings_block {
    float box[4];     // corner of the grid; 1 / voxel
    float size[4];    // voxels
    float texel[4];   // 1 / atlas size; opacity where there is no array
    float head[4];    // centre; 1 where there is a head
    float inverse[4]; // 1 / radius; reach of rays in cells
    float cells[4];   // of the lists; cells a voxel, along an axis
    uint32_t all[4];  // banks; texels to the next along y, z, bank
    uint32_t light[CROSSINGS_LIGHTS_MAX][4]; // first way, ways; float bits:
                                             // lambda, width of a way's share
    float centre[CROSSINGS_LIGHTS_MAX][4];
    float way[CROSSINGS_WAYS_MAX][4];  // direction, slot
    float slot[CROSSINGS_WAYS_MAX][4]; // direction in units of the head's
                                       // radii, 1 / width of its share
    uint32_t run[CROSSINGS_WAYS_MAX];  // see shadow.glsl: RUN_*
};

// What is done after a slot (shadow.glsl has the same numbers).
enum {
    CROSSINGS_RUN_END = 256,     // of a run; with a light's row + 1, or of none
    CROSSINGS_RUN_AGAIN = 512,   // not the light's first
    CROSSINGS_RUN_SHARED = 1024, // the light has several
    CROSSINGS_RUN_WAYS = 16      // shift: ways of the light
};

// --- crossings_grid.c: the hair in voxels
struct crossings_hair { // a groom in the grid's frame: voxels from its corner
    const uint32_t *first; // [strands + 1], borrowed
    uint32_t strands, points;
    float *at;      // [4 * points]: position, diameter, all in voxels
    float *opacity; // [points], or NULL
    struct watch *watch;
};
// unit: of the world, that becomes 1.  h->watch is set; where it cuts, what is
// in *h is of no use.
void crossings_grid_hair(struct crossings_hair *h, const float corner[3],
                         float unit, const struct groom *g,
                         const struct params *p);
void crossings_grid_hair_finish(struct crossings_hair *h);
// tensor: 2 x 4 floats a voxel, x fastest, in two arrays; rho in 1 / voxel.
void crossings_grid_splat(const struct crossings_hair *h, const int size[3],
                          float *const tensor[2]);

// --- crossings_lists.c: which segments are near (crossings_build_lists)
void crossings_lists_forget(struct crossings *c);
void crossings_lists_bind(struct crossings *c, const struct strands *s);

// --- crossings_sweep.c: what is in the field
// of: whose programs to use; NULL: own ones
bool crossings_sweep_init(struct crossings *c, const struct crossings *of,
                          struct error *err);
void crossings_sweep_finish(struct crossings *c);
void crossings_sweep_forget(struct crossings *c); // scratch memory
// Fills the field with stats.ways directions, which block->way holds.
// False where it was cut.
bool crossings_sweep_run(struct crossings *c);

// --- crossings_map.c: depth maps, and the field that is sampled from them
bool crossings_map_run(struct crossings *c, const struct crossings_light *l,
                       struct error *err);
void crossings_map_bind(const struct crossings *c);
void crossings_map_forget(struct crossings *c);
void crossings_map_finish(struct crossings *c);

// --- crossings.c
enum { CROSSINGS_BANK = 16 }; // slots of a texel, a byte each
uint64_t crossings_voxels(const struct crossings *c);

// --- crossings_ways.c: the directions that stand for a lobe
// Two unit vectors across z.
void crossings_ways_frame(const float z[3], float x[3], float y[3]);
int crossings_ways_count(const struct crossings_light *l,
                         enum crossings_quality quality);
void crossings_ways_direction(const struct crossings_light *l, int i, int count,
                              float out[3]);
// Slots for so many directions, at most.  The four of a word are swept
// together.
int crossings_ways_slots(int ways);
// Fills block->all, way and run, swept and slots_way, for stats.lights.
void crossings_ways_lay(struct crossings *c, const struct crossings_light *l);

#endif
