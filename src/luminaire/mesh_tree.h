// Lines against the triangles of a mesh: a bounding volume hierarchy of nodes with 8 boxes over blocks of 8 triangles,
// so that a step of a walk is arithmetic over vectors. A line through an edge or a vertex meets at least one of the
// triangles there. A tree of its own, because Embree belongs to scenes. Queries check nothing and are thread-safe.
#pragma once

#include <stddef.h>
#include <stdint.h>

#include "base/error.h"
#include "math/vec.h"

struct mesh_tree;

// Vertices finite, indices in range, count < 2^26; all is copied. Triangles without area (but for rounding) are left
// out.
enum status mesh_tree_create(struct mesh_tree **tree, const float (*vertices)[3], const uint32_t (*triangles)[3],
                             size_t count, struct error *error);
void mesh_tree_destroy(struct mesh_tree *tree); // NULL is allowed

// The triangle with the least t > t_min at origin + t direction (unit), or MESH_MISSED.
enum { MESH_MISSED = UINT32_MAX };
uint32_t mesh_tree_nearest(const struct mesh_tree *tree, vec3 origin, vec3 direction, float t_min, float *t);
// Where the line meets the mesh first and last, t of any sign; false: nowhere. The mesh lies about [0, length] in t.
bool mesh_tree_span(const struct mesh_tree *tree, vec3 origin, vec3 direction, float length, float *first, float *last);
// All triangles with t > t_min, in no particular order.
typedef void mesh_visit(void *user, uint32_t triangle);
void mesh_tree_visit(const struct mesh_tree *tree, vec3 origin, vec3 direction, float t_min, mesh_visit *visit,
                     void *user);
