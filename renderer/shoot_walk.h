// shoot_walk.h - what is behind a struct shoot, and the one walk through its
// strands that every query is.  For shoot*.c only.
// Thread: any; a finished scene is immutable.
#ifndef RENDERER_SHOOT_WALK_H
#define RENDERER_SHOOT_WALK_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "renderer/shoot.h"
#include "renderer/shoot_tree.h"

struct shoot {
    struct shoot_tree tree; // scene units
    float *point;           // [4 * points] scene units: x, y, z, diameter
    uint32_t *first;        // [strands + 1]
    uint32_t strands, points;
    bool tapered;    // some segment's two diameters differ
    float *opacity;  // [points], or NULL: all strands are opaque
    double unit;     // scene units per world unit, a power of two
    double diameter; // mean, world
    bool head;
    double head_centre[3], head_radius[3]; // world
};

struct shoot_own { // the points of the origin's strand; none: 0, 0
    uint32_t begin, end;
};
struct shoot_own shoot_own(const struct shoot *s, uint32_t segment);

// Distance to the head, INFINITY when it is not met within reach, 0 when the
// ray leads into it from its surface.
double shoot_head(const struct shoot *s, const struct shoot_ray *ray);

enum shoot_want {
    SHOOT_ALL,   // every fibre within reach
    SHOOT_CLEAR, // until nothing passes
    SHOOT_FIRST, // the nearest
};

struct shoot_walk {
    enum shoot_want want;
    const double *attenuation; // [4], or NULL: no `forward` wanted
    // results of SHOOT_ALL, SHOOT_CLEAR
    double crossings, transmittance, forward[4];
    // results of SHOOT_FIRST: INFINITY, UINT32_MAX when nothing is met
    double distance, along;
    uint32_t segment;
};

// Fills the results; the head is the caller's business.
void shoot_walk(const struct shoot *s, const struct shoot_ray *ray,
                struct shoot_own own, struct shoot_walk *w);

#endif
