// A scene file to a committed scene: description -> plugins through their tables (load_*.c) -> scene_commit.
// Everything is made in the order of the file; textures before the BSDFs and BSDFs before the shapes that use them.
#include <string.h>

#include "scene/load_private.h"
#include "scene/scene_commit.h"
#include "scene/scene_embree.h"

static void note_left_aside(const struct loader *loader, const struct object *object) {
    run_note(loader->run, "%s:%d:%d: %s '%s' is left aside: only the lamp itself is read", object->place.file,
             object->place.line, object->place.column, object->tag, object->type);
}

// Constant and envmap emitters by table, so that their files are not even opened.
static bool is_infinite(const struct object *object) {
    for (const struct emitter_type *const *type = emitter_table; *type; type++)
        if (param_name_equal((*type)->name, object->type)) return ((*type)->flags & EMITTER_INFINITE) != 0;
    return false;
}

static enum status load_child(struct loader *loader, struct object_child *child) {
    struct object *object = child->object;
    const char *tag = object->tag;
    bool is_lamp = loader->options->lamp_only || loader->placement.depth;
    if (!strcmp(tag, "shape")) return load_shape(loader, object);
    if (!strcmp(tag, "bsdf")) return load_bsdf(loader, object, &(const struct bsdf *){NULL});
    if (!strcmp(tag, "texture")) return load_texture(loader, object, &(const struct texture *){NULL}, loader->error);
    if (!strcmp(tag, "sensor") || !strcmp(tag, "integrator")) {
        if (is_lamp) {
            note_left_aside(loader, object);
            return STATUS_OK;
        }
        if (*tag == 'i') return load_integrator(loader, object);
        if (!loader->scene->sensor) return load_sensor(loader, object);
        run_note(loader->run, "%s:%d:%d: the first sensor is used; this one is left aside", child->place.file,
                 child->place.line, child->place.column);
        return STATUS_OK;
    }
    if (!strcmp(tag, "emitter")) {
        // Of a lamp placed in a scene, only shapes emit: points and spots inside glass cannot be seen anyway.
        if (loader->placement.depth || (is_lamp && is_infinite(object))) {
            note_left_aside(loader, object);
            return STATUS_OK;
        }
        return load_emitter(loader, object, NULL, NULL);
    }
    if (!strcmp(tag, "medium") && !param_name_equal(object->type, "homogeneous"))
        run_warn(loader->run, "%s:%d:%d: medium '%s' is not supported; it is ignored unless a shape refers to it",
                 object->place.file, object->place.line, object->place.column, object->type);
    // Media, films, samplers and filters stand here to be referred to.
    if (!strcmp(tag, "medium") || !strcmp(tag, "film") || !strcmp(tag, "sampler") || !strcmp(tag, "rfilter"))
        return STATUS_OK;
    return error_at(loader->error, child->place, "<%s> is not supported", tag);
}

enum status load_children(struct loader *loader, struct object *root) {
    enum status status = params_check_properties(root, NULL, 0, loader->error);
    for (size_t i = 0; i < root->child_count && !status; i++) status = load_child(loader, &root->children[i]);
    return status;
}

// Of a definition that neither the scene nor a lamp in it uses.
static void warn_unused_definitions(const struct scene *scene, const struct scene_options *options,
                                    const struct run *run) {
    for (size_t i = 0; i < options->definition_count; i++) {
        const struct definition *definition = &options->definitions[i];
        bool used = scene->description.definition_used[i];
        for (const struct lamp_description *lamp = scene->lamps; lamp && !used; lamp = lamp->next)
            used = lamp->description.definition_used[i];
        if (!used)
            run_warn(run, "%s: -D %s=%s is used nowhere in the scene", scene->path, definition->name,
                     definition->value);
    }
}

enum status scene_load(struct scene *scene, const char *path, const struct scene_options *options,
                       const struct run *run, struct error *error) {
    static const struct scene_options no_options = {0};
    struct error unwanted = {0};
    const struct run silent = {.threads = options && options->threads > 0 ? options->threads : 1};
    if (!error) error = &unwanted;
    if (!run) run = &silent;
    if (!options) options = &no_options;
    *scene = (struct scene){0};
    struct loader loader = {.scene = scene, .options = options, .run = run, .error = error};
    loader.maker = (struct texture_maker){load_texture, &loader};
    loader.placement = (struct placement){.to_world = transform_identity(), .dim = rgb_gray(1), .luminaire = -1};
    scene->share_light = options->share_light;
    scene->unbiased = options->unbiased;
    if (!(scene->path = arena_strdup(&scene->arena, path))) return load_out_of_memory(&loader);
    enum status status =
        description_load(&scene->description, path, options->definitions, options->definition_count, run, error);
    if (!status) status = load_default_integrator(&loader);
    if (!status) status = load_children(&loader, scene->description.root);
    if (!status) warn_unused_definitions(scene, options, run);
    if (!status && !scene->shape_count && !scene->luminaire_count) run_warn(run, "%s: the scene holds no shapes", path);
    struct commit_context context = {&scene->arena, run, scene->description.root, options->skip_missing};
    if (!status) status = scene_commit(scene, &context, error);
    if (status) scene_fini(scene);
    return status;
}

void scene_fini(struct scene *scene) {
    embree_scene_destroy(scene->embree);
    for (size_t i = 0; i < scene->luminaire_count; i++) {
        const struct luminaire_instance *instance = &scene->luminaires[i];
        if (instance->luminaire != instance->file)
            luminaire_destroy((struct luminaire *)(uintptr_t)instance->luminaire);
    }
    for (size_t i = 0; i < scene->luminaire_count; i++) { // instances share files
        size_t first = 0;
        while (scene->luminaires[first].file != scene->luminaires[i].file) first++;
        if (first == i) luminaire_destroy((struct luminaire *)(uintptr_t)scene->luminaires[i].file);
    }
    for (struct lamp_description *lamp = scene->lamps; lamp; lamp = lamp->next) description_fini(&lamp->description);
    description_fini(&scene->description);
    arena_fini(&scene->arena);
    *scene = (struct scene){0};
}
