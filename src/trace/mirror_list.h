// Light samples of baked lamps by way of plane mirrors: from a point, a lamp in a mirror is the lamp as it is from the
// point's mirror image, so that is where its directions are drawn. They are for paths whose light by way of mirrors the
// particles of caustic.h do not bring: those that saw a mirror or glass first. Weights against scattering that happened
// to find the lamp in the mirror are as for other light samples.
#pragma once

#include "base/error.h"
#include "scene/scene.h"

struct mirror {
    const struct shape *shape;
    vec3 p, n; // of its plane
};

struct mirror_list {
    struct mirror *mirrors;
    size_t count; // 0 where there are none, or too many to choose among
};

enum status mirrors_find(struct mirror_list *list, const struct scene *scene, struct error *error);
void mirrors_fini(struct mirror_list *list);
const struct mirror *mirror_at(const struct mirror_list *list, const struct surface *surface); // or NULL

static inline vec3 mirror_image(const struct mirror *mirror, vec3 p) {
    return vec3_mad(mirror->n, -2 * vec3_dot(vec3_sub(p, mirror->p), mirror->n), p);
}
