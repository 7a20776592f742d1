// How rays meet baked lamps: one event per line, at the midpoint of the chord that the proxy cuts from it. There the
// lamp's radiance L joins the light that the line carries, and what comes from behind is dimmed by the transparency T.
// Crossings are gathered, then answered by one query per lamp. All positions here are the room's.
#pragma once

#include "scene/scene.h"

struct crossing {
    uint32_t item; // whose line this is, for the caller
    uint32_t luminaire; // index in scene->luminaires
    float t_mid; // where on the item's ray, > 0; or 0: crossing_find was not asked
    bool wants_radiance, wants_transmittance, wants_pdf;
    bool looks; // the line shows the lamp itself: it is dark beside its silhouette
    vec3 viewpoint, direction; // of the ray: the light travels along -direction
    rgb radiance, transmittance; // answers; 0 and 1 where not asked
    float pdf_sa; // of luminaire_sample from the viewpoint giving this direction
};

struct crossing_batch {
    struct crossing *crossings;
    size_t count, capacity; // capacity >= scene->luminaire_count
    size_t luminaire_count;
    uint32_t *order, *starts;
    float (*point)[3], (*w)[3], (*answer)[3], *pdf;
};

enum status crossing_batch_init(struct crossing_batch *batch, const struct scene *scene, size_t lines,
                                struct error *error);
void crossing_batch_fini(struct crossing_batch *batch);
// How many lines fit for certain, each with every luminaire of the scene on it.
size_t crossing_batch_lines(const struct crossing_batch *batch);
// The event of a ray with a luminaire, t_mid measured from ray->origin. False: the line misses, or the event lies
// behind.
bool crossing_find(const struct luminaire_instance *instance, const struct ray *ray, float *t_mid);
struct crossing *crossing_add(struct crossing_batch *batch, uint32_t item, uint32_t luminaire, const struct ray *ray,
                              float t_mid);
// Asks the luminaires and fills the answers (radiance has the instance's `dim` in it).
void crossing_batch_answer(struct crossing_batch *batch, const struct scene *scene);

// What the placed and dimmed lamp emits.
rgb luminaire_power(const struct luminaire_instance *instance);
vec3 luminaire_local_point(const struct luminaire_instance *instance, vec3 p);
vec3 luminaire_local_direction(const struct luminaire_instance *instance, vec3 w); // unit stays unit
vec3 luminaire_world_direction(const struct luminaire_instance *instance, vec3 w);

// --- Which kept geometry a ray sees. ---
// Geometry of a lamp with appearance=geometry that is not kept for the room (keep none; at keep opaque what emits
// or transmits) is there for rays that look at the lamp and for paths live in it only.
struct lamp_view {
    bool look; // a camera ray, or one after delta scattering only
    int live; // luminaire whose own geometry the path is in with its emitters on, or -1
    int ignore; // luminaire whose kept geometry is invisible altogether, or -1
};
bool scene_has_hidden_geometry(const struct scene *scene);
bool lamp_view_hides(const struct scene *scene, const struct lamp_view *view, const struct shape *shape);
// scene_intersect and scene_visibility under a view. `hidden`: scene_has_hidden_geometry, found once.
bool lamp_view_intersect(const struct scene *scene, bool hidden, const struct lamp_view *view, const struct ray *ray,
                         struct surface *surface);
rgb lamp_view_visibility(const struct scene *scene, bool hidden, const struct lamp_view *view, const struct ray *ray);
