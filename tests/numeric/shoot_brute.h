// shoot_brute.h - grooms for the ray shooter's tests, and the slow truth: every
// segment against the ray, in extended precision, by other formulas than
// renderer/shoot's.
#ifndef TESTS_NUMERIC_SHOOT_BRUTE_H
#define TESTS_NUMERIC_SHOOT_BRUTE_H

#include <stdint.h>

#include "renderer/groom.h"
#include "renderer/shoot.h"

// strands x points at the origin, z up, diameter `diameter` everywhere.
struct groom *shoot_brute_groom(uint32_t strands, uint32_t points,
                                float diameter);
// What shoot_create does with default parameters, or the test is over.
struct shoot *shoot_brute_scene(const struct groom *g);

double shoot_brute_uniform(uint64_t *state, double lo, double hi);
void shoot_brute_aim(uint64_t *state, double d[3]); // uniform on the sphere

struct shoot_brute {
    double crossings, transmittance, distance, along;
    uint32_t segment;
};
// Over a groom with default parameters (world = file units, z up), opacity
// where there is an array; heads are not looked at.
struct shoot_brute shoot_brute(const struct groom *g,
                               const struct shoot_ray *ray);

#endif
