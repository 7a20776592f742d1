// Differences and crops.
#include "report/picture.h"

#include <assert.h>
#include <math.h>
#include <string.h>

enum status image_difference(struct image *difference, const struct image *a, const struct image *r,
                             struct error *error) {
    assert(a->width == r->width && a->height == r->height);
    enum status status = image_init(difference, r->width, r->height, 3, error);
    size_t pixels = (size_t)r->width * (size_t)r->height;
    for (size_t i = 0; !status && i < pixels; i++)
        for (size_t c = 0; c < 3; c++)
            difference->pixels[3 * i + c] =
                fabsf(a->pixels[i * (size_t)a->channels + c] - r->pixels[i * (size_t)r->channels + c]);
    return status;
}

enum status image_crop(struct image *crop, const struct image *image, int x, int y, int width, int height, int zoom,
                       struct error *error) {
    assert(x >= 0 && y >= 0 && x + width <= image->width && y + height <= image->height && image->channels >= 3);
    enum status status = image_init(crop, width * zoom, height * zoom, 3, error);
    if (status) return status;
    for (int j = 0; j < crop->height; j++)
        for (int i = 0; i < crop->width; i++)
            memcpy(&crop->pixels[3 * ((size_t)j * (size_t)crop->width + (size_t)i)],
                   &image->pixels[((size_t)(y + j / zoom) * (size_t)image->width + (size_t)(x + i / zoom)) *
                                  (size_t)image->channels],
                   3 * sizeof(float));
    return STATUS_OK;
}
