// Surfaces that let light straight through (mask, null, thin glass): a path goes on through them, which is no vertex,
// or scatters. The choice is random with the mean of `through` as its probability.
#pragma once

#include "scene/scene.h"

struct fork {
    bool passes;
    rgb weight; // of the branch taken: multiplies the path, and with it a sample of the BSDF
    float inverse_share; // 1 / probability of the branch: all that eval needs, which holds (1 - through) already
};

static inline struct fork fork_choose(const struct surface *surface, vec3 wi, float u) {
    rgb through = surface_through(surface, wi);
    float p = minf(rgb_mean(through), 1);
    if (u < p) return (struct fork){true, rgb_scale(through, 1 / p), 1 / p};
    return (struct fork){false, rgb_scale(rgb_sub(rgb_gray(1), through), 1 / (1 - p)), 1 / (1 - p)};
}
static inline struct fork fork_none(void) { return (struct fork){false, rgb_gray(1), 1}; }
