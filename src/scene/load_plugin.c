// Textures and BSDFs from their tables: each object becomes one instance, which all its references share.
#include <string.h>

#include "scene/load_private.h"
#include "scene/plugins.h"

enum status load_out_of_memory(const struct loader *loader) {
    return error_set(loader->error, STATUS_MEMORY, "%s: out of memory while loading the scene", loader->scene->path);
}

void *load_alloc(const struct loader *loader, size_t size) {
    void *memory = arena_alloc(&loader->scene->arena, 1, size);
    if (!memory) load_out_of_memory(loader);
    return memory;
}

struct commit_context load_context(const struct loader *loader, const struct object *object) {
    return (struct commit_context){&loader->scene->arena, loader->run, object, loader->options->skip_missing};
}

enum status load_append(const struct loader *loader, void *array_of_pointers, size_t *count, void *item) {
    void **items, *location = array_of_pointers;
    memcpy(&items, location, sizeof items);
    if ((*count & (*count - 1)) == 0) { // 0 or a power of two: full
        void **larger = arena_alloc(&loader->scene->arena, *count ? 2 * *count : 1, sizeof *larger);
        if (!larger) return load_out_of_memory(loader);
        if (*count) memcpy(larger, items, *count * sizeof *items);
        items = larger;
        memcpy(location, &items, sizeof items);
    }
    items[(*count)++] = item;
    return STATUS_OK;
}

enum status load_check_children(const struct loader *loader, const struct object *object, const char *const *tags) {
    for (size_t i = 0; i < object->child_count; i++) {
        const struct object_child *child = &object->children[i];
        const char *const *tag = tags;
        while (*tag && strcmp(*tag, child->object->tag)) tag++;
        if (!*tag)
            return error_at(loader->error, child->place, "a <%s> has no meaning in %s '%s'", child->object->tag,
                            object->tag, object->type);
    }
    return STATUS_OK;
}

enum status load_unknown_type(const struct loader *loader, const struct object *object) {
    const char *near = plugin_nearest(object->tag, object->type);
    return error_at(loader->error, object->place, "unknown %s '%.60s'; %s%s%ssee `sconce help %s`", object->tag,
                    object->type, near ? "did you mean '" : "", near ? near : "", near ? "'? Or " : "", object->tag);
}

enum status load_texture(void *user, struct object *object, const struct texture **result, struct error *error) {
    static const char *const tags[] = {"texture", NULL};
    static const char *const ignored[] = {"cache", "max_anisotropy", "format", "accel", NULL};
    const struct loader *loader = user;
    struct plugin_view view;
    size_t index;
    *result = object->instance;
    if (*result) return STATUS_OK;
    if (!plugin_find("texture", object->type, &view, &index)) return load_unknown_type(loader, object);
    const struct texture_type *type = texture_table[index];
    struct texture *texture = load_alloc(loader, type->size);
    if (!texture) return STATUS_MEMORY;
    texture->type = type;
    struct commit_context context = load_context(loader, object);
    params_ignore(object, ignored);
    enum status status = load_check_children(loader, object, tags);
    if (!status) status = params_read(texture, type->params, NULL, object, &context, &loader->maker, error);
    if (!status) status = params_check_used(object, &type->params, 1, error);
    if (!status && type->commit) status = type->commit(texture, &context, error);
    object->instance = texture;
    *result = texture;
    return status;
}

static void add_fetch(struct bsdf *bsdf, const struct texture *texture) {
    if (!texture || !texture->type || !texture->type->fetch) return;
    for (int i = 0; i < BSDF_FETCHES; i++) {
        if (bsdf->fetches[i]) continue;
        bsdf->fetches[i] = texture;
        return;
    }
}

static void find_fetches(struct bsdf *bsdf) {
    for (const struct param *param = bsdf->type->params; param->name; param++) {
        const struct texture *texture;
        if (param->type != PARAM_TEXTURE) continue;
        memcpy(&texture, (const char *)bsdf + param->offset, sizeof texture);
        add_fetch(bsdf, texture);
    }
}

static enum status load_bsdf_children(struct loader *loader, struct object *object, struct bsdf *bsdf) {
    const struct bsdf_type *type = bsdf->type;
    int count = 0;
    for (size_t i = 0; i < object->child_count; i++) {
        struct object_child *child = &object->children[i];
        if (strcmp(child->object->tag, "bsdf")) continue;
        const struct bsdf *nested;
        if (count == type->max_children)
            return error_at(loader->error, child->place, "bsdf '%s' takes %s%.0d nested bsdf%s", type->name,
                            type->max_children ? "at most " : "no", type->max_children,
                            type->max_children == 1 ? "" : "s");
        enum status status = load_bsdf(loader, child->object, &nested);
        if (status) return status;
        memcpy((char *)bsdf + type->children_offset + (size_t)count++ * sizeof nested, &nested, sizeof nested);
        for (int k = 0; k < BSDF_FETCHES; k++) add_fetch(bsdf, nested->fetches[k]);
    }
    if (count < type->min_children)
        return error_at(loader->error, object->place, "bsdf '%s' needs %d nested bsdf%s", type->name,
                        type->min_children, type->min_children == 1 ? "" : "s");
    return STATUS_OK;
}

enum status load_bsdf(struct loader *loader, struct object *object, const struct bsdf **result) {
    static const char *const tags[] = {"texture", "bsdf", NULL};
    static const char *const ignored[] = {"sample_visible",
                                          "flip_invalid_normals",
                                          "main_specular_sampling_rate",
                                          "clearcoat_sampling_rate",
                                          "diffuse_reflectance_sampling_rate",
                                          NULL};
    struct plugin_view view;
    size_t index;
    *result = object->instance;
    if (*result) return STATUS_OK;
    if (!plugin_find("bsdf", object->type, &view, &index)) return load_unknown_type(loader, object);
    const struct bsdf_type *type = bsdf_table[index];
    struct bsdf *bsdf = load_alloc(loader, type->size);
    if (!bsdf) return STATUS_MEMORY;
    *bsdf = (struct bsdf){.type = type, .flags = type->flags};
    struct commit_context context = load_context(loader, object);
    params_ignore(object, ignored);
    enum status status = load_check_children(loader, object, tags);
    if (!status) status = params_read(bsdf, type->params, NULL, object, &context, &loader->maker, loader->error);
    if (!status) status = params_check_used(object, &type->params, 1, loader->error);
    if (!status) find_fetches(bsdf);
    if (!status) status = load_bsdf_children(loader, object, bsdf);
    if (!status && type->commit) status = type->commit(bsdf, &context, loader->error);
    object->instance = bsdf;
    *result = bsdf;
    return status;
}
