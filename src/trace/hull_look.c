#include "trace/hull_look.h"

#include "trace/line_radiance.h"

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

struct hull_way {
    struct ray ray;
    float weight;
    int splits, passes;
};

// The way's next surface that is no glass. Where glass is split the reflected way joins the branches.
static bool hull_follow(const struct scene *scene, struct hull_way *way, struct sampler *sampler,
                        struct surface *surface, struct hull_way *branches, size_t *branch_count) {
    for (; way->passes < MAX_PASSES; way->passes++) {
        if (!scene_intersect_hulls(scene, &way->ray, -1, surface)) return false;
        if (surface->shape->hull->kind != HULL_GLASS) return true;
        const vec3 wi = vec3_neg(way->ray.direction);
        struct bsdf_sample sample, reflected;
        if (way->splits > 0 && surface_split(surface, wi, &reflected, &sample)) {
            way->splits--;
            branches[*branch_count] = *way;
            branches[*branch_count].weight *= reflected.pdf;
            branches[(*branch_count)++].ray = surface_spawn_ray(surface, reflected.wo);
            way->weight *= sample.pdf;
        } else {
            vec2 u = sampler_2d(sampler);
            if (!surface_sample_bsdf(surface, wi, (vec3){u.x, u.y, sampler_1d(sampler)}, TRANSPORT_RADIANCE, &sample))
                return false;
        }
        way->ray = surface_spawn_ray(surface, sample.wo);
    }
    return false;
}

// Glass neither tints nor, in the radiance that comes out of the lamp again, concentrates: weights are Fresnel's
// shares.
size_t hull_trace(const struct scene *scene, const struct hull *hull, const struct ray *ray, struct sampler *sampler,
                  int splits, struct hull_glimpse *seen) {
    struct hull_way ways[MAX_SPLITS + 1] = {{*ray, 1, splits, 0}};
    size_t count = 0, left = 1;
    while (left) {
        struct hull_way way = ways[--left];
        struct surface surface;
        if (!hull_follow(scene, &way, sampler, &surface, ways, &left)) continue;
        struct hull_glimpse *glimpse = &seen[count++];
        glimpse->weight = way.weight;
        glimpse->at.part = (uint32_t)(surface.shape->hull - hull->parts);
        vec3_store(glimpse->at.point, surface.p);
        vec3_store(glimpse->at.normal, surface.shading.n);
        vec3_store(glimpse->at.w, vec3_neg(way.ray.direction));
    }
    return count;
}
