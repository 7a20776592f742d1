// Warps of the unit square to directions, disks, triangles and filters: the leaves of every sampling routine.
// Sources: Shirley and Chiu 1997 (concentric disk), Engelhardt and Dachsbacher 2008 (octahedral map), Osada et al. 2002
// (triangle), Giles 2010, "Approximating the erfinv function" (single precision).
#include "math/warp.h"

#include <stddef.h>

static vec3 from_cosine(float cosine, float sine, float u_phi) {
    float phi = 2 * PI_F * u_phi;
    return (vec3){cosf(phi) * sine, sinf(phi) * sine, cosine};
}

vec3 warp_uniform_sphere(vec2 u) {
    float z = 1 - 2 * u.y;
    return from_cosine(z, 2 * sqrtf(maxf(u.y * (1 - u.y), 0)), u.x);
}

float warp_uniform_sphere_pdf(void) { return INV_PI_F / 4; }

vec3 warp_uniform_hemisphere(vec2 u) { return from_cosine(1 - u.y, sqrtf(maxf(u.y * (2 - u.y), 0)), u.x); }

vec3 warp_cosine_hemisphere(vec2 u) {
    vec2 disk = warp_concentric_disk(u);
    // Never exactly in the plane: callers divide by the cosine.
    return (vec3){disk.x, disk.y, sqrtf(maxf(1 - disk.x * disk.x - disk.y * disk.y, 1e-12f))};
}

float warp_cosine_hemisphere_pdf(vec3 w) { return w.z > 0 ? w.z * INV_PI_F : 0; }

// The height below the pole is kept as 1 - cos, which keeps narrow cones exact in float.
vec3 warp_uniform_cone(vec2 u, float cos_max) {
    float depth = u.y * (1 - cos_max);
    return from_cosine(1 - depth, sqrtf(maxf(depth * (2 - depth), 0)), u.x);
}

float warp_uniform_cone_pdf(float cos_max) { return INV_PI_F / (2 * (1 - cos_max)); }

// Sine and cosine by their Taylor series, which at |phi| <= pi / 4 end within half a unit in the last place or so.
vec2 warp_concentric_disk(vec2 u) {
    float a = 2 * u.x - 1, b = 2 * u.y - 1;
    if (a == 0 && b == 0) return (vec2){0, 0};
    bool steep = fabsf(a) <= fabsf(b);
    float radius = steep ? b : a, phi = PI_F / 4 * (steep ? a / b : b / a), x = phi * phi;
    float sine = phi * (1 + x * (-1.0f / 6 + x * (1.0f / 120 + x * (-1.0f / 5040 + x * (1.0f / 362880)))));
    float cosine = 1 + x * (-1.0f / 2 + x * (1.0f / 24 + x * (-1.0f / 720 + x * (1.0f / 40320))));
    return steep ? (vec2){radius * sine, radius * cosine} : (vec2){radius * cosine, radius * sine};
}

vec2 warp_triangle(vec2 u) {
    float root = sqrtf(1 - u.x);
    return (vec2){1 - root, u.y * root};
}

float warp_tent(float u) { return u < 0.5f ? sqrtf(2 * u) - 1 : 1 - sqrtf(maxf(2 - 2 * u, 0)); }

static float polynomial(const float *coefficients, int n, float x) {
    float value = coefficients[0];
    for (int i = 1; i < n; ++i) value = value * x + coefficients[i];
    return value;
}

static float inverse_erf(float x) {
    static const float center[] = {2.81022636e-08f, 3.43273939e-07f, -3.5233877e-06f, -4.39150654e-06f, 0.00021858087f,
                                   -0.00125372503f, -0.00417768164f, 0.246640727f,    1.50140941f};
    static const float tail[] = {-0.000200214257f, 0.000100950558f, 0.00134934322f, -0.00367342844f, 0.00573950773f,
                                 -0.0076224613f,   0.00943887047f,  1.00167406f,    2.83297682f};
    float w = -logf(maxf((1 - x) * (1 + x), 1e-30f));
    return x * (w < 5 ? polynomial(center, 9, w - 2.5f) : polynomial(tail, 9, sqrtf(w) - 3));
}

float warp_gaussian(float u, float stddev, float radius) {
    float edge = erff(radius / (stddev * sqrtf(2)));
    return clampf(stddev * sqrtf(2) * inverse_erf((2 * u - 1) * edge), -radius, radius);
}

vec2 octahedral_from_direction(vec3 w) {
    float scale = 1 / (fabsf(w.x) + fabsf(w.y) + fabsf(w.z));
    float x = w.x * scale, y = w.y * scale;
    if (w.z < 0) {
        float folded = copysignf(1 - fabsf(y), x);
        y = copysignf(1 - fabsf(x), y);
        x = folded;
    }
    return (vec2){clampf(0.5f * x + 0.5f, 0, 1), clampf(0.5f * y + 0.5f, 0, 1)};
}

vec3 direction_from_octahedral(vec2 p) {
    float x = 2 * p.x - 1, y = 2 * p.y - 1, z = 1 - fabsf(x) - fabsf(y);
    if (z < 0) {
        float unfolded = copysignf(1 - fabsf(y), x);
        y = copysignf(1 - fabsf(x), y);
        x = unfolded;
    }
    return vec3_normalize((vec3){x, y, z});
}

static const float table_cone = 0.8f;
static float uniform_sphere_pdf(vec3 w) { return (void)w, warp_uniform_sphere_pdf(); }
static float uniform_hemisphere_pdf(vec3 w) { return w.z >= 0 ? INV_PI_F / 2 : 0; }
static vec3 uniform_cone(vec2 u) { return warp_uniform_cone(u, table_cone); }
static float uniform_cone_pdf(vec3 w) { return w.z >= table_cone ? warp_uniform_cone_pdf(table_cone) : 0; }

// The octahedral map stretches area by dw = 4 |n|_1^3 du dv (the plane |x|+|y|+|z| = 1 seen from the origin).
static float octahedral_pdf(vec3 w) {
    float norm = fabsf(w.x) + fabsf(w.y) + fabsf(w.z);
    return 1 / (4 * norm * norm * norm);
}

const struct warp warp_table[] = {
    {"uniform_sphere", warp_uniform_sphere, uniform_sphere_pdf},
    {"uniform_hemisphere", warp_uniform_hemisphere, uniform_hemisphere_pdf},
    {"cosine_hemisphere", warp_cosine_hemisphere, warp_cosine_hemisphere_pdf},
    {"uniform_cone", uniform_cone, uniform_cone_pdf},
    {"octahedral", direction_from_octahedral, octahedral_pdf},
    {NULL, NULL, NULL},
};
