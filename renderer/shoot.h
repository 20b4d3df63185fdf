// shoot.h - the truth about shadows: rays against the strands themselves.
//
// Every segment is a ribbon of the strand's diameter that faces the ray, cut
// square at the segment's ends.  Double precision throughout.  It serves the
// references, the tests and the refinement at rest; nothing interactive waits
// for it.
// Thread: shoot_create and the queries use all cores themselves; a finished
// scene is immutable and may be queried from any thread.
#ifndef RENDERER_SHOOT_H
#define RENDERER_SHOOT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "protocol/error.h"
#include "protocol/params.h"
#include "renderer/groom.h"

struct shoot;

// Builds the hierarchy over a groom as hair.* of `p` places it in the world
// (scale, axes, diameter; opacity where hair.use_opacity is on).  The groom may
// go afterwards.  NULL when it does not fit in memory limits stated in the .c.
struct shoot *shoot_create(const struct groom *g, const struct params *p,
                           struct error *err);
void shoot_destroy(struct shoot *s); // NULL is allowed
double shoot_diameter(const struct shoot *s); // mean, world

struct shoot_ray {
    double origin[3], direction[3]; // direction: unit
    double reach;                   // INFINITY: to the end of the world
    uint32_t segment; // the segment (point number of its first point) on which
                      // the origin lies, UINT32_MAX for none
};

struct shoot_hit { // what lies along a ray
    double crossings;     // fibres crossed, each weighted by its opacity
    bool head;            // the head is met: nothing passes
    double transmittance; // product of (1 - opacity), 0 behind the head
};

// Fibres crossed along one ray.  Crossings of the origin's own strand nearer
// than 8 diameters are not counted (the fibre's own scattering has them).
void shoot_ray(const struct shoot *s, const struct shoot_ray *ray,
               struct shoot_hit *hit);

// The first thing met: distance, INFINITY when nothing.  segment and `along`
// (0..1) tell where; segment is UINT32_MAX for the head.
double shoot_first(const struct shoot *s, const struct shoot_ray *ray,
                   uint32_t *segment, double *along);

struct shoot_lobe { // an SRBF light seen from a point (Xu 2011, eq 2)
    double direction[3], lambda;
    double transmittance;  // mean over the lobe of what arrives unblocked
    double forward[4];     // mean of E[a^N] for the given attenuations
    double crossings;      // mean number of fibres crossed, head counted as 1e9
    double deviation;      // standard error of `transmittance`
};

// Lobe averages from one point by `rays` stratified directions distributed as
// the lobe (low discrepancy, seeded by `seed`).  attenuation: 4 values of the
// forward attenuation a, 0..1.
void shoot_lobe(const struct shoot *s, const struct shoot_ray *from,
                const double attenuation[4], int rays, uint64_t seed,
                struct shoot_lobe *lobe);

// Many of the above, over all cores: lobes[count], from[count].
void shoot_lobes(const struct shoot *s, const struct shoot_ray *from,
                 const double attenuation[4], int rays, uint64_t seed,
                 struct shoot_lobe *lobes, size_t count);

#endif
