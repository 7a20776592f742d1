// The sphere's data, which area lights need to sample its visible part.
#pragma once

#include "scene/shape.h"

struct sphere {
    struct shape base;
    vec3 center; // parameter, then in the world
    float radius;
    bool inward; // the outside is towards the centre
    struct transform object; // unit sphere to world, for the uvs
};
extern const struct shape_type shape_sphere;
