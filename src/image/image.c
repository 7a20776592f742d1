// Images in memory and the choice of the codec: by content when reading, by extension when writing.
#include "image/image.h"

#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "base/file.h"
#include "image/image_codec.h"

enum { SIDE_MAX = 1 << 20, CHANNELS_MAX = 1 << 12 };

enum status image_init(struct image *image, int width, int height, int channels, struct error *error) {
    *image = (struct image){0};
    if (width < 1 || height < 1 || channels < 1 || width > SIDE_MAX || height > SIDE_MAX || channels > CHANNELS_MAX) {
        return error_set(error, STATUS_INVALID, "an image of %d x %d pixels with %d channels is not possible", width,
                         height, channels);
    }
    size_t count = (size_t)width * (size_t)height * (size_t)channels; // at most 2^52
    image->pixels = calloc(count, sizeof *image->pixels);
    if (!image->pixels) {
        return error_set(error, STATUS_MEMORY, "out of memory for an image of %d x %d pixels with %d channels", width,
                         height, channels);
    }
    image->width = width;
    image->height = height;
    image->channels = channels;
    return STATUS_OK;
}

void image_fini(struct image *image) {
    free(image->pixels);
    free(image->channel_names);
    *image = (struct image){0};
}

enum status image_mean(struct image *mean, const struct image *a, const struct image *b, struct error *error) {
    enum status status = image_init(mean, a->width, a->height, 3, error);
    for (size_t i = 0; !status && i < (size_t)a->width * (size_t)a->height; i++)
        for (size_t c = 0; c < 3; c++)
            mean->pixels[3 * i + c] =
                0.5f * (a->pixels[i * (size_t)a->channels + c] + b->pixels[i * (size_t)b->channels + c]);
    return status;
}

int image_channel(const struct image *image, const char *name) {
    for (int c = 0; image->channel_names && c < image->channels; c++)
        if (!strcmp(image->channel_names[c], name)) return c;
    return -1;
}

enum status image_name_channels(struct image *image, struct error *error) {
    image->channel_names = calloc((size_t)image->channels, sizeof *image->channel_names);
    return image->channel_names ? STATUS_OK : error_set(error, STATUS_MEMORY, "out of memory for channel names");
}

enum status image_load(struct image *image, const char *path, bool raw, struct error *error) {
    static const uint8_t exr_magic[4] = {0x76, 0x2f, 0x31, 0x01};
    *image = (struct image){0};
    uint8_t *bytes;
    size_t length;
    enum status status = file_read(path, &bytes, &length, error);
    if (status != STATUS_OK) return status;
    if (length >= sizeof exr_magic && memcmp(bytes, exr_magic, sizeof exr_magic) == 0) {
        status = image_decode_exr(image, path, bytes, length, error);
    } else {
        status = image_decode_ldr(image, path, bytes, length, raw, error);
    }
    free(bytes);
    if (status != STATUS_OK) image_fini(image);
    return status;
}

enum status image_save(const struct image *image, const char *path, float exposure, struct error *error) {
    const char *extension = strrchr(path, '.');
    uint8_t *bytes = NULL;
    size_t length = 0;
    enum status status;
    if (extension && strcasecmp(extension, ".exr") == 0) {
        status = image_encode_exr(image, path, &bytes, &length, error);
    } else if (extension && strcasecmp(extension, ".png") == 0) {
        status = image_encode_png(image, exposure, &bytes, &length, error);
    } else {
        return error_set(error, STATUS_INVALID, "%s: unknown image format; give a name that ends in .exr or .png",
                         path);
    }
    if (status == STATUS_OK) status = file_write_atomic(path, bytes, length, error);
    free(bytes);
    return status;
}

// IEC 61966-2-1.
float srgb_from_linear(float v) { return v <= 0.0031308f ? 12.92f * v : 1.055f * powf(v, 1 / 2.4f) - 0.055f; }
float linear_from_srgb(float v) { return v <= 0.04045f ? v / 12.92f : powf((v + 0.055f) / 1.055f, 2.4f); }
