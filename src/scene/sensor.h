// Cameras. sensor_table lists every type.
#pragma once

#include "base/param.h"
#include "scene/commit.h"
#include "scene/shape.h"

struct sensor_sample { // of the camera seen from a point, for light tracing
    vec3 p; // on the lens
    vec3 direction; // unit, from the point to p
    float distance;
    vec2 film; // in [0,1]^2 of the full film, from the top left
    float importance; // W: the film's response per unit radiance along the ray, so that the pixel mean of (importance *
                      // radiance flux) over all the film is the image; see docs/conventions.md
    float pdf_area; // of p on the lens (1 for a pinhole)
    float cos_theta; // at the lens
};

struct sensor {
    const struct sensor_type *type;
    struct transform to_world;
    int width, height; // full film
    int crop_x, crop_y, crop_width, crop_height; // rendered part
    int filter; // index in film filter table: box, tent, gaussian
    float filter_radius, filter_stddev;
    float near_clip, far_clip;
    int sample_count; // of the file's sampler
};

struct sensor_type {
    const char *name, *help;
    const struct param *params;
    size_t size;
    enum status (*commit)(struct sensor *sensor, struct commit_context *context, struct error *error);
    // film in [0,1]^2 of the full film from the top left, lens in [0,1)^2. Returns the ray; its weight is 1 for all
    // types.
    void (*sample_ray)(const struct sensor *sensor, vec2 film, vec2 lens, struct ray *ray);
    bool (*sample_connection)(const struct sensor *sensor, vec3 p, vec2 lens,
                              struct sensor_sample *sample); // false: not seen
    // Densities of sample_ray at uniform film: of the position [1/area] and the direction [1/sr].
    void (*pdf_ray)(const struct sensor *sensor, const struct ray *ray, float *pdf_position, float *pdf_direction);
};
extern const struct sensor_type *const sensor_table[]; // ends with NULL
