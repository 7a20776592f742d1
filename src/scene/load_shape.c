// Shapes with what stands inside them (bsdf, area emitter, interior medium), and emitters.
#include <string.h>

#include "scene/load_private.h"
#include "scene/plugins.h"

const struct param shape_common_params[] = {
    {"to_world", PARAM_TRANSFORM, offsetof(struct shape, to_world), "", .help = "places the shape in the scene"},
    {"flip_normals", PARAM_BOOL, offsetof(struct shape, flip_normals), "false", .help = "turn the outside in"},
    {"face_normals", PARAM_BOOL, offsetof(struct shape, face_normals), "false",
     .help = "flat triangles: no vertex normals"},
    PARAM_END,
};

struct medium {
    rgb sigma_a, sigma_s, sigma_t, albedo;
    float scale;
};

const struct param medium_params[] = {
    {"sigma_a", PARAM_RGB, offsetof(struct medium, sigma_a), "", 0, 1e9, "1/length", .help = "absorption"},
    {"sigma_t", PARAM_RGB, offsetof(struct medium, sigma_t), "", 0, 1e9, "1/length",
     .help = "extinction, instead of sigma_a"},
    {"sigma_s", PARAM_RGB, offsetof(struct medium, sigma_s), "", 0, 1e9, "1/length", .help = "scattering: must be 0"},
    {"albedo", PARAM_RGB, offsetof(struct medium, albedo), "", 0, 1, "1",
     .help = "share of extinction that scatters: must be 0"},
    {"scale", PARAM_FLOAT, offsetof(struct medium, scale), "1", 0, 1e9, "1", .help = "multiplies all of them"},
    PARAM_END,
};

static enum status read_interior(struct loader *loader, struct object *object, struct shape *shape) {
    static const char *const tags[] = {"phase", NULL};
    const struct param *const table = medium_params;
    struct medium medium = {0};
    struct commit_context context = load_context(loader, object);
    if (!param_name_equal(object->type, "homogeneous"))
        return error_at(loader->error, object->place,
                        "medium '%s' is not supported; only 'homogeneous' without scattering is", object->type);
    enum status status = load_check_children(loader, object, tags);
    if (!status) status = params_read(&medium, medium_params, NULL, object, &context, NULL, loader->error);
    if (!status) status = params_check_used(object, &table, 1, loader->error);
    if (status) return status;
    const struct property *a = object_property(object, "sigma_a"), *t = object_property(object, "sigma_t");
    if (!a == !t) return error_at(loader->error, object->place, "the medium needs sigma_a, or sigma_t with albedo 0");
    if (t && !object_property(object, "albedo"))
        return error_at(loader->error, object->place,
                        "sigma_t needs albedo 0 beside it: media that scatter are not supported");
    if (!rgb_is_black(medium.albedo) || !rgb_is_black(medium.sigma_s))
        return error_at(loader->error, object->place,
                        "the medium scatters, which is not supported; only absorption is");
    shape->has_interior = true;
    shape->sigma_a = rgb_scale(a ? medium.sigma_a : medium.sigma_t, medium.scale);
    // A lamp that is placed larger or smaller keeps its look.
    if (loader->placement.depth)
        shape->sigma_a = rgb_scale(
            shape->sigma_a,
            1 / cbrtf(fabsf(vec3_dot(vec3_cross(transform_vector(&loader->placement.to_world, vec3_make(1, 0, 0)),
                                                transform_vector(&loader->placement.to_world, vec3_make(0, 1, 0))),
                                     transform_vector(&loader->placement.to_world, vec3_make(0, 0, 1))))));
    return STATUS_OK;
}

// Of a shape without one: diffuse, black where the shape emits, as in all versions of Mitsuba.
static enum status default_bsdf(struct loader *loader, bool emits, const struct bsdf **bsdf) {
    static const struct property black = {.name = "reflectance", .type = PROPERTY_FLOAT, .string = "0"};
    const struct bsdf **made = &loader->default_bsdf[emits];
    if (!*made) {
        struct object *object = load_alloc(loader, sizeof *object);
        struct property *reflectance = load_alloc(loader, sizeof *reflectance);
        if (!object || !reflectance) return STATUS_MEMORY;
        *reflectance = black;
        *object = (struct object){.tag = "bsdf", .type = "diffuse", .id = "", .place = {loader->scene->path, 0, 0}};
        object->properties = reflectance;
        object->property_count = emits;
        enum status status = load_bsdf(loader, object, made);
        if (status) return status;
    }
    *bsdf = *made;
    return STATUS_OK;
}

// Reads what stands in the shape, except the emitter, which is returned.
static enum status read_shape_children(struct loader *loader, struct object *object, struct shape *shape,
                                       struct object **emitter) {
    static const char *const tags[] = {"bsdf", "emitter", "medium", "texture", NULL};
    enum status status = load_check_children(loader, object, tags);
    for (size_t i = 0; i < object->child_count && !status; i++) {
        struct object_child *child = &object->children[i];
        const char *tag = child->object->tag;
        if (!strcmp(tag, "medium") && param_name_equal(child->name, "interior")) {
            status = read_interior(loader, child->object, shape);
        } else if (!strcmp(tag, "medium")) {
            run_warn(loader->run, "%s:%d:%d: only a medium named 'interior' is supported: this one is left out",
                     child->place.file, child->place.line, child->place.column);
        } else if (!strcmp(tag, "bsdf") && !shape->bsdf) {
            status = load_bsdf(loader, child->object, &shape->bsdf);
        } else if (!strcmp(tag, "emitter") && !*emitter) {
            *emitter = child->object;
        } else if (strcmp(tag, "texture")) {
            status = error_at(loader->error, child->place, "a second <%s> in one shape", tag);
        }
    }
    return status || shape->bsdf ? status : default_bsdf(loader, *emitter != NULL, &shape->bsdf);
}

enum status load_shape(struct loader *loader, struct object *object) {
    static const char *const ignored[] = {
        "max_smooth_angle", "collapse", "load_materials", "vertex_colors", "srgb", "silhouette_sampling_weight", NULL};
    struct plugin_view view;
    size_t index;
    struct object *emitter = NULL;
    if (!plugin_find("shape", object->type, &view, &index)) return load_unknown_type(loader, object);
    if (view.params == luminaire_params) return load_luminaire(loader, object);
    if (view.params == instance_params) return load_instance(loader, object);
    if (view.params == merge_params) return load_members(loader, object);
    if (view.params == shapegroup_params) return STATUS_OK; // stands there to be referred to
    const struct shape_type *type = shape_table[index];
    struct shape *shape = load_alloc(loader, type->size);
    if (!shape) return STATUS_MEMORY;
    *shape = (struct shape){
        .type = type, .id = object->id, .place = object->place, .luminaire = loader->placement.luminaire};
    struct commit_context context = load_context(loader, object);
    const struct param *const tables[] = {type->params, shape_common_params};
    params_ignore(object, ignored);
    enum status status = params_read(shape, type->params, NULL, object, &context, &loader->maker, loader->error);
    if (!status) status = params_read(shape, shape_common_params, type->params, object, &context, NULL, loader->error);
    if (!status) status = read_shape_children(loader, object, shape, &emitter);
    if (!status) status = params_check_used(object, tables, 2, loader->error);
    if (status) return status;
    if (loader->placement.opaque_only && (emitter || shape->bsdf->flags & BSDF_TRANSMISSION)) return STATUS_OK;
    shape->to_world = transform_multiply(&loader->placement.to_world, &shape->to_world);
    status = type->commit ? type->commit(shape, &context, loader->error) : STATUS_OK;
    if (status == STATUS_IO && loader->options->skip_missing) {
        run_warn(loader->run, "%s; the shape is left out", loader->error ? loader->error->text : "a file is missing");
        return STATUS_OK;
    }
    if (status) return status;
    shape->index = (uint32_t)loader->scene->shape_count;
    status = load_append(loader, &loader->scene->shapes, &loader->scene->shape_count, shape);
    return status || !emitter ? status : load_emitter(loader, emitter, shape, &shape->emitter);
}

enum status load_emitter(struct loader *loader, struct object *object, struct shape *shape,
                         const struct emitter **result) {
    static const char *const tags[] = {"texture", NULL};
    static const char *const ignored[] = {"sampling_weight", "cache", "medium", NULL};
    struct scene *scene = loader->scene;
    struct plugin_view view;
    size_t index;
    if (!plugin_find("emitter", object->type, &view, &index)) return load_unknown_type(loader, object);
    const struct emitter_type *type = emitter_table[index];
    if (type->needs_shape != (shape != NULL))
        return error_at(loader->error, object->place,
                        shape ? "emitter '%s' cannot stand inside a shape" : "emitter '%s' must stand inside a shape",
                        type->name);
    struct emitter *emitter = load_alloc(loader, type->size);
    if (!emitter) return STATUS_MEMORY;
    *emitter = (struct emitter){.type = type,
                                .shape = shape,
                                .flags = type->flags,
                                .index = (uint32_t)scene->emitter_count,
                                .id = shape && !object->id[0] ? shape->id : object->id,
                                .factor = rgb_gray(1)};
    struct commit_context context = load_context(loader, object);
    params_ignore(object, ignored);
    enum status status = load_check_children(loader, object, tags);
    if (!status) status = params_read(emitter, type->params, NULL, object, &context, &loader->maker, loader->error);
    if (!status) status = params_check_used(object, &type->params, 1, loader->error);
    if (!status && type->commit) status = type->commit(emitter, &context, loader->error);
    if (status == STATUS_IO && loader->options->skip_missing) {
        run_warn(loader->run, "%s; the emitter is left out", loader->error ? loader->error->text : "a file is missing");
        return STATUS_OK;
    }
    if (status) return status;
    if (emitter->flags & EMITTER_INFINITE && !(emitter->flags & EMITTER_DELTA_DIRECTION)) {
        if (scene->environment) return error_at(loader->error, object->place, "the scene has an environment already");
        scene->environment = emitter;
    }
    if (result) *result = emitter;
    return load_append(loader, &scene->emitters, &scene->emitter_count, emitter);
}
