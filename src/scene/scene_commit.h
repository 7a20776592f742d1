// From loaded shapes and emitters to a scene that can be traced.
#pragma once

#include "scene/scene.h"

// Computes scene->bounds, the triangle distributions of emitters, readies the emitters (scene->environment is set if
// the loader did not) and builds the ray casting structure, which scene_fini frees by embree_scene_destroy; everything
// else lives in context->arena. Shapes with their bsdf, luminaires, emitters and the sensor must be there.
enum status scene_commit(struct scene *scene, struct commit_context *context, struct error *error);
