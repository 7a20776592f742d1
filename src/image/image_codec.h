// What image_load and image_save hand to the codecs. Bytes in, pixels out: the files are image.c's business.
#pragma once

#include <stdint.h>

#include "image/image.h"

// `path` names the file in errors.
enum status image_decode_exr(struct image *image, const char *path, const uint8_t *bytes, size_t length,
                             struct error *error);
enum status image_encode_exr(const struct image *image, const char *path, uint8_t **bytes, size_t *length,
                             struct error *error);
enum status image_decode_ldr(struct image *image, const char *path, const uint8_t *bytes, size_t length, bool raw,
                             struct error *error);
// Allocates image->channel_names (all empty).
enum status image_name_channels(struct image *image, struct error *error);
