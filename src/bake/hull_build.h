// The hull of a lamp (luminaire/hull.h): its shapes sorted into parts, what can be seen from outside of them as one
// mesh, simplified and quantised.
#pragma once

#include "bake/gather.h"
#include "luminaire/hull.h"

struct hull_map { // from the lamp's shapes to the hull's parts
    uint32_t *part; // of every shape of the scene
    bool *glass; // of every shape: the hull traces it
};

// *hull is freed by hull_destroy, the map by hull_map_fini. The hull has at most `triangles` triangles, or as many as
// could not be removed without harm. *hull = NULL where the lamp has nothing to see (lights without a surface), or
// where it is too large for a hull.
enum status hull_build(struct hull **hull, struct hull_map *map, const struct lamp *lamp, size_t triangles,
                       struct error *error);
void hull_map_fini(struct hull_map *map);
