// principled: the material of artists' tools and their exporters, one model from matt paint over lacquer and metal to
// rough glass. Burley 2012, "Physically based shading at Disney" (diffuse part, sheen, clear coat), and 2015,
// "Extending the Disney BRDF to a BSDF with integrated subsurface scattering" (transmission, retro-reflection,
// flatness); where the notes leave a choice, as Mitsuba 3 has made it. Not energy conserving: a white base under a
// gloss can return a little more than it gets. Everything is computed with wi on the upper side: a configuration from
// below is mirrored at z = 0.
#include "math/warp.h"
#include "scene/bsdf/bsdf_parts.h"
#include "scene/bsdf/fresnel.h"
#include "scene/bsdf/microfacet.h"

static const float least_alpha = 1e-3f, least_eta_gap = 1e-3f;
static const float coat_strength = 0.25f, coat_alpha_g = 0.25f, coat_r0 = 0.04f;
static const float least_share = 0.05f; // of samples of the base's gloss: it can be dark from wi and bright elsewhere

struct principled {
    struct bsdf base;
    const struct texture *base_color, *roughness, *anisotropic, *metallic, *spec_trans, *spec_tint;
    const struct texture *sheen, *sheen_tint, *flatness, *clearcoat, *clearcoat_gloss;
    float eta, specular; // eta: inside over outside; specular: another way to give it
};

static enum status principled_commit(struct bsdf *bsdf, struct commit_context *context, struct error *error) {
    struct principled *p = (struct principled *)bsdf;
    const struct property *specular = object_property(context->object, "specular");
    if (p->eta > 0 && specular)
        return error_at(error, specular->place,
                        "principled has both eta and specular: they say the same, leave one out");
    if (!(p->eta > 0)) p->eta = 2 / (1 - sqrtf(0.08f * p->specular)) - 1;
    if (rgb_mean(p->spec_trans->value) > 0) {
        bsdf->flags |= BSDF_TRANSMISSION;
        if (fabsf(p->eta - 1) < least_eta_gap) p->eta = 1 + least_eta_gap; // a facet must have a direction
    }
    return STATUS_OK;
}

// The material at a point, seen from one side.
struct principled_look {
    struct microfacet facets;
    rgb color, tint, half_color; // tint: without its luminance; half_color: of one of two surfaces
    float roughness, metallic, spec_tint, sheen, sheen_tint, flatness, coat, coat_alpha;
    float matt, glass; // shares of the diffuse base and of the transmission
    float eta; // far side over wi's
    bool outside;
};

static struct principled_look principled_look(const struct principled *p, vec2 uv, bool outside) {
    const float roughness = texture_eval_scalar(p->roughness, uv), metallic = texture_eval_scalar(p->metallic, uv);
    const float glass = texture_eval_scalar(p->spec_trans, uv);
    const float aspect = sqrtf(1 - 0.9f * texture_eval_scalar(p->anisotropic, uv)), alpha = roughness * roughness;
    struct principled_look l = {.color = texture_eval(p->base_color, uv), .roughness = roughness, .outside = outside};
    l.facets = microfacet_make(MICROFACET_GGX, maxf(alpha / aspect, least_alpha), maxf(alpha * aspect, least_alpha));
    l.glass = (1 - metallic) * glass;
    l.eta = outside ? p->eta : 1 / p->eta;
    l.half_color = (rgb){sqrtf(l.color.r), sqrtf(l.color.g), sqrtf(l.color.b)};
    if (!outside) return l;
    const float luminance = rgb_luminance(l.color);
    l.tint = luminance > 0 ? rgb_scale(l.color, 1 / luminance) : rgb_gray(1);
    l.metallic = metallic;
    l.matt = (1 - metallic) * (1 - glass);
    l.spec_tint = texture_eval_scalar(p->spec_tint, uv);
    l.sheen = (1 - metallic) * texture_eval_scalar(p->sheen, uv);
    l.sheen_tint = texture_eval_scalar(p->sheen_tint, uv);
    l.flatness = texture_eval_scalar(p->flatness, uv);
    l.coat = coat_strength * texture_eval_scalar(p->clearcoat, uv);
    l.coat_alpha = lerpf(0.1f, 0.001f, texture_eval_scalar(p->clearcoat_gloss, uv));
    return l;
}

static inline rgb rgb_mix(rgb a, rgb b, float t) { return rgb_add(rgb_scale(a, 1 - t), rgb_scale(b, t)); }

// --- Fresnel terms. ---
static inline float schlick_weight(float cosine) {
    const float x = clampf(1 - cosine, 0, 1), x2 = x * x;
    return x2 * x2 * x;
}

// Schlick's approximation from the reflectance at normal incidence; where wi is on the denser side by the angle on the
// other one.
static inline float schlick_cosine(float cos_i, float eta) {
    return eta > 1 ? cos_i : sqrtf(maxf(1 - (1 - cos_i * cos_i) / (eta * eta), 0));
}
static inline rgb schlick(rgb r0, float weight) { return rgb_mix(r0, rgb_gray(1), weight); }

// What a facet reflects and what it lets in, at the angle to the facet.
static void facet_shares(const struct principled_look *l, float cos_i, rgb *reflected, rgb *passed) {
    float cos_t;
    const float dielectric = fresnel_dielectric(cos_i, l->eta, &cos_t);
    *passed = l->glass > 0 ? rgb_scale(l->half_color, l->glass * (1 - dielectric)) : rgb_gray(0);
    if (!l->outside) {
        *reflected = rgb_gray(l->glass * dielectric);
        return;
    }
    const float weight = schlick_weight(schlick_cosine(cos_i, l->eta)), plain = 1 - l->metallic;
    rgb sum = rgb_scale(schlick(l->color, weight), l->metallic);
    if (l->spec_tint > 0) {
        const rgb r0 = rgb_scale(l->tint, sqrf((l->eta - 1) / (l->eta + 1)));
        sum = rgb_add(sum, rgb_scale(schlick(r0, weight), plain * l->spec_tint));
    }
    *reflected = rgb_add(sum, rgb_gray(plain * (1 - l->spec_tint) * dielectric));
}

// --- The clear coat: a distribution with a long tail (Burley 2012, eq. 4, gamma 1). ---
static inline float coat_d(float alpha, float cos_m) {
    const float a2 = alpha * alpha;
    return (a2 - 1) * INV_PI_F / (logf(a2) * (1 + (a2 - 1) * cos_m * cos_m));
}

static inline vec3 coat_normal_sample(float alpha, vec2 u) {
    const float a2 = alpha * alpha, cos2 = (1 - powf(a2, 1 - u.x)) / (1 - a2);
    const float sine = sqrtf(clampf(1 - cos2, 0, 1)), phi = 2 * PI_F * u.y;
    return (vec3){sine * cosf(phi), sine * sinf(phi), sqrtf(clampf(cos2, 0, 1))};
}

// Value times cosine, and the density.
static float coat_both(const struct principled_look *l, vec3 wi, vec3 wo, float *pdf) {
    const vec3 m = vec3_normalize(vec3_add(wi, wo));
    const float cos_i = vec3_dot(wi, m), d = coat_d(l->coat_alpha, m.z);
    *pdf = d * m.z / (4 * cos_i);
    const struct microfacet wide = {MICROFACET_GGX, coat_alpha_g, coat_alpha_g};
    const float masking = microfacet_g1(&wide, wi) * microfacet_g1(&wide, wo);
    const float fresnel = lerpf(coat_r0, 1, schlick_weight(schlick_cosine(cos_i, l->eta)));
    return l->coat * fresnel * d * masking * wo.z;
}

// --- The matt base with its sheen (Burley 2012, section 5.3 and 5.4; 2015, section 4). ---
static rgb matt_value(const struct principled_look *l, vec3 wi, vec3 wo) {
    const float cos_d = vec3_dot(vec3_normalize(vec3_add(wi, wo)), wo);
    const float fi = schlick_weight(wi.z), fo = schlick_weight(wo.z), rr = 2 * l->roughness * cos_d * cos_d;
    float share = (1 - 0.5f * fi) * (1 - 0.5f * fo) + rr * (fi + fo + fi * fo * (rr - 1));
    if (l->flatness > 0) {
        const float ss = lerpf(1, 0.5f * rr, fi) * lerpf(1, 0.5f * rr, fo);
        share = lerpf(share, 1.25f * (ss * (1 / (wi.z + wo.z) - 0.5f) + 0.5f), l->flatness);
    }
    const rgb base = rgb_scale(l->color, l->matt * share * INV_PI_F);
    const rgb sheen = rgb_scale(rgb_mix(rgb_gray(1), l->tint, l->sheen_tint), l->sheen * schlick_weight(cos_d));
    return rgb_scale(rgb_add(base, sheen), wo.z);
}

// --- All of it. ---
struct principled_choice { // probabilities of the parts' samples
    float matt, coat, facets;
};

static struct principled_choice principled_choice(const struct principled_look *l, float cos_i) {
    rgb reflected, passed;
    facet_shares(l, cos_i, &reflected, &passed);
    const float matt = l->matt * rgb_mean(l->color) + 0.1f * l->sheen;
    const float coat = l->coat * lerpf(coat_r0, 1, schlick_weight(cos_i));
    float facets = rgb_mean(rgb_add(reflected, passed));
    if (l->outside) facets = maxf(facets, least_share * (matt + coat));
    const float sum = matt + coat + facets;
    return sum > 0 ? (struct principled_choice){matt / sum, coat / sum, facets / sum} : (struct principled_choice){0};
}

static inline float reflection_share(rgb reflected, rgb passed) {
    const float r = rgb_mean(reflected), t = rgb_mean(passed);
    return r > 0 ? r / (r + t) : 0;
}

// wi.z > 0. Value times cosine and density of a pair of directions.
static rgb principled_both(const struct principled_look *l, vec3 wi, vec3 wo, enum transport transport, float *pdf) {
    const struct principled_choice choice = principled_choice(l, wi.z);
    rgb value = rgb_gray(0), reflected, passed;
    *pdf = 0;
    float cos_m,
        density = wo.z < 0 && !(l->glass > 0) ? 0 : microfacet_scatter_density(&l->facets, wi, wo, l->eta, &cos_m);
    if (density > 0) {
        facet_shares(l, minf(cos_m, 1.0f), &reflected, &passed);
        const float up = reflection_share(reflected, passed);
        *pdf = choice.facets * density * (wo.z > 0 ? up : 1 - up);
        float scale = density * microfacet_g1(&l->facets, (vec3){wo.x, wo.y, fabsf(wo.z)});
        if (wo.z < 0 && transport == TRANSPORT_RADIANCE) scale /= l->eta * l->eta;
        value = rgb_scale(wo.z > 0 ? reflected : passed, scale);
    }
    if (wo.z < 0 || !l->outside) return value;
    *pdf += choice.matt * wo.z * INV_PI_F;
    if (l->matt > 0 || l->sheen > 0) value = rgb_add(value, matt_value(l, wi, wo));
    if (l->coat > 0) {
        float coat_pdf;
        value = rgb_add(value, rgb_gray(coat_both(l, wi, wo, &coat_pdf)));
        *pdf += choice.coat * coat_pdf;
    }
    return value;
}

// As a pair of directions with wi on the upper side. False where nothing scatters from there.
static bool principled_turn(const struct principled *p, vec3 *wi, vec3 *wo) {
    if (wi->z == 0 || (wi->z < 0 && !(p->base.flags & BSDF_TRANSMISSION))) return false;
    if (wi->z > 0) return true;
    *wi = direction_flip_z(*wi);
    *wo = direction_flip_z(*wo);
    return true;
}

static rgb principled_eval(const struct bsdf *bsdf, const struct bsdf_point *point, vec3 wi, vec3 wo,
                           enum transport transport) {
    const struct principled *p = (const struct principled *)bsdf;
    const bool outside = wi.z > 0;
    float pdf;
    if (!principled_turn(p, &wi, &wo) || wo.z == 0) return rgb_gray(0);
    const struct principled_look look = principled_look(p, point->uv, outside);
    return principled_both(&look, wi, wo, transport, &pdf);
}

static float principled_pdf(const struct bsdf *bsdf, const struct bsdf_point *point, vec3 wi, vec3 wo,
                            enum transport transport) {
    const struct principled *p = (const struct principled *)bsdf;
    const bool outside = wi.z > 0;
    float pdf;
    if (!principled_turn(p, &wi, &wo) || wo.z == 0) return 0;
    const struct principled_look look = principled_look(p, point->uv, outside);
    principled_both(&look, wi, wo, transport, &pdf);
    return pdf;
}

// A direction by the facets: u.z, in [0, 1), decides between reflection and refraction.
static bool facets_sample(const struct principled_look *l, vec3 wi, vec3 u, vec3 *wo) {
    const vec3 m = microfacet_sample(&l->facets, wi, (vec2){u.x, u.y});
    const float cos_i = minf(vec3_dot(wi, m), 1.0f);
    if (cos_i <= 0) return false;
    rgb reflected, passed;
    facet_shares(l, cos_i, &reflected, &passed);
    if (u.z < reflection_share(reflected, passed)) {
        *wo = vec3_mad(m, 2 * cos_i, vec3_neg(wi));
        return wo->z > 0;
    }
    float cos_t;
    fresnel_dielectric(cos_i, l->eta, &cos_t);
    *wo = microfacet_refract(wi, m, l->eta, cos_i, cos_t);
    return wo->z < 0;
}

static bool principled_sample(const struct bsdf *bsdf, const struct bsdf_point *point, vec3 wi, vec3 u,
                              enum transport transport, struct bsdf_sample *sample) {
    const struct principled *p = (const struct principled *)bsdf;
    const bool outside = wi.z > 0;
    vec3 wo = {0};
    if (!principled_turn(p, &wi, &wo)) return false;
    const struct principled_look look = principled_look(p, point->uv, outside);
    const struct principled_choice choice = principled_choice(&look, wi.z);
    if (u.z < choice.facets) {
        if (!facets_sample(&look, wi, (vec3){u.x, u.y, minf(u.z / choice.facets, 0x1.fffffep-1f)}, &wo)) return false;
    } else if (u.z < choice.facets + choice.coat) {
        const vec3 m = coat_normal_sample(look.coat_alpha, (vec2){u.x, u.y});
        wo = vec3_mad(m, 2 * vec3_dot(wi, m), vec3_neg(wi));
    } else {
        wo = warp_cosine_hemisphere((vec2){u.x, u.y});
    }
    if (wo.z == 0 || (wo.z < 0 && u.z >= choice.facets)) return false;
    float pdf;
    const rgb value = principled_both(&look, wi, wo, transport, &pdf);
    if (!(pdf > 0)) return false;
    *sample = (struct bsdf_sample){.wo = outside ? wo : direction_flip_z(wo),
                                   .weight = rgb_scale(value, 1 / pdf),
                                   .pdf = pdf,
                                   .eta = wo.z < 0 ? look.eta : 1};
    return true;
}

static rgb principled_albedo(const struct bsdf *bsdf, vec2 uv) {
    return texture_eval(((const struct principled *)bsdf)->base_color, uv);
}

#define SHARE(field, fallback, text)                                                                                   \
    { #field, PARAM_TEXTURE, offsetof(struct principled, field), fallback, .max = 1, .unit = "1", .help = text }
static const struct param principled_params[] = {
    SHARE(base_color, "0.5", "colour of the matt base, of the metal, and of the glass after two surfaces"),
    SHARE(roughness, "0.5", "0 is a mirror, 1 matt: the root of the microfacets' slope"),
    SHARE(anisotropic, "0", "how much the gloss is drawn out along the tangent"),
    SHARE(metallic, "0", "share of metal: its gloss has the base's colour, nothing else is there"),
    SHARE(spec_trans, "0", "share of glass, instead of the matt base"),
    {"eta", PARAM_FLOAT, offsetof(struct principled, eta), "", .min = 1e-3, .max = 10, .unit = "1",
     .help = "index of refraction inside over outside, instead of specular"},
    {"specular", PARAM_FLOAT, offsetof(struct principled, specular), "0.5", .max = 1, .unit = "1",
     .help = "reflectance at normal incidence over 0.08; 0.5 is an index of 1.5"},
    SHARE(spec_tint, "0", "how much the gloss takes the base's colour"),
    SHARE(sheen, "0", "the bright edge of cloth"),
    SHARE(sheen_tint, "0", "how much the sheen takes the base's colour"),
    SHARE(flatness, "0", "how much the base looks like thin skin or wax"),
    SHARE(clearcoat, "0", "a clear coat over all of it"),
    SHARE(clearcoat_gloss, "0", "1 is a mirror-like coat, 0 a satin one"),
    PARAM_END,
};

const struct bsdf_type bsdf_principled = {
    .name = "principled",
    .help = "artists' material, from matt paint over lacquer and metal to rough glass",
    .params = principled_params,
    .size = sizeof(struct principled),
    .flags = BSDF_SMOOTH,
    .commit = principled_commit,
    .eval = principled_eval,
    .pdf = principled_pdf,
    .sample = principled_sample,
    .albedo = principled_albedo,
};
