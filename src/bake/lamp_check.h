// First look at a loaded lamp: does it give light, and are its glass bodies closed?
#pragma once

#include "scene/scene.h"

// STATUS_INVALID: no emitter, or none with any power. Warns of emitters without power, of point lights (no
// radiance) and of open meshes with a dielectric (where light would enter glass and never leave it).
enum status lamp_check(const struct scene *scene, const struct run *run, struct error *error);

// How many edges of the mesh belong to an odd number of triangles, once vertices at equal positions are joined;
// 0: closed. SIZE_MAX: memory is out.
size_t mesh_open_edges(const struct mesh *mesh);
