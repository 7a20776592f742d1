// Orthographic pictures of a lamp's bounding sphere from one direction: by traced lines, by the light field, by the
// hull.
#pragma once

#include "bake/gather.h"
#include "image/image.h"

struct lamp_picture {
    const struct luminaire *luminaire;
    const struct lamp *lamp;
    const struct scene *hull; // of the luminaire (scene_init_hull), or NULL
    vec3 w; // of the light: towards the viewer
    uint64_t stream; // of random numbers; bits 0 to 39 are the pixels'
    size_t samples; // of a pixel
    // Square RGB pictures of one size, black before; surface only where there is a hull.
    struct image *reference, *model, *surface;
};

void lamp_picture_take(const struct lamp_picture *picture);
