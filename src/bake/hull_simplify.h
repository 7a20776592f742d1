// Fewer triangles for the same shape: edge collapse by quadric error (Garland and Heckbert 1997, "Surface
// Simplification Using Quadric Error Metrics").
#pragma once

#include "base/error.h"
#include "math/vec.h"

#include <stddef.h>
#include <stdint.h>

struct loose_mesh { // triangles of several parts; vertices are of one part each and joined within it
    vec3 *positions;
    uint32_t *vertex_part;
    uint32_t (*triangles)[3];
    size_t vertex_count, triangle_count;
};

void loose_mesh_fini(struct loose_mesh *mesh);
// Joins vertices of one part at equal positions and drops triangles without area.
enum status loose_mesh_join(struct loose_mesh *mesh, struct error *error);
struct mesh_limit {
    size_t vertices, triangles;
};
// Collapses edges, the least harmful first, while the surface moves by less than `tolerance`, and further until the
// mesh keeps the limit. `stiffness` per part multiplies the distances that its surface moves by. Vertices that no
// triangle uses are dropped; the order of the triangles is kept. Deterministic.
enum status loose_mesh_simplify(struct loose_mesh *mesh, const float *stiffness, float tolerance,
                                const struct mesh_limit *most, struct error *error);
