// Lamps whose light field is known in closed form: opaque emitting balls with a textured, coloured radiance in clear
// air. A line's radiance is that of the last ball it leaves... seen from outside: the first one a viewer meets.
#pragma once

#include <stdlib.h>
#include <string.h>

#include "luminaire/build.h"
#include "math/sampler.h"
#include "math/warp.h"

struct lamp_ball {
    vec3 center;
    float radius;
    rgb radiance;
    float texture; // amplitude of the variation over the surface, < 1
};

struct lamp {
    struct proxy proxy;
    struct lamp_ball balls[12];
    int count;
};

static inline struct lamp lamp_clear(void) { // eight bulbs of 8 mm in a ring, in a bounding sphere of 300 mm
    struct lamp lamp = {.proxy = {.kind = PROXY_SPHERE, .center = {0.1f, -0.2f, 2}, .radius = 0.3f}, .count = 8};
    for (int i = 0; i < 8; i++) {
        float turn = 2 * PI_F * (float)i / 8;
        lamp.balls[i] =
            (struct lamp_ball){{0.1f + 0.2f * cosf(turn), -0.2f + 0.2f * sinf(turn), 2.0f + 0.03f * (float)(i % 3)},
                               0.008f,
                               {3 + (float)i, 6, 2 + 0.5f * (float)(i % 4)},
                               0.3f};
    }
    return lamp;
}

static inline struct lamp lamp_frosted(void) { // one large ball, strongly textured
    return (struct lamp){.proxy = {.kind = PROXY_SPHERE, .center = {-1, 0.5f, 1}, .radius = 0.5f},
                         .balls = {{{-1, 0.5f, 1}, 0.35f, {2, 1.5f, 1}, 0.7f}},
                         .count = 1};
}

static inline rgb ball_radiance(const struct lamp_ball *ball, vec3 p) {
    vec3 n = vec3_scale(vec3_sub(p, ball->center), 1 / ball->radius);
    float a = 1 + ball->texture * sinf(5 * n.x + 1) * cosf(4 * n.y), b = 1 + ball->texture * sinf(4 * n.z - 2 * n.x);
    return rgb_mul(ball->radiance, (rgb){a, a, b});
}

// The ball where the light of the line (p, w) comes from: the one left last. t of the point along w.
static inline int lamp_hit(const struct lamp *lamp, vec3 p, vec3 w, float after, float *t) {
    int hit = -1;
    *t = after;
    for (int i = 0; i < lamp->count; i++) {
        vec3 d = vec3_sub(p, lamp->balls[i].center);
        float along = vec3_dot(d, w);
        vec3 across = vec3_mad(w, -along, d);
        float half2 = sqrf(lamp->balls[i].radius) - vec3_dot(across, across);
        if (half2 > 0 && -along + sqrtf(half2) > *t) {
            *t = -along + sqrtf(half2);
            hit = i;
        }
    }
    return hit;
}

static inline rgb lamp_radiance(const struct lamp *lamp, vec3 p, vec3 w) {
    float t;
    int hit = lamp_hit(lamp, p, w, -1e30f, &t);
    return hit < 0 ? (rgb){0, 0, 0} : ball_radiance(&lamp->balls[hit], vec3_mad(w, t, p));
}

static inline void store(float to[3], vec3 v) { to[0] = v.x, to[1] = v.y, to[2] = v.z; }
static inline vec3 lamp_center(const struct lamp *lamp) {
    return vec3_make(lamp->proxy.center[0], lamp->proxy.center[1], lamp->proxy.center[2]);
}

// A line by a density that mixes all lines of the bounding sphere with those that pass near a ball. Returns 1 / (p M).
static inline float lamp_line(const struct lamp *lamp, struct sampler *s, vec3 *p, vec3 *w) {
    const float wide = 1.5f, uniform = 0.3f;
    *w = warp_uniform_sphere(sampler_2d(s));
    struct frame frame = frame_from_normal(*w);
    float choice = sampler_1d(s), radius = lamp->proxy.radius, pdf = uniform / (PI_F * sqrf(radius));
    vec2 disk = warp_concentric_disk(sampler_2d(s));
    vec3 center = lamp_center(lamp);
    if (choice >= uniform) {
        int i = (int)((choice - uniform) / (1 - uniform) * (float)lamp->count);
        i = i < lamp->count ? i : lamp->count - 1;
        center = lamp->balls[i].center;
        radius = wide * lamp->balls[i].radius;
    }
    *p = vec3_add(center, vec3_scale(vec3_mad(frame.s, disk.x, vec3_scale(frame.t, disk.y)), radius));
    for (int i = 0; i < lamp->count; i++) {
        vec3 d = vec3_sub(*p, lamp->balls[i].center), across = vec3_mad(*w, -vec3_dot(d, *w), d);
        float r2 = sqrf(wide * lamp->balls[i].radius);
        if (vec3_dot(across, across) <= r2) pdf += (1 - uniform) / ((float)lamp->count * PI_F * r2);
    }
    return 4 * PI_F / (pdf * LINE_MEASURE(lamp->proxy.radius)); // directions: uniform, 1 / (4 pi)
}

static inline void lamp_flux(const struct lamp *lamp, double flux[3]) {
    double sum[3] = {0};
    const int n = 1 << 21;
    for (int i = 0; i < n; i++) {
        struct sampler s = sampler_make(99, 0, (uint64_t)i);
        vec3 p, w;
        double mass = (double)lamp_line(lamp, &s, &p, &w);
        rgb l = lamp_radiance(lamp, p, w);
        sum[0] += mass * (double)l.r, sum[1] += mass * (double)l.g, sum[2] += mass * (double)l.b;
    }
    for (int c = 0; c < 3; c++) flux[c] = sum[c] / n * (double)LINE_MEASURE(lamp->proxy.radius);
}

// One emitted particle; false where another ball absorbs it.
static inline bool lamp_exit(const struct lamp *lamp, struct sampler *s, struct line_exit *exit) {
    int i = (int)(sampler_1d(s) * (float)lamp->count);
    const struct lamp_ball *ball = &lamp->balls[i < lamp->count ? i : 0];
    vec3 n = warp_uniform_sphere(sampler_2d(s)), local = warp_cosine_hemisphere(sampler_2d(s));
    struct frame frame = frame_from_normal(n);
    vec3 p = vec3_mad(n, ball->radius, ball->center), w = frame_world_from_local(&frame, local);
    float t, scale = PI_F * 4 * PI_F * sqrf(ball->radius) * (float)lamp->count;
    if (lamp_hit(lamp, p, w, 1e-4f * lamp->proxy.radius, &t) >= 0) return false;
    rgb l = ball_radiance(ball, p);
    vec3 from = vec3_sub(p, lamp_center(lamp));
    float along = vec3_dot(from, w), half2 = sqrf(lamp->proxy.radius) - vec3_dot(from, from) + along * along;
    store(exit->point, vec3_mad(w, sqrtf(half2) - along, p));
    store(exit->w, w);
    exit->flux[0] = scale * l.r, exit->flux[1] = scale * l.g, exit->flux[2] = scale * l.b;
    return true;
}

enum lamp_data { DATA_CAMERA, DATA_PARTICLES };

// One training batch. DATA_PARTICLES: half exits, half untraced lines.
static inline void lamp_batch(const struct lamp *lamp, enum lamp_data data, float unit, uint64_t step, size_t n,
                              struct line_sample *samples) {
    size_t lines = data == DATA_CAMERA ? n : n / 2, emitted = n - lines;
    for (size_t i = 0; i < n; i++) {
        struct sampler s = sampler_make(17, step, i);
        struct line_sample *sample = &samples[i];
        memset(sample, 0, sizeof *sample);
        if (i < lines) {
            vec3 p, w;
            sample->mass = lamp_line(lamp, &s, &p, &w) / (float)lines;
            store(sample->point, p);
            store(sample->w, w);
            rgb l = data == DATA_CAMERA ? lamp_radiance(lamp, p, w) : (rgb){0, 0, 0};
            sample->target[0] = sample->mass * l.r / unit;
            sample->target[1] = sample->mass * l.g / unit;
            sample->target[2] = sample->mass * l.b / unit;
        } else {
            struct line_exit exit;
            if (!lamp_exit(lamp, &s, &exit)) { // an absorbed particle: a sample without weight
                store(sample->point, lamp_center(lamp));
                sample->w[2] = 1;
                continue;
            }
            memcpy(sample->point, exit.point, sizeof exit.point);
            memcpy(sample->w, exit.w, sizeof exit.w);
            float scale = 1 / ((float)emitted * LINE_MEASURE(lamp->proxy.radius) * unit);
            for (int c = 0; c < 3; c++) sample->target[c] = scale * exit.flux[c];
        }
    }
}
