// shoot_tree.h - the hierarchy that shoot.c walks and shoot_build.c makes.
//
// All of it is in scene units: world units times a power of two that brings
// every coordinate into -1..1, so scaling is exact and one absolute margin
// serves every scene.
// Thread: any; immutable once built.
#ifndef RENDERER_SHOOT_TREE_H
#define RENDERER_SHOOT_TREE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum {
    SHOOT_LANES = 4,      // children of a node, segments of a leaf
    SHOOT_PARTS = 256,    // a segment's length in parts (see shoot_leaf)
    SHOOT_STACK = 256,    // entries a walk may need: 3 x depth + 1
    SHOOT_DEPTH_MAX = 80, // of the tree; the builder keeps to it
};
#define SHOOT_LEAF 0x80000000u // child: this bit + index of a leaf
#define SHOOT_NONE 0xffffffffu // child: there is none

// Boxes and the quick test of a leaf are single precision, in a scene of extent
// 2.  A ray in floats strays by 2^-25 (1 + its path of 3.5) < 2^-22 from the
// true one: boxes are four times as much too large.  The quick test rounds
// about 20 results of size 3.5 or less, in all below 1.5e-6; its reach is
// 3.8e-6 too far.  So neither loses what the double-precision test would find.
#define SHOOT_BOX_MARGIN 0x1p-20
#define SHOOT_REACH_MARGIN 0x1p-18

typedef float shoot_f4 __attribute__((vector_size(16)));
typedef int32_t shoot_i4 __attribute__((vector_size(16)));

struct shoot_node {
    shoot_f4 side[2][3]; // [low, high][axis], a lane a child
    uint32_t child[SHOOT_LANES];
    uint32_t unused[4]; // to two cache lines
};

// Whole segments, of which the leaf answers for the stretch from part
// `from` to `to` of SHOOT_PARTS only: a long segment across the axes lies in
// several leaves with tight boxes and yet counts once.
struct shoot_leaf {
    shoot_f4 a[3], b[3]; // ends: [axis], a lane a segment; NaN: no segment
    shoot_f4 reach2;     // (the larger radius + margin)^2
    float radius_a[SHOOT_LANES], radius_b[SHOOT_LANES];
    uint32_t segment[SHOOT_LANES]; // number of its first point
    uint16_t from[SHOOT_LANES], to[SHOOT_LANES];
};

struct shoot_tree {
    struct shoot_node *node; // [0] is the root
    struct shoot_leaf *leaf;
    size_t nodes, leaves;
    float low[3], high[3]; // around everything
};

struct shoot_segments {    // what the tree is built over, scene units
    const float *point;    // [4 * points]: x, y, z, diameter
    const uint32_t *first; // [strands + 1]
    uint32_t strands;
};

// Segments without length are left out: nothing can meet them.
void shoot_build(struct shoot_tree *t, const struct shoot_segments *segments);
void shoot_build_finish(struct shoot_tree *t);

#endif
