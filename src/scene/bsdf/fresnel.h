// Fresnel reflectances of smooth interfaces for unpolarised light (Born and Wolf, Principles of Optics, 1.5 and 14.2),
// the indices of refraction of named media, and the indices of named metals. Used by every specular BSDF.
#pragma once

#include "scene/commit.h"
#include "math/vec.h"

// eta: IOR of the far side over the near side; cos_i >= 0. *cos_t >= 0 is the far side's cosine, 0 at total reflection.
static inline float fresnel_dielectric(float cos_i, float eta, float *cos_t) {
    float sin2_t = (1.0f - cos_i * cos_i) / (eta * eta);
    if (sin2_t >= 1.0f) {
        *cos_t = 0;
        return 1;
    }
    float c = sqrtf(1.0f - sin2_t);
    *cos_t = c;
    float s = (cos_i - eta * c) / (cos_i + eta * c), p = (eta * cos_i - c) / (eta * cos_i + c);
    return 0.5f * (s * s + p * p);
}

static inline float fresnel_conductor_channel(float cos_i, float eta, float k) {
    float cos2 = cos_i * cos_i, sin2 = 1.0f - cos2, eta2 = eta * eta, k2 = k * k;
    float t0 = eta2 - k2 - sin2, modulus = sqrtf(t0 * t0 + 4.0f * eta2 * k2); // a^2 + b^2
    float a = sqrtf(fmaxf(0.5f * (modulus + t0), 0.0f));
    float t1 = modulus + cos2, t2 = 2.0f * a * cos_i;
    float t3 = cos2 * modulus + sin2 * sin2, t4 = t2 * sin2;
    float s = (t1 - t2) / (t1 + t2);
    return 0.5f * s * (1.0f + (t3 - t4) / (t3 + t4));
}

// eta and k: the metal's complex index over the index outside.
static inline rgb fresnel_conductor(float cos_i, rgb eta, rgb k) {
    return (rgb){fresnel_conductor_channel(cos_i, eta.r, k.r), fresnel_conductor_channel(cos_i, eta.g, k.g),
                 fresnel_conductor_channel(cos_i, eta.b, k.b)};
}

// The reflectance of an interface under diffuse light, seen from the side that eta (far over near) is taken from.
float fresnel_diffuse_reflectance(float eta);

extern const char ior_suggestions[]; // names, "vacuum|air|...", for the parameters' help
// text: a positive number or a name. Sets *ratio = int_ior / ext_ior.
enum status ior_ratio_parse(float *ratio, const char *int_ior, const char *ext_ior,
                            const struct commit_context *context, struct error *error);

extern const char metal_suggestions[];
// Fills eta and k (zero: not given) from the material's name, and divides by the index outside.
enum status metal_resolve(rgb *eta, rgb *k, const char *material, const char *ext_eta,
                          const struct commit_context *context, struct error *error);
