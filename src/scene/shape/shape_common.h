// What several shape plugins share: the transform checks and the last steps of a mesh.
#pragma once

#include "scene/shape.h"

// An error when it is projective, singular or not finite.
enum status shape_check_transform(struct shape *shape, struct commit_context *context, struct error *error);
// The scale of a rotation or reflection with uniform scale; 0 for every other transform.
float shape_similarity_scale(const struct transform *t);
// The orthonormal frame about n whose s follows dp_du (any s where dp_du is zero or along n).
struct frame shape_frame(vec3 n, vec3 dp_du);
// The steps from a loaded mesh in its own coordinates to the shape: to_world, vertex normals (kept, computed or
// dropped), flip_normals, area.
enum status shape_finish_mesh(struct shape *shape, struct commit_context *context, struct error *error);
// A flat-shaded mesh of quadrilaterals: 4 corners each, uvs (0,0) (1,0) (1,1) (0,1).
// A mirroring to_world keeps the outside as it is.
enum status shape_finish_quads(struct shape *shape, const vec3 *corners, size_t quad_count,
                               struct commit_context *context, struct error *error);
