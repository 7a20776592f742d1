// Single lines through a lamp: how much of its own radiance comes back along a ray, and how much of the light behind
// the lamp gets through it. The lamp is the geometry of one luminaire instance of a scene, or, for the baker, a scene
// of its own (luminaire -1).
#pragma once

#include "math/sampler.h"
#include "scene/scene.h"

struct aim { // a sphere around a cluster of emitters
    vec3 center;
    float radius;
};

struct line_walk { // a path through a lamp, at a surface of it
    const struct scene *scene;
    int luminaire;
    struct ray ray; // that arrives there
    struct surface surface, from; // from: where the ray starts; only with has_from
    bool has_from;
    rgb beta;
    bool particles_too; // false after line_walk_begin; see line_walk_radiance
};

// Follows a ray that starts at `from` (NULL: in the open) to the lamp. What lets light straight through on the way dims
// it; false where the ray meets anything else first, or nothing.
bool line_walk_begin(struct line_walk *walk, const struct scene *scene, int luminaire, const struct ray *ray,
                     const struct surface *from);
// The same where it is known that the first surface on the ray is `surface`, and that it is the lamp's.
void line_walk_begin_at(struct line_walk *walk, const struct scene *scene, const struct ray *ray,
                        const struct surface *from, const struct surface *surface);

struct line_hit {
    rgb radiance; // an unbiased estimate of what arrives at the walk's first origin (light travels along -direction)
    float distance; // of the first surface that scatters, where `hit`
    bool hit;
};

// Path tracing in which the lamp's emitters are hit by chance (a shadow ray would always end at the lamp's shell);
// where the scattering is not a delta, a second path goes towards the spheres (aim_count may be 0). A path that
// meets what does not belong to the lamp ends there: it brings none of the lamp's own light. max_depth in edges, at
// least 1; -1: unlimited. `particles_too`: the ray is a camera's, and particles bring what its first vertex scatters by
// no delta, so this leaves it out (and what hide_emitters hides).
void line_walk_radiance(const struct line_walk *walk, struct sampler *sampler, const struct aim *aims, size_t aim_count,
                        int max_depth, struct line_hit *out);

// Both in one, for a lamp's own scene.
void trace_line_radiance(const struct scene *scene, const struct ray *ray, struct sampler *sampler,
                         const struct aim *aims, size_t aim_count, int max_depth, struct line_hit *out);

// The same, but of the first `splits` surfaces of clear glass that a path meets, at most MAX_SPLITS, both what
// they reflect and what they refract are followed: up to 2^splits paths, of much less noise where glass shows small
// lights.
enum { MAX_SPLITS = 4 };
void trace_line_radiance_split(const struct scene *scene, const struct ray *ray, struct sampler *sampler,
                               const struct aim *aims, size_t aim_count, int max_depth, int splits,
                               struct line_hit *out);

// What a surface of clear glass reflects and refracts along wi, each with its share of the light in weight * pdf.
// False: it is something else, or reflects everything.
bool surface_split(const struct surface *surface, vec3 wi, struct bsdf_sample *reflected,
                   struct bsdf_sample *refracted);

// A stochastic estimate of the transparency: the throughput of a path that crosses the lamp by transmission only and
// leaves within cos >= cos_limit of ray->direction; 0 where it is reflected, absorbed or turned further; 1 where
// nothing is hit. With a cos_limit that is not positive reflections count as well: -1 is all the light that leaves.
rgb trace_line_transmittance(const struct scene *scene, const struct ray *ray, struct sampler *sampler, int max_depth,
                             float cos_limit);
