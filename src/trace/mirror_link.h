// The camera seen from a point by way of a plane mirror: as it is seen from the point's mirror image. For walks from
// lights, which otherwise never reach what stands in a mirror (Veach 1997, 10.3, where the camera is at the image).
#pragma once

#include "math/sampler.h"
#include "trace/mirror_list.h"
#include "trace/subpath.h"

struct mirror_link {
    const struct mirror *mirror;
    struct camera_link camera; // seen from the image; the distance is that of the whole way
    vec3 direction; // unit, from the point towards the mirror
    float distance; // from the point to the mirror
};

// False: the camera is not seen in this mirror, were nothing in between.
bool mirror_link_find(const struct mirror *mirror, const struct camera *camera, vec3 p, vec2 lens,
                      struct mirror_link *link);
// What arrives at the camera of the light that leaves `surface` along the link: reflectance, surfaces in between,
// absorption. Black where the mirror is not the first surface that is met. Where a BSDF has other lobes, the reflection
// is chosen by chance.
rgb mirror_link_transmits(const struct mirror_link *link, const struct camera *camera, const struct scene *scene,
                          const struct surface *surface, struct sampler *sampler);
