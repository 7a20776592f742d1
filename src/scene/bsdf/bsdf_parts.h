// Small things that several BSDFs share.
#pragma once

#include "scene/bsdf.h"

static inline vec3 direction_flip_z(vec3 v) { return (vec3){v.x, v.y, -v.z}; }

// eval and pdf of a BSDF without a smooth part.
rgb bsdf_eval_nothing(const struct bsdf *bsdf, const struct bsdf_point *point, vec3 wi, vec3 wo,
                      enum transport transport);
float bsdf_pdf_nothing(const struct bsdf *bsdf, const struct bsdf_point *point, vec3 wi, vec3 wo,
                       enum transport transport);
