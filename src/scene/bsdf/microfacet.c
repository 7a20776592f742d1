// The Beckmann distribution's transcendental parts: exact masking, and visible normals by inverting the distribution of
// visible slopes (Jakob 2014, "An improved visible normal sampling routine for the Beckmann distribution").
// Mitsuba uses the rational fit of Walter et al. 2007 for the masking (up to 0.35 % off); the exact one is used here so
// that densities integrate to one.
#include "scene/bsdf/microfacet.h"

#define SQRT_PI_F 1.7724538509055160273f

float microfacet_beckmann_g1(float a) {
    if (a > 4.0f) return 1.0f; // lambda < 1e-9
    float lambda = 0.5f * (expf(-a * a) / (a * SQRT_PI_F) - erfcf(a));
    return 1.0f / (1.0f + lambda);
}

// Giles 2012, "Approximating the erfinv function", GPU Computing Gems 2, single precision.
static float erf_inverse(float x) {
    static const float central[9] = {2.81022636e-08f,  3.43273939e-07f, -3.5233877e-06f,
                                     -4.39150654e-06f, 0.00021858087f,  -0.00125372503f,
                                     -0.00417768164f,  0.246640727f,    1.50140941f};
    static const float tail[9] = {-0.000200214257f, 0.000100950558f, 0.00134934322f, -0.00367342844f, 0.00573950773f,
                                  -0.0076224613f,   0.00943887047f,  1.00167406f,    2.83297682f};
    float w = -logf((1.0f - x) * (1.0f + x));
    const float *c = w < 5.0f ? central : tail;
    w = w < 5.0f ? w - 2.5f : sqrtf(w) - 3.0f;
    float p = c[0];
    for (int i = 1; i < 9; ++i) p = p * w + c[i];
    return p * x;
}

// The slope along the plane of incidence that is visible at angle theta, for alpha = 1. With b = erf(slope) the
// unnormalised CDF is C(b) = 1 + b + tan(theta) / sqrt(pi) exp(-slope^2), and C' = 1 - slope tan(theta).
static float visible_slope(float cos_theta, float tan_theta, float u) {
    float cot = 1.0f / tan_theta, high = erff(cot), low = -1.0f;
    float t = tan_theta / SQRT_PI_F, total = 1.0f + high + t * expf(-cot * cot), target = u * total;
    float theta = acosf(cos_theta);
    float fit = 1.0f + theta * (-0.876f + theta * (0.4265f - 0.0594f * theta)); // Jakob's starting point
    float b = high - (1.0f + high) * powf(1.0f - u, fit), slope = 0;
    for (int i = 0; i < 12; ++i) {
        if (!(b > low && b < high)) b = 0.5f * (low + high);
        b = clampf(b, -0.9999999f, 0.9999999f);
        slope = erf_inverse(b);
        float value = 1.0f + b + t * expf(-slope * slope) - target;
        if (fabsf(value) < 1e-5f * total) break;
        if (value > 0)
            high = b;
        else
            low = b;
        b -= value / (1.0f - slope * tan_theta);
    }
    return slope;
}

vec3 microfacet_beckmann_sample(const struct microfacet *d, vec3 v, vec2 u) {
    vec3 s = vec3_normalize((vec3){d->alpha_u * v.x, d->alpha_v * v.y, v.z});
    float sin_theta = sqrtf(s.x * s.x + s.y * s.y), x, y;
    if (sin_theta < 1e-4f * s.z) { // normal incidence: every slope is visible
        float r = sqrtf(-logf(1.0f - u.x));
        x = r * cosf(2.0f * PI_F * u.y);
        y = r * sinf(2.0f * PI_F * u.y);
    } else {
        float along = visible_slope(s.z, sin_theta / s.z, maxf(u.x, 1e-7f));
        float across = erf_inverse(2.0f * maxf(u.y, 1e-7f) - 1.0f);
        float c = s.x / sin_theta, n = s.y / sin_theta;
        x = c * along - n * across;
        y = n * along + c * across;
    }
    return vec3_normalize((vec3){-d->alpha_u * x, -d->alpha_v * y, 1.0f});
}
