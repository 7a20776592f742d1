// Light sources. emitter_table lists every type; statistical tests loop over it. Units: radiance [W/(m^2 sr)] or any
// consistent unit, per linear RGB channel.
#pragma once

#include "base/param.h"
#include "math/sampler.h"
#include "scene/commit.h"
#include "scene/shape.h"

enum emitter_flags { EMITTER_DELTA_POSITION = 1, EMITTER_DELTA_DIRECTION = 2, EMITTER_INFINITE = 4 };

struct light_sample { // of the light that arrives at a point
    vec3 direction; // unit, from the point to the light
    float distance; // INFINITY for EMITTER_INFINITE
    rgb radiance; // emitted towards the point, unoccluded; for delta emitters: intensity / distance^2 or irradiance,
                  // pdf_sa = 1
    float pdf_sa; // [1/sr] at the point
    vec3 n; // normal of the emitter there (area), else -direction
    struct surface surface; // of an area emitter
};

struct emission_sample { // of a ray that leaves the light
    struct ray ray;
    vec3 n; // normal where it starts (infinite emitters: the ray's direction)
    rgb radiance; // emitted along the ray, or intensity, or irradiance perpendicular to it
    float cos_theta; // between n and the ray (1 for points and infinite emitters)
    float pdf_position; // [1/area] (1 for a delta position; infinite: over the disk of the scene's bounding sphere)
    float pdf_direction; // [1/sr] (1 for a delta direction)
    struct surface surface; // of an area emitter
};

struct scene_bounds {
    vec3 center;
    float radius;
};

struct emitter {
    const struct emitter_type *type;
    const struct shape *shape; // area emitters
    unsigned flags; // copied from type->flags
    uint32_t index; // in scene->emitters
    const char *id; // its own, or its shape's, or ""
    rgb factor; // multiplies the light of an area emitter: a dimmed or tinted lamp's
    struct scene_bounds bounds; // of the scene, set by scene_commit before `ready`
    rgb power; // total emitted power, set by `ready` (an estimate is enough for textured ones)
};

struct emitter_type {
    const char *name, *help;
    const struct param *params;
    size_t size;
    unsigned flags;
    bool needs_shape;
    enum status (*commit)(struct emitter *emitter, struct commit_context *context, struct error *error); // may be NULL
    enum status (*ready)(struct emitter *emitter, struct commit_context *context,
                         struct error *error); // shape and bounds known
    // Radiance emitted from `surface` towards unit direction `w` (area), or arriving from direction -w (infinite;
    // surface NULL).
    rgb (*eval)(const struct emitter *emitter, const struct surface *surface, vec3 w);
    bool (*sample_light)(const struct emitter *emitter, vec3 p, vec2 u, struct light_sample *sample);
    // pdf_sa at p of sample_light giving the point `surface` (area) or direction (infinite: surface NULL). 0 for
    // deltas.
    float (*pdf_light)(const struct emitter *emitter, vec3 p, const struct surface *surface, vec3 direction);
    bool (*sample_emission)(const struct emitter *emitter, vec2 u_position, vec2 u_direction,
                            struct emission_sample *sample);
    // The two densities of sample_emission for a ray that leaves `surface` (or, infinite, travels along `direction`).
    void (*pdf_emission)(const struct emitter *emitter, const struct surface *surface, vec3 direction,
                         float *pdf_position, float *pdf_direction);
};
extern const struct emitter_type *const emitter_table[]; // ends with NULL
