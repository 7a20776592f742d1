// A camera of parallel rays: its film is the rectangle of half width 1 and half height height / width in camera
// coordinates, sized by the scale of to_world, as in Mitsuba 3. All rays have one direction: pdf_direction and
// cos_theta are 1 by convention, and the importance contains distance^2 (docs/conventions.md).
#include "scene/sensor/sensor_common.h"

struct orthographic_sensor {
    struct sensor base;
    float aspect; // height / width
    float area; // of the film in the world
};

static const struct param orthographic_params[] = {PARAM_END};

static vec3 camera_axis(const struct sensor *sensor) {
    return vec3_normalize(transform_vector(&sensor->to_world, vec3_make(0, 0, 1)));
}

static enum status orthographic_commit(struct sensor *sensor, struct commit_context *context, struct error *error) {
    struct orthographic_sensor *self = (struct orthographic_sensor *)sensor;
    self->aspect = (float)sensor->height / (float)sensor->width;
    vec3 x = transform_vector(&sensor->to_world, vec3_make(1, 0, 0));
    vec3 y = transform_vector(&sensor->to_world, vec3_make(0, 1, 0));
    vec3 z = camera_axis(sensor);
    float lx = vec3_length(x), ly = vec3_length(y);
    if (fabsf(vec3_dot(x, y)) > 1e-4f * lx * ly || fabsf(vec3_dot(x, z)) > 1e-4f * lx ||
        fabsf(vec3_dot(y, z)) > 1e-4f * ly)
        return error_at(error, context->object->place,
                        "to_world of this camera shears; use rotations, translations, lookat and scales before them");
    self->area = 4 * self->aspect * lx * ly;
    return STATUS_OK;
}

static void orthographic_sample_ray(const struct sensor *sensor, vec2 film, vec2 lens, struct ray *ray) {
    (void)lens;
    const struct orthographic_sensor *self = (const struct orthographic_sensor *)sensor;
    vec3 origin = {1 - 2 * film.x, (1 - 2 * film.y) * self->aspect, 0};
    *ray = (struct ray){transform_point(&sensor->to_world, origin), camera_axis(sensor), sensor->near_clip,
                        sensor->far_clip};
}

static bool orthographic_sample_connection(const struct sensor *sensor, vec3 p, vec2 lens,
                                           struct sensor_sample *sample) {
    (void)lens;
    const struct orthographic_sensor *self = (const struct orthographic_sensor *)sensor;
    struct transform camera_from_world = transform_inverse(&sensor->to_world);
    vec3 local = transform_point(&camera_from_world, p);
    sample->distance = local.z * vec3_length(transform_vector(&sensor->to_world, vec3_make(0, 0, 1)));
    if (!(sample->distance >= sensor->near_clip && sample->distance <= sensor->far_clip)) return false;
    sample->film = (vec2){0.5f - 0.5f * local.x, 0.5f - 0.5f * local.y / self->aspect};
    if (!(sample->film.x >= 0 && sample->film.x < 1 && sample->film.y >= 0 && sample->film.y < 1)) return false;
    sample->direction = vec3_neg(camera_axis(sensor));
    sample->p = vec3_mad(sample->direction, sample->distance, p);
    sample->cos_theta = sample->pdf_area = 1;
    sample->importance = sqrf(sample->distance) / self->area;
    return true;
}

static void orthographic_pdf_ray(const struct sensor *sensor, const struct ray *ray, float *pdf_position,
                                 float *pdf_direction) {
    (void)ray;
    *pdf_position = 1 / ((const struct orthographic_sensor *)sensor)->area;
    *pdf_direction = 1;
}

const struct sensor_type sensor_orthographic = {
    .name = "orthographic",
    .help = "a camera of parallel rays; to_world scales its width of 2",
    .params = orthographic_params,
    .size = sizeof(struct orthographic_sensor),
    .commit = orthographic_commit,
    .sample_ray = orthographic_sample_ray,
    .sample_connection = orthographic_sample_connection,
    .pdf_ray = orthographic_pdf_ray,
};
