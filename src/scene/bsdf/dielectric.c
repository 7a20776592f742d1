// dielectric: smooth glass, Snell's law and Fresnel's equations.
#include "scene/bsdf/bsdf_parts.h"
#include "scene/bsdf/fresnel.h"

struct dielectric {
    struct bsdf base;
    const char *int_ior, *ext_ior;
    const struct texture *specular_reflectance, *specular_transmittance;
    float eta; // inside over outside
};

static enum status dielectric_commit(struct bsdf *bsdf, struct commit_context *context, struct error *error) {
    struct dielectric *d = (struct dielectric *)bsdf;
    return ior_ratio_parse(&d->eta, d->int_ior, d->ext_ior, context, error);
}

static bool dielectric_sample(const struct bsdf *bsdf, const struct bsdf_point *point, vec3 wi, vec3 u,
                              enum transport transport, struct bsdf_sample *sample) {
    const struct dielectric *d = (const struct dielectric *)bsdf;
    if (wi.z == 0) return false;
    float eta = wi.z > 0 ? d->eta : 1.0f / d->eta, cos_t;
    float reflectance = fresnel_dielectric(fabsf(wi.z), eta, &cos_t);
    sample->delta = true;
    if (u.z < reflectance) {
        sample->wo = (vec3){-wi.x, -wi.y, wi.z};
        sample->weight = texture_eval(d->specular_reflectance, point->uv);
        sample->pdf = reflectance;
        sample->eta = 1;
    } else {
        float inverse = 1.0f / eta;
        sample->wo = (vec3){-wi.x * inverse, -wi.y * inverse, copysignf(cos_t, -wi.z)};
        sample->weight = texture_eval(d->specular_transmittance, point->uv);
        if (transport == TRANSPORT_RADIANCE) sample->weight = rgb_scale(sample->weight, inverse * inverse);
        sample->pdf = 1.0f - reflectance;
        sample->eta = eta;
    }
    return true;
}

static rgb dielectric_albedo(const struct bsdf *bsdf, vec2 uv) {
    return texture_eval(((const struct dielectric *)bsdf)->specular_transmittance, uv);
}

static const struct param dielectric_params[] = {
    {"int_ior", PARAM_STRING, offsetof(struct dielectric, int_ior), "bk7", .choices = ior_suggestions,
     .help = "index of refraction inside: a number or a name"},
    {"ext_ior", PARAM_STRING, offsetof(struct dielectric, ext_ior), "air", .choices = ior_suggestions,
     .help = "index of refraction outside: a number or a name"},
    {"specular_reflectance", PARAM_TEXTURE, offsetof(struct dielectric, specular_reflectance), "1", .max = 1,
     .unit = "1", .help = "tint of the reflection; 1 is physical"},
    {"specular_transmittance", PARAM_TEXTURE, offsetof(struct dielectric, specular_transmittance), "1", .max = 1,
     .unit = "1", .help = "tint of the refraction; 1 is physical"},
    PARAM_END,
};

const struct bsdf_type bsdf_dielectric = {
    .name = "dielectric",
    .help = "smooth glass, water, crystal: refracts and reflects",
    .params = dielectric_params,
    .size = sizeof(struct dielectric),
    .flags = BSDF_DELTA | BSDF_TRANSMISSION,
    .commit = dielectric_commit,
    .eval = bsdf_eval_nothing,
    .pdf = bsdf_pdf_nothing,
    .sample = dielectric_sample,
    .albedo = dielectric_albedo,
};
