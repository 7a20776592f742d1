// Vectors, linear Rec. 709 colours and orthonormal frames. All angles in radians.
#pragma once

#include <math.h>
#include <stdbool.h>

#define PI_F 3.14159265358979323846f
#define INV_PI_F 0.31830988618379067154f

typedef struct {
    float x, y;
} vec2;
typedef struct {
    float x, y, z;
} vec3;
typedef struct {
    float r, g, b;
} rgb; // linear Rec. 709

// One instruction each, which fminf and fmaxf are not for their care with NaN: with a NaN the result is b.
static inline float minf(float a, float b) { return a < b ? a : b; }
static inline float maxf(float a, float b) { return a > b ? a : b; }
static inline int mini(int a, int b) { return a < b ? a : b; }
static inline int maxi(int a, int b) { return a > b ? a : b; }

static inline vec3 vec3_make(float x, float y, float z) { return (vec3){x, y, z}; }
static inline vec3 vec3_add(vec3 a, vec3 b) { return (vec3){a.x + b.x, a.y + b.y, a.z + b.z}; }
static inline vec3 vec3_sub(vec3 a, vec3 b) { return (vec3){a.x - b.x, a.y - b.y, a.z - b.z}; }
static inline vec3 vec3_mul(vec3 a, vec3 b) { return (vec3){a.x * b.x, a.y * b.y, a.z * b.z}; }
static inline vec3 vec3_scale(vec3 a, float s) { return (vec3){a.x * s, a.y * s, a.z * s}; }
static inline vec3 vec3_neg(vec3 a) { return (vec3){-a.x, -a.y, -a.z}; }
static inline vec3 vec3_mad(vec3 a, float s, vec3 b) { return (vec3){a.x * s + b.x, a.y * s + b.y, a.z * s + b.z}; }
static inline float vec3_dot(vec3 a, vec3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
static inline vec3 vec3_cross(vec3 a, vec3 b) {
    return (vec3){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
static inline float vec3_length(vec3 a) { return sqrtf(vec3_dot(a, a)); }
static inline vec3 vec3_normalize(vec3 a) { return vec3_scale(a, 1.0f / vec3_length(a)); }
static inline vec3 vec3_from(const float v[3]) { return (vec3){v[0], v[1], v[2]}; }
static inline void vec3_store(float to[3], vec3 v) { to[0] = v.x, to[1] = v.y, to[2] = v.z; }
static inline bool vec3_is_finite(vec3 a) { return isfinite(a.x) && isfinite(a.y) && isfinite(a.z); }

static inline rgb rgb_make(float r, float g, float b) { return (rgb){r, g, b}; }
static inline rgb rgb_gray(float v) { return (rgb){v, v, v}; }
static inline rgb rgb_add(rgb a, rgb b) { return (rgb){a.r + b.r, a.g + b.g, a.b + b.b}; }
static inline rgb rgb_sub(rgb a, rgb b) { return (rgb){a.r - b.r, a.g - b.g, a.b - b.b}; }
static inline rgb rgb_mul(rgb a, rgb b) { return (rgb){a.r * b.r, a.g * b.g, a.b * b.b}; }
static inline rgb rgb_scale(rgb a, float s) { return (rgb){a.r * s, a.g * s, a.b * s}; }
static inline float rgb_max(rgb a) { return maxf(a.r, maxf(a.g, a.b)); }
static inline float rgb_mean(rgb a) { return (a.r + a.g + a.b) * (1.0f / 3.0f); }
static inline float rgb_luminance(rgb a) { return 0.212671f * a.r + 0.715160f * a.g + 0.072169f * a.b; }
static inline bool rgb_is_black(rgb a) { return a.r == 0 && a.g == 0 && a.b == 0; }
static inline bool rgb_is_finite(rgb a) { return isfinite(a.r) && isfinite(a.g) && isfinite(a.b); }

static inline float clampf(float v, float lo, float hi) { return v < lo ? lo : v > hi ? hi : v; }
static inline float lerpf(float a, float b, float t) { return a + (b - a) * t; }
static inline float sqrf(float v) { return v * v; }

// Orthonormal, right-handed; local z is n.
struct frame {
    vec3 s, t, n;
};

// Duff et al. 2017, "Building an Orthonormal Basis, Revisited", JCGT 6(1).
static inline struct frame frame_from_normal(vec3 n) {
    float sign = copysignf(1.0f, n.z);
    float a = -1.0f / (sign + n.z), b = n.x * n.y * a;
    return (struct frame){{1 + sign * n.x * n.x * a, sign * b, -sign * n.x}, {b, sign + n.y * n.y * a, -n.y}, n};
}
static inline vec3 frame_world_from_local(const struct frame *f, vec3 v) {
    return vec3_mad(f->s, v.x, vec3_mad(f->t, v.y, vec3_scale(f->n, v.z)));
}
static inline vec3 frame_local_from_world(const struct frame *f, vec3 v) {
    return (vec3){vec3_dot(v, f->s), vec3_dot(v, f->t), vec3_dot(v, f->n)};
}
