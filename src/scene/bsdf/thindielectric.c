// thindielectric: a pane of glass without thickness. Light inside bounces any number of times (Stokes 1862), so the
// pane reflects R' = 2R / (1 + R) and passes the rest straight on: that part is `through`, which shadow rays use too.
#include "scene/bsdf/bsdf_parts.h"
#include "scene/bsdf/fresnel.h"

struct thindielectric {
    struct bsdf base;
    const char *int_ior, *ext_ior;
    const struct texture *specular_reflectance, *specular_transmittance;
    float eta; // inside over outside
};

static enum status thindielectric_commit(struct bsdf *bsdf, struct commit_context *context, struct error *error) {
    struct thindielectric *t = (struct thindielectric *)bsdf;
    return ior_ratio_parse(&t->eta, t->int_ior, t->ext_ior, context, error);
}

static float thindielectric_reflectance(const struct thindielectric *t, vec3 wi) {
    float cos_t, once = fresnel_dielectric(minf(fabsf(wi.z), 1.0f), t->eta, &cos_t);
    return 2.0f * once / (1.0f + once);
}

static rgb thindielectric_through(const struct bsdf *bsdf, const struct bsdf_point *point, vec3 wi) {
    const struct thindielectric *t = (const struct thindielectric *)bsdf;
    return rgb_scale(texture_eval(t->specular_transmittance, point->uv), 1.0f - thindielectric_reflectance(t, wi));
}

static bool thindielectric_sample(const struct bsdf *bsdf, const struct bsdf_point *point, vec3 wi, vec3 u,
                                  enum transport transport, struct bsdf_sample *sample) {
    const struct thindielectric *t = (const struct thindielectric *)bsdf;
    (void)u, (void)transport;
    float reflectance = thindielectric_reflectance(t, wi);
    rgb through = rgb_scale(texture_eval(t->specular_transmittance, point->uv), 1.0f - reflectance);
    rgb reflected = rgb_scale(texture_eval(t->specular_reflectance, point->uv), reflectance);
    *sample = (struct bsdf_sample){
        .wo = {-wi.x, -wi.y, wi.z}, .weight = rgb_divide_rest(reflected, through), .pdf = 1, .eta = 1, .delta = true};
    return reflectance > 0;
}

static rgb thindielectric_albedo(const struct bsdf *bsdf, vec2 uv) {
    return texture_eval(((const struct thindielectric *)bsdf)->specular_transmittance, uv);
}

static const struct param thindielectric_params[] = {
    {"int_ior", PARAM_STRING, offsetof(struct thindielectric, int_ior), "bk7", .choices = ior_suggestions,
     .help = "index of refraction inside: a number or a name"},
    {"ext_ior", PARAM_STRING, offsetof(struct thindielectric, ext_ior), "air", .choices = ior_suggestions,
     .help = "index of refraction outside: a number or a name"},
    {"specular_reflectance", PARAM_TEXTURE, offsetof(struct thindielectric, specular_reflectance), "1", .max = 1,
     .unit = "1", .help = "tint of the reflection; 1 is physical"},
    {"specular_transmittance", PARAM_TEXTURE, offsetof(struct thindielectric, specular_transmittance), "1", .max = 1,
     .unit = "1", .help = "tint of the transmission; 1 is physical"},
    PARAM_END,
};

const struct bsdf_type bsdf_thindielectric = {
    .name = "thindielectric",
    .help = "thin glass pane: reflects, and passes light straight on",
    .params = thindielectric_params,
    .size = sizeof(struct thindielectric),
    .flags = BSDF_DELTA | BSDF_NULL,
    .commit = thindielectric_commit,
    .eval = bsdf_eval_nothing,
    .pdf = bsdf_pdf_nothing,
    .sample = thindielectric_sample,
    .through = thindielectric_through,
    .albedo = thindielectric_albedo,
};
