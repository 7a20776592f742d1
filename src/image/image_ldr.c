// PNG, JPEG and Radiance HDR: read with stb_image, written (PNG) with libpng. Neither library is seen outside this
// file. Colour is decoded from sRGB to linear unless `raw`; alpha is always linear.
#include "image/image_codec.h"

#include <limits.h>
#include <math.h>
#include <png.h>
#include <stdlib.h>
#include <string.h>

#pragma GCC diagnostic ignored "-Wunused-function" // judged at the end of the file: cannot be popped
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wconversion"
#pragma GCC diagnostic ignored "-Wsign-conversion"
#pragma GCC diagnostic ignored "-Wshadow"
#define STB_IMAGE_IMPLEMENTATION
#define STB_IMAGE_STATIC
#define STBI_NO_STDIO
#define STBI_ONLY_PNG
#define STBI_ONLY_JPEG
#define STBI_ONLY_HDR
#define STBI_MAX_DIMENSIONS 65536
#include <stb_image.h>
#pragma GCC diagnostic pop

enum depth { DEPTH_8, DEPTH_16, DEPTH_FLOAT }; // floats are linear already

static enum status fill_pixels(struct image *image, const void *samples, enum depth depth, bool raw,
                               struct error *error) {
    static const char *const names[4][4] = {{"Y"}, {"Y", "A"}, {"R", "G", "B"}, {"R", "G", "B", "A"}};
    enum status status = image_name_channels(image, error);
    if (status != STATUS_OK) return status;
    for (int c = 0; c < image->channels; ++c) strcpy(image->channel_names[c], names[image->channels - 1][c]);
    bool has_alpha = image->channels % 2 == 0;
    size_t count = (size_t)image->width * (size_t)image->height * (size_t)image->channels;
    if (depth == DEPTH_FLOAT) {
        memcpy(image->pixels, samples, count * sizeof *image->pixels);
        return STATUS_OK;
    }
    for (size_t i = 0; i < count; ++i) {
        float value =
            depth == DEPTH_16 ? ((const uint16_t *)samples)[i] / 65535.0f : ((const uint8_t *)samples)[i] / 255.0f;
        bool alpha = has_alpha && (i + 1) % (size_t)image->channels == 0;
        image->pixels[i] = raw || alpha ? value : linear_from_srgb(value);
    }
    return STATUS_OK;
}

// stb_image takes the missing rest of an HDR file for black: read through here, a file that ends too early is noticed.
struct source {
    const uint8_t *bytes;
    size_t left;
    bool ran_out;
};

static int source_read(void *user, char *data, int size) {
    struct source *source = user;
    size_t n = (size_t)size < source->left ? (size_t)size : source->left;
    if (n) memcpy(data, source->bytes, n);
    source->bytes += n;
    source->left -= n;
    source->ran_out = source->ran_out || (!n && size > 0);
    return (int)n;
}

static void source_skip(void *user, int n) {
    struct source *source = user;
    size_t step = n > 0 ? (size_t)n : 0;
    if (step > source->left) step = source->left;
    source->bytes += step;
    source->left -= step;
}

static int source_eof(void *user) { return ((struct source *)user)->left == 0; }

static const stbi_io_callbacks source_callbacks = {source_read, source_skip, source_eof};

enum status image_decode_ldr(struct image *image, const char *path, const uint8_t *bytes, size_t length, bool raw,
                             struct error *error) {
    if (length > INT_MAX) return error_set(error, STATUS_UNSUPPORTED, "%s: larger than 2 GiB; convert it to EXR", path);
    int width, height, channels, size = (int)length;
    enum depth depth = stbi_is_hdr_from_memory(bytes, size)      ? DEPTH_FLOAT
                       : stbi_is_16_bit_from_memory(bytes, size) ? DEPTH_16
                                                                 : DEPTH_8;
    struct source source = {bytes, length, false};
    void *samples = depth == DEPTH_FLOAT
                        ? (void *)stbi_loadf_from_callbacks(&source_callbacks, &source, &width, &height, &channels, 0)
                    : depth == DEPTH_16 ? (void *)stbi_load_16_from_memory(bytes, size, &width, &height, &channels, 0)
                                        : (void *)stbi_load_from_memory(bytes, size, &width, &height, &channels, 0);
    if (source.ran_out) {
        stbi_image_free(samples);
        return error_set(error, STATUS_INVALID, "%s: the file ends within the image", path);
    }
    if (!samples) {
        return error_set(error, STATUS_INVALID, "%s: cannot be read as EXR, PNG, JPEG or HDR: %s", path,
                         stbi_failure_reason());
    }
    enum status status = image_init(image, width, height, channels, error);
    if (status == STATUS_OK) status = fill_pixels(image, samples, depth, raw, error);
    stbi_image_free(samples);
    return status;
}

static uint8_t byte_from_unit(float v) { return (uint8_t)(v > 0 ? fminf(v, 1) * 255 + 0.5f : 0); } // NaN gives 0

enum status image_encode_png(const struct image *image, float exposure, unsigned char **bytes, size_t *length,
                             struct error *error) {
    bool alpha = image->channels == 4 && (!image->channel_names || strcmp(image->channel_names[3], "A") == 0);
    int channels = image->channels < 3 ? 1 : alpha ? 4 : 3;
    size_t count = (size_t)image->width * (size_t)image->height;
    *bytes = NULL;
    *length = 0;
    if (count > SIZE_MAX / 4 || (size_t)image->width * (size_t)channels > INT_MAX) {
        return error_set(error, STATUS_UNSUPPORTED, "an image of %d x %d pixels is too large for PNG", image->width,
                         image->height);
    }
    uint8_t *samples = malloc(count * (size_t)channels);
    if (!samples)
        return error_set(error, STATUS_MEMORY, "out of memory for a PNG of %d x %d pixels", image->width,
                         image->height);
    for (size_t i = 0; i < count; ++i) {
        for (int c = 0; c < channels; ++c) {
            float value = image->pixels[i * (size_t)image->channels + (size_t)c];
            samples[i * (size_t)channels + (size_t)c] =
                byte_from_unit(c == 3 ? value : srgb_from_linear(value * exposure));
        }
    }
    png_image png = {.version = PNG_IMAGE_VERSION,
                     .width = (png_uint_32)image->width,
                     .height = (png_uint_32)image->height,
                     .format = channels == 1   ? PNG_FORMAT_GRAY
                               : channels == 3 ? PNG_FORMAT_RGB
                                               : PNG_FORMAT_RGBA};
    png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(png);
    *bytes = malloc(size);
    bool written = *bytes && png_image_write_to_memory(&png, *bytes, &size, 0, samples, 0, NULL);
    free(samples);
    if (written) {
        *length = size;
        return STATUS_OK;
    }
    bool memory = !*bytes;
    free(*bytes);
    *bytes = NULL;
    return error_set(error, memory ? STATUS_MEMORY : STATUS_INVALID, "a PNG of %d x %d pixels cannot be encoded: %s",
                     image->width, image->height, memory ? "out of memory" : png.message);
}
