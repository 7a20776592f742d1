// diffuse: Lambert's law, on the front side only.
#include "math/warp.h"
#include "scene/bsdf/bsdf_parts.h"

struct diffuse {
    struct bsdf base;
    const struct texture *reflectance;
};

static rgb diffuse_eval(const struct bsdf *bsdf, const struct bsdf_point *point, vec3 wi, vec3 wo,
                        enum transport transport) {
    (void)transport;
    if (wi.z <= 0 || wo.z <= 0) return rgb_gray(0);
    return rgb_scale(texture_eval(((const struct diffuse *)bsdf)->reflectance, point->uv), wo.z * INV_PI_F);
}

static float diffuse_pdf(const struct bsdf *bsdf, const struct bsdf_point *point, vec3 wi, vec3 wo,
                         enum transport transport) {
    (void)bsdf, (void)point, (void)transport;
    return wi.z > 0 && wo.z > 0 ? wo.z * INV_PI_F : 0;
}

static bool diffuse_sample(const struct bsdf *bsdf, const struct bsdf_point *point, vec3 wi, vec3 u,
                           enum transport transport, struct bsdf_sample *sample) {
    (void)transport;
    vec3 wo = warp_cosine_hemisphere((vec2){u.x, u.y});
    if (wi.z <= 0 || wo.z <= 0) return false;
    rgb weight = texture_eval(((const struct diffuse *)bsdf)->reflectance, point->uv);
    *sample = (struct bsdf_sample){.wo = wo, .weight = weight, .pdf = wo.z * INV_PI_F, .eta = 1};
    return true;
}

static rgb diffuse_albedo(const struct bsdf *bsdf, vec2 uv) {
    return texture_eval(((const struct diffuse *)bsdf)->reflectance, uv);
}

static const struct param diffuse_params[] = {
    {"reflectance", PARAM_TEXTURE, offsetof(struct diffuse, reflectance), "0.5", .max = 1, .unit = "1",
     .help = "share of light that is reflected"},
    PARAM_END,
};

const struct bsdf_type bsdf_diffuse = {
    .name = "diffuse",
    .help = "ideally matt surface (Lambert), black from behind",
    .params = diffuse_params,
    .size = sizeof(struct diffuse),
    .flags = BSDF_SMOOTH,
    .eval = diffuse_eval,
    .pdf = diffuse_pdf,
    .sample = diffuse_sample,
    .albedo = diffuse_albedo,
};
