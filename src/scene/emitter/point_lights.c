// Lights at a point: the same intensity everywhere (point), or within a cone about local +z (spot), which falls off
// linearly with the angle from beam_width to cutoff_angle as in Mitsuba 3.
#include "math/warp.h"
#include "scene/emitter.h"

struct point_emitter {
    struct emitter base;
    struct transform to_world;
    vec3 position; // parameter, then in the world
    rgb intensity;
    float cutoff_degrees, beam_degrees; // spot; beam 0: 3/4 of the cutoff
    float cutoff, beam, cos_cutoff; // radians; a point has a cutoff of pi
    struct frame axes; // n: the spot's axis
};

#define INTENSITY_PARAMS                                                                                               \
    {.name = "intensity",                                                                                              \
     .type = PARAM_RGB,                                                                                                \
     .offset = offsetof(struct point_emitter, intensity),                                                              \
     .fallback = "1 1 1",                                                                                              \
     .min = 0,                                                                                                         \
     .max = 1e30,                                                                                                      \
     .unit = "W sr^-1",                                                                                                \
     .help = "radiant intensity"},                                                                                     \
    {                                                                                                                  \
        .name = "to_world", .type = PARAM_TRANSFORM, .offset = offsetof(struct point_emitter, to_world),               \
        .fallback = "", .help = "placement in the world"                                                               \
    }

static const struct param point_params[] = {INTENSITY_PARAMS,
                                            {.name = "position",
                                             .type = PARAM_VEC3,
                                             .offset = offsetof(struct point_emitter, position),
                                             .fallback = "0 0 0",
                                             .unit = "length",
                                             .help = "where it stands, before to_world"},
                                            PARAM_END};

static const struct param spot_params[] = {INTENSITY_PARAMS,
                                           {.name = "cutoff_angle",
                                            .type = PARAM_FLOAT,
                                            .offset = offsetof(struct point_emitter, cutoff_degrees),
                                            .fallback = "20",
                                            .min = 0.01,
                                            .max = 180,
                                            .unit = "degrees",
                                            .help = "no light beyond this angle from the axis (local +z)"},
                                           {.name = "beam_width",
                                            .type = PARAM_FLOAT,
                                            .offset = offsetof(struct point_emitter, beam_degrees),
                                            .fallback = "",
                                            .min = 0,
                                            .max = 180,
                                            .unit = "degrees",
                                            .help = "full intensity up to this angle; default 3/4 of cutoff_angle"},
                                           PARAM_END};

static enum status point_commit(struct emitter *emitter, struct commit_context *context, struct error *error) {
    (void)context, (void)error;
    struct point_emitter *self = (struct point_emitter *)emitter;
    self->position = transform_point(&self->to_world, self->position);
    self->cutoff = self->beam = PI_F;
    self->cos_cutoff = -1;
    self->axes = frame_from_normal(vec3_make(0, 0, 1));
    return STATUS_OK;
}

static enum status spot_commit(struct emitter *emitter, struct commit_context *context, struct error *error) {
    struct point_emitter *self = (struct point_emitter *)emitter;
    if (self->beam_degrees == 0) self->beam_degrees = 0.75f * self->cutoff_degrees;
    if (self->beam_degrees > self->cutoff_degrees)
        return error_at(error, context->object->place, "beam_width %g exceeds cutoff_angle %g; make it smaller",
                        (double)self->beam_degrees, (double)self->cutoff_degrees);
    self->position = transform_point(&self->to_world, vec3_make(0, 0, 0));
    vec3 axis = transform_vector(&self->to_world, vec3_make(0, 0, 1));
    if (!(vec3_length(axis) > 0))
        return error_at(error, context->object->place, "to_world of this spot is singular; give it a direction");
    self->axes = frame_from_normal(vec3_normalize(axis));
    self->cutoff = self->cutoff_degrees * PI_F / 180;
    self->beam = self->beam_degrees * PI_F / 180;
    self->cos_cutoff = cosf(self->cutoff);
    return STATUS_OK;
}

// The cone's profile integrated over directions: 2 pi (1 - cos beam) + 2 pi int (cutoff - x) / (cutoff - beam) sin x
// dx.
static enum status point_ready(struct emitter *emitter, struct commit_context *context, struct error *error) {
    (void)context, (void)error;
    const struct point_emitter *self = (const struct point_emitter *)emitter;
    double c = (double)self->cutoff, b = (double)self->beam, width = c - b;
    double ramp = width > 0 ? cos(b) - (sin(c) - sin(b)) / width : 0;
    emitter->power = rgb_scale(self->intensity, (float)(2 * 3.14159265358979323846 * (1 - cos(b) + ramp)));
    return STATUS_OK;
}

static rgb point_intensity(const struct point_emitter *self, vec3 w) {
    float angle = acosf(clampf(vec3_dot(w, self->axes.n), -1, 1));
    if (angle <= self->beam) return self->intensity;
    return rgb_scale(self->intensity, angle < self->cutoff ? (self->cutoff - angle) / (self->cutoff - self->beam) : 0);
}

static rgb point_eval(const struct emitter *emitter, const struct surface *surface, vec3 w) {
    (void)emitter, (void)surface, (void)w;
    return rgb_gray(0);
}

static bool point_sample_light(const struct emitter *emitter, vec3 p, vec2 u, struct light_sample *sample) {
    (void)u;
    const struct point_emitter *self = (const struct point_emitter *)emitter;
    *sample = (struct light_sample){.pdf_sa = 1};
    vec3 way = vec3_sub(self->position, p);
    sample->distance = vec3_length(way);
    if (!(sample->distance > 0)) return false;
    sample->direction = vec3_scale(way, 1 / sample->distance);
    sample->n = vec3_neg(sample->direction);
    sample->radiance = rgb_scale(point_intensity(self, sample->n), 1 / sqrf(sample->distance));
    return !rgb_is_black(sample->radiance) && rgb_is_finite(sample->radiance);
}

static float point_pdf_light(const struct emitter *emitter, vec3 p, const struct surface *surface, vec3 direction) {
    (void)emitter, (void)p, (void)surface, (void)direction;
    return 0;
}

static void point_pdf_emission(const struct emitter *emitter, const struct surface *surface, vec3 direction,
                               float *pdf_position, float *pdf_direction) {
    (void)surface;
    const struct point_emitter *self = (const struct point_emitter *)emitter;
    *pdf_position = 1;
    *pdf_direction =
        vec3_dot(direction, self->axes.n) >= self->cos_cutoff ? warp_uniform_cone_pdf(self->cos_cutoff) : 0;
}

static bool point_sample_emission(const struct emitter *emitter, vec2 u_position, vec2 u_direction,
                                  struct emission_sample *sample) {
    (void)u_position;
    const struct point_emitter *self = (const struct point_emitter *)emitter;
    vec3 w = vec3_normalize(frame_world_from_local(&self->axes, warp_uniform_cone(u_direction, self->cos_cutoff)));
    *sample = (struct emission_sample){.ray = {self->position, w, 0, INFINITY},
                                       .n = w,
                                       .radiance = point_intensity(self, w),
                                       .cos_theta = 1,
                                       .pdf_position = 1,
                                       .pdf_direction = warp_uniform_cone_pdf(self->cos_cutoff)};
    return !rgb_is_black(sample->radiance);
}

const struct emitter_type emitter_point = {
    .name = "point",
    .help = "a point that shines equally in all directions",
    .params = point_params,
    .size = sizeof(struct point_emitter),
    .flags = EMITTER_DELTA_POSITION,
    .commit = point_commit,
    .ready = point_ready,
    .eval = point_eval,
    .sample_light = point_sample_light,
    .pdf_light = point_pdf_light,
    .sample_emission = point_sample_emission,
    .pdf_emission = point_pdf_emission,
};
const struct emitter_type emitter_spot = {
    .name = "spot",
    .help = "a point that shines within a cone about local +z",
    .params = spot_params,
    .size = sizeof(struct point_emitter),
    .flags = EMITTER_DELTA_POSITION,
    .commit = spot_commit,
    .ready = point_ready,
    .eval = point_eval,
    .sample_light = point_sample_light,
    .pdf_light = point_pdf_light,
    .sample_emission = point_sample_emission,
    .pdf_emission = point_pdf_emission,
};
