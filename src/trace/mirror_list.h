// Plane mirrors, by way of which a point is connected with what is seen in them as from its mirror image:
//   - the path tracer samples baked lamps (path_mirror.c), for paths whose light by way of mirrors the particles of
//     caustic.h do not bring: those that saw a mirror or glass first;
//   - walks from lights are seen by the camera (mirror_link.c), without which neither bdpt nor particle finds a wall in
//     a mirror that a lamp behind glass lights.
#pragma once

#include "scene/scene.h"

struct mirror {
    const struct shape *shape;
    vec3 p, n; // of its plane
    vec3 lower, upper; // of the shape, a little widened
};

enum { MIRRORS_MAX = 8 }; // more would make each too rare a choice
struct mirror_list {
    struct mirror mirrors[MIRRORS_MAX]; // the largest
    size_t count;
};

enum mirror_kind {
    MIRROR_PURE, // one delta reflection and nothing else
    MIRROR_COATED, // these, and what reflects so besides other scattering: smooth plastic, a pane of glass
};
void mirrors_find(struct mirror_list *list, const struct scene *scene, enum mirror_kind kind);
bool mirror_spans(const struct mirror *mirror, vec3 p); // a point of its plane; false: it is not on the mirror
const struct mirror *mirror_at(const struct mirror_list *list, const struct surface *surface); // or NULL

static inline vec3 mirror_image(const struct mirror *mirror, vec3 p) {
    return vec3_mad(mirror->n, -2 * vec3_dot(vec3_sub(p, mirror->p), mirror->n), p);
}

// Where the line from an image meets the mirror's plane, and the unit direction there from the point itself. False:
// the plane is not in front.
static inline bool mirror_way(const struct mirror *mirror, vec3 p, vec3 from_image, float *distance, vec3 *direction) {
    const vec3 image = mirror_image(mirror, p);
    const float along = vec3_dot(from_image, mirror->n), away = vec3_dot(vec3_sub(mirror->p, image), mirror->n);
    if (!(away * along > 0)) return false;
    *distance = away / along;
    *direction = vec3_normalize(vec3_sub(vec3_mad(from_image, *distance, image), p));
    return true;
}

static inline bool mirror_reflects(const struct surface *surface, vec3 wi, const struct bsdf_sample *sample) {
    return sample->delta && vec3_dot(surface->ng, wi) * vec3_dot(surface->ng, sample->wo) > 0;
}
