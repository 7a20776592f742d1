// Light that reaches the camera in pixels nobody asked for: splats. Every work block gathers its own list; afterwards
// the lists are added to the pass in block order, so that the image is the same for any number of threads.
#pragma once

#include <stddef.h>
#include <stdint.h>

#include "scene/sensor.h"

struct splat {
    uint32_t pixel; // in the crop
    uint32_t source;
    rgb value;
};

struct splat_list { // zeroed: empty; one writer at a time
    struct splat *items;
    size_t count, capacity;
    uint32_t source; // the writer's number for what it adds next
    bool out_of_memory; // something was left out
    size_t dropped; // values that were not finite
};

// Adds `value` at `film` ([0,1]^2 of the full film) to every pixel of the crop whose reconstruction filter reaches it.
void splat_add(struct splat_list *list, const struct sensor *sensor, vec2 film, rgb value);
// pixels[3 i + c] += scale * the values of all lists, in order, in parallel by bands of pixels.
void splat_merge(const struct splat_list *lists, size_t list_count, float scale, float *pixels, size_t pixel_count,
                 int threads);
void splat_list_clear(struct splat_list *list); // keeps the memory
void splat_list_fini(struct splat_list *list);
