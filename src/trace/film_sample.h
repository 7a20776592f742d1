// Where on the film a pixel's sample falls. The reconstruction filter is importance sampled (Ernst, Stamminger and
// Greiner 2006, "Filter Importance Sampling"), so every sample has weight 1 and counts for its own pixel only.
#pragma once

#include <stdint.h>

#include "math/warp.h"
#include "scene/sensor.h"

enum film_filter { FILM_FILTER_BOX, FILM_FILTER_TENT, FILM_FILTER_GAUSSIAN }; // values of sensor->filter

static inline float film_filter_offset(const struct sensor *sensor, float u) { // [pixels] from the pixel's centre
    switch (sensor->filter) {
    case FILM_FILTER_TENT:
        return sensor->filter_radius * warp_tent(u);
    case FILM_FILTER_GAUSSIAN:
        return warp_gaussian(u, sensor->filter_stddev, sensor->filter_radius);
    default:
        return sensor->filter_radius * (2 * u - 1);
    }
}

// Pixel (x, y) of the full film; the result is in units of the full film, a little outside [0,1]^2 at its borders.
static inline vec2 film_sample_position(const struct sensor *sensor, int x, int y, vec2 u) {
    return (vec2){((float)x + 0.5f + film_filter_offset(sensor, u.x)) / (float)sensor->width,
                  ((float)y + 0.5f + film_filter_offset(sensor, u.y)) / (float)sensor->height};
}

// The sampler stream of a pixel: the same whatever the crop.
static inline uint64_t film_pixel_stream(const struct sensor *sensor, int x, int y) {
    return (uint64_t)y * (uint64_t)sensor->width + (uint64_t)x;
}
