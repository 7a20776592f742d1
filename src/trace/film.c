// The film: the last stop of every integrator. Passes are independent estimates of the whole image, so their mean and
// the variance of that mean follow from Welford's recurrence (Welford 1962, Technometrics 4(3)) pixel by pixel.
#include "trace/film.h"

#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/parallel.h"

enum status film_init(struct film *film, const struct sensor *sensor, struct error *error) {
    *film = (struct film){.width = sensor->crop_width, .height = sensor->crop_height};
    if (film->width < 1 || film->height < 1)
        return error_set(error, STATUS_INVALID, "the film is %d x %d pixels; both must be at least 1", film->width,
                         film->height);
    size_t count = (size_t)film->width * (size_t)film->height;
    if (count > SIZE_MAX / (6 * sizeof *film->mean))
        return error_set(error, STATUS_INVALID, "a film of %d x %d pixels is too large", film->width, film->height);
    film->pass = calloc(3 * count, sizeof *film->pass);
    film->mean = calloc(3 * count, sizeof *film->mean);
    film->m2 = calloc(3 * count, sizeof *film->m2);
    if (film->pass && film->mean && film->m2) return STATUS_OK;
    film_fini(film);
    return error_set(error, STATUS_MEMORY, "out of memory for a film of %d x %d pixels", sensor->crop_width,
                     sensor->crop_height);
}

void film_fini(struct film *film) {
    free(film->pass);
    free(film->mean);
    free(film->m2);
    *film = (struct film){0};
}

static void end_pass_row(void *user, size_t row, int worker) {
    (void)worker;
    struct film *film = user;
    size_t stride = 3 * (size_t)film->width;
    double share = 1.0 / (double)film->pass_count;
    for (size_t i = row * stride; i < (row + 1) * stride; i++) {
        double value = film->pass[i], before = value - film->mean[i];
        film->mean[i] += before * share;
        film->m2[i] += before * (value - film->mean[i]);
        film->pass[i] = 0;
    }
}

void film_end_pass(struct film *film, int threads) {
    film->pass_count++;
    parallel_for(threads, (size_t)film->height, end_pass_row, film);
}

enum status film_image(const struct film *film, struct image *image, struct error *error) {
    static const char *const names[6] = {"R", "G", "B", "variance.R", "variance.G", "variance.B"};
    enum status status = image_init(image, film->width, film->height, 6, error);
    if (status != STATUS_OK) return status;
    image->channel_names = calloc(6, sizeof *image->channel_names);
    if (!image->channel_names) {
        image_fini(image);
        return error_set(error, STATUS_MEMORY, "out of memory for an image of %d x %d pixels", film->width,
                         film->height);
    }
    for (int c = 0; c < 6; c++) snprintf(image->channel_names[c], sizeof image->channel_names[c], "%s", names[c]);
    double n = (double)film->pass_count, to_variance = film->pass_count > 1 ? 1 / (n * (n - 1)) : 0;
    size_t count = (size_t)film->width * (size_t)film->height;
    for (size_t i = 0; i < count; i++) {
        for (size_t c = 0; c < 3; c++) {
            image->pixels[6 * i + c] = (float)film->mean[3 * i + c];
            image->pixels[6 * i + 3 + c] = (float)(film->m2[3 * i + c] * to_variance);
        }
    }
    return STATUS_OK;
}
