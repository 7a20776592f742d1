// Discrete and piecewise constant distributions, sampled by bisection of the cumulative sum. Used for emitters,
// triangles, environment maps and the luminaire's sampling tables.
// The probability of an index is the difference of the float cdf, i.e. exactly what sampling does, and not the input
// weight: the estimators divided by it stay unbiased although the cdf is rounded.
#include "math/distribution.h"

#include <stdint.h>
#include <stdlib.h>

enum status distribution_init(struct distribution *d, const float *weights, size_t n, struct error *error) {
    *d = (struct distribution){0};
    if (n == 0) return error_set(error, STATUS_INVALID, "a distribution needs at least one weight");
    if (n >= SIZE_MAX / sizeof(float))
        return error_set(error, STATUS_MEMORY, "a distribution of %zu weights is too large", n);
    double total = 0;
    for (size_t i = 0; i < n; ++i) {
        if (!isfinite(weights[i]) || weights[i] < 0) {
            return error_set(error, STATUS_INVALID,
                             "weight %zu of a distribution is %g; weights must be finite and not negative", i,
                             (double)weights[i]);
        }
        total += (double)weights[i];
    }
    d->cdf = malloc((n + 1) * sizeof *d->cdf);
    if (!d->cdf) return error_set(error, STATUS_MEMORY, "out of memory for a distribution of %zu weights", n);
    double sum = 0;
    size_t last = n - 1; // the last index that may be sampled: all later ones get probability 0
    while (total > 0 && last > 0 && weights[last] == 0) --last;
    for (size_t i = 0; i < n; ++i) {
        d->cdf[i] = (float)(total > 0 ? sum / total : (double)i / (double)n);
        if (i > last) d->cdf[i] = 1;
        sum += (double)weights[i];
    }
    d->cdf[n] = 1;
    d->n = n;
    d->total = total;
    return STATUS_OK;
}

void distribution_fini(struct distribution *d) {
    free(d->cdf);
    *d = (struct distribution){0};
}

// Largest index with cdf[index] <= u: its successor is above u, so an index of probability 0 is never returned.
size_t distribution_sample(const struct distribution *d, float u, float *remapped_u) {
    u = clampf(u, 0, 0x1.fffffep-1f);
    size_t low = 0, high = d->n;
    while (high - low > 1) {
        size_t middle = low + (high - low) / 2;
        if (d->cdf[middle] <= u) {
            low = middle;
        } else {
            high = middle;
        }
    }
    if (remapped_u) *remapped_u = fminf((u - d->cdf[low]) / (d->cdf[low + 1] - d->cdf[low]), 0x1.fffffep-1f);
    return low;
}

float distribution_pmf(const struct distribution *d, size_t index) { return d->cdf[index + 1] - d->cdf[index]; }

enum status distribution2d_init(struct distribution2d *d, const float *weights, size_t width, size_t height,
                                struct error *error) {
    *d = (struct distribution2d){.width = width};
    if (width == 0 || height == 0)
        return error_set(error, STATUS_INVALID, "a 2D distribution needs at least one weight");
    d->columns = calloc(height, sizeof *d->columns);
    float *row_weights = calloc(height, sizeof *row_weights);
    enum status status =
        d->columns && row_weights
            ? STATUS_OK
            : error_set(error, STATUS_MEMORY, "out of memory for a %zu x %zu distribution", width, height);
    if (status == STATUS_OK) d->height = height;
    double largest = 0;
    for (size_t y = 0; y < height && status == STATUS_OK; ++y) {
        status = distribution_init(&d->columns[y], weights + y * width, width, error);
        largest = fmax(largest, d->columns[y].total);
    }
    for (size_t y = 0; y < height && status == STATUS_OK && largest > 0; ++y) {
        row_weights[y] = (float)(d->columns[y].total / largest); // scaled: the sum of a row may exceed FLT_MAX
    }
    if (status == STATUS_OK) status = distribution_init(&d->rows, row_weights, height, error);
    if (status == STATUS_OK) d->rows.total *= largest;
    free(row_weights);
    if (status != STATUS_OK) distribution2d_fini(d);
    return status;
}

void distribution2d_fini(struct distribution2d *d) {
    for (size_t y = 0; y < d->height; ++y) distribution_fini(&d->columns[y]);
    free(d->columns);
    distribution_fini(&d->rows);
    *d = (struct distribution2d){0};
}

static float cell_pdf(const struct distribution2d *d, size_t x, size_t y) {
    return distribution_pmf(&d->rows, y) * distribution_pmf(&d->columns[y], x) * (float)d->width * (float)d->height;
}

vec2 distribution2d_sample(const struct distribution2d *d, vec2 u, float *pdf) {
    float within_x, within_y;
    size_t y = distribution_sample(&d->rows, u.y, &within_y);
    size_t x = distribution_sample(&d->columns[y], u.x, &within_x);
    if (pdf) *pdf = cell_pdf(d, x, y);
    return (vec2){((float)x + within_x) / (float)d->width, ((float)y + within_y) / (float)d->height};
}

static size_t cell_index(float p, size_t n) {
    size_t i = (size_t)(clampf(p, 0, 1) * (float)n);
    return i < n ? i : n - 1;
}

float distribution2d_pdf(const struct distribution2d *d, vec2 p) {
    return cell_pdf(d, cell_index(p.x, d->width), cell_index(p.y, d->height));
}
