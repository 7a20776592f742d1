// The training state of a field on disk, for resuming: weights, moments and the step, all in float, so that a resumed
// training continues bit for bit. The same options must have created the field.
#include <stdlib.h>
#include <string.h>

#include "base/hash.h"
#include "format/safetensors.h"
#include "luminaire/light_field.h"

enum { STATE_TENSORS = 6 };
static const char format_name[] = "sconce-training-state";

// The tensors of a state, pointing into the trainer. `key` tells states of other options apart.
static void describe(const struct field_net *net, const uint64_t *key, struct tensor tensors[STATE_TENSORS]) {
    const struct trainer *trainer = net->trainer;
    size_t entries = trainer->layout.entry_count;
    const struct tensor all[STATE_TENSORS] = {
        {.name = "table", .type = TENSOR_F32, .dimension_count = 2, .shape = {entries, 2}, .data = trainer->table},
        {.name = "moments", .type = TENSOR_F32, .dimension_count = 2, .shape = {entries, 4}, .data = trainer->moments},
        {.name = "mlp", .type = TENSOR_F32, .dimension_count = 1, .shape = {trainer->mlp_count}, .data = trainer->mlp},
        {.name = "mlp_moments",
         .type = TENSOR_F32,
         .dimension_count = 2,
         .shape = {2, trainer->mlp_count},
         .data = trainer->mlp_moments},
        {.name = "step", .type = TENSOR_U64, .dimension_count = 1, .shape = {1}, .data = &trainer->step},
        {.name = "options", .type = TENSOR_U64, .dimension_count = 1, .shape = {1}, .data = key},
    };
    memcpy(tensors, all, sizeof all);
}

static uint64_t options_key(const struct field_net *net) {
    const struct encoding_options *options = &net->encoding.options;
    const int32_t counts[] = {options->anchor_count, options->shell_count, options->use_grid4, options->use_hull,
                              options->log2_entries};
    uint64_t hash = hash_bytes(HASH_START, net->center, sizeof net->center);
    hash = hash_bytes(hash, &net->radius, sizeof net->radius);
    hash = hash_bytes(hash, counts, sizeof counts);
    hash = hash_bytes(hash, options->anchors, sizeof options->anchors);
    hash = hash_bytes(hash, options->shells, sizeof options->shells);
    return hash_bytes(hash, &options->anchor_radius, sizeof options->anchor_radius);
}

static enum status state_save(const struct field_net *net, const char *path, struct error *error) {
    const char *keys[] = {"format"}, *values[] = {format_name};
    struct tensor tensors[STATE_TENSORS];
    uint64_t key = options_key(net);
    describe(net, &key, tensors);
    return safetensors_save(&(struct safetensors){.tensors = tensors,
                                                  .tensor_count = STATE_TENSORS,
                                                  .metadata_keys = keys,
                                                  .metadata_values = values,
                                                  .metadata_count = 1},
                            path, error);
}

static enum status state_load(struct field_net *net, const char *path, struct error *error) {
    struct safetensors file = {0};
    enum status status = safetensors_load(&file, path, error);
    if (status) return status;
    struct tensor expected[STATE_TENSORS];
    uint64_t key = options_key(net);
    describe(net, &key, expected);
    const struct tensor *found[STATE_TENSORS];
    const char *format = safetensors_metadata(&file, "format");
    bool fits = format && strcmp(format, format_name) == 0;
    for (int i = 0; i < STATE_TENSORS && fits; i++) {
        found[i] = safetensors_find(&file, expected[i].name);
        fits = found[i] && found[i]->type == expected[i].type &&
               found[i]->dimension_count == expected[i].dimension_count &&
               memcmp(found[i]->shape, expected[i].shape, expected[i].dimension_count * sizeof(size_t)) == 0;
    }
    if (fits && memcmp(found[STATE_TENSORS - 1]->data, &key, sizeof key) == 0) {
        struct trainer *trainer = net->trainer;
        void *targets[STATE_TENSORS - 1] = {trainer->table, trainer->moments, trainer->mlp, trainer->mlp_moments,
                                            &trainer->step};
        for (int i = 0; i < STATE_TENSORS - 1; i++) {
            size_t count = expected[i].shape[0] * (expected[i].dimension_count > 1 ? expected[i].shape[1] : 1);
            memcpy(targets[i], found[i]->data, count * tensor_element_size(expected[i].type));
        }
    } else
        status = error_set(error, STATUS_INVALID, "%s: not the training state of this bake; remove it to start afresh",
                           path);
    safetensors_fini(&file);
    return status;
}

enum status light_field_save_state(const struct light_field *field, const char *path, struct error *error) {
    return state_save(&field->net, path, error);
}

enum status light_field_load_state(struct light_field *field, const char *path, struct error *error) {
    return state_load(&field->net, path, error);
}

enum status transparency_save_state(const struct transparency *t, const char *path, struct error *error) {
    return state_save(&t->net, path, error);
}

enum status transparency_load_state(struct transparency *t, const char *path, struct error *error) {
    return state_load(&t->net, path, error);
}
