// <shape type="luminaire">: a lamp in a scene, either as the geometry of its XML or as its baked file, with as much of
// the geometry beside it as `keep` and `appearance` ask for.
#include <limits.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "base/file.h"
#include "scene/lamp_identity.h"
#include "scene/load_private.h"

struct luminaire_shape {
    const char *filename, *geometry, *groups;
    int keep, appearance;
    rgb dim;
    struct transform to_world;
};

const struct param luminaire_params[] = {
    {"filename", PARAM_STRING, offsetof(struct luminaire_shape, filename), NULL,
     .help = "the lamp's scene (.xml): its geometry; or its baked file (.safetensors)"},
    {"to_world", PARAM_TRANSFORM, offsetof(struct luminaire_shape, to_world), "",
     .help = "places the lamp; of a baked one only rotation, uniform scale and translation"},
    {"keep", PARAM_CHOICE, offsetof(struct luminaire_shape, keep), "none", .choices = "none|opaque|all",
     .help = "geometry that stays beside the baked light field"},
    {"appearance", PARAM_CHOICE, offsetof(struct luminaire_shape, appearance), "auto",
     .choices = "neural|surface|geometry|auto",
     .help = "what the camera sees: light field, hull in the baked file, lamp's geometry; auto: the hull if it can be"},
    {"dim", PARAM_RGB, offsetof(struct luminaire_shape, dim), "1", 0, 1e9, "1", .help = "multiplies the lamp's light"},
    {"groups", PARAM_STRING, offsetof(struct luminaire_shape, groups), "",
     .help = "groups of emitters, by factor, colours, colour temperature or flux: \"bulb=0.3; spot=800lm 2700K\""},
    {"geometry", PARAM_STRING, offsetof(struct luminaire_shape, geometry), "",
     .help = "the baked lamp's scene (.xml), for keep and appearance; default: where it was baked from"},
    PARAM_END,
};

static bool has_extension(const char *path, const char *extension) {
    size_t n = strlen(path), m = strlen(extension);
    return n > m && param_name_equal(path + n - m, extension);
}

// Reads a lamp's XML and adds its shapes under `placement`.
static enum status expand(struct loader *loader, const struct object *object, const char *path,
                          struct placement placement) {
    if (placement.depth > LAMP_MAX_DEPTH)
        return error_at(loader->error, object->place,
                        "lamps stand within each other more than %d deep: does '%s' hold itself?", (int)LAMP_MAX_DEPTH,
                        path);
    struct lamp_description *lamp = load_alloc(loader, sizeof *lamp);
    if (!lamp) return STATUS_MEMORY;
    const struct scene_options *options = loader->options;
    enum status status = description_load(&lamp->description, path, options->definitions, options->definition_count,
                                          loader->run, loader->error);
    if (status) return status;
    lamp->next = loader->scene->lamps;
    loader->scene->lamps = lamp;
    struct placement outer = loader->placement;
    loader->placement = placement;
    status = load_children(loader, lamp->description.root);
    loader->placement = outer;
    return status;
}

static enum status baked_file(struct loader *loader, struct place place, const char *path,
                              const struct luminaire **luminaire) {
    for (const struct luminaire_file *file = loader->luminaire_files; file; file = file->next) {
        if (strcmp(file->path, path)) continue;
        *luminaire = file->luminaire;
        return STATUS_OK;
    }
    struct luminaire_file *file = load_alloc(loader, sizeof *file);
    char *copy = arena_strdup(&loader->scene->arena, path);
    if (!file || !copy) return load_out_of_memory(loader);
    struct luminaire *loaded;
    enum status status = luminaire_load(&loaded, path, loader->error);
    if (status && access(path, F_OK))
        error_at(loader->error, place,
                 "the baked lamp '%s' is missing; make it with sconce bake, or name another or the lamp's XML "
                 "(-D lamp=... where the scene has that variable)",
                 path);
    if (status) return status;
    *file = (struct luminaire_file){loader->luminaire_files, copy, loaded};
    loader->luminaire_files = file;
    *luminaire = loaded;
    return STATUS_OK;
}

// The geometry must be what the lamp was baked from, for its light is corrected by it.
static enum status check_geometry(struct loader *loader, const struct object *object, const struct luminaire *luminaire,
                                  const char *baked, const char *geometry) {
    const char *expected = luminaire_metadata(luminaire, "bake.source_hash");
    struct scene_options options = *loader->options;
    options.lamp_only = true;
    options.unbiased = false;
    struct run silent = {.threads = loader->run->threads, .seed = loader->run->seed};
    struct scene lamp;
    struct error error = {0};
    uint64_t identity = 0;
    enum status status = scene_load(&lamp, geometry, &options, &silent, &error);
    if (!status) {
        status = lamp_identity(&lamp, &identity, &error);
        scene_fini(&lamp);
    }
    if (status)
        return error_at(loader->error, object->place,
                        "an unbiased rendering needs the geometry that '%s' was baked from: %s; name the lamp's XML by "
                        "<string name=\"geometry\" value=\"...\"/>, or render without --unbiased",
                        baked, error.text);
    char found[24];
    snprintf(found, sizeof found, "%016llx", (unsigned long long)identity);
    if (!expected || !strcmp(found, expected)) return STATUS_OK;
    return error_at(loader->error, object->place,
                    "'%s' was baked from another lamp than '%s' is now; bake it again, or name what it was baked from "
                    "by <string name=\"geometry\" value=\"...\"/>",
                    baked, geometry);
}

static void dim_emitters(struct scene *scene, size_t first, rgb dim) {
    for (size_t i = first; i < scene->emitter_count; i++)
        scene->emitters[i]->factor = rgb_mul(scene->emitters[i]->factor, dim);
}

static enum appearance choose_appearance(const struct luminaire_shape *shape, const struct luminaire *luminaire,
                                         bool unbiased) {
    if (unbiased) return APPEARANCE_NEURAL;
    if (shape->appearance <= APPEARANCE_GEOMETRY) return (enum appearance)shape->appearance;
    return shape->keep == KEEP_NONE && luminaire_hull(luminaire) ? APPEARANCE_SURFACE : APPEARANCE_NEURAL;
}

static enum status load_baked(struct loader *loader, const struct object *object, const struct luminaire_shape *shape,
                              const char *path, struct placement placement) {
    struct scene *scene = loader->scene;
    float scale = transform_uniform_scale(&placement.to_world);
    if (!(scale > 0) || transform_flips_handedness(&placement.to_world))
        return error_at(
            loader->error, object->place,
            "to_world of a baked lamp may only rotate, scale evenly and translate; bake a lamp of the other form");
    // A plain array that grows by one: there are few lamps, and the last copy is the scene's.
    size_t count = scene->luminaire_count;
    struct luminaire_instance *instances = arena_alloc(&scene->arena, count + 1, sizeof *instances);
    if (!instances) return load_out_of_memory(loader);
    if (count) memcpy(instances, scene->luminaires, count * sizeof *instances);
    const struct luminaire *luminaire = NULL;
    enum status status = baked_file(loader, object->place, path, &luminaire);
    if (status) return status;
    bool unbiased = loader->options->unbiased;
    enum keep_geometry keep = unbiased ? KEEP_ALL : (enum keep_geometry)shape->keep;
    enum appearance appearance = choose_appearance(shape, luminaire, unbiased);
    instances[count] = (struct luminaire_instance){.luminaire = luminaire,
                                                   .file = luminaire,
                                                   .to_world = placement.to_world,
                                                   .scale = scale,
                                                   .keep = keep,
                                                   .appearance = appearance,
                                                   .dim = placement.dim,
                                                   .place = object->place};
    scene->luminaires = instances;
    scene->luminaire_count = count + 1;
    if (keep == KEEP_NONE && (status = load_lamp_scatter(loader, &instances[count], (int)count))) return status;
    float factors[LUMINAIRE_MAX_GROUPS][3];
    if (shape->groups) {
        struct luminaire *dimmed;
        status = load_groups_baked(loader, object, shape->groups, luminaire, scale, &dimmed, factors);
        if (status) return status;
        instances[count].luminaire = dimmed;
    }
    if (appearance == APPEARANCE_SURFACE) {
        if (shape->keep != KEEP_NONE)
            return error_at(loader->error, object->place,
                            "appearance surface goes with keep none; kept geometry is seen with appearance geometry");
        if (!luminaire_hull(luminaire))
            return error_at(loader->error, object->place,
                            "'%s' was baked without a hull; bake it with --view hull, or use another appearance", path);
        return load_hull(loader, &instances[count], (int)count);
    }
    if (keep == KEEP_NONE && appearance == APPEARANCE_NEURAL) return STATUS_OK;

    const char *source = luminaire_metadata(luminaire, "bake.source");
    char geometry[PATH_MAX];
    if (shape->geometry)
        path_resolve(geometry, sizeof geometry, object->place.file, shape->geometry);
    else if (source)
        path_resolve(geometry, sizeof geometry, path, source);
    else
        return error_at(loader->error, object->place,
                        "'%s' does not say where it was baked from; "
                        "name the lamp's XML by <string name=\"geometry\" value=\"...\"/>",
                        path);
    placement.luminaire = (int)count;
    placement.opaque_only = keep != KEEP_ALL && appearance == APPEARANCE_NEURAL;
    if (unbiased && (status = check_geometry(loader, object, luminaire, path, geometry))) return status;
    const size_t first = scene->emitter_count;
    status = expand(loader, object, geometry, placement);
    if (!status && shape->groups)
        status = load_groups_kept(loader, object, luminaire, (const float(*)[3])factors, first);
    if (!status) dim_emitters(scene, first, placement.dim);
    return status;
}

enum status load_luminaire(struct loader *loader, struct object *object) {
    static const char *const tags[] = {NULL};
    const struct param *const table = luminaire_params;
    struct luminaire_shape shape = {0};
    struct commit_context context = load_context(loader, object);
    enum status status = load_check_children(loader, object, tags);
    if (!status) status = params_read(&shape, luminaire_params, NULL, object, &context, NULL, loader->error);
    if (!status) status = params_check_used(object, &table, 1, loader->error);
    if (status) return status;
    struct placement placement = loader->placement;
    placement.to_world = transform_multiply(&placement.to_world, &shape.to_world);
    placement.dim = rgb_mul(placement.dim, shape.dim);
    placement.depth++;
    placement.instance = false; // the lamp may have instances of its own
    char path[PATH_MAX];
    path_resolve(path, sizeof path, object->place.file, shape.filename);
    if (has_extension(path, ".xml")) {
        const size_t first = loader->scene->emitter_count;
        status = expand(loader, object, path, placement);
        if (!status && shape.groups) status = load_groups_geometry(loader, object, shape.groups, first);
        if (!status) dim_emitters(loader->scene, first, shape.dim);
        return status;
    }
    if (!has_extension(path, ".safetensors"))
        return error_at(loader->error, object->place,
                        "filename '%s' is neither a lamp's scene (.xml) nor a baked lamp (.safetensors)",
                        shape.filename);
    if (loader->placement.luminaire >= 0) { // its light is in the outer lamp's field
        run_note(loader->run, "%s:%d:%d: a baked lamp inside kept geometry is left aside", object->place.file,
                 object->place.line, object->place.column);
        return STATUS_OK;
    }
    return load_baked(loader, object, &shape, path, placement);
}
