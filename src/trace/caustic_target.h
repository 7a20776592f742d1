// Where caustics begin: the mirrors and smooth glass that a baked lamp can light. A particle starts there, at a point
// uniform on a target, not at the lamp: a light sample from that point gives the line it came along, and no particle
// is spent on directions in which there is nothing to be reflected or refracted.
#pragma once

#include "math/distribution.h"
#include "scene/scene.h"

struct caustic_target { // uniform by area
    const struct shape *shape;
    uint32_t triangle; // of a mesh; an analytic shape is one target
    float area;
};

struct caustic_targets { // of one lamp
    struct caustic_target *targets;
    size_t count;
    struct distribution choice;
    double weight; // a rough measure of the light that meets them
};

// Leaves *targets empty (count 0) where the lamp can light none.
enum status caustic_targets_init(struct caustic_targets *targets, const struct scene *scene, uint32_t luminaire,
                                 struct error *error);
void caustic_targets_fini(struct caustic_targets *targets);
// A point on a target and the density with which it is found.
void caustic_targets_sample(const struct caustic_targets *targets, float u_target, vec2 u_point,
                            struct surface *surface, float *pdf_area);
