// crossings_scene.h - small scenes for the tests of crossings, and a way to ask
// them.  Each function ends the test when it fails.
#ifndef TESTS_NUMERIC_CROSSINGS_SCENE_H
#define TESTS_NUMERIC_CROSSINGS_SCENE_H

#include "tests/numeric/crossings_truth.h"

struct scene {
    struct groom *groom;
    struct params params;
    struct strands strands;
    struct crossings crossings;
};

// n x n strands along z on a square lattice that fills the unit cube.
struct groom *scene_lattice(uint32_t n, float diameter);
// Strands of 12 points that bend at random in the unit cube.
struct groom *scene_tangle(uint32_t n, float diameter);
struct crossings_light scene_light(uint64_t *state, float lambda); // any aim

// Takes the groom; params are to be set before.
bool scene_open(struct scene *s, struct groom *g, int resolution);
void scene_close(struct scene *s);
bool scene_aim(struct scene *s, const struct crossings_light *l, int count,
               enum crossings_quality quality);
// out[count * lights], for truth_attenuation.
bool scene_look(struct scene *s, int rays, const struct crossings_place *p,
                int count, int lights, struct crossings_result *out);
// Node number k of a result, 0 to 1.
double scene_node(const struct crossings_result *r, int k);

#endif
