// roughplastic: a rough coat over a matt base, after Mitsuba's model of that name. What the coat lets pass at each
// angle and what it reflects inside are integrated once, when the material is made.
#include "math/warp.h"
#include "scene/bsdf/bsdf_parts.h"
#include "scene/bsdf/fresnel.h"
#include "scene/bsdf/microfacet.h"

#define TABLE_SIZE 64

struct roughplastic {
    struct bsdf base;
    int distribution;
    float alpha;
    const char *int_ior, *ext_ior;
    const struct texture *diffuse_reflectance, *specular_reflectance;
    bool nonlinear;
    float eta; // inside over outside
    float internal; // diffuse reflectance of the coat from inside
    float specular_tendency; // share of the specular part in the mean reflectances
    float transmittance[TABLE_SIZE]; // from outside, over cosines 0..1
};

// Shares of light that the coat reflects and passes from a direction (eta: far over near side): the mean weights of
// visible normals over a stratified square. What is masked is in neither.
static void coat_integrate(const struct microfacet *d, float cos_i, float eta, double *reflected, double *passed) {
    enum { side = 32 };
    vec3 wi = {sqrtf(1 - cos_i * cos_i), 0, cos_i};
    *reflected = *passed = 0;
    for (int i = 0; i < side * side; ++i) {
        vec2 u = {((float)(i % side) + 0.5f) / side, ((float)(i / side) + 0.5f) / side};
        vec3 m = microfacet_sample(d, wi, u);
        float cos_m = clampf(vec3_dot(wi, m), 0, 1), cos_t, fresnel = fresnel_dielectric(cos_m, eta, &cos_t);
        vec3 up = vec3_mad(m, 2 * cos_m, vec3_neg(wi));
        vec3 down = vec3_mad(m, cos_m / eta - cos_t, vec3_scale(wi, -1 / eta));
        if (up.z > 0) *reflected += (double)(fresnel * microfacet_g1(d, up));
        if (down.z < 0) *passed += (double)((1 - fresnel) * microfacet_g1(d, (vec3){down.x, down.y, -down.z}));
    }
    *reflected /= side * side;
    *passed /= side * side;
}

static enum status roughplastic_commit(struct bsdf *bsdf, struct commit_context *context, struct error *error) {
    struct roughplastic *p = (struct roughplastic *)bsdf;
    enum status status = ior_ratio_parse(&p->eta, p->int_ior, p->ext_ior, context, error);
    if (status != STATUS_OK) return status;
    struct microfacet d = microfacet_make(p->distribution, p->alpha, p->alpha);
    double inside = 0;
    for (int i = 0; i < TABLE_SIZE; ++i) {
        float cos_i = maxf((float)i / (TABLE_SIZE - 1), 1e-6f);
        double reflected, passed, ignored;
        coat_integrate(&d, cos_i, p->eta, &ignored, &passed);
        coat_integrate(&d, cos_i, 1 / p->eta, &reflected, &ignored);
        p->transmittance[i] = (float)passed;
        inside += 2 * (double)cos_i * reflected;
    }
    p->internal = (float)(inside / TABLE_SIZE);
    float diffuse = rgb_mean(p->diffuse_reflectance->value), specular = rgb_mean(p->specular_reflectance->value);
    p->specular_tendency = diffuse + specular > 0 ? specular / (diffuse + specular) : 0;
    return STATUS_OK;
}

static inline float roughplastic_transmittance(const struct roughplastic *p, float cos_i) {
    float x = minf(cos_i, 1.0f) * (TABLE_SIZE - 1);
    int i = x >= TABLE_SIZE - 1 ? TABLE_SIZE - 2 : (int)x;
    return lerpf(p->transmittance[i], p->transmittance[i + 1], x - (float)i);
}

static inline float roughplastic_specular_probability(const struct roughplastic *p, float transmittance) {
    float specular = (1 - transmittance) * p->specular_tendency, diffuse = transmittance * (1 - p->specular_tendency);
    return specular + diffuse > 0 ? specular / (specular + diffuse) : 0;
}

// Value and density of one pair of directions on the upper side.
static rgb roughplastic_both(const struct roughplastic *p, vec2 uv, vec3 wi, vec3 wo, float *pdf) {
    struct microfacet d = microfacet_make(p->distribution, p->alpha, p->alpha);
    vec3 m = vec3_normalize(vec3_add(wi, wo));
    float cos_t, density = microfacet_d(&d, m), specular = 0;
    if (density > 0) {
        density *= microfacet_g1(&d, wi) / (4 * wi.z);
        specular = density * microfacet_g1(&d, wo) * fresnel_dielectric(minf(vec3_dot(wi, m), 1.0f), p->eta, &cos_t);
    }
    float passed = roughplastic_transmittance(p, wi.z), probability = roughplastic_specular_probability(p, passed);
    float base = passed * roughplastic_transmittance(p, wo.z) / (p->eta * p->eta) * wo.z * INV_PI_F;
    *pdf = probability * density + (1 - probability) * wo.z * INV_PI_F;
    rgb diffuse =
        plastic_internal_scattering(texture_eval(p->diffuse_reflectance, uv), p->internal, p->nonlinear, base);
    return rgb_add(rgb_scale(texture_eval(p->specular_reflectance, uv), specular), diffuse);
}

static rgb roughplastic_eval(const struct bsdf *bsdf, const struct bsdf_point *point, vec3 wi, vec3 wo,
                             enum transport transport) {
    float pdf;
    (void)transport;
    if (wi.z <= 0 || wo.z <= 0) return rgb_gray(0);
    return roughplastic_both((const struct roughplastic *)bsdf, point->uv, wi, wo, &pdf);
}

static float roughplastic_pdf(const struct bsdf *bsdf, const struct bsdf_point *point, vec3 wi, vec3 wo,
                              enum transport transport) {
    const struct roughplastic *p = (const struct roughplastic *)bsdf;
    (void)point, (void)transport;
    if (wi.z <= 0 || wo.z <= 0) return 0;
    struct microfacet d = microfacet_make(p->distribution, p->alpha, p->alpha);
    float probability = roughplastic_specular_probability(p, roughplastic_transmittance(p, wi.z));
    float density = microfacet_d(&d, vec3_normalize(vec3_add(wi, wo)));
    if (density > 0) density *= microfacet_g1(&d, wi) / (4 * wi.z);
    return probability * density + (1 - probability) * wo.z * INV_PI_F;
}

static bool roughplastic_sample(const struct bsdf *bsdf, const struct bsdf_point *point, vec3 wi, vec3 u,
                                enum transport transport, struct bsdf_sample *sample) {
    const struct roughplastic *p = (const struct roughplastic *)bsdf;
    (void)transport;
    if (wi.z <= 0) return false;
    vec3 wo;
    if (u.z < roughplastic_specular_probability(p, roughplastic_transmittance(p, wi.z))) {
        struct microfacet d = microfacet_make(p->distribution, p->alpha, p->alpha);
        vec3 m = microfacet_sample(&d, wi, (vec2){u.x, u.y});
        wo = vec3_mad(m, 2 * vec3_dot(wi, m), vec3_neg(wi));
    } else {
        wo = warp_cosine_hemisphere((vec2){u.x, u.y});
    }
    if (wo.z <= 0) return false;
    float pdf;
    rgb value = roughplastic_both(p, point->uv, wi, wo, &pdf);
    if (!(pdf > 0)) return false;
    *sample = (struct bsdf_sample){.wo = wo, .weight = rgb_scale(value, 1 / pdf), .pdf = pdf, .eta = 1};
    return true;
}

static rgb roughplastic_albedo(const struct bsdf *bsdf, vec2 uv) {
    return texture_eval(((const struct roughplastic *)bsdf)->diffuse_reflectance, uv);
}

static const struct param roughplastic_params[] = {
    {"distribution", PARAM_CHOICE, offsetof(struct roughplastic, distribution), "beckmann",
     .choices = MICROFACET_CHOICES, .help = "shape of the microfacet distribution"},
    {"alpha", PARAM_FLOAT, offsetof(struct roughplastic, alpha), "0.1", .max = 1, .unit = "1",
     .help = "roughness of the coat: rms slope of the microfacets"},
    {"diffuse_reflectance", PARAM_TEXTURE, offsetof(struct roughplastic, diffuse_reflectance), "0.5", .max = 1,
     .unit = "1", .help = "reflectance of the matt base"},
    {"specular_reflectance", PARAM_TEXTURE, offsetof(struct roughplastic, specular_reflectance), "1", .max = 1,
     .unit = "1", .help = "tint of the coat's reflection; 1 is physical"},
    {"nonlinear", PARAM_BOOL, offsetof(struct roughplastic, nonlinear), "false",
     .help = "the base's colour deepens with every bounce under the coat"},
    {"int_ior", PARAM_STRING, offsetof(struct roughplastic, int_ior), "polypropylene", .choices = ior_suggestions,
     .help = "index of refraction of the coat: a number or a name"},
    {"ext_ior", PARAM_STRING, offsetof(struct roughplastic, ext_ior), "air", .choices = ior_suggestions,
     .help = "index of refraction outside: a number or a name"},
    PARAM_END,
};

const struct bsdf_type bsdf_roughplastic = {
    .name = "roughplastic",
    .help = "satin plastic: a rough coat over a matt base",
    .params = roughplastic_params,
    .size = sizeof(struct roughplastic),
    .flags = BSDF_SMOOTH,
    .commit = roughplastic_commit,
    .eval = roughplastic_eval,
    .pdf = roughplastic_pdf,
    .sample = roughplastic_sample,
    .albedo = roughplastic_albedo,
};
