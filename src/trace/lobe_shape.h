// How broadly a BSDF scatters: what the guide and the cache of radiance may do at its surfaces depends on it.
#pragma once

#include "scene/bsdf.h"

struct lobe_shape {
    float smooth; // share of the samples that are no delta; 0 for what transmits
    float broadness; // of those: 1 as broad as a cosine, towards 0 narrow
};
// By samples from one side; of textured lobes the narrowest.
struct lobe_shape lobe_shape_measure(const struct bsdf *bsdf);
