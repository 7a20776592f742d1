// Microfacet distributions over slopes, anisotropic GGX and Beckmann, with Smith's separable shadowing (Walter et al.
// 2007, "Microfacet models for refraction through rough surfaces"; Heitz 2014, "Understanding the masking-shadowing
// function", JCGT 3(2)) and sampling of visible normals. Hot: does no checks. Directions `v` have v.z > 0, normals m.z
// > 0.
#pragma once

#include "math/vec.h"

enum microfacet_kind { MICROFACET_BECKMANN, MICROFACET_GGX };
#define MICROFACET_CHOICES "beckmann|ggx"
#define MICROFACET_ALPHA_MIN 1e-4f // below it a float direction cannot resolve the lobe

struct microfacet {
    enum microfacet_kind kind;
    float alpha_u, alpha_v; // rms-like slopes along x and y, >= MICROFACET_ALPHA_MIN
};

static inline struct microfacet microfacet_make(int kind, float alpha_u, float alpha_v) {
    return (struct microfacet){(enum microfacet_kind)kind, maxf(alpha_u, MICROFACET_ALPHA_MIN),
                               maxf(alpha_v, MICROFACET_ALPHA_MIN)};
}

// Density of normals per area of the mean surface [1/sr]. Written with m.x, m.y, which keep their precision at small
// alpha.
static inline float microfacet_d(const struct microfacet *d, vec3 m) {
    float x = m.x / d->alpha_u, y = m.y / d->alpha_v, z2 = m.z * m.z, r2 = x * x + y * y;
    float scale = INV_PI_F / (d->alpha_u * d->alpha_v);
    if (d->kind == MICROFACET_GGX) return scale / sqrf(r2 + z2);
    return r2 < 80.0f * z2 ? scale * expf(-r2 / z2) / (z2 * z2) : 0.0f; // less than 1e-34 of the peak
}

float microfacet_beckmann_g1(float a); // a = 1 / (alpha tan(theta)) of the direction

// Smith's masking: the visible share of the projected area, without the test for the back side of the facet.
static inline float microfacet_g1(const struct microfacet *d, vec3 v) {
    float r2 = sqrf(d->alpha_u * v.x) + sqrf(d->alpha_v * v.y);
    if (d->kind == MICROFACET_GGX) return 2.0f * v.z / (v.z + sqrtf(v.z * v.z + r2));
    return r2 > 0 ? microfacet_beckmann_g1(v.z / sqrtf(r2)) : 1.0f;
}

vec3 microfacet_beckmann_sample(const struct microfacet *d, vec3 v, vec2 u);

// A normal m visible from v, with density g1(v) d(m) dot(v, m) / v.z.
// GGX: Dupuy and Benyoub 2023, "Sampling visible GGX normals with spherical caps".
static inline vec3 microfacet_sample(const struct microfacet *d, vec3 v, vec2 u) {
    if (d->kind == MICROFACET_BECKMANN) return microfacet_beckmann_sample(d, v, u);
    vec3 s = vec3_normalize((vec3){d->alpha_u * v.x, d->alpha_v * v.y, v.z});
    float phi = 2.0f * PI_F * u.x, rise = (1.0f - u.y) * (1.0f + s.z); // cap height z = rise - s.z
    float z = rise - s.z, r = sqrtf(clampf(1.0f - z * z, 0, 1));
    // The cap's direction plus s; z + s.z is `rise` itself.
    vec3 h = {(r * cosf(phi) + s.x) * d->alpha_u, (r * sinf(phi) + s.y) * d->alpha_v, maxf(rise, 1e-8f)};
    return vec3_normalize(h);
}

// The density of wo given wi by a visible normal, without the choice between reflection and refraction [1/sr]; 0 where
// no facet takes wi (wi.z > 0) to wo. eta: IOR of the far side over the near side; *cos_i: between wi and the facet's
// normal. Walter et al. 2007, eq. 13 to 17.
static inline float microfacet_scatter_density(const struct microfacet *d, vec3 wi, vec3 wo, float eta, float *cos_i) {
    const bool reflects = wo.z > 0;
    vec3 m = vec3_normalize(vec3_mad(wo, reflects ? 1.0f : eta, wi));
    if (m.z < 0) m = vec3_neg(m);
    const float cos_o = vec3_dot(wo, m);
    *cos_i = vec3_dot(wi, m);
    if (!(*cos_i > 0) || (cos_o > 0) != reflects) return 0;
    const float facets = microfacet_d(d, m) * microfacet_g1(d, wi) / wi.z;
    if (reflects) return facets * 0.25f;
    return facets * *cos_i * fabsf(cos_o) * sqrf(eta / (*cos_i + eta * cos_o));
}

// wi refracted by the facet m; cos_i, cos_t: the angles to m on both sides.
static inline vec3 microfacet_refract(vec3 wi, vec3 m, float eta, float cos_i, float cos_t) {
    const float inverse = 1.0f / eta;
    return vec3_mad(m, cos_i * inverse - cos_t, vec3_scale(wi, -inverse));
}
