// What the cameras share. Film coordinates and the importance are defined in docs/conventions.md.
#pragma once

#include "scene/sensor.h"

struct perspective_sensor {
    struct sensor base;
    float fov_degrees; // 0: by focal_length
    int fov_axis;
    const char *focal_length;
    float offset_x, offset_y; // of the principal point, in parts of the film
    float aperture_radius, focus_distance; // thin lens; 0: pinhole
    float tan_x, tan_y; // half the film's extent at distance 1
    struct transform world_from_camera; // to_world without its scale
};

#define PERSPECTIVE_PARAMS                                                                                             \
    {.name = "fov",                                                                                                    \
     .type = PARAM_FLOAT,                                                                                              \
     .offset = offsetof(struct perspective_sensor, fov_degrees),                                                       \
     .fallback = "",                                                                                                   \
     .min = 0.001,                                                                                                     \
     .max = 179.99,                                                                                                    \
     .unit = "degrees",                                                                                                \
     .help = "field of view along fov_axis; default: by focal_length"},                                                \
        {.name = "fov_axis",                                                                                           \
         .type = PARAM_CHOICE,                                                                                         \
         .offset = offsetof(struct perspective_sensor, fov_axis),                                                      \
         .fallback = "x",                                                                                              \
         .choices = "x|y|diagonal|smaller|larger",                                                                     \
         .help = "which extent of the film fov spans"},                                                                \
        {.name = "focal_length",                                                                                       \
         .type = PARAM_STRING,                                                                                         \
         .offset = offsetof(struct perspective_sensor, focal_length),                                                  \
         .fallback = "50mm",                                                                                           \
         .unit = "mm",                                                                                                 \
         .help = "of a 36 x 24 mm film with the same diagonal angle, instead of fov"},                                 \
        {.name = "principal_point_offset_x",                                                                           \
         .type = PARAM_FLOAT,                                                                                          \
         .offset = offsetof(struct perspective_sensor, offset_x),                                                      \
         .fallback = "0",                                                                                              \
         .min = -100,                                                                                                  \
         .max = 100,                                                                                                   \
         .help = "shift of the image, in parts of its width"},                                                         \
    {                                                                                                                  \
        .name = "principal_point_offset_y", .type = PARAM_FLOAT,                                                       \
        .offset = offsetof(struct perspective_sensor, offset_y), .fallback = "0", .min = -100, .max = 100,             \
        .help = "shift of the image, in parts of its height"                                                           \
    }

// The scale of to_world, which must be a rotation or reflection with uniform scale; an error otherwise.
enum status sensor_check_transform(const struct sensor *sensor, float *scale, struct commit_context *context,
                                   struct error *error);
