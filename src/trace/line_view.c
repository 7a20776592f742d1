#include "trace/line_view.h"

enum { MAX_PASSES = 64 };

bool trace_line_view(const struct scene *scene, const bool *glass, const struct ray *ray, struct sampler *sampler,
                     struct line_view *view) {
    view->ray = *ray;
    view->weight = 1;
    for (int i = 0; i < MAX_PASSES; i++) {
        if (!scene_intersect(scene, &view->ray, -1, &view->surface)) return false;
        if (surface_is_hole(&view->surface, vec3_neg(view->ray.direction))) {
            view->ray = surface_spawn_ray(&view->surface, view->ray.direction);
            continue;
        }
        if (!glass[view->surface.shape->index]) return true;
        struct bsdf_sample sample;
        vec2 u = sampler_2d(sampler);
        if (!surface_sample_bsdf(&view->surface, vec3_neg(view->ray.direction), (vec3){u.x, u.y, sampler_1d(sampler)},
                                 TRANSPORT_RADIANCE, &sample))
            return false;
        view->weight *= rgb_mean(sample.weight);
        view->ray = surface_spawn_ray(&view->surface, sample.wo);
    }
    return false;
}
