// Where the walks of subpath.h begin: emission from a light, rays from the camera.
#include <stdlib.h>

#include "trace/subpath.h"

enum status light_source_init(struct light_source *source, const struct scene *scene, const struct light_select *lights,
                              struct error *error) {
    *source = (struct light_source){.scene = scene, .lights = lights};
    if (!scene->emitter_count) return STATUS_OK;
    float *weights = malloc(scene->emitter_count * sizeof *weights);
    if (!weights)
        return error_set(error, STATUS_MEMORY, "out of memory for the choice among %zu lights", scene->emitter_count);
    for (size_t i = 0; i < scene->emitter_count; i++) weights[i] = fmaxf(rgb_mean(scene->emitters[i]->power), 0);
    enum status status = distribution_init(&source->by_power, weights, scene->emitter_count, error);
    free(weights);
    return status;
}

void light_source_fini(struct light_source *source) { distribution_fini(&source->by_power); }

float light_source_pmf(const struct light_source *source, const struct emitter *emitter) {
    return distribution_pmf(&source->by_power, emitter->index);
}

bool light_source_emit(const struct light_source *source, struct sampler *sampler, struct walk *walk,
                       struct emission_sample *emission) {
    if (!source->by_power.n) return false;
    size_t index = distribution_sample(&source->by_power, sampler_1d(sampler), NULL);
    const struct emitter *emitter = source->scene->emitters[index];
    vec2 u_position = sampler_2d(sampler), u_direction = sampler_2d(sampler);
    if (!emitter->type->sample_emission(emitter, u_position, u_direction, emission)) return false;
    float pmf = distribution_pmf(&source->by_power, index), pdf = emission->pdf_position * emission->pdf_direction;
    rgb beta = rgb_scale(emission->radiance, emission->cos_theta / (pdf * pmf));
    float start = rgb_max(beta);
    if (!(start > 0) || !isfinite(start)) return false;
    bool delta = emitter->flags & (EMITTER_DELTA_POSITION | EMITTER_DELTA_DIRECTION);
    *walk = (struct walk){
        .scene = source->scene,
        .transport = TRANSPORT_IMPORTANCE,
        .ray = emission->ray,
        .beta = beta,
        .start = start,
        .eta2 = 1,
        .d_vc = delta ? 0 : mis((double)emission->cos_theta / ((double)pdf * pmf)),
        .emission = emission,
        .emitter = emitter,
        .lights = source->lights,
        .emission_pmf = pmf,
    };
    if (emitter->shape) {
        walk->has_from = true;
        walk->from = emission->surface;
    }
    return true;
}

void camera_init(struct camera *camera, const struct scene *scene) {
    const struct sensor *sensor = scene->sensor;
    *camera = (struct camera){.sensor = sensor};
    camera->crop_share =
        (float)sensor->crop_width * (float)sensor->crop_height / ((float)sensor->width * (float)sensor->height);
    struct ray a, b; // the sensor's table does not say which of its densities is a delta's; two rays do
    sensor->type->sample_ray(sensor, (vec2){0.25f, 0.5f}, (vec2){0.5f, 0.5f}, &a);
    sensor->type->sample_ray(sensor, (vec2){0.75f, 0.5f}, (vec2){0.5f, 0.5f}, &b);
    camera->parallel =
        vec3_length(vec3_sub(a.direction, b.direction)) < 1e-4f && vec3_length(vec3_sub(a.origin, b.origin)) > 0;
    if (sensor->far_clip > 4 * scene->bounds.radius) mirrors_find(&camera->mirrors, scene, MIRROR_COATED);
}

void camera_walk(const struct camera *camera, const struct scene *scene, vec2 film, vec2 lens, struct walk *walk) {
    *walk = (struct walk){.scene = scene,
                          .mirrors = &camera->mirrors,
                          .transport = TRANSPORT_RADIANCE,
                          .beta = {1, 1, 1},
                          .start = 1,
                          .eta2 = 1,
                          .distant = camera->parallel};
    camera->sensor->type->sample_ray(camera->sensor, film, lens, &walk->ray);
    float pdf_position, pdf_direction;
    camera->sensor->type->pdf_ray(camera->sensor, &walk->ray, &pdf_position, &pdf_direction);
    float pdf = (camera->parallel ? pdf_position : pdf_direction) / camera->crop_share;
    walk->d_vcm = pdf > 0 ? mis(1 / (double)pdf) : 0; // outside the film nothing connects to the camera
}

bool camera_connect(const struct camera *camera, vec3 p, vec2 lens, struct camera_link *link) {
    struct sensor_sample sample;
    if (!camera->sensor->type->sample_connection(camera->sensor, p, lens, &sample)) return false;
    *link = (struct camera_link){.direction = sample.direction,
                                 .distance = sample.distance,
                                 .reach = sample.distance - camera->sensor->near_clip / sample.cos_theta,
                                 .film = sample.film};
    link->response = sample.importance * sample.cos_theta / (sqrf(sample.distance) * sample.pdf_area);
    link->pdf = link->response / camera->crop_share;
    return link->response > 0;
}
