// Ray casting of a whole scene. Embree's types stay in scene_embree.c.
#pragma once

#include "scene/scene.h"

struct embree_scene;

// Builds over scene->shapes; *result is freed by embree_scene_destroy (NULL is allowed).
enum status embree_scene_create(struct embree_scene **result, const struct scene *scene, int threads,
                                struct error *error);
void embree_scene_destroy(struct embree_scene *embree);
// Whether any shape lets light straight through (BSDF_NULL).
bool embree_scene_has_through(const struct embree_scene *embree);
// Whether anything lies on the ray; faster than the nearest hit.
bool embree_scene_occluded(const struct embree_scene *embree, const struct ray *ray, int ignore_luminaire);
