// Lines in the unit ball: the bounding sphere of the proxy becomes the unit sphere. A block of NET_LANES lines, each by
// its exit point u, entry point e, direction w and point q nearest the centre, as the encodings want them.
#pragma once

#include "net/grid.h"

struct hull_crossing;

struct line_block {
    _Alignas(64) float u[3][NET_LANES], e[3][NET_LANES], q[3][NET_LANES], w[3][NET_LANES];
    float half_chord[NET_LANES]; // |u - q|
    const struct hull_crossing *crossings; // of the lines with a hull, or NULL; not set by line_block_load
    float hit[NET_LANES]; // 1: the line meets the sphere, 0: it does not (its points then lie on the rim)
};

// `count` <= NET_LANES lines; the rest of the block repeats the last one.
void line_block_load(struct line_block *block, const float center[3], float radius, int count, const float (*point)[3],
                     const float (*w)[3]);
