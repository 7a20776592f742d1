// The proxy as lines meet it.
#pragma once

#include "luminaire/build.h"
#include "luminaire/mesh_tree.h"

struct proxy_shape {
    struct proxy proxy; // owns its vertices and indices
    struct mesh_tree *tree; // of PROXY_MESH
};

// Copies the proxy after checking it: finite, positive sizes, indices in range, everything inside the bounding sphere.
enum status proxy_shape_init(struct proxy_shape *shape, const struct proxy *proxy, struct error *error);
void proxy_shape_fini(struct proxy_shape *shape);
bool proxy_shape_span(const struct proxy_shape *shape, const float origin[3], const float direction[3], float *t_near,
                      float *t_far);
