// Where a line meets the first translucent surface of the lamp's hull, in a 3D hash grid, with what lies behind it:
// what varies on frosted glass is where on which surface a line passes, and how many it passes.
#include "luminaire/encoding.h"
#include "luminaire/hull_tree.h"

enum { LEVELS = 6, RAW = 9, MOST_LAYERS = 8 };

static void hull_plan(struct encoding *encoding) {
    if (!encoding->options.use_hull) return;
    struct grid_layout *layout = &encoding->layout;
    encoding->hull_set = layout->set_count;
    encoding->hull_raw = layout->raw_count;
    layout->raw_count += RAW;
    for (int k = 0; k < LEVELS; k++)
        grid_add_lookup(
            layout,
            grid_add_level(layout, 3, encoding_resolution(k, LEVELS, 8, 160), encoding->options.log2_entries, 1),
            encoding->hull_set);
}

static void hull_encode(const struct encoding *encoding, const struct line_block *lines, struct grid_input *input) {
    if (!encoding->options.use_hull) return;
    const int set = encoding->hull_set;
    float(*raw)[NET_LANES] = input->raw + encoding->hull_raw;
    for (int l = 0; l < NET_LANES; l++) {
        const struct hull_crossing *crossing = &lines->crossings[l];
        float facing = 0;
        for (int a = 0; a < 3; a++) {
            input->set[set][a][l] = 0.5f + 0.5f * crossing->point[a];
            raw[a][l] = crossing->point[a];
            raw[3 + a][l] = crossing->normal[a];
            facing += crossing->normal[a] * lines->w[a][l];
        }
        input->slice[set][l] = 0;
        float layers = (float)(crossing->layers < MOST_LAYERS ? crossing->layers : MOST_LAYERS);
        raw[6][l] = facing;
        raw[7][l] = layers / MOST_LAYERS;
        raw[8][l] = crossing->blocked ? 1.0f : 0.0f;
    }
}

const struct encoding_type encoding_hull = {"hull", hull_plan, hull_encode};
