// What lights from outside the scene share: rays that start on a disk beside the scene's bounding sphere.
#pragma once

#include "math/warp.h"
#include "scene/emitter.h"

static inline float bounds_disk_pdf(const struct scene_bounds *bounds) { return 1 / (PI_F * sqrf(bounds->radius)); }

// A ray along w through a point uniform on the disk.
static inline struct ray bounds_disk_ray(const struct scene_bounds *bounds, vec3 w, vec2 u) {
    vec2 disk = warp_concentric_disk(u);
    struct frame frame = frame_from_normal(w);
    vec3 offset = frame_world_from_local(&frame, vec3_make(disk.x, disk.y, -1));
    return (struct ray){vec3_mad(offset, bounds->radius, bounds->center), w, 0, INFINITY};
}
