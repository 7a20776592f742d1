#include "trace/hull_look.h"

enum { MAX_PASSES = 64 };

bool hull_look(const struct scene *scene, const struct ray *ray, int luminaire, enum hull_kind *kind) {
    struct ray rest = *ray;
    struct surface surface;
    while (scene_intersect_hulls(scene, &rest, -1, &surface)) {
        if (surface.shape->luminaire == luminaire) {
            *kind = surface.shape->hull->kind;
            return true;
        }
        float t_max = rest.t_max - surface.t;
        rest = surface_spawn_ray(&surface, ray->direction);
        rest.t_max = t_max;
    }
    return false;
}

static struct ray from_camera(const struct ray *to_camera) {
    return (struct ray){vec3_mad(to_camera->direction, to_camera->t_max, to_camera->origin),
                        vec3_neg(to_camera->direction), 0, to_camera->t_max};
}

bool hulls_block(const struct scene *scene, const struct ray *to_camera) {
    struct ray look = from_camera(to_camera);
    enum hull_kind kind;
    for (size_t i = 0; scene->hull_count && i < scene->luminaire_count; i++)
        if (hull_look(scene, &look, (int)i, &kind) && kind != HULL_TRANSLUCENT) return true;
    return false;
}

bool hull_dims(const struct scene *scene, const struct ray *to_camera, int luminaire) {
    struct ray look = from_camera(to_camera);
    enum hull_kind kind;
    return hull_look(scene, &look, luminaire, &kind) && kind == HULL_TRANSLUCENT;
}

bool hull_trace(const struct scene *scene, const struct hull *hull, const struct ray *look, struct sampler *sampler,
                struct view_point *at) {
    struct ray ray = *look;
    for (int i = 0; i < MAX_PASSES; i++) {
        struct surface surface;
        struct bsdf_sample sample;
        vec3 wi = vec3_neg(ray.direction);
        if (!scene_intersect_hulls(scene, &ray, -1, &surface)) return false;
        if (surface.shape->hull->kind != HULL_GLASS) {
            at->part = (uint32_t)(surface.shape->hull - hull->parts);
            vec3_store(at->point, surface.p);
            vec3_store(at->normal, surface.shading.n);
            vec3_store(at->w, wi);
            return true;
        }
        vec2 u = sampler_2d(sampler);
        if (!surface_sample_bsdf(&surface, wi, (vec3){u.x, u.y, sampler_1d(sampler)}, TRANSPORT_RADIANCE, &sample))
            return false;
        ray = surface_spawn_ray(&surface, sample.wo);
    }
    return false;
}
