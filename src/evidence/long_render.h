// A rendering that may take hours: what is done so far is on disk, and a later call with the same request goes on
// there.
#pragma once

#include "base/error.h"
#include "base/run.h"
#include "format/description.h"
#include "image/image.h"

struct long_render {
    const char *stem; // its files are STEM.exr and STEM.json
    const char *mask; // also make this mask (render/render.h), or NULL
    const char *stage; // for the progress
    const char *scene, *integrator;
    const struct definition *definitions;
    size_t definition_count;
    int width, height;
    uint64_t seed;
    int samples; // per pixel
};

struct long_render_result {
    struct image image; // RGB and variances, as film.h has them; the caller's
    double cpu_s; // of all calls together, without loading
    int samples;
};

// More samples than an earlier call asked for are added to its samples. Anything else that differs (the request, a file
// of the scene, the program's version) begins anew. On STATUS_CANCELLED what is done is kept, and *result is empty.
enum status long_render(const struct long_render *request, const struct run *run, struct long_render_result *result,
                        struct error *error);
