// Lines into a lamp as an eye follows them: through clear glass to the first surface that is not. For the baker.
#pragma once

#include "math/sampler.h"
#include "scene/scene.h"

struct line_view {
    struct ray ray; // the last stretch of the line
    struct surface surface; // where it ends
    float weight; // of radiance there on its way out: 1 but in glass
};

// Reflection or refraction is chosen by chance at every glass surface (`glass`: of every shape of the scene). False:
// the line leaves the lamp.
bool trace_line_view(const struct scene *scene, const bool *glass, const struct ray *ray, struct sampler *sampler,
                     struct line_view *view);
