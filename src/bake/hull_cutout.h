// Surfaces that an opacity texture cuts holes into (mask): perforated metal, leaves, feathers on cards. A hull has no
// textures, so their triangles are divided until each is nearly whole or a hole.
#pragma once

#include "bake/gather.h"

// Whether a shape is either there or not at nearly all of its points, by its opacity.
bool hull_shape_is_cutout(const struct shape *shape);
struct cutout_piece { // a triangle that is there
    vec3 p[3], normal; // the normal is the surface's
    uint32_t primitive; // that it is a part of; UINT32_MAX: of an analytic shape
};
typedef void cutout_add(void *user, const struct cutout_piece *piece);
// The pieces of a cut-out: each call of `add` is one. Edges that triangles share are divided alike, none shorter than
// about half of `finest`.
void hull_cut(const struct shape *shape, float finest, cutout_add *add, void *user);
