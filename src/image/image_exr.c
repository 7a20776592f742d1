// OpenEXR through OpenEXRCore, the only file that knows it. Both directions work on memory, so that reading names the
// file in errors and writing is as atomic as every other output.
// Read: the first part, scanline or tiled (level 0), any compression but DWA (OpenEXRCore 3.1 cannot), half, float or
// uint, all as float; R, G, B, A come first, the others in alphabetical order. Written: float,
// uncompressed scanlines: the ZIP encoder of OpenEXRCore 3.1.5 writes chunks that no program reads back when their data
// hardly shrink (200 of 3000 images of random bits with 4 to 7 % of equal words).
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

static int channel_index(const char *const *order, int count, const char *name) {
    int c = 0;
    while (c < count - 1 && strcmp(order[c], name) != 0) ++c;
    return c;
}

struct decoder {
    exr_const_context_t context;
    exr_decode_pipeline_t pipeline;
    const struct image *image;
    const char *const *order; // the channels' names as the image has them
    float *planes; // of one chunk, channel by channel
    size_t plane_capacity;
};

// Decodes one chunk whose upper left pixel is (x, y) of the image. It is unpacked plane by plane and interleaved here:
// the interleaving unpackers of OpenEXRCore 3.1.5 swap R with A and G with B when all four are there.
static exr_result_t decode_chunk(struct decoder *d, const exr_chunk_info_t *chunk, int x, int y) {
    const struct image *image = d->image;
    size_t plane = (size_t)chunk->width * (size_t)chunk->height, channels = (size_t)image->channels;
    if (plane * channels > d->plane_capacity) {
        free(d->planes);
        d->planes = calloc(plane * channels, sizeof *d->planes);
        d->plane_capacity = d->planes ? plane * channels : 0;
        if (!d->planes) return EXR_ERR_OUT_OF_MEMORY;
    }
    bool first = d->pipeline.channels == NULL;
    exr_result_t result = first ? exr_decoding_initialize(d->context, 0, chunk, &d->pipeline)
                                : exr_decoding_update(d->context, 0, chunk, &d->pipeline);
    if (result != EXR_ERR_SUCCESS) return result;
    for (int c = 0; c < d->pipeline.channel_count; ++c) {
        exr_coding_channel_info_t *channel = &d->pipeline.channels[c];
        channel->decode_to_ptr = (uint8_t *)(d->planes + plane * (size_t)c);
        channel->user_data_type = EXR_PIXEL_FLOAT;
        channel->user_bytes_per_element = sizeof(float);
        channel->user_pixel_stride = sizeof(float);
        channel->user_line_stride = chunk->width * (int)sizeof(float);
    }
    if (first) result = exr_decoding_choose_default_routines(d->context, 0, &d->pipeline);
    if (result == EXR_ERR_SUCCESS) result = exr_decoding_run(d->context, 0, &d->pipeline);
    if (result != EXR_ERR_SUCCESS) return result;
    for (int c = 0; c < d->pipeline.channel_count; ++c) {
        int slot = channel_index(d->order, image->channels, d->pipeline.channels[c].channel_name);
        const float *source = d->planes + plane * (size_t)c;
        for (int row = 0; row < chunk->height; ++row) {
            size_t start = (size_t)(y + row) * (size_t)image->width + (size_t)x;
            for (int column = 0; column < chunk->width; ++column) {
                image->pixels[(start + (size_t)column) * channels + (size_t)slot] = *source++;
            }
        }
    }
    return EXR_ERR_SUCCESS;
}

static exr_result_t decode_scanlines(struct decoder *d, int top) {
    int32_t step = 1;
    exr_result_t result = exr_get_scanlines_per_chunk(d->context, 0, &step);
    for (int y = 0; y < d->image->height && result == EXR_ERR_SUCCESS; y += step) {
        exr_chunk_info_t chunk;
        result = exr_read_scanline_chunk_info(d->context, 0, top + y, &chunk);
        bool inside =
            result == EXR_ERR_SUCCESS && chunk.width == d->image->width && chunk.height <= d->image->height - y;
        if (result == EXR_ERR_SUCCESS && !inside) result = EXR_ERR_BAD_CHUNK_LEADER;
        if (result == EXR_ERR_SUCCESS) result = decode_chunk(d, &chunk, 0, y);
    }
    return result;
}

static exr_result_t decode_tiles(struct decoder *d) {
    int32_t width = 0, height = 0;
    exr_result_t result = exr_get_tile_sizes(d->context, 0, 0, 0, &width, &height);
    if (result == EXR_ERR_SUCCESS && (width < 1 || height < 1)) result = EXR_ERR_INVALID_ATTR;
    for (int y = 0, row = 0; result == EXR_ERR_SUCCESS && y < d->image->height; y += height, ++row) {
        for (int x = 0, column = 0; result == EXR_ERR_SUCCESS && x < d->image->width; x += width, ++column) {
            exr_chunk_info_t chunk;
            result = exr_read_tile_chunk_info(d->context, 0, column, row, 0, 0, &chunk);
            bool inside =
                result == EXR_ERR_SUCCESS && chunk.width <= d->image->width - x && chunk.height <= d->image->height - y;
            if (result == EXR_ERR_SUCCESS && !inside) result = EXR_ERR_BAD_CHUNK_LEADER;
            if (result == EXR_ERR_SUCCESS) result = decode_chunk(d, &chunk, x, y);
        }
    }
    return result;
}

static enum status decode_part(struct image *image, exr_const_context_t context, const struct stream *stream,
                               struct error *error) {
    exr_storage_t storage;
    exr_compression_t compression;
    exr_attr_box2i_t window;
    const exr_attr_chlist_t *channels;
    exr_result_t result = exr_get_storage(context, 0, &storage);
    if (result == EXR_ERR_SUCCESS) result = exr_get_compression(context, 0, &compression);
    if (result == EXR_ERR_SUCCESS) result = exr_get_data_window(context, 0, &window);
    if (result == EXR_ERR_SUCCESS) result = exr_get_channels(context, 0, &channels);
    enum status status = exr_status(result, stream, "read", error);
    if (status != STATUS_OK) return status;
    if (storage != EXR_STORAGE_SCANLINE && storage != EXR_STORAGE_TILED) {
        return error_set(error, STATUS_UNSUPPORTED, "%s: deep images are not supported; flatten it first",
                         stream->path);
    }
    if (compression == EXR_COMPRESSION_DWAA || compression == EXR_COMPRESSION_DWAB) {
        return error_set(error, STATUS_UNSUPPORTED,
                         "%s: DWA compression is not supported; save the image with ZIP or PIZ", stream->path);
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
        struct decoder decoder = {.context = context, .image = image, .order = order};
        result = storage == EXR_STORAGE_TILED ? decode_tiles(&decoder) : decode_scanlines(&decoder, window.min.y);
        exr_decoding_destroy(context, &decoder.pipeline);
        free(decoder.planes);
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
            size_t start = (size_t)y * (size_t)image->width * (size_t)image->channels;
            int slot = channel_index(order, image->channels, channel->channel_name);
            channel->encode_from_ptr = (const uint8_t *)(image->pixels + start + slot);
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
        result = exr_initialize_required_attr_simple(context, part, image->width, image->height, EXR_COMPRESSION_NONE);
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
