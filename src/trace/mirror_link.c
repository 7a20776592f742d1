#include "trace/mirror_link.h"

void camera_mirrors_find(struct mirror_list *list, const struct scene *scene) {
    list->count = 0;
    if (scene->sensor->far_clip > 4 * scene->bounds.radius) mirrors_find(list, scene, MIRROR_COATED);
}

bool mirror_link_find(const struct mirror *mirror, const struct camera *camera, vec3 p, vec2 lens,
                      struct mirror_link *link) {
    const vec3 image = mirror_image(mirror, p);
    link->mirror = mirror;
    if (!camera_connect(camera, image, lens, &link->camera)) return false;
    const float away = vec3_dot(vec3_sub(mirror->p, image), mirror->n),
                along = vec3_dot(link->camera.direction, mirror->n);
    if (!(away * along > 0)) return false;
    link->distance = away / along;
    const vec3 met = vec3_mad(link->camera.direction, link->distance, image);
    if (!(link->distance < link->camera.reach) || !mirror_spans(mirror, met)) return false;
    link->direction = vec3_normalize(vec3_sub(met, p));
    return true;
}

rgb mirror_link_transmits(const struct mirror_link *link, const struct mirror_list *list, const struct scene *scene,
                          const struct surface *surface, struct sampler *sampler) {
    struct ray ray = surface_spawn_ray(surface, link->direction);
    struct surface met;
    if (!scene_intersect(scene, &ray, -1, &met) || mirror_at(list, &met) != link->mirror) return rgb_gray(0);
    const vec3 wi = vec3_neg(link->direction);
    const vec2 u = sampler_2d(sampler);
    struct bsdf_sample sample;
    if (!surface_sample_bsdf(&met, wi, (vec3){u.x, u.y, sampler_1d(sampler)}, TRANSPORT_IMPORTANCE, &sample) ||
        !mirror_reflects(&met, wi, &sample))
        return rgb_gray(0);
    rgb value = rgb_mul(sample.weight, segment_absorption(surface, &met, link->direction, met.t));
    ray = surface_spawn_ray(&met, link->camera.direction);
    ray.t_max = link->camera.reach - link->distance;
    value = rgb_mul(value, scene_visibility(scene, &ray, -1));
    return rgb_mul(value, segment_absorption(&met, NULL, ray.direction, link->camera.distance - link->distance));
}
