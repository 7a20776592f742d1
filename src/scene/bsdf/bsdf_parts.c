// The empty smooth part of mirrors and smooth glass.
#include "scene/bsdf/bsdf_parts.h"

rgb bsdf_eval_nothing(const struct bsdf *bsdf, const struct bsdf_point *point, vec3 wi, vec3 wo,
                      enum transport transport) {
    (void)bsdf, (void)point, (void)wi, (void)wo, (void)transport;
    return rgb_gray(0);
}

float bsdf_pdf_nothing(const struct bsdf *bsdf, const struct bsdf_point *point, vec3 wi, vec3 wo,
                       enum transport transport) {
    (void)bsdf, (void)point, (void)wi, (void)wo, (void)transport;
    return 0;
}
