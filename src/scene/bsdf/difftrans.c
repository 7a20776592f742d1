// difftrans: Lambert's law on the other side, as of Mitsuba 0.6: paper, thin cloth, opal foil. What a shade reflects is
// another BSDF beside it, in a mixturebsdf.
#include "math/warp.h"
#include "scene/bsdf/bsdf_parts.h"

struct difftrans {
    struct bsdf base;
    const struct texture *transmittance;
};

static float difftrans_pdf(const struct bsdf *bsdf, const struct bsdf_point *point, vec3 wi, vec3 wo,
                           enum transport transport) {
    (void)bsdf, (void)point, (void)transport;
    return wi.z * wo.z < 0 ? fabsf(wo.z) * INV_PI_F : 0;
}

static rgb difftrans_albedo(const struct bsdf *bsdf, vec2 uv) {
    return texture_eval(((const struct difftrans *)bsdf)->transmittance, uv);
}

static rgb difftrans_eval(const struct bsdf *bsdf, const struct bsdf_point *point, vec3 wi, vec3 wo,
                          enum transport transport) {
    return rgb_scale(difftrans_albedo(bsdf, point->uv), difftrans_pdf(bsdf, point, wi, wo, transport));
}

static bool difftrans_sample(const struct bsdf *bsdf, const struct bsdf_point *point, vec3 wi, vec3 u,
                             enum transport transport, struct bsdf_sample *sample) {
    vec3 wo = warp_cosine_hemisphere((vec2){u.x, u.y});
    if (wi.z > 0) wo.z = -wo.z;
    const float pdf = difftrans_pdf(bsdf, point, wi, wo, transport);
    *sample = (struct bsdf_sample){.wo = wo, .weight = difftrans_albedo(bsdf, point->uv), .pdf = pdf, .eta = 1};
    return pdf > 0;
}

static const struct param difftrans_params[] = {
    {"transmittance", PARAM_TEXTURE, offsetof(struct difftrans, transmittance), "0.5", .max = 1, .unit = "1",
     .help = "share of light that comes out of the other side, from either"},
    PARAM_END,
};

const struct bsdf_type bsdf_difftrans = {
    .name = "difftrans",
    .help = "paper, thin cloth: ideally matt light on the other side, none reflected (Mitsuba 0.6)",
    .params = difftrans_params,
    .size = sizeof(struct difftrans),
    .flags = BSDF_SMOOTH | BSDF_TRANSMISSION,
    .eval = difftrans_eval,
    .pdf = difftrans_pdf,
    .sample = difftrans_sample,
    .albedo = difftrans_albedo,
};
