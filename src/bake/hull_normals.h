// Normals of a hull's smooth parts, from the lamp's own surfaces: highlights are where normals turn to, and those of
// the few triangles that are left would turn elsewhere.
#pragma once

#include "bake/hull_build.h"

// Positions, triangles and parts are final but for vertices that are split where a crease meets them.
enum status hull_take_normals(struct hull *hull, const struct hull_map *map, const struct lamp *lamp,
                              struct error *error);
