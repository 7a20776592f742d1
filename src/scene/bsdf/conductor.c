// conductor: a smooth metal mirror.
#include "scene/bsdf/bsdf_parts.h"
#include "scene/bsdf/fresnel.h"

struct conductor {
    struct bsdf base;
    const char *material, *ext_eta;
    rgb eta, k;
    const struct texture *specular_reflectance;
};

static enum status conductor_commit(struct bsdf *bsdf, struct commit_context *context, struct error *error) {
    struct conductor *c = (struct conductor *)bsdf;
    return metal_resolve(&c->eta, &c->k, c->material, c->ext_eta, context, error);
}

static rgb conductor_reflectance(const struct conductor *c, vec2 uv, float cos_i) {
    return rgb_mul(fresnel_conductor(cos_i, c->eta, c->k), texture_eval(c->specular_reflectance, uv));
}

static bool conductor_sample(const struct bsdf *bsdf, const struct bsdf_point *point, vec3 wi, vec3 u,
                             enum transport transport, struct bsdf_sample *sample) {
    (void)u, (void)transport;
    if (wi.z <= 0) return false;
    *sample = (struct bsdf_sample){.wo = {-wi.x, -wi.y, wi.z},
                                   .weight = conductor_reflectance((const struct conductor *)bsdf, point->uv, wi.z),
                                   .pdf = 1,
                                   .eta = 1,
                                   .delta = true};
    return true;
}

static rgb conductor_albedo(const struct bsdf *bsdf, vec2 uv) {
    return conductor_reflectance((const struct conductor *)bsdf, uv, 1.0f);
}

static const struct param conductor_params[] = {
    {"material", PARAM_STRING, offsetof(struct conductor, material), "none", .choices = metal_suggestions,
     .help = "name of a metal; none is a perfect mirror"},
    {"eta", PARAM_RGB, offsetof(struct conductor, eta), "", .max = 100, .unit = "1",
     .help = "real part of the index of refraction, instead of material"},
    {"k", PARAM_RGB, offsetof(struct conductor, k), "", .max = 100, .unit = "1",
     .help = "imaginary part of the index of refraction"},
    {"ext_eta", PARAM_STRING, offsetof(struct conductor, ext_eta), "vacuum", .choices = ior_suggestions,
     .alias = "ext_ior", .help = "index of refraction outside: a number or a name"},
    {"specular_reflectance", PARAM_TEXTURE, offsetof(struct conductor, specular_reflectance), "1", .max = 1,
     .unit = "1", .help = "tint of the reflection; 1 is physical"},
    PARAM_END,
};

const struct bsdf_type bsdf_conductor = {
    .name = "conductor",
    .help = "smooth metal, a mirror",
    .params = conductor_params,
    .size = sizeof(struct conductor),
    .flags = BSDF_DELTA,
    .commit = conductor_commit,
    .eval = bsdf_eval_nothing,
    .pdf = bsdf_pdf_nothing,
    .sample = conductor_sample,
    .albedo = conductor_albedo,
};
