// Rays against a hull without a scene: which of its parts a line through the lamp meets, and how much of the light that
// comes along it smooth glass lets through.
#pragma once

#include "luminaire/hull.h"

struct hull_tree;

enum status hull_tree_create(struct hull_tree **tree, const struct hull *hull, struct error *error); // copies
void hull_tree_destroy(struct hull_tree *tree); // NULL is allowed

enum hull_answer {
    HULL_MISSED, // nothing of the hull lies on the line
    HULL_SOLVED, // only clear glass and opaque parts: the transmittance is known
    HULL_DIFFUSED, // the first part other than clear glass is translucent
};
struct hull_crossing {
    enum hull_answer answer;
    float transmittance[3]; // HULL_MISSED: 1; HULL_DIFFUSED: of the clear glass before it
    float point[3], normal[3]; // HULL_DIFFUSED: the first translucent point; its unit normal, towards the ray's origin
    int layers; // HULL_DIFFUSED: translucent surfaces on the straight rest of the line
    bool blocked; // HULL_DIFFUSED: an opaque part lies on it
};

// The ray goes from `origin` against the light. It is refracted by clear glass, which reflects by Fresnel; where it
// ends up turned by more than acos(cos_limit), nothing comes straight through. No checks.
void hull_tree_cross(const struct hull_tree *tree, vec3 origin, vec3 direction, float cos_limit,
                     struct hull_crossing *crossing);
