// Rays that look at a lamp with appearance=surface meet its hull instead of its light field: glass refracts them, any
// other part ends them with the view field's radiance or, where it is translucent, lets them straight on through the
// rest of that lamp, dimmed by its transparency.
#pragma once

#include "luminaire/hull.h"
#include "luminaire/view_field.h"
#include "math/sampler.h"
#include "scene/scene.h"

// What a ray meets first of one lamp's hull within t_max. False: nothing.
bool hull_look(const struct scene *scene, const struct ray *ray, int luminaire, enum hull_kind *kind);
// Whether anything of any hull that light does not pass straight stands between a point and the camera; `to_camera`
// ends there.
bool hulls_block(const struct scene *scene, const struct ray *to_camera);
// Whether lamp's transparency dims that light.
bool hull_dims(const struct scene *scene, const struct ray *to_camera, int luminaire);
// Follows a ray through the glass of the hulls, as a path does, to where the view field answers, and `splits` times
// (at most MAX_SPLITS, line_radiance.h) what glass reflects and what it refracts. Returns how many of the at most
// 2^splits ways end on the hull. For scenes of scene_init_hull.
struct hull_glimpse {
    struct view_point at;
    float weight; // what of its radiance comes back along the ray
};
size_t hull_trace(const struct scene *scene, const struct hull *hull, const struct ray *ray, struct sampler *sampler,
                  int splits, struct hull_glimpse *seen);
