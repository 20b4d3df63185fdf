// scene.h - small scenes for the render tests, and pictures of them.
#ifndef TESTS_RENDER_SCENE_H
#define TESTS_RENDER_SCENE_H

#include "protocol/bytes.h"
#include "protocol/params.h"
#include "renderer/renderer.h"

// `strands` straight strands in the plane y = 0, each `length` long, `points`
// points, turned evenly over half a turn about their middles, on a grid.
struct groom *scene_fan(int strands, int points, float length, float spacing);
// A fan with one opacity for all points.
struct groom *scene_fan_opacity(int strands, float opacity);
// A curved lock of strands: something with every direction in it.
struct groom *scene_lock(int strands, int points);
// Every point turned about the z axis by `degrees`.
void scene_turn(struct groom *g, float degrees);

struct sky_map *scene_constant_sky(float radiance);
struct sky_map *scene_two_lamps(void); // a warm and a cool lamp on grey

// A lock whose points have opacities and colours.
struct groom *scene_lock_tinted(int strands, int points);

// 96 x 64, few samples, a camera that sees the fan from the front with 1 pixel
// = 1 unit in the plane y = 0.
void scene_params(struct params *p);
// The same with strands of .6 pixels that shadow themselves.
void scene_shadowed(struct params *p, int samples, int rays, int resolution);

// A renderer with groom and sky (both taken) and parameters; exits on failure.
struct renderer *scene_renderer(struct groom *g, struct sky_map *m,
                                const struct params *p);
// Steps until final.
bool scene_finish(struct renderer *r);
// The final linear picture; scene_picture_free it.
struct buf scene_linear(struct renderer *r);
struct buf scene_display(struct renderer *r);

double scene_sum(const struct buf *linear, int channel); // over all pixels
// Sum of |a - b| over RGB / sum of b.
double scene_difference(const struct buf *a, const struct buf *b);
bool scene_same(const struct buf *a, const struct buf *b); // bytes

#endif
