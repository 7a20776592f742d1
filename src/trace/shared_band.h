// What is known of the pixels in a band of rows, and what their neighbours predict; see shared_filter.c.
#pragma once

#include "trace/shared_filter.h"

// Means over the discs, and over all but the first the value here of the plane that fits best.
enum { TILTED = DISCS - 1, PREDICTIONS = DISCS + TILTED };
enum estimate { OWN_SAMPLES = PREDICTIONS, OWN_BATCHES, ESTIMATES }; // after the predictions
enum { MOMENTS = 5 }; // x, y, xx, xy, yy

struct part_planes {
    bool lit; // else there is nothing to share
    float *light[3]; // sums
    float *weight; // squared luminance of the mean weight; once predicted relative, as the errors; 0: shares nothing
    float *prediction[PREDICTIONS][3]; // these and the errors are of one layer at a time
    // As the picture would have them, relative to its level there: squared distances from the predictions to the own
    // mean; the variance of that by its samples and by its batches, of which either may be too large.
    float *errors[ESTIMATES];
    float *tilt[TILTED][3][2]; // of a row: sums of light times the columns and rows that it is away
};

struct layer {
    uint32_t *surface; // 0: shares nothing
    float *count, *p[3], *n[3];
    struct part_planes parts[SHARED_PARTS];
    bool met; // else there is nothing in it
};

struct disc_offset { // from a pixel to a neighbour in the widest disc
    int dx, dy, disc; // the smallest that it is in
    ptrdiff_t away; // in the planes
    float weights[DISCS];
};
enum { MOST_OFFSETS = (2 * REACH + 1) * (2 * REACH + 1) };

struct band {
    const struct shared_light *shared;
    const struct excess_list *outliers; // of every band of the picture
    int width, first, last; // rows that it holds
    size_t stride; // from row to row: whole vectors, with empty columns on both sides
    struct disc_offset offsets[MOST_OFFSETS]; // row by row
    int offset_count;
    struct layer layers[SHARED_LAYERS];
    float *level; // luminance of all that is shared
    float least_level; // is added to it
    float *counts[DISCS], *moments[TILTED][MOMENTS]; // of a row
    float *memory; // of all but the surfaces
    uint32_t *surfaces;
};

// Rows. BAND: most that are made at a time; EDGE: columns that are left empty on both sides.
enum { BAND = 32, WINDOW = 3, HALO = WINDOW + REACH, MOST_ROWS = BAND + 2 * HALO, EDGE = 8 };
_Static_assert((int)EDGE >= (int)REACH && (int)EDGE >= (int)LANE_COUNT, "vectors end in the empty columns");

bool band_init(struct band *band, const struct shared_light *shared, const struct excess_list *outliers,
               float least_level); // false: out of memory
void band_fini(struct band *band);
void band_fill(struct band *band, int first, int last, size_t first_list, size_t lists); // rows; their outliers
void band_predict(struct band *band, int layer, int first, int last); // rows among them
float pixel_level(const struct shared_light *shared, size_t pixel);

static inline size_t band_row(const struct band *band, int y) {
    return (size_t)(y - band->first) * band->stride + EDGE;
}
