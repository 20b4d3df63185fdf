// groom.h - strands of hair as plain arrays, from a .hair file or built in.
//
// Immutable once made; who creates destroys.  Positions are in the file's own
// units and axes: hair.scale and hair.up are applied where the strands are sent
// to the GPU (strands.h).
// Thread: any; a groom has no shared state.
#ifndef RENDERER_GROOM_H
#define RENDERER_GROOM_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "protocol/bytes.h"
#include "protocol/error.h"

// An opaque ellipsoid that hides hair behind it and, later, light.
struct groom_head {
    bool present;
    float centre[3], radius[3]; // file units, axis-aligned in file axes
};

struct groom {
    char name[64]; // file name without folders, or "builtin:ponytail"
    uint32_t strands;
    uint32_t points;
    uint32_t *first; // [strands + 1] index of each strand's first point;
                     // every strand has at least two points
    float *position; // [3 * points], root first
    float *diameter; // [points] in file units, or NULL: none in the file
    float *opacity;  // [points] 0..1 (1 - the file's transparency), or NULL
    float *colour;   // [3 * points] linear RGB, or NULL
    float default_diameter;  // file units; 0 = unknown, take the automatic one
    float default_opacity;   // 0..1, where opacity is NULL; 1 when unknown
    float default_colour[3]; // where colour is NULL; 1,1,1 when unknown
    float box_min[3], box_max[3];
    struct groom_head head;
    int up; // 0, 1, 2: axis along which tips hang below roots (x, y, z);
            // built-in grooms: 2.  -1 is never stored
};

// A .hair file's bytes (layout: docs/FORMATS.md).  Everything is checked: the
// magic, the flags, sum(segments + 1) == point_count, the exact file length,
// finite positions, a limit of 8 M points.  Strands of a single point are
// dropped.  NULL and *err on any fault.
struct groom *groom_parse(struct span file, const char *name,
                          struct error *err);

// Reads and parses a file (at most 512 MB).
struct groom *groom_load(const char *path, struct error *err);

// "ponytail" "animation" "bob" "dark" "straight" "natural": strand and point
// counts of Xu 2011, Table 2, the same bytes on every call.  Units: 1 = 1 cm
// (a head is about 19 long); z up, the face looks along -y.
struct groom *groom_builtin(const char *name, struct error *err);
extern const char *const groom_builtin_names[]; // NULL-terminated

// "builtin:NAME" or a path.
struct groom *groom_open(const char *source, struct error *err);

// Every `stride`-th strand, as many times as wide where the file has widths;
// the box and the head stay those of all.
struct groom *groom_share(const struct groom *g, uint32_t stride);

void groom_destroy(struct groom *g); // NULL is allowed

// The diameter in use, in file units, when the file has none and hair.diameter
// is 0: the groom covers as much as 100,000 real strands would on a head of its
// size, 0.0004 x box diagonal x sqrt(100000 / strands).
float groom_auto_diameter(const struct groom *g);

#endif
