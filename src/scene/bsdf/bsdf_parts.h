// Small things that several BSDFs share.
#pragma once

#include "scene/bsdf.h"

static inline vec3 direction_flip_z(vec3 v) { return (vec3){v.x, v.y, -v.z}; }

// value / (1 - through) per channel: the weight of scattering given that light did not go through (see bsdf.h).
static inline rgb rgb_divide_rest(rgb value, rgb through) {
    return (rgb){through.r < 1 ? value.r / (1 - through.r) : 0, through.g < 1 ? value.g / (1 - through.g) : 0,
                 through.b < 1 ? value.b / (1 - through.b) : 0};
}

// A matt base under a coat that reflects the share `internal` back down: the sum over all bounces, times `scale`.
// Not nonlinear: the colour is applied once, as Mitsuba does by default.
static inline rgb plastic_internal_scattering(rgb diffuse, float internal, bool nonlinear, float scale) {
    if (!nonlinear) return rgb_scale(diffuse, scale / (1 - internal));
    return (rgb){scale * diffuse.r / (1 - internal * diffuse.r), scale * diffuse.g / (1 - internal * diffuse.g),
                 scale * diffuse.b / (1 - internal * diffuse.b)};
}

// eval and pdf of a BSDF without a smooth part.
rgb bsdf_eval_nothing(const struct bsdf *bsdf, const struct bsdf_point *point, vec3 wi, vec3 wo,
                      enum transport transport);
float bsdf_pdf_nothing(const struct bsdf *bsdf, const struct bsdf_point *point, vec3 wi, vec3 wo,
                       enum transport transport);
