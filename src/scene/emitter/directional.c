// Parallel light from outside the scene, such as the sun's.
#include "scene/emitter/infinite.h"

struct directional_emitter {
    struct emitter base;
    struct transform to_world;
    vec3 direction; // in which the light travels; parameter, then in the world
    rgb irradiance;
};

static const struct param directional_params[] = {{.name = "irradiance",
                                                   .type = PARAM_RGB,
                                                   .offset = offsetof(struct directional_emitter, irradiance),
                                                   .fallback = "1 1 1",
                                                   .min = 0,
                                                   .max = 1e30,
                                                   .unit = "W m^-2",
                                                   .help = "on a surface that faces the light"},
                                                  {.name = "direction",
                                                   .type = PARAM_VEC3,
                                                   .offset = offsetof(struct directional_emitter, direction),
                                                   .fallback = "0 0 1",
                                                   .help = "in which the light travels, before to_world"},
                                                  {.name = "to_world",
                                                   .type = PARAM_TRANSFORM,
                                                   .offset = offsetof(struct directional_emitter, to_world),
                                                   .fallback = "",
                                                   .help = "turns the direction"},
                                                  PARAM_END};

static enum status directional_commit(struct emitter *emitter, struct commit_context *context, struct error *error) {
    struct directional_emitter *self = (struct directional_emitter *)emitter;
    vec3 w = transform_vector(&self->to_world, self->direction);
    if (!(vec3_length(w) > 0))
        return error_at(error, context->object->place, "the direction of this light has no length; give it one");
    self->direction = vec3_normalize(w);
    return STATUS_OK;
}

static enum status directional_ready(struct emitter *emitter, struct commit_context *context, struct error *error) {
    (void)context, (void)error;
    const struct directional_emitter *self = (const struct directional_emitter *)emitter;
    emitter->power = rgb_scale(self->irradiance, 1 / bounds_disk_pdf(&emitter->bounds));
    return STATUS_OK;
}

static rgb directional_eval(const struct emitter *emitter, const struct surface *surface, vec3 w) {
    (void)emitter, (void)surface, (void)w;
    return rgb_gray(0);
}

static bool directional_sample_light(const struct emitter *emitter, vec3 p, vec2 u, struct light_sample *sample) {
    (void)p, (void)u;
    const struct directional_emitter *self = (const struct directional_emitter *)emitter;
    *sample = (struct light_sample){.direction = vec3_neg(self->direction),
                                    .distance = INFINITY,
                                    .radiance = self->irradiance,
                                    .pdf_sa = 1,
                                    .n = self->direction};
    return !rgb_is_black(sample->radiance);
}

static float directional_pdf_light(const struct emitter *emitter, vec3 p, const struct surface *surface,
                                   vec3 direction) {
    (void)emitter, (void)p, (void)surface, (void)direction;
    return 0;
}

static bool directional_sample_emission(const struct emitter *emitter, vec2 u_position, vec2 u_direction,
                                        struct emission_sample *sample) {
    (void)u_direction;
    const struct directional_emitter *self = (const struct directional_emitter *)emitter;
    *sample = (struct emission_sample){.ray = bounds_disk_ray(&emitter->bounds, self->direction, u_position),
                                       .n = self->direction,
                                       .radiance = self->irradiance,
                                       .cos_theta = 1,
                                       .pdf_position = bounds_disk_pdf(&emitter->bounds),
                                       .pdf_direction = 1};
    return !rgb_is_black(sample->radiance);
}

static void directional_pdf_emission(const struct emitter *emitter, const struct surface *surface, vec3 direction,
                                     float *pdf_position, float *pdf_direction) {
    (void)surface, (void)direction;
    *pdf_position = bounds_disk_pdf(&emitter->bounds);
    *pdf_direction = 1;
}

const struct emitter_type emitter_directional = {
    .name = "directional",
    .help = "parallel light from outside the scene",
    .params = directional_params,
    .size = sizeof(struct directional_emitter),
    .flags = EMITTER_INFINITE | EMITTER_DELTA_DIRECTION,
    .commit = directional_commit,
    .ready = directional_ready,
    .eval = directional_eval,
    .sample_light = directional_sample_light,
    .pdf_light = directional_pdf_light,
    .sample_emission = directional_sample_emission,
    .pdf_emission = directional_pdf_emission,
};
