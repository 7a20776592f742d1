// Scattering functions. bsdf_table lists every type; parsing, `sconce help`, chi-square, energy and reciprocity tests
// loop over it. All directions are local (z = shading normal) and point away from the surface; `wi` is the known one.
#pragma once

#include "base/param.h"
#include "scene/commit.h"
#include "scene/texture.h"

enum transport {
    TRANSPORT_RADIANCE,
    TRANSPORT_IMPORTANCE
}; // what flows from wo to wi: tracing from the camera is RADIANCE

enum bsdf_flags {
    BSDF_SMOOTH = 1, // has a part that eval and pdf see (not a delta)
    BSDF_DELTA = 2, // has a delta part (mirror, smooth glass)
    BSDF_TRANSMISSION = 4, // can scatter to the other side
    BSDF_NULL = 8, // can let light straight through unchanged in direction (mask, null, thin): see `through`
    BSDF_BUMP = 16, // reads bsdf_point.uv_from_local (bump maps); without it the caller may leave that unset
};

struct bsdf_point { // where on the surface
    vec2 uv;
    vec2 uv_from_local[2]; // d(uv)/d(local x), d(uv)/d(local y) [1/length]; zero where the surface has no uvs
};

struct bsdf_sample {
    vec3 wo;
    rgb weight; // f cos / pdf (delta: the whole throughput); for RADIANCE it has the 1/eta^2 scaling of refraction
    float pdf; // [1/sr]; of a delta part: its discrete probability
    float eta; // IOR on wo's side over IOR on wi's side; 1 for reflection
    bool delta;
};

enum { BSDF_FETCHES = 2 };
struct bsdf {
    const struct bsdf_type *type;
    unsigned flags; // set by commit (or copied from type->flags)
    const struct texture *fetches[BSDF_FETCHES]; // its and its children's that have `fetch`, or NULL
};

struct bsdf_type {
    const char *name, *help;
    const struct param *params;
    size_t size; // of the plugin's struct, which begins with struct bsdf
    unsigned flags;
    int min_children, max_children; // nested <bsdf>s; their pointers go to:
    size_t children_offset; // offsetof a `const struct bsdf *[max_children]`
    enum status (*commit)(struct bsdf *bsdf, struct commit_context *context, struct error *error); // may be NULL
    // f(wi, wo) |cos wo|, without deltas and without `through`.
    rgb (*eval)(const struct bsdf *bsdf, const struct bsdf_point *point, vec3 wi, vec3 wo, enum transport transport);
    float (*pdf)(const struct bsdf *bsdf, const struct bsdf_point *point, vec3 wi, vec3 wo,
                 enum transport transport); // [1/sr], smooth part only; its integral is the share of smooth samples
    // u = three numbers in [0,1). False: absorbed (no sample). pdf of a smooth sample equals pdf(wi, wo).
    bool (*sample)(const struct bsdf *bsdf, const struct bsdf_point *point, vec3 wi, vec3 u, enum transport transport,
                   struct bsdf_sample *sample);
    // Fraction of light that goes straight through (mask: 1 - opacity, null: 1, thin glass: by angle). NULL: none.
    // sample, eval and pdf describe what remains, given that the light did NOT go through. The tracer goes through with
    // a probability p of its choice and weight through / p; else it samples and multiplies by (1 - through) / (1 - p).
    // So eval includes the factor (1 - through), sample's weight and pdf do not: eval = weight * pdf * (1 - through).
    rgb (*through)(const struct bsdf *bsdf, const struct bsdf_point *point, vec3 wi);
    rgb (*albedo)(const struct bsdf *bsdf,
                  vec2 uv); // a rough hemispherical reflectance, for guides and AOVs; may be NULL
};
extern const struct bsdf_type *const bsdf_table[]; // ends with NULL

// Asks the memory for what the functions below will read.
static inline void bsdf_fetch(const struct bsdf *b, vec2 uv) {
    for (int i = 0; i < BSDF_FETCHES && b->fetches[i]; i++) b->fetches[i]->type->fetch(b->fetches[i], uv);
}
static inline rgb bsdf_eval(const struct bsdf *b, const struct bsdf_point *point, vec3 wi, vec3 wo,
                            enum transport transport) {
    return b->type->eval(b, point, wi, wo, transport);
}
static inline float bsdf_pdf(const struct bsdf *b, const struct bsdf_point *point, vec3 wi, vec3 wo,
                             enum transport transport) {
    return b->type->pdf(b, point, wi, wo, transport);
}
static inline bool bsdf_sample(const struct bsdf *b, const struct bsdf_point *point, vec3 wi, vec3 u,
                               enum transport transport, struct bsdf_sample *sample) {
    return b->type->sample(b, point, wi, u, transport, sample);
}
static inline rgb bsdf_through(const struct bsdf *b, const struct bsdf_point *point, vec3 wi) {
    return b->type->through ? b->type->through(b, point, wi) : rgb_gray(0);
}
static inline rgb bsdf_albedo(const struct bsdf *b, vec2 uv) {
    return b->type->albedo ? b->type->albedo(b, uv) : rgb_gray(0.5f);
}
