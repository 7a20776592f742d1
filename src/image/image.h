// Images of float pixels, row-major from the top left, channels interleaved.
#pragma once

#include <stdbool.h>
#include <stddef.h>

#include "base/error.h"

struct image {
    int width, height, channels;
    float *pixels; // width * height * channels, malloc'ed
    char (*channel_names)[32]; // channels names as in the EXR ("R", "variance.R"), or NULL: 1 = Y, 3 = RGB, 4 = RGBA
};

enum status image_init(struct image *image, int width, int height, int channels, struct error *error); // zeroed pixels
void image_fini(struct image *image);
// RGB, the mean of the first three channels of two images of one size.
enum status image_mean(struct image *mean, const struct image *a, const struct image *b, struct error *error);
int image_channel(const struct image *image, const char *name); // its number, or -1
// EXR (half and float, any channels; R G B A come first), PNG and JPEG (converted from sRGB to linear unless `raw`),
// Radiance HDR.
enum status image_load(struct image *image, const char *path, bool raw, struct error *error);
// By extension: .exr (float, uncompressed, with channel_names), .png (8-bit sRGB after `exposure` scaling). Written
// then renamed.
enum status image_save(const struct image *image, const char *path, float exposure, struct error *error);
// PNG bytes in memory, malloc'ed, for the report.
enum status image_encode_png(const struct image *image, float exposure, unsigned char **bytes, size_t *length,
                             struct error *error);
float srgb_from_linear(float v);
float linear_from_srgb(float v);
