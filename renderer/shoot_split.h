// shoot_split.h - segments halved again and again: the tree of two from which
// shoot_build.c makes the tree of eight.
// Thread: one calls; shoot_split uses all cores.
#ifndef RENDERER_SHOOT_SPLIT_H
#define RENDERER_SHOOT_SPLIT_H

#include <stdint.h>

#include "renderer/shoot_tree.h"

typedef float shoot_f4 __attribute__((vector_size(16)));

struct shoot_box {
    shoot_f4 low, high; // lane 3 is not used
};

struct shoot_piece { // a segment and the box around its cylinder
    float low[3];
    uint32_t segment;
    float high[3];
    uint32_t unused;
};

struct shoot_branch {
    struct shoot_box box;
    struct shoot_branch *left, *right; // NULL at a leaf
    uint32_t begin, end;               // of the pieces
    // The best wide tree (shoot_split.c): its cost if this branch may take up
    // to k places in a node, and how many of them go to the left side; 0: it
    // takes one place.  share[0]: of its own node's places.
    float cost[SHOOT_LANES + 1];
    uint8_t share[SHOOT_LANES + 1];
};

struct shoot_split {
    struct shoot_piece *piece; // in the order of the leaves
    uint32_t pieces;
    struct shoot_branch *root;
    struct shoot_split_part *part; // owns the branches
    uint32_t parts;
};

// Where the segments' watch cuts it only shoot_split_finish may follow.
void shoot_split(struct shoot_split *s, const struct shoot_segments *in);
void shoot_split_finish(struct shoot_split *s);

#endif
