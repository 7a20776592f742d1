// Two image files held against each other.
#pragma once

#include "image/metric.h"

struct comparison {
    struct metrics metrics;
    double
        rel_mse_corrected; // metrics.rel_mse less the reference's own noise, or NAN where it has no variance channels
};

// mask_path may be NULL.
enum status compare_files(const char *image_path, const char *reference_path, const char *mask_path,
                          struct comparison *comparison, struct error *error);
enum status compare_images(const struct image *image, const struct image *reference, const struct image *mask,
                           struct comparison *comparison, struct error *error);
