// The sphere's data, which area lights need to sample its visible part.
#pragma once

#include "scene/shape.h"

struct sphere {
    struct shape base;
    vec3 center; // parameter, then in the world
    float radius;
    bool inward; // the outside is towards the centre
    struct transform object, from_world; // unit sphere to world, for the uvs, and back
};
extern const struct shape_type shape_sphere;
