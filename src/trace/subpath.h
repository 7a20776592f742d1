// Random walks from a light or from the camera, with the running sums of multiple importance sampling that let
// bdpt_connect.c weight any connection in constant time. Used by the bidirectional and the particle integrator.
//
// The sums are those of Georgiev 2012, "Implementing Vertex Connection and Merging" (tech. report, Saarland
// University), eqs. 31-38 without merging, and of van Antwerpen 2011: at a vertex y of a subpath, with p the densities
// per area
//   d_vcm = mis(p(previous vertex by connecting) / p(previous vertex, y by this walk)),
//   d_vc  = the sum over all techniques that walk further from the other side, over the density of walking back to the
//           previous vertex [per solid angle].
// Deviations: the light's part in d_vcm is found at the first hit, because pdf_light depends on the point that sees the
// light; mis() is the power heuristic with exponent 2, in double. Chances of Russian roulette and of passing through
// masks are left out of the densities: every technique leaves out the same, so the weights still sum to one.
#pragma once

#include "math/distribution.h"
#include "math/sampler.h"
#include "scene/scene.h"
#include "trace/fork.h"
#include "trace/light_select.h"
#include "trace/mirror_list.h"

static inline double mis(double ratio) { return ratio * ratio; }

struct vertex {
    struct surface surface;
    vec3 wi; // unit, towards the previous vertex
    rgb arrived; // throughput on arrival
    rgb beta; // the same over the chance of scattering here: multiplies surface_eval_bsdf
    rgb scatter; // the same times the share that does not go through: multiplies a BSDF sample's weight
    double d_vcm, d_vc;
    int depth; // edges from the start
    unsigned flags; // of the BSDF
};

struct walk {
    const struct scene *scene;
    enum transport transport; // of surface_sample_bsdf
    struct ray ray;
    rgb beta;
    float start, eta2; // for Russian roulette: brightness of beta at the start, product of the squared relative IORs
    int depth; // edges walked
    vec3 vertex_p; // the last vertex; where depth > 0
    float travelled; // since the last vertex, where surfaces were passed
    bool has_from; // the ray starts at a surface
    struct surface from;
    double d_vcm, d_vc;
    bool distant; // first edge only: starts at infinity or as parallel rays, so distance has no part in its density
    // Of a camera's walk: by way of which mirrors the camera is linked, until the first vertex that is none; and that
    // the walk comes from such a mirror, so its sums and `travelled` are as if it came from the camera's image.
    const struct mirror_list *mirrors;
    bool mirrored;
    // A walk from a light, before its first vertex:
    const struct emission_sample *emission; // NULL afterwards; the caller's
    const struct emitter *emitter;
    const struct light_select *lights;
    float emission_pmf;
};

enum walk_event {
    WALK_HIT, // *vertex is complete: the walk may go on with walk_scatter
    WALK_PASSED, // a surface let the walk through: *vertex is good for `arrived`, d_vcm, d_vc and the emission there
    WALK_ESCAPED, // left the scene, walk->ray says how
};
enum walk_event walk_advance(struct walk *walk, struct sampler *sampler, struct vertex *vertex);
// Scatters at the vertex and plays Russian roulette from rr_depth edges on. False: the walk ends.
bool walk_scatter(struct walk *walk, const struct vertex *vertex, struct sampler *sampler, int rr_depth);

// --- Lights. ---
struct light_source { // the choice of an emitter in proportion to its power
    const struct scene *scene;
    const struct light_select *lights; // of next-event estimation, for the weights; NULL where they are not wanted
    struct distribution by_power;
};
enum status light_source_init(struct light_source *source, const struct scene *scene, const struct light_select *lights,
                              struct error *error);
void light_source_fini(struct light_source *source);
float light_source_pmf(const struct light_source *source, const struct emitter *emitter);
// False: no light came out.
bool light_source_emit(const struct light_source *source, struct sampler *sampler, struct walk *walk,
                       struct emission_sample *emission);

// --- The camera. ---
struct camera {
    const struct sensor *sensor;
    bool parallel; // all rays have one direction (orthographic)
    float crop_share; // of the crop in the full film, by area
    struct mirror_list mirrors; // in which it is linked, see mirror_link.h; none where far_clip could cut a way
};
struct camera_link { // the camera seen from a point
    vec3 direction; // unit, towards the camera
    float distance, reach; // to the lens, to the near plane: what is nearer to the lens does not block
    vec2 film;
    float response; // of the full film's mean to radiance along the link, per area of the surface perpendicular to it
    float pdf; // the same as a density of camera rays of the crop
};
void camera_init(struct camera *camera, const struct scene *scene);
void camera_walk(const struct camera *camera, const struct scene *scene, vec2 film, vec2 lens, struct walk *walk);
bool camera_connect(const struct camera *camera, vec3 p, vec2 lens, struct camera_link *link);
