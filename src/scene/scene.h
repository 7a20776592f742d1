// A committed scene: what the integrators see. Embree is behind scene_embree.c only.
#pragma once

#include "base/run.h"
#include "format/description.h"
#include "luminaire/luminaire.h"
#include "scene/bsdf.h"
#include "scene/emitter.h"
#include "scene/sensor.h"
#include "scene/shape.h"

enum integrator_kind { INTEGRATOR_PATH, INTEGRATOR_BDPT, INTEGRATOR_PARTICLE };
enum keep_geometry { KEEP_NONE, KEEP_OPAQUE, KEEP_ALL };
enum appearance { APPEARANCE_NEURAL, APPEARANCE_SURFACE, APPEARANCE_GEOMETRY };
// What becomes of the light behind a baked lamp: it is dimmed by T per colour, let through where the mean of T is at
// least a half, or stopped. The last two are for comparison only.
enum lamp_mask { LAMP_MASK_RGB, LAMP_MASK_BINARY, LAMP_MASK_NONE };

struct luminaire_instance { // a baked lamp placed in the scene
    const struct luminaire *luminaire; // the file's, or a copy of it with its groups dimmed
    const struct luminaire *file; // several instances share it
    struct transform to_world; // rotation, uniform scale, translation
    float scale; // its uniform scale (radiance is unchanged by scaling)
    enum keep_geometry keep;
    enum appearance appearance;
    enum lamp_mask mask;
    rgb dim; // multiplies L
    struct shape *sheet; // scatters the room's light that the lamp stops; NULL: kept geometry does, or nothing
    struct place place;
};

struct lamp_description { // of a lamp whose XML is part of the scene as geometry
    struct lamp_description *next;
    struct description description;
};

struct scene {
    struct shape **shapes;
    size_t shape_count;
    struct emitter **emitters; // those of kept geometry are in here too, see shape->luminaire
    size_t emitter_count;
    const struct emitter *environment; // or NULL; at most one of constant, envmap
    struct luminaire_instance *luminaires;
    size_t luminaire_count;
    struct shape **hulls; // the parts of the hulls of lamps with APPEARANCE_SURFACE
    size_t hull_count;
    struct sensor *sensor; // NULL for a lamp without one
    enum integrator_kind integrator;
    int max_depth; // edges of a path, as in Mitsuba (1: emission only); -1: unlimited
    int rr_depth; // Russian roulette from this depth on
    bool hide_emitters;
    bool share_light; // paths may end in what others found (trace/radiance_cache.h), pixels share (shared_light.h)
    bool unbiased; // every baked lamp keeps its geometry, which corrects its light field (trace/residual.h)
    struct scene_bounds bounds; // of all shapes, proxies and the sensor; radius > 0
    const char *path;
    struct embree_scene *embree;
    struct arena arena;
    struct description description;
    struct lamp_description *lamps; // freed by scene_fini
};

struct scene_options {
    const struct definition *definitions;
    size_t definition_count;
    bool skip_missing;
    bool lamp_only; // load as a lamp: sensor, integrator and infinite emitters are left aside with a note
    bool share_light; // for scene->share_light
    bool unbiased; // load the geometry of all baked lamps, as they were baked from, for scene->unbiased
    int width, height; // > 0: the whole film in this size instead of the file's, its crop scaled along
    int threads;
};

// Where a ray is scattered by the lamp's sheet.
void luminaire_sheet_hit(const struct luminaire_instance *instance, const struct ray *ray, float t,
                         struct surface *surface);

enum status scene_load(struct scene *scene, const char *path, const struct scene_options *options,
                       const struct run *run, struct error *error);
// Nothing but the hull of a luminaire (which has one), in lamp coordinates; the luminaire stays the caller's.
enum status scene_init_hull(struct scene *scene, const struct luminaire *luminaire, int threads, struct error *error);
void scene_fini(struct scene *scene);

// --- Rays. All are thread-safe and do no checks. ---
// `ignore_luminaire`: kept geometry of that luminaire instance is invisible to the ray; -1: sees everything.
// Nearest surface, of whatever BSDF. False: none.
bool scene_intersect(const struct scene *scene, const struct ray *ray, int ignore_luminaire, struct surface *surface);
// The same in two steps, between which the memory can be asked for the triangles of many hits (shape.h).
struct scene_hit {
    const struct shape *shape; // NULL: none
    uint32_t primitive;
    vec2 uv;
    float t;
};
struct scene_hit scene_trace(const struct scene *scene, const struct ray *ray, int ignore_luminaire);
void scene_fill(const struct ray *ray, const struct scene_hit *hit, struct surface *surface);
// Nearest part of a lamp's hull, those of `ignore_luminaire` left out: for rays that look at lamps, and no others.
bool scene_intersect_hulls(const struct scene *scene, const struct ray *ray, int ignore_luminaire,
                           struct surface *surface);
// What fraction gets from one end of the ray to the other: surfaces with `through` attenuate, everything else blocks.
// Interior absorption and baked luminaires are the callers' business (path_segment.h).
rgb scene_visibility(const struct scene *scene, const struct ray *ray, int ignore_luminaire);
// A ray from a surface point towards unit `direction`, moved off the surface so that it does not hit it again
// (Waechter and Binder 2019, Ray Tracing Gems ch. 6). t_max = INFINITY.
struct ray surface_spawn_ray(const struct surface *surface, vec3 direction);
// The same for a segment that ends just short of another point.
struct ray surface_spawn_segment(const struct surface *surface, vec3 target, float *distance);

// --- Scattering at a surface in world directions; applies bump and normal maps and twosided shells. ---
rgb surface_eval_bsdf(const struct surface *surface, vec3 wi, vec3 wo,
                      enum transport transport); // f |cos|, with the
                                                 // shading-normal correction of Veach 1997, 5.3 for IMPORTANCE, 0 where
                                                 // geometric and shading sides disagree
float surface_pdf_bsdf(const struct surface *surface, vec3 wi, vec3 wo, enum transport transport);
// Both at once, for RADIANCE; the density is left at 0 where the value is.
rgb surface_eval_pdf_bsdf(const struct surface *surface, vec3 wi, vec3 wo, float *pdf);
bool surface_sample_bsdf(const struct surface *surface, vec3 wi, vec3 u, enum transport transport,
                         struct bsdf_sample *sample);
rgb surface_through(const struct surface *surface, vec3 wi);
bool surface_is_hole(const struct surface *surface, vec3 wi); // there is nothing: a mask of opacity 0
unsigned surface_bsdf_flags(const struct surface *surface);
// Emission towards w: 0 where the shape has no emitter or w is on the dark side.
rgb surface_emission(const struct surface *surface, vec3 w);
// Absorption along a segment of length `distance` that leaves `from` (NULL: a camera or light point outside everything)
// in `direction` and ends at `to` (NULL likewise).
rgb segment_absorption(const struct surface *from, const struct surface *to, vec3 direction, float distance);
