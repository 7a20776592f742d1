#include "trace/mirror_link.h"

bool mirror_link_find(const struct mirror *mirror, const struct camera *camera, vec3 p, vec2 lens,
                      struct mirror_link *link) {
    const vec3 image = mirror_image(mirror, p);
    link->mirror = mirror;
    return camera_connect(camera, image, lens, &link->camera) &&
           mirror_way(mirror, p, link->camera.direction, &link->distance, &link->direction) &&
           link->distance < link->camera.reach &&
           mirror_spans(mirror, vec3_mad(link->camera.direction, link->distance, image));
}

rgb mirror_link_transmits(const struct mirror_link *link, const struct camera *camera, const struct scene *scene,
                          const struct surface *surface, struct sampler *sampler) {
    struct ray ray = surface_spawn_ray(surface, link->direction);
    struct surface met;
    if (!scene_intersect(scene, &ray, -1, &met) || mirror_at(&camera->mirrors, &met) != link->mirror)
        return rgb_gray(0);
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
