// From image files to figures. A Monte Carlo reference has noise of its own: E|a - r|^2 = E|a - truth|^2 + var(r), so
// its variance channels, where the file has them, are taken off for the corrected figure.
#include "report/compare.h"

#include <math.h>

static double reference_noise(const struct image *reference, const struct image *mask) {
    int variance[3] = {image_channel(reference, "variance.R"), image_channel(reference, "variance.G"),
                       image_channel(reference, "variance.B")};
    if (variance[0] < 0 || variance[1] < 0 || variance[2] < 0) return NAN;
    double sum = 0;
    size_t count = 0, pixels = (size_t)reference->width * (size_t)reference->height;
    for (size_t i = 0; i < pixels; i++) {
        if (mask && !(mask->pixels[i * (size_t)mask->channels] > 0.5f)) continue;
        const float *pixel = &reference->pixels[i * (size_t)reference->channels];
        for (int c = 0; c < 3; c++) sum += pixel[variance[c]] / ((double)pixel[c] * pixel[c] + 1e-3);
        count += 3;
    }
    return count ? sum / (double)count : NAN;
}

enum status compare_images(const struct image *image, const struct image *reference, const struct image *mask,
                           struct comparison *comparison, struct error *error) {
    enum status status =
        metrics_compute(&comparison->metrics, image, reference, mask, image_auto_exposure(reference), error);
    if (!status) comparison->rel_mse_corrected = comparison->metrics.rel_mse - reference_noise(reference, mask);
    return status;
}

enum status compare_files(const char *image_path, const char *reference_path, const char *mask_path,
                          struct comparison *comparison, struct error *error) {
    struct image image = {0}, reference = {0}, mask = {0};
    enum status status = image_load(&image, image_path, false, error);
    if (!status) status = image_load(&reference, reference_path, false, error);
    if (!status && mask_path) status = image_load(&mask, mask_path, true, error);
    if (!status) status = compare_images(&image, &reference, mask_path ? &mask : NULL, comparison, error);
    image_fini(&image);
    image_fini(&reference);
    image_fini(&mask);
    return status;
}
