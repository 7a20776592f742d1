// The same radiance from all directions around the scene.
#include "scene/emitter/infinite.h"

struct constant_emitter {
    struct emitter base;
    rgb radiance;
};

static const struct param constant_params[] = {{.name = "radiance",
                                                .type = PARAM_RGB,
                                                .offset = offsetof(struct constant_emitter, radiance),
                                                .fallback = "1 1 1",
                                                .min = 0,
                                                .max = 1e30,
                                                .unit = "W m^-2 sr^-1",
                                                .help = "from every direction"},
                                               PARAM_END};

static enum status constant_ready(struct emitter *emitter, struct commit_context *context, struct error *error) {
    (void)context, (void)error;
    const struct constant_emitter *self = (const struct constant_emitter *)emitter;
    emitter->power = rgb_scale(self->radiance, 4 * PI_F / bounds_disk_pdf(&emitter->bounds));
    return STATUS_OK;
}

static rgb constant_eval(const struct emitter *emitter, const struct surface *surface, vec3 w) {
    (void)surface, (void)w;
    return ((const struct constant_emitter *)emitter)->radiance;
}

static bool constant_sample_light(const struct emitter *emitter, vec3 p, vec2 u, struct light_sample *sample) {
    (void)p;
    vec3 direction = warp_uniform_sphere(u);
    *sample = (struct light_sample){.direction = direction,
                                    .distance = INFINITY,
                                    .radiance = ((const struct constant_emitter *)emitter)->radiance,
                                    .pdf_sa = warp_uniform_sphere_pdf(),
                                    .n = vec3_neg(direction)};
    return !rgb_is_black(sample->radiance);
}

static float constant_pdf_light(const struct emitter *emitter, vec3 p, const struct surface *surface, vec3 direction) {
    (void)emitter, (void)p, (void)surface, (void)direction;
    return warp_uniform_sphere_pdf();
}

static bool constant_sample_emission(const struct emitter *emitter, vec2 u_position, vec2 u_direction,
                                     struct emission_sample *sample) {
    vec3 w = warp_uniform_sphere(u_direction);
    *sample = (struct emission_sample){.ray = bounds_disk_ray(&emitter->bounds, w, u_position),
                                       .n = w,
                                       .radiance = ((const struct constant_emitter *)emitter)->radiance,
                                       .cos_theta = 1,
                                       .pdf_position = bounds_disk_pdf(&emitter->bounds),
                                       .pdf_direction = warp_uniform_sphere_pdf()};
    return !rgb_is_black(sample->radiance);
}

static void constant_pdf_emission(const struct emitter *emitter, const struct surface *surface, vec3 direction,
                                  float *pdf_position, float *pdf_direction) {
    (void)surface, (void)direction;
    *pdf_position = bounds_disk_pdf(&emitter->bounds);
    *pdf_direction = warp_uniform_sphere_pdf();
}

const struct emitter_type emitter_constant = {
    .name = "constant",
    .help = "the same radiance from everywhere around the scene",
    .params = constant_params,
    .size = sizeof(struct constant_emitter),
    .flags = EMITTER_INFINITE,
    .ready = constant_ready,
    .eval = constant_eval,
    .sample_light = constant_sample_light,
    .pdf_light = constant_pdf_light,
    .sample_emission = constant_sample_emission,
    .pdf_emission = constant_pdf_emission,
};
