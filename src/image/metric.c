// Error measures of `sconce compare`, `sconce evaluate` and the tests. Everything is summed in double.
#include "image/metric.h"

#include <math.h>
#include <stdlib.h>

#include "math/vec.h"

enum { BLOCKS = 4 };

struct sums {
    double squared, relative, logarithmic;
    double peak, log_peak; // the reference's maxima
    double image[3], reference[3];
    double block_image[BLOCKS * BLOCKS], block_reference[BLOCKS * BLOCKS];
    size_t count;
};

static const float *pixel_at(const struct image *image, int x, int y) {
    return image->pixels + ((size_t)y * (size_t)image->width + (size_t)x) * (size_t)image->channels;
}

static bool pixel_counts(const struct image *mask, int x, int y) { return !mask || pixel_at(mask, x, y)[0] > 0.5f; }

double pixel_relative_error(const float *pixel, const float *reference) {
    double sum = 0;
    for (int c = 0; c < 3; c++) {
        const double r = reference[c], difference = (double)pixel[c] - r;
        sum += difference * difference / (r * r + 1e-3);
    }
    return sum;
}

static void sums_add(struct sums *sums, const float *image, const float *reference, int block) {
    for (int c = 0; c < 3; ++c) {
        double a = image[c], r = reference[c], difference = a - r;
        double log_a = log1p(fmax(a, 0)), log_r = log1p(fmax(r, 0));
        sums->squared += difference * difference;
        sums->logarithmic += (log_a - log_r) * (log_a - log_r);
        sums->peak = fmax(sums->peak, r);
        sums->log_peak = fmax(sums->log_peak, log_r);
        sums->image[c] += a;
        sums->reference[c] += r;
        sums->block_image[block] += a;
        sums->block_reference[block] += r;
    }
    sums->relative += pixel_relative_error(image, reference);
    ++sums->count;
}

static bool size_equal(const struct image *a, const struct image *b) {
    return a->width == b->width && a->height == b->height;
}

static enum status check_images(const struct image *image, const struct image *reference, const struct image *mask,
                                struct error *error) {
    if (!size_equal(image, reference) || (mask && !size_equal(mask, reference))) {
        return error_set(error, STATUS_INVALID, "the images differ in size: %d x %d and %d x %d%s", image->width,
                         image->height, reference->width, reference->height,
                         mask && !size_equal(mask, reference) ? "; the mask differs too" : "");
    }
    if (image->channels < 3 || reference->channels < 3) {
        return error_set(error, STATUS_INVALID, "images are compared as RGB; these have %d and %d channels",
                         image->channels, reference->channels);
    }
    return STATUS_OK;
}

// Relative to the whole reference where a block of it is black.
static void block_errors(struct metrics *metrics, const struct sums *sums, const size_t *block_counts) {
    double floor = 1e-6 * (sums->reference[0] + sums->reference[1] + sums->reference[2]) / (double)sums->count,
           total = 0;
    int used = 0;
    for (int b = 0; b < BLOCKS * BLOCKS; ++b) {
        if (block_counts[b] == 0) continue;
        double reference = fmax(sums->block_reference[b], floor * (double)block_counts[b]);
        double value = reference > 0 ? fabs(sums->block_image[b] - sums->block_reference[b]) / reference : 0;
        metrics->block_error_max = fmax(metrics->block_error_max, value);
        total += value;
        ++used;
    }
    metrics->block_error_mean = total / used;
}

static enum status mean_flip(double *mean, const struct image *image, const struct image *reference,
                             const struct image *mask, float exposure, size_t count, struct error *error) {
    struct image map;
    enum status status = flip_map(&map, image, reference, exposure, error);
    if (status != STATUS_OK) return status;
    double sum = 0;
    for (int y = 0; y < map.height; ++y) {
        for (int x = 0; x < map.width; ++x) sum += pixel_counts(mask, x, y) ? (double)pixel_at(&map, x, y)[0] : 0;
    }
    *mean = sum / (double)count;
    image_fini(&map);
    return STATUS_OK;
}

enum status metrics_compute(struct metrics *metrics, const struct image *image, const struct image *reference,
                            const struct image *mask, float exposure, struct error *error) {
    *metrics = (struct metrics){0};
    enum status status = check_images(image, reference, mask, error);
    if (status != STATUS_OK) return status;
    struct sums sums = {0};
    size_t block_counts[BLOCKS * BLOCKS] = {0};
    for (int y = 0; y < image->height; ++y) {
        for (int x = 0; x < image->width; ++x) {
            if (!pixel_counts(mask, x, y)) continue;
            const float *a = pixel_at(image, x, y), *r = pixel_at(reference, x, y);
            for (int c = 0; c < 3; ++c) {
                if (isfinite(a[c]) && isfinite(r[c])) continue;
                return error_set(error, STATUS_INVALID, "pixel (%d, %d) of the %s is not finite", x, y,
                                 isfinite(r[c]) ? "image" : "reference");
            }
            int block =
                (int)((long long)y * BLOCKS / image->height) * BLOCKS + (int)((long long)x * BLOCKS / image->width);
            sums_add(&sums, a, r, block);
            ++block_counts[block];
        }
    }
    if (sums.count == 0) return error_set(error, STATUS_INVALID, "the mask leaves no pixel to compare");
    double values = 3 * (double)sums.count;
    metrics->pixel_count = sums.count;
    metrics->mse = sums.squared / values;
    metrics->rel_mse = sums.relative / values;
    metrics->psnr_db = 10 * log10(sums.peak * sums.peak / metrics->mse);
    metrics->psnr_log_db = 10 * log10(sums.log_peak * sums.log_peak / (sums.logarithmic / values));
    for (int c = 0; c < 3; ++c) metrics->mean_ratio[c] = sums.image[c] / sums.reference[c];
    block_errors(metrics, &sums, block_counts);
    return mean_flip(&metrics->flip, image, reference, mask, exposure, sums.count, error);
}

static int compare_floats(const void *a, const void *b) {
    float x = *(const float *)a, y = *(const float *)b;
    return x < y ? -1 : x > y;
}

// Only pixels with light count, so that a small lamp before black is not blown out. Images without any get 1.
float image_auto_exposure(const struct image *image) {
    size_t count = (size_t)image->width * (size_t)image->height, lit = 0;
    float *values = malloc(count * sizeof *values);
    if (!values) return 1;
    for (size_t i = 0; i < count; ++i) {
        const float *p = image->pixels + i * (size_t)image->channels;
        float luminance = image->channels < 3 ? p[0] : rgb_luminance((rgb){p[0], p[1], p[2]});
        if (luminance > 0 && isfinite(luminance)) values[lit++] = luminance;
    }
    qsort(values, lit, sizeof *values, compare_floats);
    float exposure = lit > 0 ? 0.8f / values[(size_t)(0.9 * (double)(lit - 1))] : 1;
    free(values);
    return isfinite(exposure) ? exposure : 1;
}
