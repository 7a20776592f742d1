// How far an image is from its reference.
#pragma once

#include "image/image.h"

struct metrics {
    double mse, psnr_db; // of linear RGB; PSNR against the reference's maximum
    double rel_mse; // mean of (a - r)^2 / (r^2 + 1e-3)
    double psnr_log_db; // PSNR of log(1 + x), peak = the reference's maximum of it
    double flip; // mean FLIP (Andersson et al. 2020), LDR after tone mapping with `exposure`
    double mean_ratio[3]; // mean of the image / mean of the reference, per channel
    double block_error_max, block_error_mean; // |mean ratio - 1| over a 4x4 grid of blocks (masked pixels left out)
    size_t pixel_count; // how many pixels were compared
};

// Both images have the same size and at least 3 channels; mask (1+ channels, same size; pixel counts where > 0.5) may
// be NULL.
enum status metrics_compute(struct metrics *metrics, const struct image *image, const struct image *reference,
                            const struct image *mask, float exposure, struct error *error);
// FLIP per pixel, as an image of one channel.
enum status flip_map(struct image *map, const struct image *image, const struct image *reference, float exposure,
                     struct error *error);
// Sum over R, G, B of (a - r)^2 / (r^2 + 1e-3), the summand of relMSE.
double pixel_relative_error(const float *pixel, const float *reference);
// An exposure that puts the 90th-percentile luminance of the pixels that are not black at 0.8; 1 for a black image.
float image_auto_exposure(const struct image *image);
