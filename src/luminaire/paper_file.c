#include "luminaire/paper_file.h"

#include <math.h>
#include <string.h>

#include "luminaire/paper_private.h"

static const char *const tensor_names[PAPER_NETS] = {"paper.eval", "paper.transparency", "paper.sampling"};

void paper_describe(const struct paper *paper, struct tensor tensors[PAPER_NETS]) {
    for (int net = 0; net < PAPER_NETS; net++)
        tensors[net] = (struct tensor){.name = tensor_names[net],
                                       .type = TENSOR_F32,
                                       .dimension_count = 1,
                                       .shape = {paper_parameters((enum paper_net)net)},
                                       .data = paper->parameters[net]};
}

bool paper_present(const struct safetensors *file) { return safetensors_find(file, tensor_names[PAPER_EVAL]) != NULL; }

enum status paper_read(const struct safetensors *file, const char *name, const struct proxy *proxy,
                       struct paper **paper, struct error *error) {
    enum status status = paper_create(paper, proxy, error);
    for (int net = 0; net < PAPER_NETS && status == STATUS_OK; net++) {
        const struct tensor *tensor = safetensors_find(file, tensor_names[net]);
        const size_t count = paper_parameters((enum paper_net)net);
        float *parameters = (*paper)->parameters[net];
        if (!tensor || tensor->type != TENSOR_F32 || tensor->dimension_count != 1 || tensor->shape[0] != count) {
            status = error_set(error, STATUS_INVALID,
                               "%s: tensor '%s' is missing, or of the wrong type or shape; bake the lamp again", name,
                               tensor_names[net]);
            break;
        }
        memcpy(parameters, tensor->data, count * sizeof(float));
        for (size_t i = 0; i < count; i++)
            if (!isfinite(parameters[i])) {
                status = error_set(error, STATUS_INVALID, "%s: tensor '%s' holds a number that is not finite", name,
                                   tensor_names[net]);
                break;
            }
        if (status == STATUS_OK) dense_packed_set(&(*paper)->packed[net], parameters);
    }
    return status;
}
