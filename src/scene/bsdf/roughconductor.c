// roughconductor: a metal of microscopic mirrors (Cook and Torrance 1982; Walter et al. 2007 with Smith's masking),
// sampled by visible normals (Heitz and d'Eon 2014), so that a sample's weight is F * G1(wo).
#include "scene/bsdf/bsdf_parts.h"
#include "scene/bsdf/fresnel.h"
#include "scene/bsdf/microfacet.h"

struct roughconductor {
    struct bsdf base;
    int distribution;
    const struct texture *alpha, *alpha_u, *alpha_v;
    const char *material, *ext_eta;
    rgb eta, k;
    const struct texture *specular_reflectance;
};

static enum status roughconductor_commit(struct bsdf *bsdf, struct commit_context *context, struct error *error) {
    struct roughconductor *c = (struct roughconductor *)bsdf;
    if (!c->alpha_u) c->alpha_u = c->alpha;
    if (!c->alpha_v) c->alpha_v = c->alpha;
    return metal_resolve(&c->eta, &c->k, c->material, c->ext_eta, context, error);
}

static inline struct microfacet roughconductor_microfacet(const struct roughconductor *c, vec2 uv) {
    float alpha_u = texture_eval_scalar(c->alpha_u, uv);
    return microfacet_make(c->distribution, alpha_u,
                           c->alpha_v == c->alpha_u ? alpha_u : texture_eval_scalar(c->alpha_v, uv));
}

static rgb roughconductor_eval(const struct bsdf *bsdf, const struct bsdf_point *point, vec3 wi, vec3 wo,
                               enum transport transport) {
    const struct roughconductor *c = (const struct roughconductor *)bsdf;
    (void)transport;
    if (wi.z <= 0 || wo.z <= 0) return rgb_gray(0);
    struct microfacet d = roughconductor_microfacet(c, point->uv);
    vec3 m = vec3_normalize(vec3_add(wi, wo));
    float density = microfacet_d(&d, m);
    if (density == 0) return rgb_gray(0);
    rgb fresnel = fresnel_conductor(minf(vec3_dot(wi, m), 1.0f), c->eta, c->k);
    float value = density * microfacet_g1(&d, wi) * microfacet_g1(&d, wo) / (4.0f * wi.z);
    return rgb_scale(rgb_mul(fresnel, texture_eval(c->specular_reflectance, point->uv)), value);
}

static float roughconductor_pdf(const struct bsdf *bsdf, const struct bsdf_point *point, vec3 wi, vec3 wo,
                                enum transport transport) {
    (void)transport;
    if (wi.z <= 0 || wo.z <= 0) return 0;
    struct microfacet d = roughconductor_microfacet((const struct roughconductor *)bsdf, point->uv);
    vec3 m = vec3_normalize(vec3_add(wi, wo));
    float density = microfacet_d(&d, m);
    return density == 0 ? 0 : density * microfacet_g1(&d, wi) / (4.0f * wi.z);
}

static bool roughconductor_sample(const struct bsdf *bsdf, const struct bsdf_point *point, vec3 wi, vec3 u,
                                  enum transport transport, struct bsdf_sample *sample) {
    const struct roughconductor *c = (const struct roughconductor *)bsdf;
    (void)transport;
    if (wi.z <= 0) return false;
    struct microfacet d = roughconductor_microfacet(c, point->uv);
    vec3 m = microfacet_sample(&d, wi, (vec2){u.x, u.y});
    float cos_m = vec3_dot(wi, m);
    vec3 wo = vec3_mad(m, 2.0f * cos_m, vec3_neg(wi));
    if (cos_m <= 0 || wo.z <= 0) return false;
    rgb fresnel = fresnel_conductor(minf(cos_m, 1.0f), c->eta, c->k);
    rgb tint = texture_eval(c->specular_reflectance, point->uv);
    *sample = (struct bsdf_sample){.wo = wo,
                                   .weight = rgb_scale(rgb_mul(fresnel, tint), microfacet_g1(&d, wo)),
                                   .pdf = microfacet_d(&d, m) * microfacet_g1(&d, wi) / (4.0f * wi.z),
                                   .eta = 1};
    return true;
}

static rgb roughconductor_albedo(const struct bsdf *bsdf, vec2 uv) {
    const struct roughconductor *c = (const struct roughconductor *)bsdf;
    return rgb_mul(fresnel_conductor(1.0f, c->eta, c->k), texture_eval(c->specular_reflectance, uv));
}

static const struct param roughconductor_params[] = {
    {"distribution", PARAM_CHOICE, offsetof(struct roughconductor, distribution), "beckmann",
     .choices = MICROFACET_CHOICES, .help = "shape of the microfacet distribution"},
    {"alpha", PARAM_TEXTURE, offsetof(struct roughconductor, alpha), "0.1", .max = 1, .unit = "1",
     .help = "roughness: rms slope of the microfacets"},
    {"alpha_u", PARAM_TEXTURE, offsetof(struct roughconductor, alpha_u), "", .max = 1, .unit = "1",
     .help = "roughness along the tangent, instead of alpha"},
    {"alpha_v", PARAM_TEXTURE, offsetof(struct roughconductor, alpha_v), "", .max = 1, .unit = "1",
     .help = "roughness along the bitangent, instead of alpha"},
    {"material", PARAM_STRING, offsetof(struct roughconductor, material), "none", .choices = metal_suggestions,
     .help = "name of a metal; none is a perfect mirror"},
    {"eta", PARAM_RGB, offsetof(struct roughconductor, eta), "", .max = 100, .unit = "1",
     .help = "real part of the index of refraction, instead of material"},
    {"k", PARAM_RGB, offsetof(struct roughconductor, k), "", .max = 100, .unit = "1",
     .help = "imaginary part of the index of refraction"},
    {"ext_eta", PARAM_STRING, offsetof(struct roughconductor, ext_eta), "vacuum", .choices = ior_suggestions,
     .alias = "ext_ior", .help = "index of refraction outside: a number or a name"},
    {"specular_reflectance", PARAM_TEXTURE, offsetof(struct roughconductor, specular_reflectance), "1", .max = 1,
     .unit = "1", .help = "tint of the reflection; 1 is physical"},
    PARAM_END,
};

const struct bsdf_type bsdf_roughconductor = {
    .name = "roughconductor",
    .help = "rough metal",
    .params = roughconductor_params,
    .size = sizeof(struct roughconductor),
    .flags = BSDF_SMOOTH,
    .commit = roughconductor_commit,
    .eval = roughconductor_eval,
    .pdf = roughconductor_pdf,
    .sample = roughconductor_sample,
    .albedo = roughconductor_albedo,
};
