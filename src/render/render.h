// Rendering a scene file to an image file: the loop over passes.
#pragma once

#include "base/error.h"
#include "base/run.h"
#include "scene/scene.h"

struct render_options {
    const char *output;
    int samples; // 0: the scene's
    double seconds; // > 0: passes until this wall time is over
    double cpu_seconds; // > 0: the same of CPU time, for comparisons
    float exposure; // of a PNG; 0: automatic
    const char *mask; // path of the mask to write, or NULL
    const char *png; // path of a picture to write beside the output, or NULL
};

struct render_result {
    int width, height, samples;
    double wall_s, cpu_s;
    float mean[3];
};

// Renders the committed scene with its integrator. On cancellation the passes so far are written and STATUS_CANCELLED
// returned (with fewer than one pass nothing is written).
enum status render_scene(const struct scene *scene, const struct render_options *options, const struct run *run,
                         struct render_result *result, struct error *error);
// 1 where the camera sees no baked lamp, directly or after mirror reflections; 0 elsewhere.
enum status render_mask(const struct scene *scene, const char *path, const struct run *run, struct error *error);
