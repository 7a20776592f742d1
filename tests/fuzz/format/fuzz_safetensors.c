// safetensors files from arbitrary bytes: an error, or tensors whose bytes can all be read.
#include "format/safetensors.h"

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t length);

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t length) {
    struct safetensors file;
    struct error error;
    if (safetensors_parse(&file, "fuzz", bytes, length, &error) != STATUS_OK) return 0;
    volatile uint8_t sum = 0;
    for (size_t i = 0; i < file.tensor_count; ++i) {
        size_t count = tensor_element_size(file.tensors[i].type);
        for (size_t d = 0; d < file.tensors[i].dimension_count; ++d) count *= file.tensors[i].shape[d];
        for (size_t b = 0; b < count; ++b) sum = (uint8_t)(sum + ((const uint8_t *)file.tensors[i].data)[b]);
    }
    safetensors_fini(&file);
    return 0;
}
