// Light on its way out of a lamp, sorted into bins: irradiance on the patches of large spheres, and radiance in small
// bundles of lines. Particles and a luminaire's lines go through the same bins, each with its own noise.
#pragma once

#include "bake/evaluate.h"
#include "math/vec.h"

enum {
    PATCH_ROWS = 10,
    PATCH_COLUMNS = 20,
    PATCHES = PATCH_ROWS * PATCH_COLUMNS, // of equal area, on each sphere
    BUNDLE_GRID = 32,
    BUNDLES = PATCHES * BUNDLE_GRID * BUNDLE_GRID, // directions x offsets, of equal measure
};

struct bin_sums { // of one estimate: sum of the values and of the squares, of batches (patches) or samples (bundles)
    float *sum, *squares;
};

struct line_bins {
    vec3 center;
    float radius;
    size_t samples, batches; // drawn, those of value 0 included; closed
    struct bin_sums patches, bundles; // EVALUATION_DISTANCES * PATCHES; BUNDLES
    float *batch; // the patches' sums of the running batch
};

enum status line_bins_init(struct line_bins *bins, vec3 center, float radius, struct error *error);
void line_bins_fini(struct line_bins *bins);
// A sample of value y (mean over the channels) on the line that leaves through `point`.
void line_bins_add(struct line_bins *bins, vec3 point, vec3 w, float y);
// Closes a batch of so many samples. Batches are of one size; the noise on the patches is what their sums differ by, so
// that at least two are needed, and stratified samples are not taken for independent ones.
void line_bins_close_batch(struct line_bins *bins, size_t samples);

// Mean over the patches (those with at least 1 % of the mean irradiance) of |E / E_ref - 1|, and what noise alone
// gives.
void line_bins_irradiance_error(const struct line_bins *bins, const struct line_bins *reference, int distance,
                                float *error, float *noise);
// Sum over the bundles of (L - L_ref)^2 less the noise of both, over the sum of L_ref^2 less its noise.
float line_bins_radiance_error(const struct line_bins *bins, const struct line_bins *reference);
