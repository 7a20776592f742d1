// Bins of equal measure for comparing light fields by Monte Carlo; see line_bins.h.
#include "bake/line_bins.h"

#include <stdlib.h>

const float evaluation_distance_radii[EVALUATION_DISTANCES] = {1.2f, 2, 4, 10};

static bool bin_sums_init(struct bin_sums *sums, size_t n) {
    sums->sum = calloc(n, sizeof *sums->sum);
    sums->squares = calloc(n, sizeof *sums->squares);
    return sums->sum && sums->squares;
}

static void bin_sums_add(struct bin_sums *sums, size_t bin, float y) {
    sums->sum[bin] += y;
    sums->squares[bin] += y * y;
}

enum status line_bins_init(struct line_bins *bins, vec3 center, float radius, struct error *error) {
    *bins = (struct line_bins){.center = center, .radius = radius};
    bool patches = bin_sums_init(&bins->patches, (size_t)EVALUATION_DISTANCES * PATCHES);
    bins->batch = calloc((size_t)EVALUATION_DISTANCES * PATCHES, sizeof *bins->batch);
    if (bin_sums_init(&bins->bundles, BUNDLES) && patches && bins->batch) return STATUS_OK;
    line_bins_fini(bins);
    return error_set(error, STATUS_MEMORY, "out of memory for the evaluation");
}

void line_bins_fini(struct line_bins *bins) {
    free(bins->patches.sum);
    free(bins->patches.squares);
    free(bins->bundles.sum);
    free(bins->bundles.squares);
    free(bins->batch);
    *bins = (struct line_bins){0};
}

// Equal areas of the unit sphere: rows in z, columns in azimuth.
static size_t patch_from_direction(vec3 d) {
    int row = (int)(clampf(0.5f * (d.z + 1), 0, 0.999999f) * PATCH_ROWS);
    float turn = atan2f(d.y, d.x) * (0.5f * INV_PI_F);
    int column = (int)((turn < 0 ? turn + 1 : turn) * PATCH_COLUMNS);
    return (size_t)(row * PATCH_COLUMNS + (column < PATCH_COLUMNS ? column : PATCH_COLUMNS - 1));
}

static int grid_index(float offset) { return (int)clampf(0.5f * (offset + 1) * BUNDLE_GRID, 0, BUNDLE_GRID - 1); }

void line_bins_add(struct line_bins *bins, vec3 point, vec3 w, float y) {
    vec3 p = vec3_scale(vec3_sub(point, bins->center), 1 / bins->radius);
    vec3 middle = vec3_mad(w, -vec3_dot(p, w), p);
    float offset2 = vec3_dot(middle, middle);
    for (int k = 0; k < EVALUATION_DISTANCES; k++) {
        float r = evaluation_distance_radii[k], half = sqrtf(fmaxf(0, r * r - offset2));
        size_t patch = patch_from_direction(vec3_scale(vec3_mad(w, half, middle), 1 / r));
        bins->batch[(size_t)k * PATCHES + patch] += y;
    }
    struct frame frame = frame_from_normal(w);
    int x = grid_index(vec3_dot(middle, frame.s)), row = grid_index(vec3_dot(middle, frame.t));
    bin_sums_add(&bins->bundles, (patch_from_direction(w) * BUNDLE_GRID + (size_t)row) * BUNDLE_GRID + (size_t)x, y);
}

void line_bins_close_batch(struct line_bins *bins, size_t samples) {
    for (size_t i = 0; i < (size_t)EVALUATION_DISTANCES * PATCHES; i++) {
        bin_sums_add(&bins->patches, i, bins->batch[i]);
        bins->batch[i] = 0;
    }
    bins->samples += samples;
    bins->batches++;
}

static double bin_mean(const struct line_bins *bins, const struct bin_sums *sums, size_t bin) {
    return (double)sums->sum[bin] / (double)bins->samples;
}

// Of the bin's mean, by what `count` samples or batches differ by.
static double bin_variance(const struct line_bins *bins, const struct bin_sums *sums, size_t bin, size_t count) {
    double n = (double)count, sum = (double)sums->sum[bin], scale = (double)bins->samples;
    return count > 1 ? fmax(0, (double)sums->squares[bin] - sum * sum / n) * n / (n - 1) / (scale * scale) : 0;
}

static double patch_variance(const struct line_bins *bins, size_t patch) {
    return bin_variance(bins, &bins->patches, patch, bins->batches);
}

static double bundle_variance(const struct line_bins *bins, size_t bundle) {
    return bin_variance(bins, &bins->bundles, bundle, bins->samples);
}

void line_bins_irradiance_error(const struct line_bins *bins, const struct line_bins *reference, int distance,
                                float *error, float *noise) {
    const size_t first = (size_t)distance * PATCHES;
    double total = 0, sum = 0, noise_sum = 0;
    size_t count = 0;
    for (size_t i = 0; i < PATCHES; i++) total += bin_mean(reference, &reference->patches, first + i);
    for (size_t i = first; i < first + PATCHES; i++) {
        double e_ref = bin_mean(reference, &reference->patches, i), e = bin_mean(bins, &bins->patches, i);
        if (e_ref <= 0.01 * total / PATCHES) continue;
        double variance = patch_variance(reference, i) + patch_variance(bins, i);
        sum += fabs(e / e_ref - 1);
        noise_sum += sqrt(variance * 2 / (double)PI_F) / e_ref; // the mean of |x| of a normal x
        count++;
    }
    *error = count ? (float)(sum / (double)count) : 0;
    *noise = count ? (float)(noise_sum / (double)count) : 0;
}

float line_bins_radiance_error(const struct line_bins *bins, const struct line_bins *reference) {
    double error = 0, square = 0;
    for (size_t i = 0; i < BUNDLES; i++) {
        double l = bin_mean(bins, &bins->bundles, i), l_ref = bin_mean(reference, &reference->bundles, i);
        double variance = bundle_variance(bins, i), variance_ref = bundle_variance(reference, i);
        error += (l - l_ref) * (l - l_ref) - variance - variance_ref;
        square += l_ref * l_ref - variance_ref;
    }
    return square > 0 ? (float)(error / square) : 0;
}
