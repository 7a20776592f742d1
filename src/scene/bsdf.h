// Scattering functions. bsdf_table lists every type; parsing, `sconce help`, chi-square, energy and reciprocity tests
// loop over it. All directions are local (z = shading normal) and point away from the surface; `wi` is the known one.
#pragma once

#include "base/param.h"
#include "scene/commit.h"
#include "scene/texture.h"

enum transport { TRANSPORT_RADIANCE, TRANSPORT_IMPORTANCE }; // what flows from wo to wi: tracing from the camera is RADIANCE

enum bsdf_flags {
    BSDF_SMOOTH = 1,       // has a part that eval and pdf see (not a delta)
    BSDF_DELTA = 2,        // has a delta part (mirror, smooth glass)
    BSDF_TRANSMISSION = 4, // can scatter to the other side
    BSDF_NULL = 8,         // can let light straight through unchanged in direction (mask, null, thin): see `through`
};

struct bsdf_sample {
    vec3 wo;
    rgb weight;  // f cos / pdf (delta: the whole throughput); for RADIANCE it has the 1/eta^2 scaling of refraction
    float pdf;   // [1/sr]; of a delta part: its discrete probability
    float eta;   // IOR on wo's side over IOR on wi's side; 1 for reflection
    bool delta;
};

struct bsdf {
    const struct bsdf_type *type;
    unsigned flags; // set by commit (or copied from type->flags)
};

struct bsdf_type {
    const char *name, *help;
    const struct param *params;
    size_t size; // of the plugin's struct, which begins with struct bsdf
    unsigned flags;
    int min_children, max_children;                         // nested <bsdf>s; their pointers go to:
    size_t children_offset;                                 // offsetof a `const struct bsdf *[max_children]`
    enum status (*commit)(struct bsdf *bsdf, struct commit_context *context, struct error *error); // may be NULL
    // f(wi, wo) |cos wo|, without deltas and without `through`.
    rgb (*eval)(const struct bsdf *bsdf, vec2 uv, vec3 wi, vec3 wo, enum transport transport);
    float (*pdf)(const struct bsdf *bsdf, vec2 uv, vec3 wi, vec3 wo, enum transport transport); // [1/sr], smooth part only
    // u = three numbers in [0,1). False: absorbed (no sample). pdf of a smooth sample equals pdf(wi, wo) exactly.
    bool (*sample)(const struct bsdf *bsdf, vec2 uv, vec3 wi, vec3 u, enum transport transport, struct bsdf_sample *sample);
    // Fraction of light that goes straight through (mask: 1 - opacity, null: 1). NULL: none. sample, eval and pdf describe
    // what remains, given that the light did NOT go through, already weighted: eval includes the factor (1 - through),
    // sample's weight does not (the tracer chose to scatter with its probability), pdf does not.
    rgb (*through)(const struct bsdf *bsdf, vec2 uv);
    // Bump and normal maps: the perturbed frame, local to the shading frame. NULL: unchanged.
    // The caller then evaluates `child` in that frame.
    const struct bsdf *(*perturb)(const struct bsdf *bsdf, vec2 uv, vec2 uv_from_local[2], struct frame *local);
    rgb (*albedo)(const struct bsdf *bsdf, vec2 uv); // a rough hemispherical reflectance, for guides and AOVs; may be NULL
};
extern const struct bsdf_type *const bsdf_table[]; // ends with NULL
