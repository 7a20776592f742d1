// <shape type="shapegroup"> and <shape type="instance">: shapes that are described once and placed often; merge: shapes
// side by side. Each instance becomes shapes of its own, for baked lamps and their hulls know nothing else.
#include <string.h>

#include "scene/load_private.h"

struct instance_shape {
    struct transform to_world;
};

const struct param instance_params[] = {
    {"to_world", PARAM_TRANSFORM, offsetof(struct instance_shape, to_world), "", .help = "places the group's shapes"},
    PARAM_END,
};
const struct param shapegroup_params[] = {PARAM_END}, merge_params[] = {PARAM_END};

enum status load_members(struct loader *loader, struct object *group) {
    static const char *const tags[] = {"shape", "bsdf", "texture", "medium", NULL};
    enum status status = load_check_children(loader, group, tags);
    if (!status) status = params_check_properties(group, NULL, 0, loader->error);
    for (size_t i = 0; i < group->child_count && !status; i++)
        if (!strcmp(group->children[i].object->tag, "shape")) status = load_shape(loader, group->children[i].object);
    return status;
}

enum status load_instance(struct loader *loader, struct object *object) {
    const struct param *const table = instance_params;
    struct instance_shape instance = {.to_world = transform_identity()};
    struct commit_context context = load_context(loader, object);
    enum status status = params_read(&instance, instance_params, NULL, object, &context, NULL, loader->error);
    if (!status) status = params_check_used(object, &table, 1, loader->error);
    if (status) return status;
    struct object *group = object->child_count == 1 ? object->children[0].object : NULL;
    if (!group || strcmp(group->tag, "shape") || !param_name_equal(group->type, "shapegroup"))
        return error_at(loader->error, object->place,
                        "an instance holds one shapegroup: give the group an id, and the instance a <ref id=\"...\"/>");
    if (loader->placement.instance)
        return error_at(loader->error, object->place, "an instance cannot stand within a shapegroup");
    const struct placement outer = loader->placement;
    loader->placement.to_world = transform_multiply(&outer.to_world, &instance.to_world);
    loader->placement.instance = true;
    status = load_members(loader, group);
    loader->placement = outer;
    return status;
}
