// Affine and projective 4x4 transforms with their inverse. Column vectors: p' = M p; row-major storage.
#pragma once

#include "math/vec.h"

struct transform {
    float m[4][4], inverse[4][4];
};

struct transform transform_identity(void);
struct transform transform_translate(vec3 v);
struct transform transform_scale(vec3 v); // no component may be zero
struct transform transform_rotate(vec3 axis, float degrees);
struct transform transform_look_at(vec3 origin, vec3 target,
                                   vec3 up); // world from camera: +z looks at the target, as in Mitsuba
struct transform transform_from_matrix(const float m[4][4], bool *invertible);
struct transform transform_multiply(const struct transform *a, const struct transform *b); // a after b
struct transform transform_inverse(const struct transform *t);
vec3 transform_point(const struct transform *t, vec3 p);
vec3 transform_vector(const struct transform *t, vec3 v);
vec3 transform_normal(const struct transform *t, vec3 n); // by the inverse transpose; not normalised
bool transform_flips_handedness(const struct transform *t);
// The factor of a rotation + uniform scale + translation, or 0 where the transform is anything else (relative tolerance
// 1e-4).
float transform_uniform_scale(const struct transform *t);
