// The hull of a baked lamp with appearance=surface, as shapes of their own beside scene->shapes: only rays that look at
// the lamp meet them (scene_intersect_hulls). One shape a part; glass refracts like a dielectric of the same index,
// everything else is shaded by the integrator from the luminaire's view field.
#include <stdio.h>

#include "luminaire/hull.h"
#include "scene/load_private.h"
#include "scene/scene_embree.h"

static const struct bsdf view_bsdf; // of parts that the integrator shades: it scatters nothing
static const struct shape_type hull_shape = {.name = "hull"};

static enum status load_glass(struct loader *loader, const struct hull_part *part, const struct bsdf **bsdf) {
    struct object *object = load_alloc(loader, sizeof *object);
    struct property *properties = load_alloc(loader, 2 * sizeof *properties);
    char *eta = arena_printf(&loader->scene->arena, "%.9g", (double)part->eta);
    if (!object || !properties || !eta) return load_out_of_memory(loader);
    properties[0] = (struct property){.name = "int_ior", .type = PROPERTY_FLOAT, .string = eta};
    properties[1] = (struct property){.name = "ext_ior", .type = PROPERTY_FLOAT, .string = "1"};
    *object = (struct object){.tag = "bsdf",
                              .type = "dielectric",
                              .id = "",
                              .place = {loader->scene->path, 0, 0},
                              .properties = properties,
                              .property_count = 2};
    return load_bsdf(loader, object, bsdf);
}

static enum status load_part(struct loader *loader, const struct luminaire_instance *instance, int index,
                             const struct hull_part *part) {
    const struct hull *hull = luminaire_hull(instance->luminaire);
    size_t corners = 3 * (size_t)part->count, first = 3 * (size_t)part->first;
    struct shape *shape = load_alloc(loader, sizeof *shape);
    vec3 *positions = load_alloc(loader, corners * sizeof *positions);
    vec3 *turned = load_alloc(loader, corners * sizeof *turned);
    uint32_t *indices = load_alloc(loader, corners * sizeof *indices);
    if (!shape || !positions || !turned || !indices) return STATUS_MEMORY;
    for (size_t c = 0; c < corners; c++) {
        size_t from = first + c;
        positions[c] = transform_point(&instance->to_world, hull_vertex(hull, hull->triangles[from / 3][from % 3]));
        const vec3 normal = hull_normal(hull, hull->triangles[from / 3][from % 3]);
        turned[c] = vec3_normalize(transform_vector(&instance->to_world, normal));
        indices[c] = (uint32_t)c;
    }
    *shape = (struct shape){.type = &hull_shape,
                            .id = "",
                            .place = instance->place,
                            .bsdf = &view_bsdf,
                            .luminaire = index,
                            .index = (uint32_t)loader->scene->hull_count,
                            .hull = part,
                            .mesh = {.positions = positions,
                                     .normals = part->smooth ? turned : NULL,
                                     .indices = indices,
                                     .vertex_count = corners,
                                     .triangle_count = part->count}};
    if (part->kind == HULL_GLASS) {
        rgb sigma_a = rgb_make(part->sigma_a[0], part->sigma_a[1], part->sigma_a[2]);
        shape->has_interior = !rgb_is_black(sigma_a);
        shape->sigma_a = rgb_scale(sigma_a, 1 / instance->scale); // a lamp that is placed larger keeps its look
        enum status status = load_glass(loader, part, &shape->bsdf);
        if (status) return status;
    }
    return load_append(loader, &loader->scene->hulls, &loader->scene->hull_count, shape);
}

enum status load_hull(struct loader *loader, const struct luminaire_instance *instance, int index) {
    const struct hull *hull = luminaire_hull(instance->luminaire);
    enum status status = STATUS_OK;
    for (size_t i = 0; i < hull->part_count && !status; i++)
        status = load_part(loader, instance, index, &hull->parts[i]);
    return status;
}

enum status scene_init_hull(struct scene *scene, const struct luminaire *luminaire, int threads, struct error *error) {
    const struct run run = {.threads = threads};
    const struct scene_options options = {.threads = threads};
    *scene = (struct scene){.path = "hull"};
    struct loader loader = {.scene = scene, .options = &options, .run = &run, .error = error};
    loader.maker = (struct texture_maker){load_texture, &loader};
    struct luminaire_instance instance = {.luminaire = luminaire, .to_world = transform_identity(), .scale = 1};
    enum status status = load_hull(&loader, &instance, 0);
    if (!status) status = embree_scene_create(&scene->embree, scene, threads, error);
    if (status) scene_fini(scene);
    return status;
}
