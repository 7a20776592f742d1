// The line as a point of a 4D grid: its entry and its exit on the sphere, each by the octahedral map. General, and the
// only encoding that knows nothing of the lamp.
#include "luminaire/encoding.h"

enum { LEVELS = 6 };

static void grid4_plan(struct encoding *encoding) {
    if (!encoding->options.use_grid4) return;
    struct grid_layout *layout = &encoding->layout;
    encoding->grid4_set = layout->set_count;
    for (int k = 0; k < LEVELS; k++)
        grid_add_lookup(
            layout, grid_add_level(layout, 4, encoding_resolution(k, LEVELS, 6, 64), encoding->options.log2_entries, 1),
            encoding->grid4_set);
}

static void grid4_encode(const struct encoding *encoding, const struct line_block *lines, struct grid_input *input) {
    if (!encoding->options.use_grid4) return;
    float(*set)[NET_LANES] = input->set[encoding->grid4_set];
    octahedral_block(lines->e, set[0], set[1]);
    octahedral_block(lines->u, set[2], set[3]);
    for (int l = 0; l < NET_LANES; l++) input->slice[encoding->grid4_set][l] = 0;
}

const struct encoding_type encoding_grid4 = {"grid4", grid4_plan, grid4_encode};
