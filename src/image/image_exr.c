// OpenEXR through OpenEXRCore, the only file that knows it. Both directions work on memory, so that reading names the
// file in errors and writing is as atomic as every other output.
// Read: the first part, scanline or tiled (level 0), any compression, half, float or uint, all as float; R, G, B, A
// come first, the others in alphabetical order. Written: float, ZIP, scanlines.
#include "image/image_codec.h"

#include <limits.h>
#include <openexr.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

struct stream {
    const char *path;
    uint8_t *bytes;
    size_t length, capacity;
    char reason[256]; // the last message of OpenEXRCore
};

static struct stream *stream_of(exr_const_context_t context) {
    void *user = NULL;
    exr_get_user_data(context, &user);
    return user;
}

static void keep_reason(exr_const_context_t context, exr_result_t code, const char *text) {
    (void)code;
    struct stream *stream = stream_of(context);
    if (stream) snprintf(stream->reason, sizeof stream->reason, "%s", text);
}

static int64_t stream_size(exr_const_context_t context, void *user) {
    (void)context;
    return (int64_t)((struct stream *)user)->length;
}

static int64_t stream_read(exr_const_context_t context, void *user, void *buffer, uint64_t size, uint64_t offset,
                           exr_stream_error_func_ptr_t fail) {
    (void)context, (void)fail;
    struct stream *stream = user;
    if (offset >= stream->length) return 0;
    if (size > stream->length - offset) size = stream->length - offset;
    memcpy(buffer, stream->bytes + offset, size);
    return (int64_t)size;
}

static int64_t stream_write(exr_const_context_t context, void *user, const void *buffer, uint64_t size, uint64_t offset,
                            exr_stream_error_func_ptr_t fail) {
    struct stream *stream = user;
    uint64_t end = offset + size;
    if (end > stream->capacity) {
        size_t capacity = end + end / 2;
        uint8_t *larger = realloc(stream->bytes, capacity);
        if (!larger) return fail(context, EXR_ERR_OUT_OF_MEMORY, "out of memory"), -1;
        memset(larger + stream->capacity, 0, capacity - stream->capacity);
        stream->bytes = larger;
        stream->capacity = capacity;
    }
    memcpy(stream->bytes + offset, buffer, size);
    if (end > stream->length) stream->length = end;
    return (int64_t)size;
}

static enum status exr_status(exr_result_t result, const struct stream *stream, const char *doing,
                              struct error *error) {
    if (result == EXR_ERR_SUCCESS) return STATUS_OK;
    const char *reason = stream->reason[0] ? stream->reason : exr_get_default_error_message(result);
    enum status status = result == EXR_ERR_OUT_OF_MEMORY ? STATUS_MEMORY : STATUS_INVALID;
    return error_set(error, status, "%s: cannot be %s as OpenEXR: %s", stream->path, doing, reason);
}

static int channel_rank(const char *name) {
    const char *place = strlen(name) == 1 ? strchr("RGBA", name[0]) : NULL;
    return place ? (int)(place - "RGBA") : 4;
}

static int compare_channels(const void *a, const void *b) {
    const char *x = *(const char *const *)a, *y = *(const char *const *)b;
    int ranks = channel_rank(x) - channel_rank(y);
    return ranks ? ranks : strcmp(x, y);
}

// Where the named channel's sample of pixel (x, y) stands.
static float *channel_pixel(const struct image *image, const char *const *order, const char *name, int x, int y) {
    int c = 0;
    while (c < image->channels - 1 && strcmp(order[c], name) != 0) ++c;
    return image->pixels + ((size_t)y * (size_t)image->width + (size_t)x) * (size_t)image->channels + (size_t)c;
}

// Decodes one chunk whose upper left pixel is (x, y) of the image.
static exr_result_t decode_chunk(exr_const_context_t context, exr_decode_pipeline_t *decode,
                                 const exr_chunk_info_t *chunk, const struct image *image, const char *const *order,
                                 int x, int y) {
    bool first = decode->channels == NULL;
    exr_result_t result =
        first ? exr_decoding_initialize(context, 0, chunk, decode) : exr_decoding_update(context, 0, chunk, decode);
    if (result != EXR_ERR_SUCCESS) return result;
    for (int c = 0; c < decode->channel_count; ++c) {
        exr_coding_channel_info_t *channel = &decode->channels[c];
        channel->decode_to_ptr = (uint8_t *)channel_pixel(image, order, channel->channel_name, x, y);
        channel->user_data_type = EXR_PIXEL_FLOAT;
        channel->user_bytes_per_element = sizeof(float);
        channel->user_pixel_stride = image->channels * (int)sizeof(float);
        channel->user_line_stride = image->width * channel->user_pixel_stride;
    }
    if (first) result = exr_decoding_choose_default_routines(context, 0, decode);
    return result == EXR_ERR_SUCCESS ? exr_decoding_run(context, 0, decode) : result;
}

static exr_result_t decode_scanlines(exr_const_context_t context, const struct image *image, const char *const *order,
                                     int top) {
    exr_decode_pipeline_t decode = EXR_DECODE_PIPELINE_INITIALIZER;
    int32_t step = 1;
    exr_result_t result = exr_get_scanlines_per_chunk(context, 0, &step);
    for (int y = 0; y < image->height && result == EXR_ERR_SUCCESS; y += step) {
        exr_chunk_info_t chunk;
        result = exr_read_scanline_chunk_info(context, 0, top + y, &chunk);
        if (result == EXR_ERR_SUCCESS) result = decode_chunk(context, &decode, &chunk, image, order, 0, y);
    }
    exr_decoding_destroy(context, &decode);
    return result;
}

static exr_result_t decode_tiles(exr_const_context_t context, const struct image *image, const char *const *order) {
    exr_decode_pipeline_t decode = EXR_DECODE_PIPELINE_INITIALIZER;
    int32_t width = 0, height = 0;
    exr_result_t result = exr_get_tile_sizes(context, 0, 0, 0, &width, &height);
    if (result == EXR_ERR_SUCCESS && (width < 1 || height < 1)) result = EXR_ERR_INVALID_ATTR;
    for (int y = 0, row = 0; result == EXR_ERR_SUCCESS && y < image->height; y += height, ++row) {
        for (int x = 0, column = 0; result == EXR_ERR_SUCCESS && x < image->width; x += width, ++column) {
            exr_chunk_info_t chunk;
            result = exr_read_tile_chunk_info(context, 0, column, row, 0, 0, &chunk);
            bool inside =
                result == EXR_ERR_SUCCESS && x + chunk.width <= image->width && y + chunk.height <= image->height;
            if (result == EXR_ERR_SUCCESS && !inside) result = EXR_ERR_BAD_CHUNK_LEADER;
            if (result == EXR_ERR_SUCCESS) result = decode_chunk(context, &decode, &chunk, image, order, x, y);
        }
    }
    exr_decoding_destroy(context, &decode);
    return result;
}

static enum status decode_part(struct image *image, exr_const_context_t context, const struct stream *stream,
                               struct error *error) {
    exr_storage_t storage;
    exr_attr_box2i_t window;
    const exr_attr_chlist_t *channels;
    exr_result_t result = exr_get_storage(context, 0, &storage);
    if (result == EXR_ERR_SUCCESS) result = exr_get_data_window(context, 0, &window);
    if (result == EXR_ERR_SUCCESS) result = exr_get_channels(context, 0, &channels);
    enum status status = exr_status(result, stream, "read", error);
    if (status != STATUS_OK) return status;
    if (storage != EXR_STORAGE_SCANLINE && storage != EXR_STORAGE_TILED) {
        return error_set(error, STATUS_UNSUPPORTED, "%s: deep images are not supported; flatten it first",
                         stream->path);
    }
    int64_t width = (int64_t)window.max.x - window.min.x + 1, height = (int64_t)window.max.y - window.min.y + 1;
    int count = channels->num_channels;
    if (width < 1 || height < 1 || count < 1 || width * count > INT_MAX / (int)sizeof(float) || height > INT_MAX / 2) {
        return error_set(error, STATUS_INVALID, "%s: %lld x %lld pixels with %d channels cannot be loaded",
                         stream->path, (long long)width, (long long)height, count);
    }
    status = image_init(image, (int)width, (int)height, count, error);
    if (status == STATUS_OK) status = image_name_channels(image, error);
    const char **order = status == STATUS_OK ? calloc((size_t)count, sizeof *order) : NULL;
    if (status == STATUS_OK && !order) status = error_set(error, STATUS_MEMORY, "%s: out of memory", stream->path);
    for (int c = 0; c < count && status == STATUS_OK; ++c) {
        const exr_attr_chlist_entry_t *channel = &channels->entries[c];
        order[c] = channel->name.str;
        if (channel->x_sampling != 1 || channel->y_sampling != 1) {
            status = error_set(error, STATUS_UNSUPPORTED, "%s: channel %s is subsampled; save the image as RGB",
                               stream->path, order[c]);
        }
    }
    if (status == STATUS_OK) {
        qsort(order, (size_t)count, sizeof *order, compare_channels);
        for (int c = 0; c < count; ++c) snprintf(image->channel_names[c], sizeof *image->channel_names, "%s", order[c]);
        result = storage == EXR_STORAGE_TILED ? decode_tiles(context, image, order)
                                              : decode_scanlines(context, image, order, window.min.y);
        status = exr_status(result, stream, "read", error);
    }
    free(order);
    return status;
}

enum status image_decode_exr(struct image *image, const char *path, const uint8_t *bytes, size_t length,
                             struct error *error) {
    struct stream stream = {.path = path, .bytes = (uint8_t *)bytes, .length = length};
    exr_context_initializer_t setup = EXR_DEFAULT_CONTEXT_INITIALIZER;
    setup.user_data = &stream;
    setup.read_fn = stream_read;
    setup.size_fn = stream_size;
    setup.error_handler_fn = keep_reason;
    setup.flags = EXR_CONTEXT_FLAG_DISABLE_CHUNK_RECONSTRUCTION;
    exr_context_t context = NULL;
    enum status status = exr_status(exr_start_read(&context, path, &setup), &stream, "read", error);
    if (status == STATUS_OK) status = decode_part(image, context, &stream, error);
    exr_finish(&context);
    return status;
}

static exr_result_t encode_scanlines(exr_context_t context, const struct image *image, const char *const *order) {
    exr_encode_pipeline_t encode = EXR_ENCODE_PIPELINE_INITIALIZER;
    int32_t step = 1;
    exr_result_t result = exr_get_scanlines_per_chunk(context, 0, &step);
    for (int y = 0; y < image->height && result == EXR_ERR_SUCCESS; y += step) {
        exr_chunk_info_t chunk;
        result = exr_write_scanline_chunk_info(context, 0, y, &chunk);
        if (result != EXR_ERR_SUCCESS) break;
        result = y == 0 ? exr_encoding_initialize(context, 0, &chunk, &encode)
                        : exr_encoding_update(context, 0, &chunk, &encode);
        for (int c = 0; result == EXR_ERR_SUCCESS && c < encode.channel_count; ++c) {
            exr_coding_channel_info_t *channel = &encode.channels[c];
            channel->encode_from_ptr = (const uint8_t *)channel_pixel(image, order, channel->channel_name, 0, y);
            channel->user_data_type = EXR_PIXEL_FLOAT;
            channel->user_bytes_per_element = sizeof(float);
            channel->user_pixel_stride = image->channels * (int)sizeof(float);
            channel->user_line_stride = image->width * channel->user_pixel_stride;
        }
        if (result == EXR_ERR_SUCCESS && y == 0) result = exr_encoding_choose_default_routines(context, 0, &encode);
        if (result == EXR_ERR_SUCCESS) result = exr_encoding_run(context, 0, &encode);
    }
    exr_encoding_destroy(context, &encode);
    return result;
}

enum status image_encode_exr(const struct image *image, const char *path, uint8_t **bytes, size_t *length,
                             struct error *error) {
    static const char *const gray[] = {"Y"}, *const color[] = {"R", "G", "B", "A"};
    *bytes = NULL;
    *length = 0;
    bool unnamed = !image->channel_names;
    if (unnamed && image->channels != 1 && image->channels != 3 && image->channels != 4) {
        return error_set(error, STATUS_INVALID, "%s: %d channels need names to be saved", path, image->channels);
    }
    if ((int64_t)image->width * image->channels > INT_MAX / (int)sizeof(float)) {
        return error_set(error, STATUS_UNSUPPORTED, "%s: %d pixels of %d channels in a row are too many for EXR", path,
                         image->width, image->channels);
    }
    const char **order = calloc((size_t)image->channels, sizeof *order);
    if (!order) return error_set(error, STATUS_MEMORY, "%s: out of memory", path);
    for (int c = 0; c < image->channels; ++c) {
        order[c] = !unnamed ? image->channel_names[c] : image->channels == 1 ? gray[c] : color[c];
    }
    struct stream stream = {.path = path};
    exr_context_initializer_t setup = EXR_DEFAULT_CONTEXT_INITIALIZER;
    setup.user_data = &stream;
    setup.write_fn = stream_write;
    setup.error_handler_fn = keep_reason;
    exr_context_t context = NULL;
    int part;
    exr_result_t result = exr_start_write(&context, path, EXR_WRITE_FILE_DIRECTLY, &setup);
    if (result == EXR_ERR_SUCCESS) result = exr_add_part(context, NULL, EXR_STORAGE_SCANLINE, &part);
    if (result == EXR_ERR_SUCCESS)
        result = exr_initialize_required_attr_simple(context, part, image->width, image->height, EXR_COMPRESSION_ZIP);
    for (int c = 0; c < image->channels && result == EXR_ERR_SUCCESS; ++c) {
        result = exr_add_channel(context, part, order[c], EXR_PIXEL_FLOAT, EXR_PERCEPTUALLY_LINEAR, 1, 1);
    }
    if (result == EXR_ERR_SUCCESS) result = exr_write_header(context);
    if (result == EXR_ERR_SUCCESS) result = encode_scanlines(context, image, order);
    exr_result_t finished = context ? exr_finish(&context) : EXR_ERR_SUCCESS;
    free(order);
    enum status status = exr_status(result != EXR_ERR_SUCCESS ? result : finished, &stream, "written", error);
    if (status != STATUS_OK) {
        free(stream.bytes);
        return status;
    }
    *bytes = stream.bytes;
    *length = stream.length;
    return STATUS_OK;
}
