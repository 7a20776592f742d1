// The last step of loading: bounds, emitters, Embree.
#include "scene/scene_commit.h"

#include "math/distribution.h"
#include "scene/distribution_arena.h"
#include "scene/scene_embree.h"

struct box {
    vec3 lower, upper;
};

static void box_add(struct box *box, vec3 p) {
    box->lower = (vec3){fminf(box->lower.x, p.x), fminf(box->lower.y, p.y), fminf(box->lower.z, p.z)};
    box->upper = (vec3){fmaxf(box->upper.x, p.x), fmaxf(box->upper.y, p.y), fmaxf(box->upper.z, p.z)};
}

static void box_add_shape(struct box *box, const struct shape *shape) {
    const struct mesh *mesh = &shape->mesh;
    if (mesh->triangle_count == 0) {
        vec3 lower, upper;
        shape->type->bounds(shape, &lower, &upper);
        box_add(box, lower);
        box_add(box, upper);
    }
    for (size_t i = 0; i < 3 * mesh->triangle_count; ++i) box_add(box, mesh->positions[mesh->indices[i]]);
}

static void box_add_luminaire(struct box *box, const struct luminaire_instance *instance) {
    float center[3], radius;
    luminaire_bounds(instance->luminaire, center, &radius);
    vec3 c = transform_point(&instance->to_world, vec3_make(center[0], center[1], center[2]));
    float r = radius * instance->scale;
    box_add(box, vec3_sub(c, vec3_make(r, r, r)));
    box_add(box, vec3_add(c, vec3_make(r, r, r)));
}

static struct scene_bounds scene_compute_bounds(const struct scene *scene) {
    struct box box = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
    for (size_t i = 0; i < scene->shape_count; ++i) box_add_shape(&box, scene->shapes[i]);
    for (size_t i = 0; i < scene->luminaire_count; ++i) box_add_luminaire(&box, &scene->luminaires[i]);
    if (scene->sensor) box_add(&box, transform_point(&scene->sensor->to_world, vec3_make(0, 0, 0)));
    if (!(box.lower.x <= box.upper.x)) return (struct scene_bounds){{0, 0, 0}, 1};
    vec3 center = vec3_scale(vec3_add(box.lower, box.upper), 0.5f);
    float radius = 0.5f * vec3_length(vec3_sub(box.upper, box.lower)) * 1.001f;
    return (struct scene_bounds){center, radius > 0 ? radius : 1};
}

// The distribution over a mesh's triangles by area, whose probabilities are exact multiples of area where the float
// sums allow it; shape->area stays the normalisation.
static enum status shape_build_triangles(struct shape *shape, struct commit_context *context, struct error *error) {
    const struct mesh *mesh = &shape->mesh;
    if (mesh->triangle_count == 0 || shape->triangles) return STATUS_OK;
    float *areas = arena_alloc(context->arena, mesh->triangle_count, sizeof *areas);
    shape->triangles = arena_alloc(context->arena, 1, sizeof *shape->triangles);
    if (!areas || !shape->triangles)
        return error_at(error, shape->place, "out of memory for the light of this %s", shape->type->name);
    for (size_t i = 0; i < mesh->triangle_count; ++i) {
        const uint32_t *v = mesh->indices + 3 * i;
        vec3 a = mesh->positions[v[0]];
        areas[i] =
            0.5f * vec3_length(vec3_cross(vec3_sub(mesh->positions[v[1]], a), vec3_sub(mesh->positions[v[2]], a)));
    }
    return distribution_init_arena(shape->triangles, areas, mesh->triangle_count, context->arena, error);
}

static enum status emitter_make_ready(struct scene *scene, size_t index, struct commit_context *context,
                                      struct error *error) {
    struct emitter *emitter = scene->emitters[index];
    emitter->index = (uint32_t)index;
    emitter->bounds = scene->bounds;
    bool environment = (emitter->flags & EMITTER_INFINITE) && !(emitter->flags & EMITTER_DELTA_DIRECTION);
    if (environment && !scene->environment) scene->environment = emitter;
    enum status status = STATUS_OK;
    if (emitter->shape) status = shape_build_triangles(scene->shapes[emitter->shape->index], context, error);
    if (status == STATUS_OK && emitter->type->ready) status = emitter->type->ready(emitter, context, error);
    if (status == STATUS_OK && rgb_is_black(emitter->power) && !rgb_is_black(emitter->factor)) {
        if (emitter->shape) {
            run_warn(context->run, "%s:%d:%d: the %s light of this shape emits nothing", emitter->shape->place.file,
                     emitter->shape->place.line, emitter->shape->place.column, emitter->type->name);
        } else {
            run_warn(context->run, "%s: a %s light emits nothing", scene->path ? scene->path : "scene",
                     emitter->type->name);
        }
    }
    return status;
}

enum status scene_commit(struct scene *scene, struct commit_context *context, struct error *error) {
    scene->bounds = scene_compute_bounds(scene);
    if (!isfinite(scene->bounds.radius))
        return error_set(error, STATUS_INVALID, "%s: the scene's extent is not finite; scale it down",
                         scene->path ? scene->path : "scene");
    for (size_t i = 0; i < scene->shape_count; ++i) scene->shapes[i]->index = (uint32_t)i;
    for (size_t i = 0; i < scene->luminaire_count; ++i) // beyond all shapes
        if (scene->luminaires[i].sheet) scene->luminaires[i].sheet->index = (uint32_t)scene->shape_count;
    enum status status = STATUS_OK;
    for (size_t i = 0; status == STATUS_OK && i < scene->emitter_count; ++i)
        status = emitter_make_ready(scene, i, context, error);
    if (status != STATUS_OK) return status;
    return embree_scene_create(&scene->embree, scene, context->run->threads, error);
}
