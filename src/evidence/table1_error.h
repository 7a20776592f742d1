// What an error is made of. relMSE, the mean of (x - r)^2 / (r^2 + 1e-3), of a picture against a noisy reference is
// bias + the picture's noise + the reference's noise; two independent renderings of each tell the three apart.
#pragma once

#include "image/image.h"

struct error_parts {
    double reference_noise; // of the mean of both reference renderings
    double noise; // of the mean of both renderings
    double bias; // of a rendering without noise against a reference without; may come out below 0 within bias_error
    double bias_error; // standard error of it
};

// All of one size with at least 3 channels; mask (pixels count where > 0.5) may be NULL. Does no checks.
struct error_parts error_split(const struct image *const pictures[2], const struct image *const references[2],
                               const struct image *mask);

// The share of the picture's squared relative error that lies in the worst thousandth of the pixels (at least one):
// fireflies, of the picture or of the reference. NAN without memory or without error. drop: these pixels are taken out
// of the mask, which may be NULL only without.
double error_share_of_worst(const struct image *picture, const struct image *reference, struct image *mask, bool drop);

// How many samples a pixel bring the error down to `target`, where it is bias + noise_of_one / samples; INFINITY where
// the bias alone is as much.
double error_samples(double noise_of_one, double bias, double target);
