#include "luminaire/encoding.h"

#include <math.h>

const struct encoding_type *const encoding_table[] = {&encoding_grid4, &encoding_anchors, &encoding_shells,
                                                      &encoding_hull,  &encoding_raw,     NULL};

void encoding_init(struct encoding *encoding, const struct encoding_options *options) {
    *encoding = (struct encoding){.options = *options};
    for (int i = 0; encoding_table[i]; i++) encoding_table[i]->plan(encoding);
}

void encoding_encode(const struct encoding *encoding, const struct line_block *lines, struct grid_input *input) {
    for (int i = 0; encoding_table[i]; i++) encoding_table[i]->encode(encoding, lines, input);
}

enum status encoding_options_check(const struct encoding_options *options, struct error *error) {
    if (options->log2_entries < 10 || options->log2_entries > 20)
        return error_set(error, STATUS_INVALID, "table size 2^%d is out of range; use 10 to 20", options->log2_entries);
    if (options->anchor_count < 0 || options->anchor_count > ENCODING_MAX_ANCHORS || options->shell_count < 0 ||
        options->shell_count > ENCODING_MAX_SHELLS)
        return error_set(error, STATUS_INVALID, "%d anchors and %d shells; at most %d and %d are possible",
                         options->anchor_count, options->shell_count, ENCODING_MAX_ANCHORS, ENCODING_MAX_SHELLS);
    if (options->anchor_count > 0 && !(options->anchor_radius > 1e-6f && options->anchor_radius <= 10))
        return error_set(error, STATUS_INVALID, "anchor radius %g of the proxy's radius is out of range",
                         (double)options->anchor_radius);
    for (int i = 0; i < options->anchor_count; i++)
        for (int a = 0; a < 3; a++)
            if (!(fabsf(options->anchors[i][a]) <= 10))
                return error_set(error, STATUS_INVALID, "anchor %d is far outside the proxy", i);
    for (int i = 0; i < options->shell_count; i++)
        if (!(options->shells[i] >= 0 && options->shells[i] <= 1))
            return error_set(error, STATUS_INVALID, "shell radius %g is not within [0, 1]", (double)options->shells[i]);
    return STATUS_OK;
}

int encoding_resolution(int k, int count, float first, float last) {
    return (int)lrintf(first * powf(last / first, (float)k / (float)(count - 1)));
}

void octahedral_block(const float w[3][NET_LANES], float x[NET_LANES], float y[NET_LANES]) {
    for (int l = 0; l < NET_LANES; l++) {
        float scale = 1 / (fabsf(w[0][l]) + fabsf(w[1][l]) + fabsf(w[2][l]));
        float px = w[0][l] * scale, py = w[1][l] * scale;
        float fx = (1 - fabsf(py)) * (px < 0 ? -1.0f : 1.0f), fy = (1 - fabsf(px)) * (py < 0 ? -1.0f : 1.0f);
        x[l] = 0.5f + 0.5f * (w[2][l] < 0 ? fx : px);
        y[l] = 0.5f + 0.5f * (w[2][l] < 0 ? fy : py);
    }
}

// --- Raw features: exit point, direction, the point nearest the centre ---

static void raw_plan(struct encoding *encoding) { encoding->layout.raw_count += 9; }

static void raw_encode(const struct encoding *encoding, const struct line_block *lines, struct grid_input *input) {
    int first = encoding->layout.raw_count - 9;
    for (int a = 0; a < 3; a++)
        for (int l = 0; l < NET_LANES; l++) {
            input->raw[first + a][l] = lines->u[a][l];
            input->raw[first + 3 + a][l] = lines->w[a][l];
            input->raw[first + 6 + a][l] = lines->q[a][l];
        }
}

const struct encoding_type encoding_raw = {"raw", raw_plan, raw_encode};
