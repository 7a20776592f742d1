// plastic: a smooth coat over a matt base, with the light that bounces between them (the diffuse internal reflectance),
// after Mitsuba's model of that name. The coat is a delta part, the base a smooth one.
#include "math/warp.h"
#include "scene/bsdf/bsdf_parts.h"
#include "scene/bsdf/fresnel.h"

struct plastic {
    struct bsdf base;
    const char *int_ior, *ext_ior;
    const struct texture *diffuse_reflectance, *specular_reflectance;
    bool nonlinear;
    float eta; // inside over outside
    float internal; // diffuse reflectance of the coat from inside
    float specular_tendency; // share of the specular part in the mean reflectances, for the choice of the part
};

static enum status plastic_commit(struct bsdf *bsdf, struct commit_context *context, struct error *error) {
    struct plastic *p = (struct plastic *)bsdf;
    enum status status = ior_ratio_parse(&p->eta, p->int_ior, p->ext_ior, context, error);
    if (status != STATUS_OK) return status;
    p->internal = fresnel_diffuse_reflectance(1.0f / p->eta);
    float diffuse = rgb_mean(p->diffuse_reflectance->value), specular = rgb_mean(p->specular_reflectance->value);
    p->specular_tendency = diffuse + specular > 0 ? specular / (diffuse + specular) : 0;
    return STATUS_OK;
}

// The probability of the specular part, and the coat's reflectance at wi.
static inline float plastic_specular_probability(const struct plastic *p, float cos_i, float *reflectance) {
    float cos_t;
    *reflectance = fresnel_dielectric(cos_i, p->eta, &cos_t);
    float specular = *reflectance * p->specular_tendency, diffuse = (1 - *reflectance) * (1 - p->specular_tendency);
    return specular + diffuse > 0 ? specular / (specular + diffuse) : 0;
}

// f / (1 - reflectance at wi), for unit cos / pi.
static inline rgb plastic_base(const struct plastic *p, vec2 uv, float cos_o) {
    float cos_t, leaving = (1 - fresnel_dielectric(cos_o, p->eta, &cos_t)) / (p->eta * p->eta);
    return plastic_internal_scattering(texture_eval(p->diffuse_reflectance, uv), p->internal, p->nonlinear, leaving);
}

static rgb plastic_eval(const struct bsdf *bsdf, const struct bsdf_point *point, vec3 wi, vec3 wo,
                        enum transport transport) {
    const struct plastic *p = (const struct plastic *)bsdf;
    (void)transport;
    if (wi.z <= 0 || wo.z <= 0) return rgb_gray(0);
    float cos_t, reflectance = fresnel_dielectric(wi.z, p->eta, &cos_t);
    return rgb_scale(plastic_base(p, point->uv, wo.z), (1 - reflectance) * wo.z * INV_PI_F);
}

static float plastic_pdf(const struct bsdf *bsdf, const struct bsdf_point *point, vec3 wi, vec3 wo,
                         enum transport transport) {
    (void)point, (void)transport;
    if (wi.z <= 0 || wo.z <= 0) return 0;
    float reflectance;
    return (1 - plastic_specular_probability((const struct plastic *)bsdf, wi.z, &reflectance)) * wo.z * INV_PI_F;
}

static bool plastic_sample(const struct bsdf *bsdf, const struct bsdf_point *point, vec3 wi, vec3 u,
                           enum transport transport, struct bsdf_sample *sample) {
    const struct plastic *p = (const struct plastic *)bsdf;
    (void)transport;
    if (wi.z <= 0) return false;
    float reflectance, probability = plastic_specular_probability(p, wi.z, &reflectance);
    sample->eta = 1;
    sample->delta = u.z < probability;
    if (sample->delta) {
        sample->wo = (vec3){-wi.x, -wi.y, wi.z};
        sample->weight = rgb_scale(texture_eval(p->specular_reflectance, point->uv), reflectance / probability);
        sample->pdf = probability;
        return true;
    }
    sample->wo = warp_cosine_hemisphere((vec2){u.x, u.y});
    if (sample->wo.z <= 0) return false;
    sample->weight = rgb_scale(plastic_base(p, point->uv, sample->wo.z), (1 - reflectance) / (1 - probability));
    sample->pdf = (1 - probability) * sample->wo.z * INV_PI_F;
    return true;
}

static rgb plastic_albedo(const struct bsdf *bsdf, vec2 uv) {
    return texture_eval(((const struct plastic *)bsdf)->diffuse_reflectance, uv);
}

static const struct param plastic_params[] = {
    {"diffuse_reflectance", PARAM_TEXTURE, offsetof(struct plastic, diffuse_reflectance), "0.5", .max = 1, .unit = "1",
     .help = "reflectance of the matt base"},
    {"specular_reflectance", PARAM_TEXTURE, offsetof(struct plastic, specular_reflectance), "1", .max = 1, .unit = "1",
     .help = "tint of the coat's reflection; 1 is physical"},
    {"nonlinear", PARAM_BOOL, offsetof(struct plastic, nonlinear), "false",
     .help = "the base's colour deepens with every bounce under the coat"},
    {"int_ior", PARAM_STRING, offsetof(struct plastic, int_ior), "polypropylene", .choices = ior_suggestions,
     .help = "index of refraction of the coat: a number or a name"},
    {"ext_ior", PARAM_STRING, offsetof(struct plastic, ext_ior), "air", .choices = ior_suggestions,
     .help = "index of refraction outside: a number or a name"},
    PARAM_END,
};

const struct bsdf_type bsdf_plastic = {
    .name = "plastic",
    .help = "glossy plastic, lacquer: a smooth coat over a matt base",
    .params = plastic_params,
    .size = sizeof(struct plastic),
    .flags = BSDF_SMOOTH | BSDF_DELTA,
    .commit = plastic_commit,
    .eval = plastic_eval,
    .pdf = plastic_pdf,
    .sample = plastic_sample,
    .albedo = plastic_albedo,
};
