// Single lines through a lamp-only scene, for the baker: how much radiance comes back along a ray, and how much of the
// light behind the lamp gets through it.
#pragma once

#include "math/sampler.h"
#include "scene/scene.h"

struct aim { // a sphere around a cluster of emitters
    vec3 center;
    float radius;
};

struct line_hit {
    rgb radiance; // an unbiased estimate of what arrives at ray->origin from ray->direction (light travels along
                  // -direction)
    float distance; // of the first surface that scatters, where `hit`
    bool hit;
};

// Path tracing in which emitters are hit by chance (a shadow ray would always end at the lamp's shell); where the
// scattering is not a delta, 60 % of the directions aim at the spheres (aim_count may be 0). max_depth in edges, -1:
// unlimited.
void trace_line_radiance(const struct scene *scene, const struct ray *ray, struct sampler *sampler,
                         const struct aim *aims, size_t aim_count, int max_depth, struct line_hit *out);

// A stochastic estimate of the transparency: the throughput of a path that crosses the lamp by transmission only and
// leaves within cos >= cos_limit of ray->direction; 0 where it is reflected, absorbed or turned further; 1 where
// nothing is hit.
rgb trace_line_transmittance(const struct scene *scene, const struct ray *ray, struct sampler *sampler, int max_depth,
                             float cos_limit);
