// Discrete distributions over n weights, and piecewise constant ones over the square.
#pragma once

#include <stddef.h>

#include "base/error.h"
#include "math/vec.h"

struct distribution { // zeroed: empty
    float *cdf; // n + 1 values, cdf[0] = 0, cdf[n] = 1
    size_t n;
    double total; // sum of the weights
};

// Weights must be finite and >= 0; with total 0 the distribution is uniform. Copies what it needs.
enum status distribution_init(struct distribution *d, const float *weights, size_t n, struct error *error);
void distribution_fini(struct distribution *d);
size_t distribution_sample(const struct distribution *d, float u, float *remapped_u); // remapped may be NULL
float distribution_pmf(const struct distribution *d, size_t index);

struct distribution2d {
    struct distribution rows, *columns; // marginal over y, conditional over x
    size_t width, height;
};

enum status distribution2d_init(struct distribution2d *d, const float *weights, size_t width, size_t height,
                                struct error *error);
void distribution2d_fini(struct distribution2d *d);
vec2 distribution2d_sample(const struct distribution2d *d, vec2 u, float *pdf); // pdf over [0,1]^2
float distribution2d_pdf(const struct distribution2d *d, vec2 p);
