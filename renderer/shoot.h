// shoot.h - the truth about shadows: rays against the strands themselves.
//
// Every segment is a ribbon of the strand's diameter that faces the ray, cut
// square at the segment's ends.  Double precision throughout.  It serves the
// references, the tests and the refinement at rest; nothing interactive waits
// for it.
// Thread: shoot_create and shoot_lobes use all cores themselves; a finished
// scene is immutable and may be queried from any thread.
#ifndef RENDERER_SHOOT_H
#define RENDERER_SHOOT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "protocol/error.h"
#include "protocol/params.h"
#include "renderer/groom.h"
#include "renderer/watch.h"

struct shoot;

// Builds the hierarchy over a groom as hair.* of `p` places it in the world
// (scale, axes, diameter; opacity where hair.use_opacity is on).  The groom may
// go afterwards.  NULL when it has more points than the limit stated in the .c,
// or one that hair.scale takes out of the range of floats.
struct shoot *shoot_create(const struct groom *g, const struct params *p,
                           struct error *err);
// NULL as well, without an error, where `watch` cuts it.
struct shoot *shoot_create_watched(const struct groom *g,
                                   const struct params *p, struct watch *watch,
                                   struct error *err);
void shoot_destroy(struct shoot *s);          // NULL is allowed
double shoot_diameter(const struct shoot *s); // mean over length, world
size_t shoot_bytes(const struct shoot *s);    // memory that it holds

struct shoot_ray {
    double origin[3], direction[3]; // direction: unit
    double reach;                   // INFINITY: to the end of the world
    uint32_t segment; // the segment (point number of its first point) on which
                      // the origin lies, UINT32_MAX for none
};

struct shoot_hit {        // what lies along a ray
    double crossings;     // fibres crossed before the head, weighted by opacity
    bool head;            // the head is met: nothing passes
    double transmittance; // product of (1 - opacity), 0 behind the head
};

// Conventions of all queries.  A segment from p to q of diameters Dp, Dq, seen
// along the ray, is a line in the plane across the ray; it is met when the foot
// of the perpendicular from the ray lies in [p, q) and is nearer than half the
// diameter, interpolated like the opacity.  A segment along the ray (to 1e-10
// rad) or without length is not met.  The distance is that of the foot; met
// counts when 0 < distance < reach.  What belongs to the origin's own strand
// and is nearer than 8 (local) diameters does not count: the fibre's own
// scattering has it.  An origin inside the head counts as lying on its surface:
// what leads inwards meets the head at once, what leads outwards never.

// Fibres crossed along one ray.
void shoot_ray(const struct shoot *s, const struct shoot_ray *ray,
               struct shoot_hit *hit);

// Only what passes: ends at the first opaque thing, so it is faster.
double shoot_transmittance(const struct shoot *s, const struct shoot_ray *ray);

// The first thing met, however transparent: distance, INFINITY when nothing.
// segment and `along` (0..1) tell where; segment is UINT32_MAX for the head and
// for nothing.
double shoot_first(const struct shoot *s, const struct shoot_ray *ray,
                   uint32_t *segment, double *along);

struct shoot_point {                // a place on a strand
    double position[3], tangent[3]; // tangent: the segment's, root to tip, unit
    double diameter, opacity;
    uint32_t strand;
};
void shoot_point(const struct shoot *s, uint32_t segment, double along,
                 struct shoot_point *out);

struct shoot_lobe { // an SRBF light seen from a point (Xu 2011, eq 2)
    double direction[3], lambda;
    double transmittance; // mean over the lobe of what arrives unblocked
    double forward[4];    // mean of E[a^N], a fibre of opacity o counting as
                          // the factor 1 - o (1 - a); 0 behind the head
    double crossings;     // mean number of fibres crossed, head counted as 1e9
    double deviation;     // standard error of `transmittance` as of independent
                          // rays: with stratified ones an upper estimate
};

// Direction number i of `rays` distributed as the lobe, density proportional
// to exp(2 (cos - 1) / lambda^2): low discrepancy, shifted by `seed`.
void shoot_lobe_direction(const struct shoot_lobe *lobe, int i, int rays,
                          uint64_t seed, double out[3]);

// Lobe averages from one point.  attenuation: 4 values of the forward
// attenuation a, 0..1; NULL: only transmittance and its deviation are wanted,
// which is faster, and the other results are NaN.
void shoot_lobe(const struct shoot *s, const struct shoot_ray *from,
                const double attenuation[4], int rays, uint64_t seed,
                struct shoot_lobe *lobe);

// Many of the above, over all cores: lobes[count], from[count]; number i has
// the seed `seed` + i.  The same bits on any number of cores.
void shoot_lobes(const struct shoot *s, const struct shoot_ray *from,
                 const double attenuation[4], int rays, uint64_t seed,
                 struct shoot_lobe *lobes, size_t count);

#endif
