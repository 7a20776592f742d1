// The tree in memory, shared by mesh_tree.c, which walks it, and mesh_tree_build.c.
#pragma once

#include "luminaire/mesh_tree.h"

enum { LANES = 8, MOST_BLOCKS = 2 }; // of a leaf

// 0: nothing; a leaf of 1 or 2 blocks: (first block << 2) | count; an inner node: (node << 2) | CHILD_INNER.
enum { CHILD_COUNT = 3, CHILD_INNER = 3, CHILD_SHIFT = 2 };

struct mesh_node {
    _Alignas(32) float bounds[2][3][LANES]; // lower and upper; of nothing: inside out
    uint32_t child[LANES];
};

struct mesh_block {
    _Alignas(32) float corners[3][3][LANES]; // [corner][axis]; left over: all the same point
    uint32_t triangle[LANES];
};

struct mesh_tree {
    struct mesh_node *nodes; // the first is the root
    struct mesh_block *blocks;
};
