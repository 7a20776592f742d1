// The proxy as lines meet it. A mesh carries a bounding volume hierarchy.
#pragma once

#include "luminaire/build.h"

struct proxy_node { // inner: children `first` and `first + 1`, count 0; leaf: triangles order[first .. first + count)
    float lower[3], upper[3];
    uint32_t first, count;
};

struct proxy_shape {
    struct proxy proxy; // owns its vertices and indices
    struct proxy_node *nodes;
    uint32_t *order;
};

// Copies the proxy after checking it: finite, positive sizes, indices in range, everything inside the bounding sphere.
enum status proxy_shape_init(struct proxy_shape *shape, const struct proxy *proxy, struct error *error);
void proxy_shape_fini(struct proxy_shape *shape);
bool proxy_shape_span(const struct proxy_shape *shape, const float origin[3], const float direction[3], float *t_near,
                      float *t_far);
