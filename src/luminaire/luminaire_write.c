// The file of a luminaire, written; docs/luminaire-format.md describes it.
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "luminaire/luminaire_file.h"
#include "luminaire/luminaire_private.h"
#include "luminaire/paper_file.h"

enum { LAMP_TENSORS = 12 + HULL_TENSORS, EMISSION_TENSORS = 14 + VIEW_TENSORS };
enum { MAX_TENSORS = LAMP_TENSORS + LUMINAIRE_MAX_GROUPS * EMISSION_TENSORS };

struct emission_numbers { // what tensors of one emission point to
    float light[4], ceiling[2], net[NET_NUMBERS], cones[2 * CONE_COUNT], view[VIEW_NUMBERS];
    uint32_t directions;
};

struct writer {
    struct safetensors file;
    struct tensor tensors[MAX_TENSORS];
    char names[MAX_TENSORS][40];
    float proxy[PROXY_NUMBERS], flux[3], scattering[2][3], group_flux[LUMINAIRE_MAX_GROUPS][3],
        transparency[NET_NUMBERS];
    struct emission_numbers emissions[LUMINAIRE_MAX_GROUPS];
    struct hull_numbers hull;
    char groups[LUMINAIRE_MAX_GROUPS * LUMINAIRE_NAME_SIZE];
};

// `tensor.name` without the prefix of a group.
static void put_tensor(struct writer *writer, const char *prefix, struct tensor tensor) {
    size_t at = writer->file.tensor_count++;
    snprintf(writer->names[at], sizeof writer->names[at], "%s%s", prefix, tensor.name);
    tensor.name = writer->names[at];
    writer->tensors[at] = tensor;
}

static void put(struct writer *writer, const char *prefix, const char *name, enum tensor_type type, size_t rows,
                size_t columns, const void *data) {
    put_tensor(
        writer, prefix,
        (struct tensor){
            .name = name, .type = type, .dimension_count = columns ? 2 : 1, .shape = {rows, columns}, .data = data});
}

static void put_net(struct writer *writer, const char *prefix, const struct field_net *net, float *numbers) {
    const struct encoding_options *options = &net->encoding.options;
    float values[NET_NUMBERS] = {(float)options->anchor_count, options->anchor_radius, (float)options->shell_count,
                                 options->use_grid4 ? 1.0f : 0.0f, (float)options->log2_entries};
    memcpy(values + 5, options->shells, sizeof options->shells);
    values[9] = options->use_hull ? 1.0f : 0.0f;
    memcpy(numbers, values, sizeof values);
    put(writer, prefix, "encoding", TENSOR_F32, NET_NUMBERS, 0, numbers);
    if (options->anchor_count)
        put(writer, prefix, "anchors", TENSOR_F32, (size_t)options->anchor_count, 3, options->anchors);
    put(writer, prefix, "mlp", TENSOR_F32, field_net_parameters(net), 0, net->mlp);
    put(writer, prefix, "table", TENSOR_I8, net->encoding.layout.entry_count, 2, net->codes);
    put(writer, prefix, "table_scale", TENSOR_F32, (size_t)net->encoding.layout.level_count, 0, net->scale);
}

static void put_density(struct writer *writer, const char *prefix, const struct sampling_density *density,
                        struct emission_numbers *numbers) {
    size_t cells = sampling_cell_count(density), anchors = (size_t)density->anchor_count;
    numbers->directions = (uint32_t)density->directions;
    put(writer, prefix, "directions", TENSOR_U32, 1, 0, &numbers->directions);
    put(writer, prefix, "map", TENSOR_U8, cells, MAP_BYTES, density->codes);
    put(writer, prefix, "residual_share", TENSOR_U8, cells, 0, density->residual_share);
    if (!anchors) return;
    memcpy(numbers->cones, density->cone_radius, sizeof density->cone_radius);
    memcpy(numbers->cones + CONE_COUNT, density->cone_share, sizeof density->cone_share);
    put(writer, prefix, "cones", TENSOR_F32, 2, CONE_COUNT, numbers->cones);
    put(writer, prefix, "anchors", TENSOR_F32, anchors, 3, density->anchors);
    put(writer, prefix, "intensity", TENSOR_F32, anchors, INTENSITY_CELLS, density->intensity);
}

static void put_emission(struct writer *writer, int group, const struct emission *emission) {
    struct emission_numbers *numbers = &writer->emissions[group];
    char prefix[EMISSION_PREFIX];
    numbers->light[0] = emission->light->radiance_unit;
    memcpy(numbers->light + 1, emission->light->scale, sizeof emission->light->scale);
    emission_prefix(prefix, group, "light.");
    put(writer, prefix, "unit", TENSOR_F32, 4, 0, numbers->light);
    numbers->ceiling[0] = emission->light->ceiling_offset;
    numbers->ceiling[1] = emission->light->ceiling;
    if (emission->light->ceiling > 0) put(writer, prefix, "ceiling", TENSOR_F32, 2, 0, numbers->ceiling);
    put_net(writer, prefix, &emission->light->net, numbers->net);
    emission_prefix(prefix, group, "sampling.");
    put_density(writer, prefix, emission->density, numbers);
    if (!emission->view) return;
    struct tensor tensors[VIEW_TENSORS];
    view_describe(emission->view, numbers->view, tensors);
    emission_prefix(prefix, group, "");
    for (int i = 0; i < VIEW_TENSORS; i++) put_tensor(writer, prefix, tensors[i]);
}

static void put_groups(struct writer *writer, const struct luminaire *luminaire) {
    size_t used = 0;
    for (int g = 0; g < luminaire->emission_count; g++) {
        memcpy(writer->group_flux[g], luminaire->emissions[g].flux, sizeof writer->group_flux[g]);
        used += (size_t)snprintf(writer->groups + used, sizeof writer->groups - used, "%s%s", g ? "," : "",
                                 luminaire->emissions[g].name);
    }
    put(writer, "groups.", "flux", TENSOR_F32, (size_t)luminaire->emission_count, 3, writer->group_flux);
}

static void describe(struct writer *writer, const struct luminaire *luminaire) {
    const struct proxy *proxy = &luminaire->shape.proxy;
    float values[PROXY_NUMBERS] = {(float)proxy->kind, proxy->center[0], proxy->center[1],   proxy->center[2],
                                   proxy->radius,      proxy->lower[0],  proxy->lower[1],    proxy->lower[2],
                                   proxy->upper[0],    proxy->upper[1],  proxy->upper[2],    proxy->axis[0],
                                   proxy->axis[1],     proxy->axis[2],   proxy->half_height, proxy->axis_radius};
    memcpy(writer->proxy, values, sizeof values);
    put(writer, "proxy", "", TENSOR_F32, PROXY_NUMBERS, 0, writer->proxy);
    if (proxy->kind == PROXY_MESH) {
        put(writer, "proxy.", "vertices", TENSOR_F32, proxy->vertex_count, 3, proxy->vertices);
        put(writer, "proxy.", "indices", TENSOR_U32, proxy->triangle_count, 3, proxy->indices);
    }
    for (int g = 0; g < luminaire->emission_count; g++) // as baked, of a dimmed lamp too
        for (int c = 0; c < 3; c++) writer->flux[c] += luminaire->emissions[g].flux[c];
    put(writer, "flux", "", TENSOR_F32, 3, 0, writer->flux);
    if (luminaire->grouped) put_groups(writer, luminaire);
    memcpy(writer->scattering, luminaire->scattering, sizeof writer->scattering);
    put(writer, "scattering", "", TENSOR_F32, 2, 3, writer->scattering);
    writer->file.tensors = writer->tensors;
    if (luminaire->hull) {
        hull_describe(luminaire->hull, &writer->hull, writer->tensors + writer->file.tensor_count);
        writer->file.tensor_count += HULL_TENSORS;
    }
    if (luminaire->paper) {
        paper_describe(luminaire->paper, writer->tensors + writer->file.tensor_count);
        writer->file.tensor_count += PAPER_NETS;
        return;
    }
    if (luminaire->transparency) put_net(writer, "transparency.", &luminaire->transparency->net, writer->transparency);
    for (int g = 0; g < luminaire->emission_count; g++) put_emission(writer, g, &luminaire->emissions[g]);
}

size_t luminaire_measure(const struct luminaire *luminaire) {
    struct writer *writer = calloc(1, sizeof *writer);
    if (!writer) return 0;
    describe(writer, luminaire);
    size_t bytes = 0;
    for (size_t i = 0; i < writer->file.tensor_count; i++) {
        const struct tensor *tensor = &writer->tensors[i];
        size_t count = tensor->shape[0] * (tensor->dimension_count > 1 ? tensor->shape[1] : 1);
        bytes += count * tensor_element_size(tensor->type);
    }
    free(writer);
    return bytes;
}

enum status luminaire_save(const struct luminaire *luminaire, const char *path, struct error *error) {
    struct writer *writer = calloc(1, sizeof *writer);
    size_t count = luminaire->metadata_count;
    const char **keys = calloc(count + 3, sizeof *keys), **values = calloc(count + 3, sizeof *values);
    enum status status;
    if (writer && keys && values) {
        describe(writer, luminaire);
        keys[0] = LUMINAIRE_FORMAT_KEY, values[0] = LUMINAIRE_FORMAT;
        keys[1] = LUMINAIRE_VERSION_KEY, values[1] = luminaire->grouped ? LUMINAIRE_VERSION_GROUPS : LUMINAIRE_VERSION;
        size_t used = 2;
        if (luminaire->grouped) keys[used] = LUMINAIRE_GROUPS_KEY, values[used++] = writer->groups;
        for (size_t i = 0; i < count; i++) {
            if (strcmp(luminaire->keys[i], LUMINAIRE_FORMAT_KEY) == 0 ||
                strcmp(luminaire->keys[i], LUMINAIRE_VERSION_KEY) == 0 ||
                strcmp(luminaire->keys[i], LUMINAIRE_GROUPS_KEY) == 0)
                continue;
            keys[used] = luminaire->keys[i], values[used] = luminaire->values[i];
            used++;
        }
        writer->file.metadata_keys = keys;
        writer->file.metadata_values = values;
        writer->file.metadata_count = used;
        status = safetensors_save(&writer->file, path, error);
    } else
        status = error_set(error, STATUS_MEMORY, "out of memory while saving %s", path);
    free(writer);
    free(keys);
    free(values);
    return status;
}
