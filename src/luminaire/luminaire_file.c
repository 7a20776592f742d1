// The file of a luminaire; docs/luminaire-format.md describes it. Everything that is read is checked here.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "format/safetensors.h"
#include "luminaire/luminaire_private.h"
#include "luminaire/paper_file.h"

static const char format_key[] = "format", format_name[] = "sconce-luminaire", version_key[] = "format_version",
                  version[] = "1";
enum { PROXY_NUMBERS = 16, MAX_TENSORS = 26 + HULL_TENSORS, NET_NUMBERS = 12 };

// --- Writing ---

struct writer {
    struct safetensors file;
    struct tensor tensors[MAX_TENSORS];
    char names[MAX_TENSORS][40];
    float proxy[PROXY_NUMBERS], light_numbers[4], cones[2 * CONE_COUNT];
    float net_numbers[2][NET_NUMBERS];
    uint32_t directions;
    struct hull_numbers hull;
};

static void put(struct writer *writer, const char *prefix, const char *name, enum tensor_type type, size_t rows,
                size_t columns, const void *data) {
    size_t at = writer->file.tensor_count++;
    snprintf(writer->names[at], sizeof writer->names[at], "%s%s", prefix, name);
    writer->tensors[at] = (struct tensor){.name = writer->names[at],
                                          .type = type,
                                          .dimension_count = columns ? 2 : 1,
                                          .shape = {rows, columns},
                                          .data = data};
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
    if (net->packed) {
        put(writer, prefix, "table4", TENSOR_U8, net->encoding.layout.entry_count, 0, net->places);
        put(writer, prefix, "table4_book", TENSOR_I8, (size_t)net->encoding.layout.level_count, GRID_BOOK, net->book);
    } else
        put(writer, prefix, "table", TENSOR_I8, net->encoding.layout.entry_count, 2, net->codes);
    put(writer, prefix, "table_scale", TENSOR_F32, (size_t)net->encoding.layout.level_count, 0, net->scale);
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
    put(writer, "flux", "", TENSOR_F32, 3, 0, luminaire->flux);
    writer->file.tensors = writer->tensors;
    if (luminaire->hull) {
        hull_describe(luminaire->hull, luminaire->view, &writer->hull, writer->tensors + writer->file.tensor_count);
        writer->file.tensor_count += HULL_TENSORS;
    }
    if (luminaire->paper) {
        paper_describe(luminaire->paper, writer->tensors + writer->file.tensor_count);
        writer->file.tensor_count += PAPER_NETS;
        return;
    }
    writer->light_numbers[0] = luminaire->light->radiance_unit;
    memcpy(writer->light_numbers + 1, luminaire->light->scale, sizeof luminaire->light->scale);
    put(writer, "light.", "unit", TENSOR_F32, 4, 0, writer->light_numbers);
    put_net(writer, "light.", &luminaire->light->net, writer->net_numbers[0]);
    if (luminaire->transparency)
        put_net(writer, "transparency.", &luminaire->transparency->net, writer->net_numbers[1]);
    const struct sampling_density *density = luminaire->density;
    size_t cells = sampling_cell_count(density), anchors = (size_t)density->anchor_count;
    writer->directions = (uint32_t)density->directions;
    put(writer, "sampling.", "directions", TENSOR_U32, 1, 0, &writer->directions);
    put(writer, "sampling.", "map", TENSOR_U8, cells, MAP_BYTES, density->codes);
    put(writer, "sampling.", "residual_share", TENSOR_U8, cells, 0, density->residual_share);
    if (anchors) {
        memcpy(writer->cones, density->cone_radius, sizeof density->cone_radius);
        memcpy(writer->cones + CONE_COUNT, density->cone_share, sizeof density->cone_share);
        put(writer, "sampling.", "cones", TENSOR_F32, 2, CONE_COUNT, writer->cones);
        put(writer, "sampling.", "anchors", TENSOR_F32, anchors, 3, density->anchors);
        put(writer, "sampling.", "intensity", TENSOR_F32, anchors, INTENSITY_CELLS, density->intensity);
    }
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
    const char **keys = calloc(count + 2, sizeof *keys), **values = calloc(count + 2, sizeof *values);
    enum status status;
    if (writer && keys && values) {
        describe(writer, luminaire);
        keys[0] = format_key, values[0] = format_name;
        keys[1] = version_key, values[1] = version;
        size_t used = 2;
        for (size_t i = 0; i < count; i++) {
            if (strcmp(luminaire->keys[i], format_key) == 0 || strcmp(luminaire->keys[i], version_key) == 0) continue;
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

// --- Reading ---

struct reader {
    const struct safetensors *file;
    const char *name;
    struct error *error;
};

// A tensor of this type and shape; rows or columns SIZE_MAX: any number. Floats must be finite.
static const struct tensor *take(const struct reader *reader, const char *prefix, const char *name,
                                 enum tensor_type type, size_t rows, size_t columns) {
    char full[64];
    snprintf(full, sizeof full, "%s%s", prefix, name);
    const struct tensor *tensor = safetensors_find(reader->file, full);
    if (!tensor) {
        error_set(reader->error, STATUS_INVALID, "%s: tensor '%s' is missing; bake the lamp again", reader->name, full);
        return NULL;
    }
    size_t dimensions = columns ? 2 : 1;
    bool fits = tensor->type == type && tensor->dimension_count == dimensions &&
                (rows == SIZE_MAX || tensor->shape[0] == rows) && (dimensions == 1 || tensor->shape[1] == columns);
    if (!fits) {
        error_set(reader->error, STATUS_INVALID, "%s: tensor '%s' has the wrong type or shape; bake the lamp again",
                  reader->name, full);
        return NULL;
    }
    size_t count = tensor->shape[0] * (columns ? columns : 1);
    if (type == TENSOR_F32)
        for (size_t i = 0; i < count; i++) {
            float value;
            memcpy(&value, (const char *)tensor->data + 4 * i, 4);
            if (!isfinite(value)) {
                error_set(reader->error, STATUS_INVALID, "%s: tensor '%s' holds a number that is not finite",
                          reader->name, full);
                return NULL;
            }
        }
    return tensor;
}

static bool take_floats(const struct reader *reader, const char *prefix, const char *name, size_t count,
                        float *values) {
    const struct tensor *tensor = take(reader, prefix, name, TENSOR_F32, count, 0);
    if (tensor) memcpy(values, tensor->data, count * sizeof(float));
    return tensor != NULL;
}

// A copy with the alignment of its element type, which the file's bytes need not have. The caller frees it.
static void *copy_tensor(const struct reader *reader, const struct tensor *tensor, size_t count) {
    size_t size = count * tensor_element_size(tensor->type);
    void *copy = malloc(size ? size : 1);
    if (copy)
        memcpy(copy, tensor->data, size);
    else
        error_set(reader->error, STATUS_MEMORY, "%s: out of memory", reader->name);
    return copy;
}

static bool is_count(float value, float most) { return value >= 0 && value <= most && value == floorf(value); }

static enum status fail(const struct reader *reader, const char *what) {
    return error_set(reader->error, STATUS_INVALID, "%s: %s; bake the lamp again", reader->name, what);
}

static enum status read_proxy(const struct reader *reader, struct proxy_shape *shape) {
    float v[PROXY_NUMBERS];
    if (!take_floats(reader, "proxy", "", PROXY_NUMBERS, v)) return STATUS_INVALID;
    if (!is_count(v[0], PROXY_MESH)) return fail(reader, "the proxy's kind is unknown");
    struct proxy proxy = {.kind = (enum proxy_kind)(int)v[0],
                          .center = {v[1], v[2], v[3]},
                          .radius = v[4],
                          .lower = {v[5], v[6], v[7]},
                          .upper = {v[8], v[9], v[10]},
                          .axis = {v[11], v[12], v[13]},
                          .half_height = v[14],
                          .axis_radius = v[15]};
    enum status status = STATUS_OK;
    if (proxy.kind == PROXY_MESH) {
        const struct tensor *vertices = take(reader, "proxy.", "vertices", TENSOR_F32, SIZE_MAX, 3);
        const struct tensor *indices = vertices ? take(reader, "proxy.", "indices", TENSOR_U32, SIZE_MAX, 3) : NULL;
        if (!indices) return STATUS_INVALID;
        proxy.vertex_count = vertices->shape[0];
        proxy.triangle_count = indices->shape[0];
        proxy.vertices = copy_tensor(reader, vertices, 3 * proxy.vertex_count);
        proxy.indices = copy_tensor(reader, indices, 3 * proxy.triangle_count);
        if (!proxy.vertices || !proxy.indices) status = STATUS_MEMORY;
    }
    struct error inner = {0};
    if (!status && (status = proxy_shape_init(shape, &proxy, &inner)))
        error_set(reader->error, status, "%s: %s", reader->name, inner.text);
    free(proxy.vertices);
    free(proxy.indices);
    return status;
}

static enum status read_net(const struct reader *reader, const char *prefix, const struct proxy *proxy,
                            struct field_net *net) {
    float v[NET_NUMBERS];
    if (!take_floats(reader, prefix, "encoding", NET_NUMBERS, v)) return STATUS_INVALID;
    if (!is_count(v[0], ENCODING_MAX_ANCHORS) || !is_count(v[2], ENCODING_MAX_SHELLS) || !is_count(v[3], 1) ||
        !is_count(v[4], 20) || !is_count(v[9], 1))
        return fail(reader, "the encoding's numbers are out of range");
    struct encoding_options *options = calloc(1, sizeof *options);
    if (!options) return error_set(reader->error, STATUS_MEMORY, "%s: out of memory", reader->name);
    options->anchor_count = (int)v[0];
    options->anchor_radius = v[1];
    options->shell_count = (int)v[2];
    options->use_grid4 = v[3] > 0;
    options->log2_entries = (int)v[4];
    options->use_hull = v[9] > 0;
    memcpy(options->shells, v + 5, sizeof options->shells);
    const struct tensor *anchors = NULL, *mlp = NULL, *table = NULL, *scale = NULL, *book = NULL;
    char packed_name[64];
    snprintf(packed_name, sizeof packed_name, "%stable4", prefix);
    const bool packed = safetensors_find(reader->file, packed_name) != NULL;
    bool complete = true;
    if (options->anchor_count)
        complete = (anchors = take(reader, prefix, "anchors", TENSOR_F32, (size_t)options->anchor_count, 3)) != NULL;
    if (anchors) memcpy(options->anchors, anchors->data, (size_t)options->anchor_count * sizeof *options->anchors);
    complete = complete && (mlp = take(reader, prefix, "mlp", TENSOR_F32, SIZE_MAX, 0)) &&
               (table = packed ? take(reader, prefix, "table4", TENSOR_U8, SIZE_MAX, 0)
                               : take(reader, prefix, "table", TENSOR_I8, SIZE_MAX, 2)) &&
               (scale = take(reader, prefix, "table_scale", TENSOR_F32, SIZE_MAX, 0)) &&
               (!packed || (book = take(reader, prefix, "table4_book", TENSOR_I8, scale->shape[0], GRID_BOOK)));
    enum status status = STATUS_INVALID;
    if (complete) {
        float *parameters = copy_tensor(reader, mlp, mlp->shape[0]),
              *scales = copy_tensor(reader, scale, scale->shape[0]);
        struct error inner = {0};
        if (!parameters || !scales)
            status = STATUS_MEMORY;
        else {
            const struct field_net_numbers numbers = {.mlp = parameters,
                                                      .scale = scales,
                                                      .codes = packed ? NULL : table->data,
                                                      .places = packed ? table->data : NULL,
                                                      .book = packed ? book->data : NULL,
                                                      .mlp_count = mlp->shape[0],
                                                      .entry_count = table->shape[0],
                                                      .level_count = scale->shape[0]};
            status = field_net_restore(net, proxy->center, proxy->radius, options, &numbers, &inner);
            if (status) error_set(reader->error, status, "%s: %s", reader->name, inner.text);
        }
        free(parameters);
        free(scales);
    }
    free(options);
    return status;
}

static enum status read_density(const struct reader *reader, const struct proxy *proxy,
                                struct sampling_density **density) {
    const struct tensor *directions = take(reader, "sampling.", "directions", TENSOR_U32, 1, 0);
    if (!directions) return STATUS_INVALID;
    uint32_t n;
    memcpy(&n, directions->data, sizeof n);
    if (n < 1 || n > SAMPLING_MAX_DIRECTIONS) return fail(reader, "the sampling map's size is out of range");
    size_t cells = (size_t)n * n * DISTANCE_BINS + INSIDE_CELLS, anchors = 0;
    const struct tensor *map = take(reader, "sampling.", "map", TENSOR_U8, cells, MAP_BYTES), *share = NULL,
                        *place = NULL, *intensity = NULL;
    if (!map || !(share = take(reader, "sampling.", "residual_share", TENSOR_U8, cells, 0))) return STATUS_INVALID;
    float cones[2][CONE_COUNT] = {{0}};
    if (safetensors_find(reader->file, "sampling.anchors")) {
        const struct tensor *cone = take(reader, "sampling.", "cones", TENSOR_F32, 2, CONE_COUNT);
        if (!cone || !(place = take(reader, "sampling.", "anchors", TENSOR_F32, SIZE_MAX, 3))) return STATUS_INVALID;
        anchors = place->shape[0];
        memcpy(cones, cone->data, sizeof cones);
        if (anchors < 1 || anchors > SAMPLING_MAX_ANCHORS) return fail(reader, "the number of anchors is out of range");
        if (!(intensity = take(reader, "sampling.", "intensity", TENSOR_F32, anchors, INTENSITY_CELLS)))
            return STATUS_INVALID;
        float sum = 0;
        for (int k = 0; k < CONE_COUNT; k++) {
            sum += cones[1][k];
            if (!(cones[0][k] > 0) || !(cones[0][k] <= proxy->radius) || !(cones[1][k] >= 0) ||
                (k > 0 && cones[0][k] < cones[0][k - 1]))
                return fail(reader, "a sampling cone is out of range");
        }
        if (!(fabsf(sum - 1) < 1e-3f)) return fail(reader, "the sampling cones' shares do not sum to 1");
    }
    enum status status = sampling_allocate(density, proxy, (int)n, (int)anchors, reader->error);
    if (status) return status;
    struct sampling_density *d = *density;
    memcpy(d->codes, map->data, cells * MAP_BYTES);
    memcpy(d->residual_share, share->data, cells);
    if (anchors) {
        memcpy(d->anchors, place->data, anchors * sizeof *d->anchors);
        memcpy(d->intensity, intensity->data, anchors * INTENSITY_CELLS * sizeof(float));
        memcpy(d->cone_radius, cones[0], sizeof cones[0]);
        memcpy(d->cone_share, cones[1], sizeof cones[1]);
    }
    for (size_t i = 0; i < anchors * INTENSITY_CELLS; i++)
        if (!(d->intensity[i] > 0) || !(d->intensity[i] < 1e6f))
            return fail(reader, "an anchor's intensity is not positive");
    for (size_t i = 0; i < anchors; i++)
        for (int a = 0; a < 3; a++)
            if (!(fabsf(d->anchors[i][a] - proxy->center[a]) <= 10 * proxy->radius))
                return fail(reader, "an anchor is far outside the proxy");
    sampling_derive(d);
    return STATUS_OK;
}

static enum status read_compact(const struct reader *reader, struct luminaire *l) {
    const struct proxy *proxy = &l->shape.proxy;
    float unit[4];
    if (!take_floats(reader, "light.", "unit", 4, unit)) return STATUS_INVALID;
    for (int c = 0; c < 3; c++)
        if (!(unit[1 + c] >= 0)) return fail(reader, "the light's scale is negative");
    if (!(unit[0] > 0)) return fail(reader, "the radiance unit is not positive");
    l->light = calloc(1, sizeof *l->light);
    if (!l->light) return error_set(reader->error, STATUS_MEMORY, "%s: out of memory", reader->name);
    l->light->radiance_unit = unit[0];
    memcpy(l->light->scale, unit + 1, sizeof l->light->scale);
    enum status status = read_net(reader, "light.", proxy, &l->light->net);
    if (!status && safetensors_find(reader->file, "transparency.encoding")) {
        l->transparency = calloc(1, sizeof *l->transparency);
        if (!l->transparency) return error_set(reader->error, STATUS_MEMORY, "%s: out of memory", reader->name);
        status = read_net(reader, "transparency.", proxy, &l->transparency->net);
    }
    return status ? status : read_density(reader, proxy, &l->density);
}

// The transparency may need the hull.
static enum status share_hull(const struct reader *reader, struct luminaire *l) {
    if (l->light && l->light->net.encoding.options.use_hull) return fail(reader, "the light field needs a hull");
    if (!l->transparency || !l->transparency->net.encoding.options.use_hull) return STATUS_OK;
    if (!l->hull) return fail(reader, "the transparency's hull is missing");
    return transparency_set_hull(l->transparency, l->hull, reader->error);
}

static enum status read_all(const struct reader *reader, struct luminaire *l) {
    enum status status = read_proxy(reader, &l->shape);
    if (status) return status;
    if (!take_floats(reader, "flux", "", 3, l->flux)) return STATUS_INVALID;
    for (int c = 0; c < 3; c++)
        if (!(l->flux[c] >= 0)) return fail(reader, "the flux is negative");
    if (paper_present(reader->file))
        status = paper_read(reader->file, reader->name, &l->shape.proxy, &l->paper, reader->error);
    else
        status = read_compact(reader, l);
    if (!status) status = hull_read(reader->file, reader->name, &l->shape.proxy, &l->hull, &l->view, reader->error);
    if (!status) status = share_hull(reader, l);
    if (status) return status;
    return luminaire_set_metadata(l, reader->file->metadata_keys, reader->file->metadata_values,
                                  reader->file->metadata_count, reader->error);
}

enum status luminaire_parse(struct luminaire **luminaire, const char *name, const uint8_t *bytes, size_t length,
                            struct error *error) {
    *luminaire = NULL;
    struct safetensors file = {0};
    enum status status = safetensors_parse(&file, name, bytes, length, error);
    if (status) return status;
    struct reader reader = {&file, name, error};
    const char *format = safetensors_metadata(&file, format_key), *found = safetensors_metadata(&file, version_key);
    struct luminaire *l = NULL;
    if (!format || strcmp(format, format_name) != 0)
        status = error_set(error, STATUS_INVALID, "%s: not a baked luminaire; make one with 'sconce bake'", name);
    else if (!found || strcmp(found, version) != 0)
        status =
            error_set(error, STATUS_INVALID, "%s: format version %.40s, this program reads %s; bake the lamp again",
                      name, found ? found : "missing", version);
    else if (!(l = calloc(1, sizeof *l)))
        status = error_set(error, STATUS_MEMORY, "%s: out of memory", name);
    else
        status = read_all(&reader, l);
    safetensors_fini(&file);
    if (status) {
        luminaire_destroy(l);
        return status;
    }
    l->bytes = length;
    *luminaire = l;
    return STATUS_OK;
}

enum status luminaire_load(struct luminaire **luminaire, const char *path, struct error *error) {
    uint8_t *bytes;
    size_t length;
    *luminaire = NULL;
    enum status status = file_read(path, &bytes, &length, error);
    if (status) return status;
    status = luminaire_parse(luminaire, path, bytes, length, error);
    free(bytes);
    return status;
}
