// A number that stands for a lamp's geometry and description, for checkpoints and for the metadata of what was baked.
#pragma once

#include "scene/scene.h"

// FNV-1a (Fowler, Noll, Vo) over the bytes of the scene file and all vertices and indices in it.
enum status lamp_identity(const struct scene *scene, uint64_t *identity, struct error *error);
