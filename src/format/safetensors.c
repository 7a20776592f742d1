// safetensors: u64 length of the header, the header in JSON, then the tensors' bytes, little-endian (format description
// in the safetensors repository). Baked luminaires are stored so. Reading is strict: the tensors must cover the bytes
// after the header exactly once. JSON goes through jansson, the only file that knows it.
#include "format/safetensors.h"

#include <jansson.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"

enum { HEADER_MAX = 100000000, DIMENSIONS_MAX = 8 }; // the header's limit is the reference implementation's

static const struct dtype {
    const char *name;
    size_t size;
} dtypes[] = {
    [TENSOR_F32] = {"F32", 4}, [TENSOR_F16] = {"F16", 2}, [TENSOR_U8] = {"U8", 1},   [TENSOR_I8] = {"I8", 1},
    [TENSOR_U16] = {"U16", 2}, [TENSOR_U32] = {"U32", 4}, [TENSOR_I64] = {"I64", 8}, [TENSOR_U64] = {"U64", 8},
};
enum { DTYPE_COUNT = sizeof dtypes / sizeof *dtypes };

size_t tensor_element_size(enum tensor_type type) { return dtypes[type].size; }

static bool tensor_bytes(const struct tensor *tensor, size_t *bytes) { // false: overflow
    *bytes = tensor_element_size(tensor->type);
    for (size_t i = 0; i < tensor->dimension_count; ++i) {
        if (__builtin_mul_overflow(*bytes, tensor->shape[i], bytes)) return false;
    }
    return true;
}

static bool json_size(const json_t *value, size_t *size) {
    if (!json_is_integer(value) || json_integer_value(value) < 0) return false;
    *size = (size_t)json_integer_value(value);
    return true;
}

struct span {
    size_t begin, end;
    struct tensor tensor;
};

static int compare_spans(const void *a, const void *b) {
    const struct span *x = a, *y = b;
    if (x->begin != y->begin) return x->begin < y->begin ? -1 : 1;
    return x->end < y->end ? -1 : x->end > y->end;
}

static enum status parse_tensor(struct span *span, const char *file, const char *name, const json_t *entry,
                                struct error *error) {
    const json_t *shape = json_object_get(entry, "shape"), *offsets = json_object_get(entry, "data_offsets");
    const char *dtype = json_string_value(json_object_get(entry, "dtype"));
    if (!dtype || !json_is_array(shape) || !json_is_array(offsets) || json_array_size(offsets) != 2 ||
        !json_size(json_array_get(offsets, 0), &span->begin) || !json_size(json_array_get(offsets, 1), &span->end) ||
        json_object_size(entry) != 3) {
        return error_set(error, STATUS_INVALID, "%s: tensor \"%s\" needs exactly dtype, shape and data_offsets", file,
                         name);
    }
    int type = 0;
    while (type < DTYPE_COUNT && strcmp(dtypes[type].name, dtype) != 0) ++type;
    if (type == DTYPE_COUNT)
        return error_set(error, STATUS_UNSUPPORTED, "%s: tensor \"%s\" has the unknown type %s", file, name, dtype);
    span->tensor.type = (enum tensor_type)type;
    span->tensor.dimension_count = json_array_size(shape);
    if (span->tensor.dimension_count > DIMENSIONS_MAX) {
        return error_set(error, STATUS_UNSUPPORTED, "%s: tensor \"%s\" has more than %d dimensions", file, name,
                         DIMENSIONS_MAX);
    }
    for (size_t i = 0; i < span->tensor.dimension_count; ++i) {
        if (!json_size(json_array_get(shape, i), &span->tensor.shape[i])) {
            return error_set(error, STATUS_INVALID, "%s: tensor \"%s\" has a bad shape", file, name);
        }
    }
    size_t bytes;
    if (!tensor_bytes(&span->tensor, &bytes) || span->end < span->begin || span->end - span->begin != bytes) {
        return error_set(error, STATUS_INVALID, "%s: the data_offsets of tensor \"%s\" do not fit its shape", file,
                         name);
    }
    return STATUS_OK;
}

static enum status parse_metadata(struct safetensors *file, const char *name, json_t *metadata, struct error *error) {
    if (!json_is_object(metadata)) return error_set(error, STATUS_INVALID, "%s: __metadata__ is not an object", name);
    size_t count = json_object_size(metadata);
    file->metadata_keys = arena_alloc(&file->arena, count + 1, sizeof *file->metadata_keys);
    file->metadata_values = arena_alloc(&file->arena, count + 1, sizeof *file->metadata_values);
    if (!file->metadata_keys || !file->metadata_values)
        return error_set(error, STATUS_MEMORY, "%s: out of memory", name);
    const char *key;
    json_t *value;
    json_object_foreach(metadata, key, value) {
        if (!json_is_string(value))
            return error_set(error, STATUS_INVALID, "%s: metadata \"%s\" is not a string", name, key);
        char *key_copy = arena_strdup(&file->arena, key),
             *value_copy = arena_strdup(&file->arena, json_string_value(value));
        if (!key_copy || !value_copy) return error_set(error, STATUS_MEMORY, "%s: out of memory", name);
        file->metadata_keys[file->metadata_count] = key_copy;
        file->metadata_values[file->metadata_count++] = value_copy;
    }
    return STATUS_OK;
}

// Copies the tensors out, in the order of their bytes, each aligned; they must follow each other from 0 to `length`.
static enum status take_tensors(struct safetensors *file, const char *name, struct span *spans, size_t count,
                                const uint8_t *data, size_t length, struct error *error) {
    size_t end = 0;
    if (count) qsort(spans, count, sizeof *spans, compare_spans);
    file->tensors = arena_alloc(&file->arena, count + 1, sizeof *file->tensors);
    if (!file->tensors) return error_set(error, STATUS_MEMORY, "%s: out of memory", name);
    for (size_t i = 0; i < count; ++i) {
        if (spans[i].begin != end || spans[i].end > length) {
            return error_set(error, STATUS_INVALID, "%s: tensor \"%s\" %s", name, spans[i].tensor.name,
                             spans[i].end > length ? "lies outside the file; it may be truncated"
                                                   : "leaves a hole or overlaps another");
        }
        size_t bytes = spans[i].end - spans[i].begin;
        void *copy = arena_alloc(&file->arena, bytes + 1, 1);
        if (!copy)
            return error_set(error, STATUS_MEMORY, "%s: out of memory for tensor \"%s\"", name, spans[i].tensor.name);
        memcpy(copy, data + spans[i].begin, bytes);
        file->tensors[i] = spans[i].tensor;
        file->tensors[i].data = copy;
        file->tensor_count = i + 1;
        end = spans[i].end;
    }
    if (end != length)
        return error_set(error, STATUS_INVALID, "%s: %zu bytes at its end belong to no tensor", name, length - end);
    return STATUS_OK;
}

static enum status parse_header(struct safetensors *file, const char *name, json_t *root, const uint8_t *data,
                                size_t length, struct error *error) {
    size_t count = 0;
    struct span *spans = calloc(json_object_size(root) + 1, sizeof *spans);
    enum status status = spans ? STATUS_OK : error_set(error, STATUS_MEMORY, "%s: out of memory", name);
    const char *key;
    json_t *value;
    json_object_foreach(root, key, value) {
        if (status != STATUS_OK) break;
        if (strcmp(key, "__metadata__") == 0) {
            status = parse_metadata(file, name, value, error);
            continue;
        }
        status = parse_tensor(&spans[count], name, key, value, error);
        if (status != STATUS_OK) break;
        spans[count].tensor.name = arena_strdup(&file->arena, key);
        if (!spans[count++].tensor.name) status = error_set(error, STATUS_MEMORY, "%s: out of memory", name);
    }
    if (status == STATUS_OK) status = take_tensors(file, name, spans, count, data, length, error);
    free(spans);
    return status;
}

enum status safetensors_parse(struct safetensors *file, const char *name, const uint8_t *bytes, size_t length,
                              struct error *error) {
    *file = (struct safetensors){0};
    if (length < 8) return error_set(error, STATUS_INVALID, "%s: too short for a safetensors file", name);
    uint64_t header = 0;
    for (int i = 7; i >= 0; --i) header = header << 8 | bytes[i];
    if (header > HEADER_MAX || header > length - 8) {
        return error_set(error, STATUS_INVALID,
                         "%s: its header would be %llu bytes long; not a safetensors file, or truncated", name,
                         (unsigned long long)header);
    }
    json_error_t reason;
    json_t *root =
        header && bytes[8] == '{' ? json_loadb((const char *)bytes + 8, header, JSON_REJECT_DUPLICATES, &reason) : NULL;
    if (!root) {
        bool object = header && bytes[8] == '{';
        return error_set(error, STATUS_INVALID, "%s: the header is not a JSON object: %s", name,
                         object ? reason.text : "no { at its start");
    }
    enum status status = parse_header(file, name, root, bytes + 8 + header, length - 8 - header, error);
    json_decref(root);
    if (status != STATUS_OK) safetensors_fini(file);
    return status;
}

enum status safetensors_load(struct safetensors *file, const char *path, struct error *error) {
    *file = (struct safetensors){0};
    uint8_t *bytes;
    size_t length;
    enum status status = file_read(path, &bytes, &length, error);
    if (status == STATUS_OK) status = safetensors_parse(file, path, bytes, length, error);
    free(bytes);
    return status;
}

static enum status header_add_tensor(json_t *root, const struct tensor *tensor, size_t *offset, const char *path,
                                     struct error *error) {
    size_t bytes, end;
    if (json_object_get(root, tensor->name) || strcmp(tensor->name, "__metadata__") == 0) {
        return error_set(error, STATUS_INVALID, "%s: the name \"%s\" is used twice", path, tensor->name);
    }
    if (tensor->dimension_count > DIMENSIONS_MAX || !tensor_bytes(tensor, &bytes) ||
        __builtin_add_overflow(*offset, bytes, &end)) {
        return error_set(error, STATUS_INVALID, "%s: tensor \"%s\" is too large", path, tensor->name);
    }
    json_t *shape = json_array();
    for (size_t i = 0; i < tensor->dimension_count; ++i)
        json_array_append_new(shape, json_integer((json_int_t)tensor->shape[i]));
    json_t *entry = json_pack("{s:s, s:o, s:[I, I]}", "dtype", dtypes[tensor->type].name, "shape", shape,
                              "data_offsets", (json_int_t)*offset, (json_int_t)end);
    *offset = end;
    if (entry && json_object_set_new(root, tensor->name, entry) == 0) return STATUS_OK;
    return error_set(error, STATUS_INVALID, "%s: the tensor name \"%s\" is not UTF-8", path, tensor->name);
}

static enum status header_build(const struct safetensors *file, json_t *root, const struct tensor **order,
                                size_t *data_length, const char *path, struct error *error) {
    json_t *metadata = file->metadata_count ? json_object() : NULL;
    if (metadata) json_object_set_new(root, "__metadata__", metadata);
    for (size_t i = 0; i < file->metadata_count; ++i) {
        const char *key = file->metadata_keys[i], *value = file->metadata_values[i];
        if (json_object_get(metadata, key) || json_object_set_new(metadata, key, json_string(value)) != 0) {
            return error_set(error, STATUS_INVALID, "%s: metadata \"%s\" is there twice or not UTF-8", path, key);
        }
    }
    // Larger elements first, which keeps every tensor aligned to its element.
    size_t count = 0;
    *data_length = 0;
    for (size_t size = 8; size > 0; size /= 2) {
        for (size_t i = 0; i < file->tensor_count; ++i) {
            if (tensor_element_size(file->tensors[i].type) != size) continue;
            enum status status = header_add_tensor(root, &file->tensors[i], data_length, path, error);
            if (status != STATUS_OK) return status;
            order[count++] = &file->tensors[i];
        }
    }
    return STATUS_OK;
}

static enum status write_file(const char *path, const char *json, const struct tensor **order, size_t count,
                              size_t data_length, struct error *error) {
    size_t text = strlen(json), header = (text + 7) / 8 * 8, total;
    uint8_t *bytes = __builtin_add_overflow(8 + header, data_length, &total) ? NULL : malloc(total);
    if (!bytes) return error_set(error, STATUS_MEMORY, "%s: out of memory for %zu bytes", path, data_length);
    for (int i = 0; i < 8; ++i) bytes[i] = (uint8_t)((uint64_t)header >> 8 * i);
    memset(bytes + 8, ' ', header);
    memcpy(bytes + 8, json, text);
    uint8_t *place = bytes + 8 + header;
    for (size_t i = 0; i < count; ++i) {
        size_t length = 0;
        tensor_bytes(order[i], &length);
        if (length) memcpy(place, order[i]->data, length);
        place += length;
    }
    enum status status = file_write_atomic(path, bytes, total, error);
    free(bytes);
    return status;
}

enum status safetensors_save(const struct safetensors *file, const char *path, struct error *error) {
    json_t *root = json_object();
    const struct tensor **order = calloc(file->tensor_count + 1, sizeof *order);
    size_t data_length = 0;
    enum status status = root && order ? header_build(file, root, order, &data_length, path, error)
                                       : error_set(error, STATUS_MEMORY, "%s: out of memory", path);
    char *json = status == STATUS_OK ? json_dumps(root, JSON_COMPACT) : NULL;
    if (status == STATUS_OK && !json) status = error_set(error, STATUS_MEMORY, "%s: out of memory", path);
    if (status == STATUS_OK) status = write_file(path, json, order, file->tensor_count, data_length, error);
    free(json);
    free(order);
    json_decref(root);
    return status;
}

void safetensors_fini(struct safetensors *file) {
    arena_fini(&file->arena);
    *file = (struct safetensors){0};
}

const struct tensor *safetensors_find(const struct safetensors *file, const char *name) {
    for (size_t i = 0; i < file->tensor_count; ++i) {
        if (strcmp(file->tensors[i].name, name) == 0) return &file->tensors[i];
    }
    return NULL;
}

const char *safetensors_metadata(const struct safetensors *file, const char *key) {
    for (size_t i = 0; i < file->metadata_count; ++i) {
        if (strcmp(file->metadata_keys[i], key) == 0) return file->metadata_values[i];
    }
    return NULL;
}
