#include "luminaire/hull_file.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "luminaire/hull_pack.h"

static struct tensor make_tensor(const char *name, enum tensor_type type, size_t rows, size_t columns,
                                 const void *data) {
    return (struct tensor){
        .name = name, .type = type, .dimension_count = columns ? 2 : 1, .shape = {rows, columns}, .data = data};
}

void hull_describe(const struct hull *hull, struct hull_numbers *numbers, struct tensor *tensors) {
    memcpy(numbers->frame, hull->lower, sizeof hull->lower);
    memcpy(numbers->frame + 3, hull->step, sizeof hull->step);
    numbers->counts[0] = (uint32_t)hull->vertex_count;
    numbers->counts[1] = (uint32_t)hull->triangle_count;
    for (size_t i = 0; i < hull->part_count; i++) {
        const struct hull_part *part = &hull->parts[i];
        const float values[HULL_PART_NUMBERS] = {(float)part->kind, part->smooth ? 1.0f : 0.0f, (float)part->count,
                                                 part->eta,         part->sigma_a[0],           part->sigma_a[1],
                                                 part->sigma_a[2]};
        memcpy(numbers->parts[i], values, sizeof values);
    }
    const struct tensor all[HULL_TENSORS] = {
        make_tensor("hull.frame", TENSOR_F32, 6, 0, numbers->frame),
        make_tensor("hull.parts", TENSOR_F32, hull->part_count, HULL_PART_NUMBERS, numbers->parts),
        make_tensor("hull.counts", TENSOR_U32, 2, 0, numbers->counts),
        make_tensor("hull.mesh", TENSOR_U8, hull->packed_bytes, 0, hull->packed),
    };
    memcpy(tensors, all, sizeof all);
}

void view_describe(const struct view_field *view, float numbers[VIEW_NUMBERS], struct tensor *tensors) {
    const float values[VIEW_NUMBERS] = {view->options.radiance_unit,
                                        view->scale[0],
                                        view->scale[1],
                                        view->scale[2],
                                        (float)view->options.part_count,
                                        (float)view->options.log2_entries};
    memcpy(numbers, values, sizeof values);
    const struct tensor all[VIEW_TENSORS] = {
        make_tensor("view.numbers", TENSOR_F32, VIEW_NUMBERS, 0, numbers),
        make_tensor("view.anchors", TENSOR_F32, (size_t)view->options.anchor_count, 3, view->options.anchors),
        make_tensor("view.mlp", TENSOR_F32, mlp_layout(&view->shape).count, 0, view->mlp),
        make_tensor("view.table", TENSOR_I8, view->layout.entry_count, 2, view->codes),
        make_tensor("view.table_scale", TENSOR_F32, (size_t)view->layout.level_count, 0, view->table_scale),
    };
    memcpy(tensors, all, sizeof all);
}

// rows or columns SIZE_MAX: any number.
static const struct tensor *find(const struct safetensors *file, const char *name, enum tensor_type type, size_t rows,
                                 size_t columns) {
    const struct tensor *tensor = safetensors_find(file, name);
    if (!tensor || tensor->type != type || tensor->dimension_count != (columns ? 2 : 1)) return NULL;
    if ((rows != SIZE_MAX && tensor->shape[0] != rows) || (columns && tensor->shape[1] != columns)) return NULL;
    for (size_t i = 0; type == TENSOR_F32 && i < tensor->shape[0] * (columns ? columns : 1); i++) {
        float value;
        memcpy(&value, (const char *)tensor->data + 4 * i, sizeof value);
        if (!isfinite(value)) return NULL;
    }
    return tensor;
}

static bool is_count(float value, float most) { return value >= 0 && value <= most && value == floorf(value); }

static bool read_parts(const struct tensor *tensor, struct hull *hull) {
    size_t first = 0;
    hull->part_count = tensor->shape[0];
    for (size_t i = 0; i < hull->part_count; i++) {
        float v[HULL_PART_NUMBERS];
        memcpy(v, (const char *)tensor->data + i * sizeof v, sizeof v);
        if (!is_count(v[0], HULL_GLASS) || !is_count(v[1], 1) || !is_count(v[2], HULL_MAX_TRIANGLES)) return false;
        hull->parts[i] = (struct hull_part){.kind = (enum hull_kind)(int)v[0],
                                            .smooth = v[1] > 0,
                                            .first = (uint32_t)first,
                                            .count = (uint32_t)v[2],
                                            .eta = v[3],
                                            .sigma_a = {v[4], v[5], v[6]}};
        first += hull->parts[i].count;
    }
    return true;
}

static const struct tensor *find_view(const struct safetensors *file, const char *prefix, const char *name,
                                      enum tensor_type type, size_t rows, size_t columns) {
    char full[64];
    snprintf(full, sizeof full, "%sview.%s", prefix, name);
    return find(file, full, type, rows, columns);
}

static enum status read_view(const struct safetensors *file, const char *prefix, const struct proxy *proxy,
                             size_t parts, struct view_field **view, struct error *error) {
    float v[VIEW_NUMBERS];
    const struct tensor *numbers = find_view(file, prefix, "numbers", TENSOR_F32, VIEW_NUMBERS, 0),
                        *anchors = find_view(file, prefix, "anchors", TENSOR_F32, SIZE_MAX, 3),
                        *mlp = find_view(file, prefix, "mlp", TENSOR_F32, SIZE_MAX, 0),
                        *table = find_view(file, prefix, "table", TENSOR_I8, SIZE_MAX, 2),
                        *scale = find_view(file, prefix, "table_scale", TENSOR_F32, SIZE_MAX, 0);
    if (!numbers || !anchors || anchors->shape[0] > VIEW_MAX_ANCHORS || !mlp || !table || !scale)
        return error_set(error, STATUS_INVALID, "a tensor of the view field is missing or of the wrong form");
    memcpy(v, numbers->data, sizeof v);
    if (!(v[1] >= 0) || !(v[2] >= 0) || !(v[3] >= 0) || v[4] != (float)parts || !is_count(v[5], 20))
        return error_set(error, STATUS_INVALID, "the view field's numbers are out of range");
    struct view_field_options options = {.center = {proxy->center[0], proxy->center[1], proxy->center[2]},
                                         .radius = proxy->radius,
                                         .part_count = (int)parts,
                                         .log2_entries = (int)v[5],
                                         .radiance_unit = v[0],
                                         .anchor_count = (int)anchors->shape[0]};
    memcpy(options.anchors, anchors->data, anchors->shape[0] * sizeof *options.anchors);
    float *parameters = malloc((mlp->shape[0] + 1) * sizeof(float)), // aligned copies
        *scales = malloc((scale->shape[0] + 1) * sizeof(float));
    enum status status = STATUS_MEMORY;
    if (parameters && scales) {
        memcpy(parameters, mlp->data, mlp->shape[0] * sizeof(float));
        memcpy(scales, scale->data, scale->shape[0] * sizeof(float));
        status = view_field_restore(view, &options, parameters, mlp->shape[0], table->data, 2 * table->shape[0], scales,
                                    scale->shape[0], error);
        if (!status) memcpy((*view)->scale, v + 1, sizeof(*view)->scale);
    } else
        error_set(error, status, "out of memory");
    free(parameters);
    free(scales);
    return status;
}

static enum status read_all(const struct safetensors *file, const struct proxy *proxy, struct hull **hull,
                            struct error *error) {
    const struct tensor *frame = find(file, "hull.frame", TENSOR_F32, 6, 0),
                        *parts = find(file, "hull.parts", TENSOR_F32, SIZE_MAX, HULL_PART_NUMBERS),
                        *counts = find(file, "hull.counts", TENSOR_U32, 2, 0),
                        *mesh = find(file, "hull.mesh", TENSOR_U8, SIZE_MAX, 0);
    uint32_t count[2] = {0, 0};
    if (counts) memcpy(count, counts->data, sizeof count);
    if (!frame || !parts || !mesh || parts->shape[0] < 1 || parts->shape[0] > HULL_MAX_PARTS || !count[0] ||
        count[0] > HULL_MAX_VERTICES || count[1] > HULL_MAX_TRIANGLES)
        return error_set(error, STATUS_INVALID, "a tensor of the hull is missing or of the wrong form");
    enum status status = hull_allocate(hull, count[0], count[1], error);
    struct hull *h = *hull;
    if (!status) status = hull_unpack(h, mesh->data, mesh->shape[0], error);
    if (status) return status;
    memcpy(h->lower, frame->data, sizeof h->lower);
    memcpy(h->step, (const char *)frame->data + sizeof h->lower, sizeof h->step);
    if (!read_parts(parts, h)) return error_set(error, STATUS_INVALID, "a part of the hull is out of range");
    return hull_check(h, proxy->center, proxy->radius, error);
}

enum status hull_read(const struct safetensors *file, const char *name, const struct proxy *proxy, struct hull **hull,
                      struct error *error) {
    *hull = NULL;
    if (!safetensors_find(file, "hull.frame")) return STATUS_OK;
    struct error inner = {0};
    enum status status = read_all(file, proxy, hull, &inner);
    if (!status) return STATUS_OK;
    hull_destroy(*hull);
    *hull = NULL;
    return error_set(error, status, "%s: %s; bake the lamp again", name, inner.text);
}

enum status view_read(const struct safetensors *file, const char *name, const char *prefix, const struct proxy *proxy,
                      const struct hull *hull, struct view_field **view, struct error *error) {
    *view = NULL;
    struct error inner = {0};
    enum status status = read_view(file, prefix, proxy, hull->part_count, view, &inner);
    if (!status) return STATUS_OK;
    view_field_destroy(*view);
    *view = NULL;
    return error_set(error, status, "%s: %s; bake the lamp again", name, inner.text);
}
