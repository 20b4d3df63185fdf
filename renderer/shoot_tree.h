// shoot_tree.h - the hierarchy that shoot_walk.c walks: shoot_split.c halves
// the segments, shoot_build.c makes wide nodes of the halves.
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

#include "renderer/watch.h"

enum {
    SHOOT_LANES = 8, // children of a node, segments of a leaf
    SHOOT_DEPTH = 66 // at most, of any tree
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

struct shoot_node {                // four cache lines
    float side[2][3][SHOOT_LANES]; // [low, high][axis][child]
    uint32_t child[SHOOT_LANES];
    uint32_t unused[SHOOT_LANES];
};

struct shoot_leaf {                             // four cache lines
    float a[3][SHOOT_LANES], b[3][SHOOT_LANES]; // ends: [axis][segment]
    float radius[SHOOT_LANES];     // the larger one; NaN: there is no segment
    uint32_t segment[SHOOT_LANES]; // number of its first point
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
    struct watch *watch; // NULL, or cuts the building
};

// Segments without length are left out: nothing can meet them.  False, and an
// empty tree, where it was cut.
bool shoot_build(struct shoot_tree *t, const struct shoot_segments *segments);
void shoot_build_finish(struct shoot_tree *t);

#endif
