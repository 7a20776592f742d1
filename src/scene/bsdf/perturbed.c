// Scattering in a tilted frame, see perturbed.h.
#include "scene/bsdf/perturbed.h"

struct frame perturbed_frame(vec3 n) {
    vec3 s = vec3_normalize((vec3){1 - n.x * n.x, -n.x * n.y, -n.x * n.z}); // x axis less its part along n
    return (struct frame){s, vec3_cross(n, s), n};
}

// True where both directions keep their sides.
static bool perturbed_sides(const struct frame *frame, vec3 *wi, vec3 *wo) {
    vec3 i = frame_local_from_world(frame, *wi), o = frame_local_from_world(frame, *wo);
    bool kept = i.z * wi->z > 0 && o.z * wo->z > 0;
    *wi = i;
    *wo = o;
    return kept;
}

rgb perturbed_eval(const struct bsdf *child, const struct frame *frame, const struct bsdf_point *point, vec3 wi,
                   vec3 wo, enum transport transport) {
    return perturbed_sides(frame, &wi, &wo) ? bsdf_eval(child, point, wi, wo, transport) : rgb_gray(0);
}

float perturbed_pdf(const struct bsdf *child, const struct frame *frame, const struct bsdf_point *point, vec3 wi,
                    vec3 wo, enum transport transport) {
    return perturbed_sides(frame, &wi, &wo) ? bsdf_pdf(child, point, wi, wo, transport) : 0;
}

bool perturbed_sample(const struct bsdf *child, const struct frame *frame, const struct bsdf_point *point, vec3 wi,
                      vec3 u, enum transport transport, struct bsdf_sample *sample) {
    vec3 tilted = frame_local_from_world(frame, wi);
    if (!(tilted.z * wi.z > 0) || !bsdf_sample(child, point, tilted, u, transport, sample)) return false;
    vec3 wo = frame_world_from_local(frame, sample->wo);
    bool kept = wo.z * sample->wo.z > 0;
    sample->wo = wo;
    return kept;
}
