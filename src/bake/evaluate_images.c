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
    enum status status = image_init(mean, EVALUATION_PIXELS, EVALUATION_PIXELS, 3, error);
    for (size_t i = 0; i < VALUES && status == STATUS_OK; i++)
        mean->pixels[i] = 0.5f * (pair->half[0].pixels[i] + pair->half[1].pixels[i]);
    return status;
}

static enum status mean_flip(const struct image *image, const struct image *reference, float exposure, double *flip,
                             struct error *error) {
    struct metrics metrics;
    enum status status = metrics_compute(&metrics, image, reference, NULL, exposure, error);
    *flip = metrics.flip;
    return status;
}

enum status image_pair_flip(const struct image_pair *model, const struct image_pair *reference, double *flip,
                            double *noise, double *black, struct error *error) {
    struct image a = {0}, r = {0}, other = {0};
    enum status status = image_pair_mean(model, &a, error);
    if (status == STATUS_OK) status = image_pair_mean(reference, &r, error);
    if (status == STATUS_OK) status = image_init(&other, EVALUATION_PIXELS, EVALUATION_PIXELS, 3, error);
    if (status == STATUS_OK) {
        const float exposure = image_auto_exposure(&r);
        status = mean_flip(&other, &r, exposure, black, error);
        if (status == STATUS_OK) status = mean_flip(&a, &r, exposure, flip, error);
        for (size_t i = 0; i < VALUES; i++) {
            float change = 0.5f * (model->half[0].pixels[i] - model->half[1].pixels[i] + reference->half[0].pixels[i] -
                                   reference->half[1].pixels[i]);
            other.pixels[i] = fmaxf(0, a.pixels[i] + change);
        }
        if (status == STATUS_OK) status = mean_flip(&other, &a, exposure, noise, error);
    }
    image_fini(&a);
    image_fini(&r);
    image_fini(&other);
    return status;
}
