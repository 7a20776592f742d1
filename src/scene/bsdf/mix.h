// A weighted sum of BSDFs, shared by blendbsdf and mixturebsdf. Weights are >= 0 and sum to at most 1.
#pragma once

#include "scene/bsdf.h"

#define MIX_MAX 8

struct mix {
    const struct bsdf *const *children;
    const float *weights;
    int count;
};

rgb mix_eval(const struct mix *mix, const struct bsdf_point *point, vec3 wi, vec3 wo, enum transport transport);
float mix_pdf(const struct mix *mix, const struct bsdf_point *point, vec3 wi, vec3 wo, enum transport transport);
bool mix_sample(const struct mix *mix, const struct bsdf_point *point, vec3 wi, vec3 u, enum transport transport,
                struct bsdf_sample *sample);
rgb mix_through(const struct mix *mix, const struct bsdf_point *point, vec3 wi);
rgb mix_albedo(const struct mix *mix, vec2 uv);
