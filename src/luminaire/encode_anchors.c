// Anchors: centres of the emission. A line takes the anchor it passes nearest; its perpendicular offset from it, in a
// frame of w, in units of the anchor radius and contracted beyond 1, indexes that anchor's own slice of two 2D grids
// and, with the octahedral w, of four 4D grids. What varies on a clear lamp is which emitter a line passes and how
// close.
#include "luminaire/encoding.h"

#include <math.h>

enum { FLAT_LEVELS = 2, LEVELS = 4, MAX_SLICE_BITS = 14, MIN_SLICE_BITS = 6 };

float anchor_contract(float distance) { return distance > 1 ? 2 - 1 / distance : distance; }

static void anchors_plan(struct encoding *encoding) {
    int count = encoding->options.anchor_count;
    if (count == 0) return;
    struct grid_layout *layout = &encoding->layout;
    encoding->anchor_set = layout->set_count;
    encoding->anchor_raw = layout->raw_count;
    layout->raw_count += 2;
    int bits = encoding->options.log2_entries + 1; // all slices of a level together
    for (int n = count; n > 1; n = (n + 1) / 2) bits--;
    bits = bits > MAX_SLICE_BITS ? MAX_SLICE_BITS : bits < MIN_SLICE_BITS ? MIN_SLICE_BITS : bits;
    for (int k = 0; k < FLAT_LEVELS; k++)
        grid_add_lookup(layout, grid_add_level(layout, 2, k ? 96 : 24, bits, (uint32_t)count), encoding->anchor_set);
    for (int k = 0; k < LEVELS; k++)
        grid_add_lookup(layout, grid_add_level(layout, 4, encoding_resolution(k, LEVELS, 6, 48), bits, (uint32_t)count),
                        encoding->anchor_set);
}

static void anchors_encode(const struct encoding *encoding, const struct line_block *lines, struct grid_input *input) {
    const struct encoding_options *options = &encoding->options;
    if (options->anchor_count == 0) return;
    float best[NET_LANES], dx[NET_LANES], dy[NET_LANES], dz[NET_LANES];
    int32_t nearest[NET_LANES];
    for (int l = 0; l < NET_LANES; l++) best[l] = INFINITY, dx[l] = dy[l] = dz[l] = 0, nearest[l] = 0;
    for (int i = 0; i < options->anchor_count; i++) {
        const float ax = options->anchors[i][0], ay = options->anchors[i][1], az = options->anchors[i][2];
        for (int l = 0; l < NET_LANES; l++) {
            float x = lines->q[0][l] - ax, y = lines->q[1][l] - ay, z = lines->q[2][l] - az;
            float along = x * lines->w[0][l] + y * lines->w[1][l] + z * lines->w[2][l];
            float d2 = x * x + y * y + z * z - along * along;
            int closer = d2 < best[l];
            best[l] = closer ? d2 : best[l];
            dx[l] = closer ? x : dx[l];
            dy[l] = closer ? y : dy[l];
            dz[l] = closer ? z : dz[l];
            nearest[l] = closer ? i : nearest[l];
        }
    }
    float(*set)[NET_LANES] = input->set[encoding->anchor_set];
    const float inverse = 1 / options->anchor_radius;
    for (int l = 0; l < NET_LANES; l++) {
        float wx = lines->w[0][l], wy = lines->w[1][l], wz = lines->w[2][l]; // frame of w as in frame_from_normal
        float sign = wz < 0 ? -1.0f : 1.0f, a = -1 / (sign + wz), b = wx * wy * a;
        float x = ((1 + sign * wx * wx * a) * dx[l] + sign * b * dy[l] - sign * wx * dz[l]) * inverse;
        float y = (b * dx[l] + (sign + wy * wy * a) * dy[l] - wy * dz[l]) * inverse;
        float r2 = x * x + y * y, r = sqrtf(r2),
              contract = r > 1 ? anchor_contract(r > 1 ? r : 1) / (r > 1 ? r : 1) : 1;
        set[0][l] = 0.5f + 0.25f * contract * x;
        set[1][l] = 0.5f + 0.25f * contract * y;
        input->slice[encoding->anchor_set][l] = nearest[l];
        input->raw[encoding->anchor_raw][l] = contract * r;
        input->raw[encoding->anchor_raw + 1][l] = 1 / (1 + 4 * r2);
    }
    octahedral_block(lines->w, set[2], set[3]);
}

const struct encoding_type encoding_anchors = {"anchors", anchors_plan, anchors_encode};
