// One particle of a lamp: from an emitter until it leaves for ever. The baker makes its light field of these.
#pragma once

#include "math/sampler.h"
#include "scene/scene.h"

struct particle_exit {
    vec3 point; // where it left: the last surface that scattered it, or the emitter
    vec3 direction; // unit
    rgb flux; // the mean over all particles emitted (absorbed ones count 0) is the lamp's flux [W]
    bool escaped; // false: absorbed, flux is 0
    vec3 emission_point; // where it was born
    int rays; // that were traced for it
};

// max_depth: edges, with the one that leaves; -1: unlimited. Unbiased: Russian roulette by brightness from the first
// scattering on keeps the weights of what is left nearly equal. Thread-safe, does no checks.
void trace_particle(const struct scene *scene, struct sampler *sampler, int max_depth, struct particle_exit *exit);

// The same, and where the light was last on something that is not clear glass (`glass`: of every shape of the scene).
struct particle_source {
    struct surface surface; // surface.shape NULL: a light without a surface
    vec3 direction; // in which it left
    rgb flux; // without what glass absorbed after that
};
void trace_particle_source(const struct scene *scene, const bool *glass, struct sampler *sampler, int max_depth,
                           struct particle_exit *exit, struct particle_source *source);
