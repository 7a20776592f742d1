// How a line becomes the inputs of a network. encoding_table lists the encodings, one file each: an encoding adds its
// levels and lookups to the layout when it is planned, and fills its coordinate sets for every block. All of it is
// derived from the few numbers of struct encoding_options, so that a file needs to hold those only.
#pragma once

#include "base/error.h"
#include "luminaire/line.h"
#include "net/grid.h"

enum { ENCODING_MAX_ANCHORS = 256, ENCODING_MAX_SHELLS = 4 };

struct encoding_options { // lengths as fractions of the bounding sphere's radius, positions relative to its centre
    float anchors[ENCODING_MAX_ANCHORS][3];
    int anchor_count;
    float anchor_radius;
    float shells[ENCODING_MAX_SHELLS];
    int shell_count;
    bool use_grid4;
    bool use_hull;
    int log2_entries; // 10..20
};

struct encoding {
    struct encoding_options options;
    struct grid_layout layout;
    int anchor_set, anchor_raw, shell_set, grid4_set, hull_set,
        hull_raw; // where each encoding's coordinates and raw features go
};

struct encoding_type {
    const char *name;
    void (*plan)(struct encoding *encoding);
    void (*encode)(const struct encoding *encoding, const struct line_block *lines, struct grid_input *input);
};
extern const struct encoding_type *const encoding_table[]; // ends with NULL

void encoding_init(struct encoding *encoding, const struct encoding_options *options);
void encoding_encode(const struct encoding *encoding, const struct line_block *lines, struct grid_input *input);
// STATUS_INVALID with a reason where a number is out of its range.
enum status encoding_options_check(const struct encoding_options *options, struct error *error);

// Resolution of level k of `count`, in geometric steps from first to last.
int encoding_resolution(int k, int count, float first, float last);
// The distance at which a line passes an anchor, in anchor radii, as the encoding has it: ascending, below 2.
float anchor_contract(float distance);
// The octahedral map of warp.h over a block, to [0,1]^2.
void octahedral_block(const float w[3][NET_LANES], float x[NET_LANES], float y[NET_LANES]);

extern const struct encoding_type encoding_grid4, encoding_anchors, encoding_shells, encoding_hull, encoding_raw;
