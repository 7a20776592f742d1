// A surface as pixels that share its light see it. What it reflects is in two: what it would were its BSDF nowhere more
// than in a direction far from its gloss, divided by its colour; and the gloss, which is what is left.
#pragma once

#include "scene/scene.h"
#include "trace/shared_light.h"

enum { SHARED_BROAD, SHARED_GLOSS }; // weights
enum { SHARED_DIRECT = 0, SHARED_INDIRECT = 2, SHARED_CAUSTIC = 4 }; // parts, each in two by weight
_Static_assert(SHARED_CAUSTIC + SHARED_WEIGHTS == SHARED_PARTS, "every part is told");

struct shared_view {
    uint32_t surface; // 1 + number; apart for each count of mirrors
    vec3 n; // on the side that is seen
    rgb broad; // of the light that arrives evenly, reflected
};

bool shared_view_exists(const struct surface *surface); // not of lamps
struct shared_view shared_view_of(const struct surface *surface, vec3 wi, int mirrors); // wi: to where it is seen from
// The broad share of what is reflected from `wo` towards `wi`.
rgb shared_view_share(const struct shared_view *view, const struct surface *surface, vec3 wi, vec3 wo);
