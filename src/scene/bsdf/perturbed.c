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

// What is left of light from or to `w` about the untilted normal.
static float unshadowed(const struct frame *frame, vec3 w) {
    float cosine2 = frame->n.z * frame->n.z, w2 = maxf(w.z * w.z, 1e-12f);
    float alpha2 = clampf(0.125f * (1 - cosine2) / maxf(cosine2, 1e-12f), 0, 1);
    return 2 / (1 + sqrtf(1 + alpha2 * maxf(1 - w2, 0) / w2));
}

rgb perturbed_eval(const struct bsdf *child, const struct frame *frame, bool shadowing, const struct bsdf_point *point,
                   vec3 wi, vec3 wo, enum transport transport) {
    vec3 light = transport == TRANSPORT_RADIANCE ? wo : wi;
    if (!perturbed_sides(frame, &wi, &wo)) return rgb_gray(0);
    rgb f = bsdf_eval(child, point, wi, wo, transport);
    return shadowing ? rgb_scale(f, unshadowed(frame, light)) : f;
}

float perturbed_pdf(const struct bsdf *child, const struct frame *frame, const struct bsdf_point *point, vec3 wi,
                    vec3 wo, enum transport transport) {
    return perturbed_sides(frame, &wi, &wo) ? bsdf_pdf(child, point, wi, wo, transport) : 0;
}

bool perturbed_sample(const struct bsdf *child, const struct frame *frame, bool shadowing,
                      const struct bsdf_point *point, vec3 wi, vec3 u, enum transport transport,
                      struct bsdf_sample *sample) {
    vec3 tilted = frame_local_from_world(frame, wi);
    if (!(tilted.z * wi.z > 0) || !bsdf_sample(child, point, tilted, u, transport, sample)) return false;
    vec3 wo = frame_world_from_local(frame, sample->wo);
    bool kept = wo.z * sample->wo.z > 0;
    sample->wo = wo;
    vec3 light = transport == TRANSPORT_RADIANCE ? wo : wi;
    if (shadowing) sample->weight = rgb_scale(sample->weight, unshadowed(frame, light));
    return kept;
}
