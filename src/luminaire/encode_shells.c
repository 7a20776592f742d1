// Shells: where the line crosses up to four concentric spheres on its way out, and the first of them on its way in,
// each looked up in one shared 3D hash grid. What varies on a frosted lamp is where on a surface the light leaves; the
// spheres lie at the radii of the lamp's own surfaces. A line that misses a sphere is looked up at its point nearest
// the centre.
#include "luminaire/encoding.h"

#include <math.h>

enum { LEVELS = 6 };

static void shells_plan(struct encoding *encoding) {
    int count = encoding->options.shell_count;
    if (count == 0) return;
    struct grid_layout *layout = &encoding->layout;
    encoding->shell_set = layout->set_count;
    for (int k = 0; k < LEVELS; k++) {
        int level =
            grid_add_level(layout, 3, encoding_resolution(k, LEVELS, 8, 160), encoding->options.log2_entries, 1);
        for (int s = 0; s <= count; s++) grid_add_lookup(layout, level, encoding->shell_set + s);
    }
}

static void shells_encode(const struct encoding *encoding, const struct line_block *lines, struct grid_input *input) {
    int count = encoding->options.shell_count;
    if (count == 0) return;
    for (int s = 0; s <= count; s++) {
        const float radius = encoding->options.shells[s < count ? s : 0], side = s < count ? 1.0f : -1.0f;
        const float step = radius * radius - 1;
        for (int l = 0; l < NET_LANES; l++) {
            float along2 = lines->half_chord[l] * lines->half_chord[l] + step;
            float along = side * sqrtf(along2 > 0 ? along2 : 0);
            for (int a = 0; a < 3; a++)
                input->set[encoding->shell_set + s][a][l] = 0.5f + 0.5f * (lines->q[a][l] + along * lines->w[a][l]);
            input->slice[encoding->shell_set + s][l] = 0;
        }
    }
}

const struct encoding_type encoding_shells = {"shells", shells_plan, shells_encode};
