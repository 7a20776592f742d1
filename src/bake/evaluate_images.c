// Images with known noise; see evaluate_private.h.
#include <math.h>

#include "bake/evaluate_private.h"
#include "image/metric.h"

enum { VALUES = 3 * EVALUATION_PIXELS * EVALUATION_PIXELS };

enum status image_pair_init(struct image_pair *pair, struct error *error) {
    *pair = (struct image_pair){0};
    enum status status = image_init(&pair->half[0], EVALUATION_PIXELS, EVALUATION_PIXELS, 3, error);
    if (status == STATUS_OK) status = image_init(&pair->half[1], EVALUATION_PIXELS, EVALUATION_PIXELS, 3, error);
    return status;
}

void image_pair_fini(struct image_pair *pair) {
    image_fini(&pair->half[0]);
    image_fini(&pair->half[1]);
}

enum status image_pair_mean(const struct image_pair *pair, struct image *mean, struct error *error) {
    return image_mean(mean, &pair->half[0], &pair->half[1], error);
}

// The bias of log(1 + x) is -variance / (2 (1 + x)^2) to first order, and half as large for the mean as for each of the
// two (Quenouille 1956).
float log_of_mean(float x0, float x1) { return 2 * log1pf(0.5f * (x0 + x1)) - 0.5f * (log1pf(x0) + log1pf(x1)); }

static enum status mean_flip(const struct image *image, const struct image *reference, float exposure, double *flip,
                             struct error *error) {
    struct metrics metrics;
    enum status status = metrics_compute(&metrics, image, reference, NULL, exposure, error);
    *flip = metrics.flip;
    return status;
}

// FLIP of the two means as if both were free of noise. Where differences are noise of variance v about true ones,
// flip^q grows in proportion to v; q is found by giving the model's mean alone the noise of once and twice v, and the
// line through v (of the means) and 2 v (of the halves) leads back to 0. Where true differences are in a few places
// only, the result is too large, by less than half of what the noise had added in the test of it.
static double flip_without_noise(double flip, double flip_half, double noise, double noise_half) {
    const double growth = noise > 0 ? noise_half / noise : 1;
    if (!(growth > 1.05)) return flip;
    const double q = fmin(1 / log2(growth), 8), rest = 2 * pow(flip, q) - pow(flip_half, q);
    return rest > 0 ? pow(rest, 1 / q) : 0;
}

// FLIP of the model's mean against itself with the noise of the difference, `times` as strong, added.
static enum status noise_flip(const struct image_pair *model, const struct image_pair *reference,
                              const struct image *mean, float times, float exposure, double *flip,
                              struct error *error) {
    struct image other = {0};
    enum status status = image_init(&other, EVALUATION_PIXELS, EVALUATION_PIXELS, 3, error);
    for (size_t i = 0; i < VALUES && status == STATUS_OK; i++) {
        float change = 0.5f * (model->half[0].pixels[i] - model->half[1].pixels[i] - reference->half[0].pixels[i] +
                               reference->half[1].pixels[i]);
        other.pixels[i] = fmaxf(0, mean->pixels[i] + times * change);
    }
    if (status == STATUS_OK) status = mean_flip(&other, mean, exposure, flip, error);
    image_fini(&other);
    return status;
}

enum status image_pair_flip(const struct image_pair *model, const struct image_pair *reference, double *flip,
                            double *noise, double *black, struct error *error) {
    struct image a = {0}, r = {0}, zero = {0};
    double noise_half = 0, half[2] = {0, 0}, both = 0;
    enum status status = image_pair_mean(model, &a, error);
    if (status == STATUS_OK) status = image_pair_mean(reference, &r, error);
    if (status == STATUS_OK) status = image_init(&zero, EVALUATION_PIXELS, EVALUATION_PIXELS, 3, error);
    const float exposure = status == STATUS_OK ? image_auto_exposure(&r) : 1;
    if (status == STATUS_OK) status = mean_flip(&zero, &r, exposure, black, error);
    if (status == STATUS_OK) status = mean_flip(&a, &r, exposure, &both, error);
    for (int h = 0; h < 2 && status == STATUS_OK; h++)
        status = mean_flip(&model->half[h], &reference->half[h], exposure, &half[h], error);
    if (status == STATUS_OK) status = noise_flip(model, reference, &a, 1, exposure, noise, error);
    if (status == STATUS_OK) status = noise_flip(model, reference, &a, sqrtf(2), exposure, &noise_half, error);
    if (status == STATUS_OK) *flip = flip_without_noise(both, 0.5 * (half[0] + half[1]), *noise, noise_half);
    image_fini(&a);
    image_fini(&r);
    image_fini(&zero);
    return status;
}
