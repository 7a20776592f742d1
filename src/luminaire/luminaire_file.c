// The file of a luminaire, read; docs/luminaire-format.md describes it. Everything that is read is checked here.
#include "luminaire/luminaire_file.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "format/safetensors.h"
#include "luminaire/luminaire_private.h"
#include "luminaire/paper_file.h"

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
    const struct tensor *anchors = NULL, *mlp = NULL, *table = NULL, *scale = NULL;
    bool complete = true;
    if (options->anchor_count)
        complete = (anchors = take(reader, prefix, "anchors", TENSOR_F32, (size_t)options->anchor_count, 3)) != NULL;
    if (anchors) memcpy(options->anchors, anchors->data, (size_t)options->anchor_count * sizeof *options->anchors);
    complete = complete && (mlp = take(reader, prefix, "mlp", TENSOR_F32, SIZE_MAX, 0)) &&
               (table = take(reader, prefix, "table", TENSOR_I8, SIZE_MAX, 2)) &&
               (scale = take(reader, prefix, "table_scale", TENSOR_F32, SIZE_MAX, 0));
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
                                                      .codes = table->data,
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

static enum status read_density(const struct reader *reader, const char *prefix, const struct proxy *proxy,
                                struct sampling_density **density) {
    const struct tensor *directions = take(reader, prefix, "directions", TENSOR_U32, 1, 0);
    if (!directions) return STATUS_INVALID;
    uint32_t n;
    memcpy(&n, directions->data, sizeof n);
    if (n < 1 || n > SAMPLING_MAX_DIRECTIONS) return fail(reader, "the sampling map's size is out of range");
    size_t cells = (size_t)n * n * DISTANCE_BINS + INSIDE_CELLS, anchors = 0;
    const struct tensor *map = take(reader, prefix, "map", TENSOR_U8, cells, MAP_BYTES), *share = NULL, *place = NULL,
                        *intensity = NULL;
    if (!map || !(share = take(reader, prefix, "residual_share", TENSOR_U8, cells, 0))) return STATUS_INVALID;
    float cones[2][CONE_COUNT] = {{0}};
    char anchors_name[EMISSION_PREFIX + 8];
    snprintf(anchors_name, sizeof anchors_name, "%sanchors", prefix);
    if (safetensors_find(reader->file, anchors_name)) {
        const struct tensor *cone = take(reader, prefix, "cones", TENSOR_F32, 2, CONE_COUNT);
        if (!cone || !(place = take(reader, prefix, "anchors", TENSOR_F32, SIZE_MAX, 3))) return STATUS_INVALID;
        anchors = place->shape[0];
        memcpy(cones, cone->data, sizeof cones);
        if (anchors < 1 || anchors > SAMPLING_MAX_ANCHORS) return fail(reader, "the number of anchors is out of range");
        if (!(intensity = take(reader, prefix, "intensity", TENSOR_F32, anchors, INTENSITY_CELLS)))
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

static enum status read_ceiling(const struct reader *reader, const char *prefix, struct light_field *light) {
    char name[EMISSION_PREFIX + 8];
    float ceiling[2];
    snprintf(name, sizeof name, "%sceiling", prefix);
    if (!safetensors_find(reader->file, name)) return STATUS_OK;
    if (!take_floats(reader, prefix, "ceiling", 2, ceiling)) return STATUS_INVALID;
    if (!(ceiling[0] >= 0) || !(ceiling[1] > 0)) return fail(reader, "the light's ceiling is out of range");
    light->ceiling_offset = ceiling[0];
    light->ceiling = ceiling[1];
    return STATUS_OK;
}

static enum status read_emission(const struct reader *reader, const struct luminaire *l, int group,
                                 struct emission *emission) {
    const struct proxy *proxy = &l->shape.proxy;
    char prefix[EMISSION_PREFIX];
    float unit[4];
    emission_prefix(prefix, group, "light.");
    if (!take_floats(reader, prefix, "unit", 4, unit)) return STATUS_INVALID;
    for (int c = 0; c < 3; c++)
        if (!(unit[1 + c] >= 0)) return fail(reader, "the light's scale is negative");
    if (!(unit[0] > 0)) return fail(reader, "the radiance unit is not positive");
    emission->light = calloc(1, sizeof *emission->light);
    if (!emission->light) return error_set(reader->error, STATUS_MEMORY, "%s: out of memory", reader->name);
    emission->light->radiance_unit = unit[0];
    memcpy(emission->light->scale, unit + 1, sizeof emission->light->scale);
    enum status status = read_ceiling(reader, prefix, emission->light);
    if (!status) status = read_net(reader, prefix, proxy, &emission->light->net);
    if (!status && emission->light->ceiling > 0 && emission->light->net.encoding.options.anchor_count == 0)
        return fail(reader, "the light has a ceiling but no anchors");
    if (!status && emission->light->net.encoding.options.use_hull) return fail(reader, "the light field needs a hull");
    emission_prefix(prefix, group, "sampling.");
    if (!status) status = read_density(reader, prefix, proxy, &emission->density);
    emission_prefix(prefix, group, "");
    if (!status && l->hull)
        status = view_read(reader->file, reader->name, prefix, proxy, l->hull, &emission->view, reader->error);
    return status;
}

static enum status read_transparency(const struct reader *reader, struct luminaire *l) {
    if (!safetensors_find(reader->file, "transparency.encoding")) return STATUS_OK;
    l->transparency = calloc(1, sizeof *l->transparency);
    if (!l->transparency) return error_set(reader->error, STATUS_MEMORY, "%s: out of memory", reader->name);
    enum status status = read_net(reader, "transparency.", &l->shape.proxy, &l->transparency->net);
    if (status || !l->transparency->net.encoding.options.use_hull) return status;
    if (!l->hull) return fail(reader, "the transparency's hull is missing");
    return transparency_set_hull(l->transparency, l->hull, reader->error);
}

// Of `rows` groups, or, where rows is 0, of the lamp.
static enum status read_flux(const struct reader *reader, const char *prefix, size_t rows, float (*flux)[3]) {
    const struct tensor *tensor = take(reader, prefix, "flux", TENSOR_F32, rows ? rows : 3, rows ? 3 : 0);
    if (!tensor) return STATUS_INVALID;
    const size_t count = rows ? rows : 1;
    memcpy(flux, tensor->data, count * sizeof *flux);
    for (size_t i = 0; i < count; i++)
        for (int c = 0; c < 3; c++)
            if (!(flux[i][c] >= 0)) return fail(reader, "the flux is negative");
    return STATUS_OK;
}

static enum status read_scattering(const struct reader *reader, struct luminaire *l) {
    if (!safetensors_find(reader->file, "scattering")) return STATUS_OK; // an older file
    const struct tensor *tensor = take(reader, "scattering", "", TENSOR_F32, 2, 3);
    if (!tensor) return STATUS_INVALID;
    float shares[2][3];
    memcpy(shares, tensor->data, sizeof shares);
    struct error inner = {0};
    return luminaire_set_scattering(l, shares[0], shares[1], &inner) ? fail(reader, inner.text) : STATUS_OK;
}

// The names, separated by commas, and the flux of each.
static enum status read_groups(const struct reader *reader, struct luminaire *l) {
    const char *text = safetensors_metadata(reader->file, LUMINAIRE_GROUPS_KEY);
    char names[LUMINAIRE_MAX_GROUPS][LUMINAIRE_NAME_SIZE];
    const char *list[LUMINAIRE_MAX_GROUPS];
    int count = 0;
    for (const char *at = text; at; count++) {
        size_t length = strcspn(at, ",");
        if (count == LUMINAIRE_MAX_GROUPS || length >= LUMINAIRE_NAME_SIZE)
            return fail(reader, "there are too many groups, or too long names");
        memcpy(names[count], at, length);
        names[count][length] = 0;
        list[count] = names[count];
        at = at[length] ? at + length + 1 : NULL;
    }
    if (!count) return fail(reader, "the names of the groups are missing");
    l->emission_count = count;
    struct error inner = {0};
    enum status status = luminaire_name_groups(l, list, &inner);
    if (status) return error_set(reader->error, status, "%s: %s", reader->name, inner.text);
    float flux[LUMINAIRE_MAX_GROUPS][3];
    if ((status = read_flux(reader, "groups.", (size_t)count, flux))) return status;
    for (int g = 0; g < count; g++) memcpy(l->emissions[g].flux, flux[g], sizeof flux[g]);
    return STATUS_OK;
}

static enum status read_all(const struct reader *reader, struct luminaire *l, bool grouped) {
    enum status status = read_proxy(reader, &l->shape);
    l->emission_count = 1;
    if (!status) status = read_flux(reader, "", 0, &l->emissions[0].flux);
    if (!status) status = read_scattering(reader, l);
    if (!status && grouped) status = read_groups(reader, l);
    if (!status) status = hull_read(reader->file, reader->name, &l->shape.proxy, &l->hull, reader->error);
    if (status) return status;
    if (paper_present(reader->file)) {
        if (grouped || l->hull) return fail(reader, "the published networks have no groups and no hull");
        status = paper_read(reader->file, reader->name, &l->shape.proxy, &l->paper, reader->error);
    } else {
        status = read_transparency(reader, l);
        for (int g = 0; g < l->emission_count && !status; g++) status = read_emission(reader, l, g, &l->emissions[g]);
    }
    if (status) return status;
    for (int g = 0; g < l->emission_count; g++)
        for (int c = 0; c < 3; c++) l->factor[g][c] = 1;
    luminaire_derive(l);
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
    const char *format = safetensors_metadata(&file, LUMINAIRE_FORMAT_KEY),
               *found = safetensors_metadata(&file, LUMINAIRE_VERSION_KEY);
    const bool grouped = found && strcmp(found, LUMINAIRE_VERSION_GROUPS) == 0;
    struct luminaire *l = NULL;
    if (!format || strcmp(format, LUMINAIRE_FORMAT) != 0)
        status = error_set(error, STATUS_INVALID, "%s: not a baked luminaire; make one with 'sconce bake'", name);
    else if (!found || (!grouped && strcmp(found, LUMINAIRE_VERSION) != 0))
        status = error_set(error, STATUS_INVALID,
                           "%s: format version %.40s, this program reads %s and %s; bake the lamp again", name,
                           found ? found : "missing", LUMINAIRE_VERSION, LUMINAIRE_VERSION_GROUPS);
    else if (!(l = calloc(1, sizeof *l)))
        status = error_set(error, STATUS_MEMORY, "%s: out of memory", name);
    else
        status = read_all(&reader, l, grouped);
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
