// The techniques that join a walk from the camera and a walk from a light into a path (Veach 1997, 10.2), with their
// weights from the sums in the vertices (Georgiev 2012, eqs. 44-52 without merging). What cannot contribute is found
// out before the densities are asked for, and those before a shadow ray is traced; faint connections are traced by
// chance with their value divided by it.
#include "trace/bdpt.h"

#include "trace/mirror_link.h"

static double cos_at(const struct surface *surface, vec3 w) { return fabsf(vec3_dot(surface->ng, w)); }

// True where the connection goes on; then *value is divided by the chance of it.
static bool connection_survives(const struct bdpt *bdpt, rgb *value, struct sampler *sampler) {
    float brightness = rgb_max(*value);
    if (!(brightness > 0)) return false;
    if (brightness >= bdpt->roulette_scale) return true;
    float survival = fmaxf(brightness / bdpt->roulette_scale, 0.05f);
    if (sampler_1d(sampler) >= survival) return false;
    *value = rgb_scale(*value, 1 / survival);
    return true;
}

rgb bdpt_connect_light(const struct bdpt *bdpt, const struct vertex *camera, struct sampler *sampler) {
    const struct surface *surface = &camera->surface;
    struct light_point point = {surface->p, -1, -1};
    struct light_choice choice;
    float u_choice = sampler_1d(sampler);
    vec2 u = sampler_2d(sampler);
    if (!light_select_sample(bdpt->lights, &point, u_choice, &choice)) return rgb_gray(0);
    const struct emitter *emitter = choice.emitter;
    struct light_sample light;
    if (!emitter->type->sample_light(emitter, surface->p, u, &light)) return rgb_gray(0);
    double pdf = (double)choice.pmf * light.pdf_sa;
    rgb value = rgb_mul(camera->beta, surface_eval_bsdf(surface, camera->wi, light.direction, TRANSPORT_RADIANCE));
    value = rgb_scale(rgb_mul(value, light.radiance), (float)(1 / pdf));
    if (!(rgb_max(value) > 0)) return rgb_gray(0);

    const struct surface *lit_from = emitter->shape ? &light.surface : NULL;
    bool delta = emitter->flags & (EMITTER_DELTA_POSITION | EMITTER_DELTA_DIRECTION);
    float pdf_position, pdf_direction;
    emitter->type->pdf_emission(emitter, lit_from, vec3_neg(light.direction), &pdf_position, &pdf_direction);
    double walked = light_source_pmf(&bdpt->source, emitter) * (double)pdf_position * pdf_direction *
                    cos_at(surface, light.direction);
    if (lit_from)
        walked /= pdf * cos_at(lit_from, light.direction);
    else if (emitter->flags & EMITTER_DELTA_POSITION)
        walked /= pdf * light.distance * light.distance;
    else
        walked /= pdf;
    double reverse = surface_pdf_bsdf(surface, light.direction, camera->wi, TRANSPORT_IMPORTANCE);
    double forward = delta ? 0 : surface_pdf_bsdf(surface, camera->wi, light.direction, TRANSPORT_RADIANCE);
    double others = mis(forward / pdf) + mis(walked) * (camera->d_vcm + camera->d_vc * mis(reverse));
    value = rgb_scale(value, (float)(1 / (1 + others)));
    if (!connection_survives(bdpt, &value, sampler)) return rgb_gray(0);

    struct ray ray;
    if (lit_from) {
        float distance;
        ray = surface_spawn_segment(surface, light.surface.p, &distance);
    } else {
        ray = surface_spawn_ray(surface, light.direction);
        if (!(emitter->flags & EMITTER_INFINITE)) ray.t_max = light.distance;
    }
    value = rgb_mul(value, scene_visibility(bdpt->scene, &ray, -1));
    return rgb_mul(value, segment_absorption(surface, lit_from, light.direction, light.distance));
}

rgb bdpt_connect_vertices(const struct bdpt *bdpt, const struct vertex *camera, const struct vertex *light,
                          struct sampler *sampler) {
    const struct surface *c = &camera->surface, *l = &light->surface;
    vec3 offset = vec3_sub(l->p, c->p);
    float distance2 = vec3_dot(offset, offset), distance = sqrtf(distance2);
    if (!(distance2 > 0)) return rgb_gray(0);
    vec3 w = vec3_scale(offset, 1 / distance), back = vec3_neg(w);
    rgb value = rgb_scale(rgb_mul(camera->beta, light->beta), 1 / distance2);
    value = rgb_mul(value, surface_eval_bsdf(c, camera->wi, w, TRANSPORT_RADIANCE));
    if (!(rgb_max(value) > 0)) return rgb_gray(0);
    value = rgb_mul(value, surface_eval_bsdf(l, light->wi, back, TRANSPORT_IMPORTANCE));
    if (!connection_survives(bdpt, &value, sampler)) return rgb_gray(0);

    double camera_forward = surface_pdf_bsdf(c, camera->wi, w, TRANSPORT_RADIANCE) * cos_at(l, w) / distance2;
    double camera_reverse = surface_pdf_bsdf(c, w, camera->wi, TRANSPORT_IMPORTANCE);
    double light_forward = surface_pdf_bsdf(l, light->wi, back, TRANSPORT_IMPORTANCE) * cos_at(c, w) / distance2;
    double light_reverse = surface_pdf_bsdf(l, back, light->wi, TRANSPORT_RADIANCE);
    double others = mis(camera_forward) * (light->d_vcm + light->d_vc * mis(light_reverse)) +
                    mis(light_forward) * (camera->d_vcm + camera->d_vc * mis(camera_reverse));
    value = rgb_scale(value, (float)(1 / (1 + others)));
    if (!connection_survives(bdpt, &value, sampler)) return rgb_gray(0);

    struct ray ray = surface_spawn_segment(c, l->p, &distance);
    value = rgb_mul(value, scene_visibility(bdpt->scene, &ray, -1));
    return rgb_mul(value, segment_absorption(c, l, w, distance));
}

rgb bdpt_hit_light(const struct bdpt *bdpt, const struct walk *walk, const struct vertex *camera) {
    const struct surface *surface = &camera->surface;
    const struct emitter *emitter = surface->shape->emitter;
    if (!emitter) return rgb_gray(0);
    rgb value = rgb_mul(camera->arrived, surface_emission(surface, camera->wi));
    if (!(rgb_max(value) > 0)) return rgb_gray(0);
    if (walk->depth == 0) return bdpt->scene->hide_emitters ? rgb_gray(0) : value; // no other technique
    if (walk->mirrored) return value; // nor here
    struct light_point point = {walk->vertex_p, -1, -1};
    vec3 direction = vec3_neg(camera->wi), offset = vec3_sub(surface->p, walk->vertex_p);
    double pdf = (double)light_select_pmf_emitter(bdpt->lights, &point, emitter) *
                 emitter->type->pdf_light(emitter, walk->vertex_p, surface, direction);
    double direct = pdf * cos_at(surface, direction) / vec3_dot(offset, offset);
    float pdf_position, pdf_direction;
    emitter->type->pdf_emission(emitter, surface, camera->wi, &pdf_position, &pdf_direction);
    double walked = light_source_pmf(&bdpt->source, emitter) * (double)pdf_position * pdf_direction;
    return rgb_scale(value, (float)(1 / (1 + mis(direct) * camera->d_vcm + mis(walked) * camera->d_vc)));
}

rgb bdpt_hit_environment(const struct bdpt *bdpt, const struct walk *walk) {
    const struct emitter *emitter = bdpt->scene->environment;
    if (!emitter) return rgb_gray(0);
    vec3 direction = walk->ray.direction, travels = vec3_neg(direction);
    rgb value = rgb_mul(walk->beta, emitter->type->eval(emitter, NULL, travels));
    if (!(rgb_max(value) > 0)) return rgb_gray(0);
    if (walk->depth == 0) return bdpt->scene->hide_emitters ? rgb_gray(0) : value;
    if (walk->mirrored) return value;
    struct light_point point = {walk->vertex_p, -1, -1};
    double direct = (double)light_select_pmf_emitter(bdpt->lights, &point, emitter) *
                    emitter->type->pdf_light(emitter, walk->vertex_p, NULL, direction);
    float pdf_position, pdf_direction;
    emitter->type->pdf_emission(emitter, NULL, travels, &pdf_position, &pdf_direction);
    double walked = light_source_pmf(&bdpt->source, emitter) * (double)pdf_position * pdf_direction;
    return rgb_scale(value, (float)(1 / (1 + mis(direct) * walk->d_vcm + mis(walked) * walk->d_vc)));
}

// What the light's vertex sends along the link, its weight included.
static rgb camera_value(const struct vertex *light, const struct camera_link *link, vec3 direction, bool weighted) {
    const struct surface *surface = &light->surface;
    rgb value = rgb_mul(light->beta, surface_eval_bsdf(surface, light->wi, direction, TRANSPORT_IMPORTANCE));
    value = rgb_scale(value, link->response);
    if (!weighted || !(rgb_max(value) > 0)) return value;
    double reverse = surface_pdf_bsdf(surface, direction, light->wi, TRANSPORT_RADIANCE);
    double traced = link->pdf * cos_at(surface, direction);
    return rgb_scale(value, (float)(1 / (1 + mis(traced) * (light->d_vcm + light->d_vc * mis(reverse)))));
}

static void connect_directly(const struct scene *scene, const struct camera *camera, const struct vertex *light,
                             bool weighted, struct sampler *sampler, struct splat_list *splats) {
    const struct surface *surface = &light->surface;
    struct camera_link link;
    if (!camera_connect(camera, surface->p, sampler_2d(sampler), &link)) return;
    rgb value = camera_value(light, &link, link.direction, weighted);
    if (!(rgb_max(value) > 0)) return;
    struct ray ray = surface_spawn_ray(surface, link.direction);
    ray.t_max = link.reach;
    value = rgb_mul(value, scene_visibility(scene, &ray, -1));
    splat_add(splats, camera->sensor, link.film,
              rgb_mul(value, segment_absorption(surface, NULL, link.direction, link.distance)));
}

static void connect_in_mirrors(const struct scene *scene, const struct camera *camera, const struct vertex *light,
                               bool weighted, struct sampler *sampler, struct splat_list *splats) {
    for (size_t i = 0; i < camera->mirrors.count; i++) {
        struct mirror_link link;
        if (!mirror_link_find(&camera->mirrors.mirrors[i], camera, light->surface.p, sampler_2d(sampler), &link))
            continue;
        rgb value = camera_value(light, &link.camera, link.direction, weighted);
        if (!(rgb_max(value) > 0)) continue;
        value = rgb_mul(value, mirror_link_transmits(&link, camera, scene, &light->surface, sampler));
        splat_add(splats, camera->sensor, link.camera.film, value);
    }
}

void bdpt_connect_camera(const struct scene *scene, const struct camera *camera, const struct vertex *light,
                         int max_depth, bool weighted, struct sampler *sampler, struct splat_list *splats) {
    connect_directly(scene, camera, light, weighted, sampler, splats);
    if (light->depth + 2 <= max_depth) connect_in_mirrors(scene, camera, light, weighted, sampler, splats);
}
