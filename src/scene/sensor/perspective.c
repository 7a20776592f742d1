// Pinhole and thin-lens cameras. The camera looks along its +z, +y is up on the film and +x is to the left, as in
// Mitsuba 3. The thin lens: Kolb et al. 1995, section 2; importance: Veach 1997, section 8.3.2.
#include <stdlib.h>
#include <string.h>

#include "math/warp.h"
#include "scene/sensor/sensor_common.h"

enum fov_axis { FOV_X, FOV_Y, FOV_DIAGONAL, FOV_SMALLER, FOV_LARGER };

static const struct param perspective_params[] = {PERSPECTIVE_PARAMS, PARAM_END};
static const struct param thinlens_params[] = {PERSPECTIVE_PARAMS,
                                               {.name = "aperture_radius",
                                                .type = PARAM_FLOAT,
                                                .offset = offsetof(struct perspective_sensor, aperture_radius),
                                                .min = 1e-9,
                                                .max = 1e9,
                                                .unit = "length",
                                                .help = "radius of the lens"},
                                               {.name = "focus_distance",
                                                .type = PARAM_FLOAT,
                                                .offset = offsetof(struct perspective_sensor, focus_distance),
                                                .min = 1e-9,
                                                .max = 1e30,
                                                .unit = "length",
                                                .help = "depth of the plane in focus"},
                                               PARAM_END};

enum status sensor_check_transform(const struct sensor *sensor, float *scale, struct commit_context *context,
                                   struct error *error) {
    struct transform proper = sensor->to_world, mirror = transform_scale(vec3_make(-1, 1, 1));
    if (transform_flips_handedness(&proper)) proper = transform_multiply(&proper, &mirror);
    *scale = transform_uniform_scale(&proper);
    if (!(*scale > 0))
        return error_at(error, context->object->place,
                        "to_world of this camera scales unevenly or shears; use rotations, translations or lookat");
    return STATUS_OK;
}

static enum status fov_from_focal_length(struct perspective_sensor *self, struct commit_context *context,
                                         struct error *error) {
    char *end;
    double f = strtod(self->focal_length, &end);
    if (end == self->focal_length || (*end && strcmp(end, "mm") != 0) || !(f > 0) || !isfinite(f))
        return error_at(error, context->object->place,
                        "focal_length '%s' is no length in millimetres; write for example 50mm", self->focal_length);
    self->fov_degrees = (float)(2 * atan(sqrt(36.0 * 36 + 24 * 24) / (2 * f)) * 180 / 3.14159265358979323846);
    self->fov_axis = FOV_DIAGONAL;
    return STATUS_OK;
}

static enum status perspective_commit(struct sensor *sensor, struct commit_context *context, struct error *error) {
    struct perspective_sensor *self = (struct perspective_sensor *)sensor;
    float scale;
    enum status status = sensor_check_transform(sensor, &scale, context, error);
    if (status == STATUS_OK && self->fov_degrees == 0) status = fov_from_focal_length(self, context, error);
    if (status != STATUS_OK) return status;
    struct transform unscale = transform_scale(vec3_make(1 / scale, 1 / scale, 1 / scale));
    self->world_from_camera = transform_multiply(&sensor->to_world, &unscale);
    double half = tan((double)self->fov_degrees * 3.14159265358979323846 / 360);
    double aspect = (double)sensor->width / (double)sensor->height, tan_x = half;
    bool along_y = self->fov_axis == FOV_Y || (self->fov_axis == FOV_SMALLER && aspect > 1) ||
                   (self->fov_axis == FOV_LARGER && aspect < 1);
    if (along_y) tan_x = half * aspect;
    if (self->fov_axis == FOV_DIAGONAL) tan_x = half * aspect / sqrt(1 + aspect * aspect);
    self->tan_x = (float)tan_x;
    self->tan_y = (float)(tan_x / aspect);
    return STATUS_OK;
}

static vec3 camera_direction(const struct perspective_sensor *self, vec2 film) { // not unit: z = 1
    return (vec3){(1 - 2 * (film.x + self->offset_x)) * self->tan_x, (1 - 2 * (film.y + self->offset_y)) * self->tan_y,
                  1};
}

static bool film_from_direction(const struct perspective_sensor *self, vec3 d, vec2 *film) {
    if (!(d.z > 0)) return false;
    *film = (vec2){0.5f - 0.5f * d.x / (d.z * self->tan_x) - self->offset_x,
                   0.5f - 0.5f * d.y / (d.z * self->tan_y) - self->offset_y};
    return film->x >= 0 && film->x < 1 && film->y >= 0 && film->y < 1;
}

static vec3 lens_point(const struct perspective_sensor *self, vec2 u) {
    if (self->aperture_radius == 0) return vec3_make(0, 0, 0);
    vec2 disk = warp_concentric_disk(u);
    return (vec3){disk.x * self->aperture_radius, disk.y * self->aperture_radius, 0};
}

static float lens_pdf(const struct perspective_sensor *self) {
    return self->aperture_radius == 0 ? 1 : 1 / (PI_F * sqrf(self->aperture_radius));
}

// The direction through the lens centre that meets d, from `lens`, in the plane in focus.
static vec3 central_direction(const struct perspective_sensor *self, vec3 lens, vec3 d) {
    if (self->aperture_radius == 0 || !(d.z > 0)) return d;
    return vec3_mad(d, self->focus_distance / d.z, lens);
}

static void perspective_sample_ray(const struct sensor *sensor, vec2 film, vec2 u, struct ray *ray) {
    const struct perspective_sensor *self = (const struct perspective_sensor *)sensor;
    vec3 d = camera_direction(self, film), lens = lens_point(self, u);
    if (self->aperture_radius > 0) d = vec3_sub(vec3_scale(d, self->focus_distance), lens);
    d = vec3_normalize(d);
    vec3 world = vec3_normalize(transform_vector(&self->world_from_camera, d));
    *ray = (struct ray){transform_point(&self->world_from_camera, lens), world, sensor->near_clip / d.z,
                        sensor->far_clip / d.z};
}

// Uniform film: a density over the plane z = 1 of 1 / (4 tan_x tan_y), seen under cos^3.
static float direction_pdf(const struct perspective_sensor *self, float cosine) {
    return 1 / (4 * self->tan_x * self->tan_y * cosine * cosine * cosine);
}

static bool perspective_sample_connection(const struct sensor *sensor, vec3 p, vec2 u, struct sensor_sample *sample) {
    const struct perspective_sensor *self = (const struct perspective_sensor *)sensor;
    vec3 lens = lens_point(self, u);
    sample->p = transform_point(&self->world_from_camera, lens);
    vec3 way = vec3_sub(sample->p, p);
    sample->distance = vec3_length(way);
    if (!(sample->distance > 0)) return false;
    sample->direction = vec3_scale(way, 1 / sample->distance);
    struct transform camera_from_world = transform_inverse(&self->world_from_camera);
    vec3 d = transform_vector(&camera_from_world, vec3_neg(sample->direction));
    float depth = d.z * sample->distance;
    if (!(depth >= sensor->near_clip && depth <= sensor->far_clip)) return false;
    if (!film_from_direction(self, central_direction(self, lens, d), &sample->film)) return false;
    sample->cos_theta = d.z;
    sample->pdf_area = lens_pdf(self);
    sample->importance = direction_pdf(self, d.z) * sample->pdf_area / d.z;
    return true;
}

static void perspective_pdf_ray(const struct sensor *sensor, const struct ray *ray, float *pdf_position,
                                float *pdf_direction) {
    const struct perspective_sensor *self = (const struct perspective_sensor *)sensor;
    struct transform camera_from_world = transform_inverse(&self->world_from_camera);
    vec3 d = transform_vector(&camera_from_world, ray->direction),
         lens = transform_point(&camera_from_world, ray->origin);
    vec2 film;
    *pdf_position = lens_pdf(self);
    *pdf_direction = film_from_direction(self, central_direction(self, lens, d), &film) ? direction_pdf(self, d.z) : 0;
}

const struct sensor_type sensor_perspective = {
    .name = "perspective",
    .help = "a pinhole camera",
    .params = perspective_params,
    .size = sizeof(struct perspective_sensor),
    .commit = perspective_commit,
    .sample_ray = perspective_sample_ray,
    .sample_connection = perspective_sample_connection,
    .pdf_ray = perspective_pdf_ray,
};
const struct sensor_type sensor_thinlens = {
    .name = "thinlens",
    .help = "a camera with depth of field",
    .params = thinlens_params,
    .size = sizeof(struct perspective_sensor),
    .commit = perspective_commit,
    .sample_ray = perspective_sample_ray,
    .sample_connection = perspective_sample_connection,
    .pdf_ray = perspective_pdf_ray,
};
