// groom_builtin.h - how the files that grow the built-in grooms fit together:
//   groom_builtin_head.c    the head, its hairline, roots on the scalp
//   groom_builtin_styles.c  the six styles as one table of numbers
//   groom_builtin_grow.c    a strand that leaves its root and falls
//   groom_builtin_tail.c    a strand that is gathered in a ponytail
//   groom_builtin_dress.c   locks, waves, frizz, cut; strands into arrays
//   groom_builtin.c         the order of work
// Lengths are in centimetres, angles in radians; z is up, the face looks
// along -y, the head's centre is the origin.
// Thread: any (no shared state).
#ifndef RENDERER_GROOM_BUILTIN_H
#define RENDERER_GROOM_BUILTIN_H

#include <stdbool.h>
#include <stdint.h>

#include "renderer/groom.h"
#include "renderer/groom_vec.h"

// Independent streams of random numbers, one per use.
enum groom_stream {
    STREAM_ACCEPT = 1,
    STREAM_HAIRLINE,
    STREAM_LENGTH,
    STREAM_LAYER,
    STREAM_LIFT,
    STREAM_COMB,
    STREAM_FLY,
    STREAM_CUT,
    STREAM_CLUMP,
    STREAM_PHASE,
    STREAM_WAVELENGTH,
    STREAM_AMPLITUDE,
    STREAM_STRAY,
    STREAM_STRAY2,
    STREAM_STRAY3,
    STREAM_BUNDLE,
    STREAM_FRIZZ, // and those after it
};

struct groom_root {
    uint32_t id;     // seed of everything random about the strand
    struct vec3 dir; // the root on the unit sphere that the head is mapped to
    struct vec3 p;   // the root itself
    float side;      // -1 or +1: side of the parting
    bool fringe;     // combed over the forehead
    bool fly;        // a stray hair that no lock holds
};

// Equal steps along the axis of a strand, root first.
enum { GROOM_CURVE_MAX = 208 };
struct groom_curve {
    int n;
    float step;
    float tie; // length from the root to the tie of a tail; 0 without one
    struct vec3 p[GROOM_CURVE_MAX];
};

struct groom_style {
    const char *name;
    uint32_t strands, points; // Xu 2011, Table 2
    bool tail;                // gathered at the back of the head
    float step;               // of the axis curves
    // Length along the strand; spread is the relative variation, layered how
    // much shorter the hair of the top and the front is.
    float length, spread, layered;
    // Height of a blunt cut (no cut below -100) and how ragged it is.
    float cut, cut_fringe, ragged;
    // Thickness of the hair on the head, angle at the root, and the length
    // over which a strand turns to where it is pulled.
    float layer, lift, stiffness;
    // The parting: its x, and the y of the crown where it ends.  How strongly
    // and how far from the root the comb holds; how much it sweeps back.
    float part, crown, comb, comb_length, sweep;
    float fringe; // half width of the fringe; 0 none
    float tuck;   // how much the ends turn in towards the neck
    struct vec3 wind;
    float gusts; // how much the wind varies in space
    // Locks: how many, how tight at the tips; then locks within locks.
    uint32_t locks, sublocks;
    float lock_tight, sublock_tight;
    // Waves: radius, length of one, where they begin, and 0 flat to 1 round.
    float wave, wavelength, wave_start, wave_round;
    float phase_spread;        // how much the waves differ over the head
    float frizz, frizz_length; // amplitude at the tips and its period
    float flyaways;            // share of the strands
};

// --- groom_builtin_head.c
extern const struct vec3 groom_builtin_head_radius;
// Height above the head (first order, exact at the surface), and the normal.
float groom_builtin_head_height(struct vec3 p, struct vec3 *normal);
// True for directions (on the unit sphere) where hair grows.
bool groom_builtin_head_scalp(struct vec3 dir, uint32_t id);
// The next root: *cursor is the caller's place in the sequence, 0 at first.
// Any beginning of the sequence covers the scalp evenly.
struct groom_root groom_builtin_head_root(const struct groom_style *style,
                                          uint32_t id, uint32_t *cursor);
// Moves the points of a strand outwards until none of its segments enters the
// head; the root stays.
void groom_builtin_head_keep_out(float *position, uint32_t n);
// Smooth noise in [-1, 1], about one bump per unit.
float groom_builtin_head_noise(struct vec3 p, uint32_t seed);

// --- groom_builtin_styles.c
extern const struct groom_style groom_builtin_styles[];
extern const int groom_builtin_styles_count;

// --- groom_builtin_grow.c, groom_builtin_tail.c: the axis of one strand, at
// least `length` long where the curve's capacity allows
void groom_builtin_grow(const struct groom_style *style,
                        const struct groom_root *root, float length,
                        struct groom_curve *curve);
void groom_builtin_tail(const struct groom_style *style,
                        const struct groom_root *root, float length,
                        struct groom_curve *curve);

// --- groom_builtin_dress.c
struct groom_dress; // the locks of one groom
struct groom_dress *groom_builtin_dress_create(const struct groom_style *style,
                                               const struct groom_root *roots);
void groom_builtin_dress_destroy(struct groom_dress *dress);
// Grows strand `root` into `n` points.
void groom_builtin_dress_strand(const struct groom_dress *dress,
                                const struct groom_root *root, float *position,
                                uint32_t n);

#endif
