// What the files of the scene loader share. load.c walks the scene; load_plugin.c makes textures and BSDFs;
// load_shape.c shapes with their emitters and media; load_instance.c groups of them; load_luminaire.c lamps,
// load_groups.c the groups of their emitters, load_hull.c their hulls; load_settings.c camera and integrator.
#pragma once

#include "scene/params.h"
#include "scene/scene.h"

enum { LAMP_MAX_DEPTH = 8 }; // of lamps within lamps

struct luminaire_file { // a baked file that several instances share
    struct luminaire_file *next;
    const char *path;
    struct luminaire *luminaire;
};

struct loader {
    struct scene *scene;
    const struct scene_options *options;
    const struct run *run;
    struct error *error;
    struct texture_maker maker;
    const struct bsdf *default_bsdf[2]; // of shapes without one: dark, shining
    struct luminaire_file *luminaire_files;
    // Where the file that is being read stands: the scene itself, or a lamp within it.
    struct placement {
        struct transform to_world;
        rgb dim; // multiplies the light of baked lamps
        int luminaire; // kept geometry of this instance, or -1
        bool opaque_only; // leave out what emits or transmits
        int depth; // 0: the scene
        bool instance; // of a shapegroup
    } placement;
};

extern const struct param shape_common_params[], luminaire_params[], instance_params[], shapegroup_params[],
    merge_params[], medium_params[], sensor_common_params[], film_params[], sampler_params[], rfilter_params[],
    integrator_params[];

enum status load_out_of_memory(const struct loader *loader);
// Memory of the scene, NULL with an error set.
void *load_alloc(const struct loader *loader, size_t size);
struct commit_context load_context(const struct loader *loader, const struct object *object);
// Appends to an array of pointers in the scene's arena.
enum status load_append(const struct loader *loader, void *array_of_pointers, size_t *count, void *item);
// An error for the first child whose tag is not in `tags` (NULL at the end).
enum status load_check_children(const struct loader *loader, const struct object *object, const char *const *tags);
enum status load_unknown_type(const struct loader *loader, const struct object *object);

enum status load_texture(void *loader, struct object *object, const struct texture **texture, struct error *error);
enum status load_bsdf(struct loader *loader, struct object *object, const struct bsdf **bsdf);
enum status load_shape(struct loader *loader, struct object *object);
enum status load_emitter(struct loader *loader, struct object *object, struct shape *shape,
                         const struct emitter **emitter);
enum status load_luminaire(struct loader *loader, struct object *object);
enum status load_instance(struct loader *loader, struct object *object);
enum status load_members(struct loader *loader, struct object *group); // the shapes of a shapegroup or merge
// The setting of a lamp's groups (luminaire/group_setting.h): of geometry, whose emitters begin at `first`; of a baked
// lamp, placed with this scale, as *dimmed with factors[LUMINAIRE_MAX_GROUPS]; of the emitters of a baked lamp's kept
// geometry.
enum status load_groups_geometry(struct loader *loader, const struct object *object, const char *text, size_t first);
enum status load_groups_baked(struct loader *loader, const struct object *object, const char *text,
                              const struct luminaire *luminaire, float scale, struct luminaire **dimmed,
                              float factors[LUMINAIRE_MAX_GROUPS][3]);
enum status load_groups_kept(struct loader *loader, const struct object *object, const struct luminaire *luminaire,
                             const float (*factors)[3], size_t first);
enum status load_hull(struct loader *loader, const struct luminaire_instance *instance, int index);
enum status load_lamp_scatter(struct loader *loader, struct luminaire_instance *instance, int index); // the sheet
enum status load_sensor(struct loader *loader, struct object *object);
enum status load_integrator(struct loader *loader, struct object *object);
enum status load_default_integrator(struct loader *loader);
// The children of a lamp's or scene's <scene>.
enum status load_children(struct loader *loader, struct object *root);
