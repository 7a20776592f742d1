// Surfaces that an opacity texture cuts holes into (mask): perforated metal, leaves, feathers on cards. A hull has no
// textures, so their triangles are divided until each is nearly whole or a hole.
#pragma once

#include "bake/gather.h"

// Whether a shape is either there or not at nearly all of its points, by its opacity.
bool hull_shape_is_cutout(const struct shape *shape);
struct cutout_corner {
    vec3 p;
    vec2 at; // barycentric in the triangle, as of shape_fill_triangle; of an analytic shape as of shape_sample
};
struct cutout_piece { // a triangle that is there
    struct cutout_corner corners[3];
    uint32_t primitive;
    vec3 normal; // the surface's
};
typedef void cutout_add(void *user, const struct cutout_piece *piece);
// The pieces of a triangle of a cut-out, or of an analytic shape between three corners (primitive UINT32_MAX): each
// call of `add` is one. Edges that triangles share are divided alike, none shorter than about half of `finest`.
void hull_cut(const struct shape *shape, uint32_t primitive, const struct cutout_corner corners[3], float finest,
              cutout_add *add, void *user);
