// roughdielectric: frosted glass, microfacets that reflect and refract (Walter et al. 2007, "Microfacet models for
// refraction through rough surfaces", eq. 20, 21, 41). Visible normals (Heitz and d'Eon 2014), then reflection or
// refraction by the Fresnel term of the facet, so that a sample's weight is G1(wo) times the tint.
// Everything is computed with wi on the upper side: a configuration from below is mirrored at z = 0.
#include "scene/bsdf/bsdf_parts.h"
#include "scene/bsdf/fresnel.h"
#include "scene/bsdf/microfacet.h"

struct roughdielectric {
    struct bsdf base;
    int distribution;
    const struct texture *alpha, *alpha_u, *alpha_v;
    const char *int_ior, *ext_ior;
    const struct texture *specular_reflectance, *specular_transmittance;
    float eta; // inside over outside
};

static enum status roughdielectric_commit(struct bsdf *bsdf, struct commit_context *context, struct error *error) {
    struct roughdielectric *r = (struct roughdielectric *)bsdf;
    if (!r->alpha_u) r->alpha_u = r->alpha;
    if (!r->alpha_v) r->alpha_v = r->alpha;
    enum status status = ior_ratio_parse(&r->eta, r->int_ior, r->ext_ior, context, error);
    if (status == STATUS_OK && fabsf(r->eta - 1.0f) < 1e-4f) {
        return error_at(
            error, context->object->place,
            "int_ior and ext_ior of roughdielectric are equal: nothing refracts; use the bsdf type \"null\" or "
            "two different indices");
    }
    return status;
}

static inline struct microfacet roughdielectric_microfacet(const struct roughdielectric *r, vec2 uv) {
    float alpha_u = texture_eval_scalar(r->alpha_u, uv);
    return microfacet_make(r->distribution, alpha_u,
                           r->alpha_v == r->alpha_u ? alpha_u : texture_eval_scalar(r->alpha_v, uv));
}

// The density of wo given wi without the Fresnel factor; *fresnel and *eta of the configuration. 0 where no facet does
// it.
static inline float roughdielectric_density(const struct roughdielectric *r, const struct microfacet *d, vec3 wi,
                                            vec3 wo, float *fresnel, float *eta) {
    *eta = wi.z > 0 ? r->eta : 1.0f / r->eta;
    *fresnel = 0;
    if (wi.z == 0 || wo.z == 0) return 0;
    if (wi.z < 0) {
        wi.z = -wi.z;
        wo.z = -wo.z;
    }
    float cos_i, cos_t, density = microfacet_scatter_density(d, wi, wo, *eta, &cos_i);
    if (density > 0) *fresnel = fresnel_dielectric(minf(cos_i, 1.0f), *eta, &cos_t);
    return density;
}

static rgb roughdielectric_eval(const struct bsdf *bsdf, const struct bsdf_point *point, vec3 wi, vec3 wo,
                                enum transport transport) {
    const struct roughdielectric *r = (const struct roughdielectric *)bsdf;
    struct microfacet d = roughdielectric_microfacet(r, point->uv);
    float fresnel, eta, density = roughdielectric_density(r, &d, wi, wo, &fresnel, &eta);
    if (density == 0) return rgb_gray(0);
    float value = density * microfacet_g1(&d, (vec3){wo.x, wo.y, fabsf(wo.z)});
    if (wi.z * wo.z > 0) return rgb_scale(texture_eval(r->specular_reflectance, point->uv), value * fresnel);
    if (transport == TRANSPORT_RADIANCE) value /= eta * eta;
    return rgb_scale(texture_eval(r->specular_transmittance, point->uv), value * (1.0f - fresnel));
}

static float roughdielectric_pdf(const struct bsdf *bsdf, const struct bsdf_point *point, vec3 wi, vec3 wo,
                                 enum transport transport) {
    const struct roughdielectric *r = (const struct roughdielectric *)bsdf;
    (void)transport;
    struct microfacet d = roughdielectric_microfacet(r, point->uv);
    float fresnel, eta, density = roughdielectric_density(r, &d, wi, wo, &fresnel, &eta);
    return density * (wi.z * wo.z > 0 ? fresnel : 1.0f - fresnel);
}

static bool roughdielectric_sample(const struct bsdf *bsdf, const struct bsdf_point *point, vec3 wi, vec3 u,
                                   enum transport transport, struct bsdf_sample *sample) {
    const struct roughdielectric *r = (const struct roughdielectric *)bsdf;
    if (wi.z == 0) return false;
    bool below = wi.z < 0;
    float eta = below ? 1.0f / r->eta : r->eta;
    if (below) wi.z = -wi.z;
    struct microfacet d = roughdielectric_microfacet(r, point->uv);
    vec3 m = microfacet_sample(&d, wi, (vec2){u.x, u.y}), wo;
    float cos_i = minf(vec3_dot(wi, m), 1.0f), cos_t, weight = 1;
    if (cos_i <= 0) return false;
    float fresnel = fresnel_dielectric(cos_i, eta, &cos_t);
    float pdf = microfacet_d(&d, m) * microfacet_g1(&d, wi) / wi.z;
    const struct texture *tint;
    if (u.z < fresnel) {
        wo = vec3_mad(m, 2.0f * cos_i, vec3_neg(wi));
        if (wo.z <= 0) return false;
        pdf *= 0.25f * fresnel;
        tint = r->specular_reflectance;
        sample->eta = 1;
    } else {
        float inverse = 1.0f / eta;
        wo = microfacet_refract(wi, m, eta, cos_i, cos_t);
        if (wo.z >= 0) return false;
        pdf *= (1.0f - fresnel) * cos_i * cos_t * sqrf(eta / (cos_i - eta * cos_t));
        tint = r->specular_transmittance;
        sample->eta = eta;
        if (transport == TRANSPORT_RADIANCE) weight = inverse * inverse;
    }
    weight *= microfacet_g1(&d, (vec3){wo.x, wo.y, fabsf(wo.z)});
    sample->wo = below ? direction_flip_z(wo) : wo;
    sample->weight = rgb_scale(texture_eval(tint, point->uv), weight);
    sample->pdf = pdf;
    sample->delta = false;
    return pdf > 0;
}

static rgb roughdielectric_albedo(const struct bsdf *bsdf, vec2 uv) {
    return texture_eval(((const struct roughdielectric *)bsdf)->specular_transmittance, uv);
}

static const struct param roughdielectric_params[] = {
    {"distribution", PARAM_CHOICE, offsetof(struct roughdielectric, distribution), "beckmann",
     .choices = MICROFACET_CHOICES, .help = "shape of the microfacet distribution"},
    {"alpha", PARAM_TEXTURE, offsetof(struct roughdielectric, alpha), "0.1", .max = 1, .unit = "1",
     .help = "roughness: rms slope of the microfacets"},
    {"alpha_u", PARAM_TEXTURE, offsetof(struct roughdielectric, alpha_u), "", .max = 1, .unit = "1",
     .help = "roughness along the tangent, instead of alpha"},
    {"alpha_v", PARAM_TEXTURE, offsetof(struct roughdielectric, alpha_v), "", .max = 1, .unit = "1",
     .help = "roughness along the bitangent, instead of alpha"},
    {"int_ior", PARAM_STRING, offsetof(struct roughdielectric, int_ior), "bk7", .choices = ior_suggestions,
     .help = "index of refraction inside: a number or a name"},
    {"ext_ior", PARAM_STRING, offsetof(struct roughdielectric, ext_ior), "air", .choices = ior_suggestions,
     .help = "index of refraction outside: a number or a name"},
    {"specular_reflectance", PARAM_TEXTURE, offsetof(struct roughdielectric, specular_reflectance), "1", .max = 1,
     .unit = "1", .help = "tint of the reflection; 1 is physical"},
    {"specular_transmittance", PARAM_TEXTURE, offsetof(struct roughdielectric, specular_transmittance), "1", .max = 1,
     .unit = "1", .help = "tint of the refraction; 1 is physical"},
    PARAM_END,
};

const struct bsdf_type bsdf_roughdielectric = {
    .name = "roughdielectric",
    .help = "frosted glass",
    .params = roughdielectric_params,
    .size = sizeof(struct roughdielectric),
    .flags = BSDF_SMOOTH | BSDF_TRANSMISSION,
    .commit = roughdielectric_commit,
    .eval = roughdielectric_eval,
    .pdf = roughdielectric_pdf,
    .sample = roughdielectric_sample,
    .albedo = roughdielectric_albedo,
};
