// safetensors files: a JSON header, then raw little-endian tensors. Written beside the target and renamed.
#pragma once

#include <stdint.h>

#include "base/arena.h"
#include "base/error.h"

enum tensor_type { TENSOR_F32, TENSOR_F16, TENSOR_U8, TENSOR_I8, TENSOR_U16, TENSOR_U32, TENSOR_I64, TENSOR_U64 };

struct tensor {
    const char *name;
    enum tensor_type type;
    size_t dimension_count, shape[8];
    const void *data; // shape product * element size bytes
};

struct safetensors {
    struct tensor *tensors;
    size_t tensor_count;
    const char **metadata_keys, **metadata_values; // __metadata__, strings only as the format demands
    size_t metadata_count;
    struct arena arena;
};

enum status safetensors_load(struct safetensors *file, const char *path, struct error *error);
enum status safetensors_parse(struct safetensors *file, const char *name, const uint8_t *bytes, size_t length,
                              struct error *error);
enum status safetensors_save(const struct safetensors *file, const char *path, struct error *error);
void safetensors_fini(struct safetensors *file);
const struct tensor *safetensors_find(const struct safetensors *file, const char *name); // or NULL
const char *safetensors_metadata(const struct safetensors *file, const char *key); // or NULL
size_t tensor_element_size(enum tensor_type type);
