// For tests that bring a luminaire of their own in place of a baked one: everything but its light. Its proxy is the
// unit sphere and light samples fill the cone under which a point sees it. The including file defines `struct
// luminaire`, stand_in, luminaire_flux, luminaire_eval and luminaire_transmittance; with STAND_IN_HAS_HULL also
// luminaire_hull and luminaire_view, with STAND_IN_SCATTERS luminaire_scattering.
#pragma once

#include "luminaire/group_setting.h"
#include "math/warp.h"

struct luminaire;
static struct luminaire *stand_in(void); // the one that is loaded from whatever file

enum status luminaire_load(struct luminaire **luminaire, const char *path, struct error *error) {
    (void)path, (void)error;
    *luminaire = stand_in();
    return STATUS_OK;
}
void luminaire_destroy(struct luminaire *luminaire) { (void)luminaire; }
size_t luminaire_group_count(const struct luminaire *luminaire) {
    (void)luminaire;
    return 0;
}
const char *luminaire_group(const struct luminaire *luminaire, size_t index, float flux[3]) {
    (void)luminaire, (void)index, (void)flux;
    return NULL;
}
enum status luminaire_dim(struct luminaire **dimmed, const struct luminaire *original, const float (*factors)[3],
                          struct error *error) {
    (void)dimmed, (void)original, (void)factors;
    return error_set(error, STATUS_UNSUPPORTED, "a stand-in cannot be dimmed");
}
enum status luminaire_group_factors(const struct luminaire *luminaire, const char *text, float length,
                                    float factors[LUMINAIRE_MAX_GROUPS][3], struct error *error) {
    (void)luminaire, (void)text, (void)length, (void)factors;
    return error_set(error, STATUS_UNSUPPORTED, "a stand-in cannot be dimmed");
}
const char *luminaire_metadata(const struct luminaire *luminaire, const char *key) {
    (void)luminaire, (void)key;
    return NULL;
}
#ifndef STAND_IN_SCATTERS
void luminaire_scattering(const struct luminaire *luminaire, float back[3], float onward[3]) {
    (void)luminaire;
    for (int c = 0; c < 3; c++) back[c] = onward[c] = 0;
}
#endif
#ifndef STAND_IN_HAS_HULL
const struct hull *luminaire_hull(const struct luminaire *luminaire) {
    (void)luminaire;
    return NULL;
}
void luminaire_view(const struct luminaire *luminaire, size_t n, const struct view_point *points,
                    float (*radiance)[3]) {
    (void)luminaire, (void)n, (void)points, (void)radiance;
}
#endif
size_t luminaire_bytes(const struct luminaire *luminaire) {
    (void)luminaire;
    return 0;
}
void luminaire_bounds(const struct luminaire *luminaire, float center[3], float *radius) {
    (void)luminaire;
    center[0] = center[1] = center[2] = 0;
    *radius = 1;
}
void luminaire_eval_met(const struct luminaire *luminaire, size_t n, const float (*point)[3], const float (*w)[3],
                        float (*radiance)[3]) {
    luminaire_eval(luminaire, n, point, w, radiance);
}
void luminaire_transmittance_met(const struct luminaire *luminaire, size_t n, const float (*point)[3],
                                 const float (*w)[3], float (*transmittance)[3]) {
    luminaire_transmittance(luminaire, n, point, w, transmittance);
}
int luminaire_seen(const struct luminaire *luminaire, const float point[3], const float w[3]) {
    (void)luminaire, (void)point, (void)w;
    return 1;
}
static inline bool sphere_span(vec3 origin, vec3 direction, vec3 center, float radius, float *t_near, float *t_far) {
    vec3 p = vec3_sub(origin, center);
    double b = vec3_dot(p, direction), c = vec3_dot(p, p) - radius * radius, discriminant = b * b - c;
    if (discriminant <= 0) return false;
    *t_near = (float)(-b - sqrt(discriminant));
    *t_far = (float)(-b + sqrt(discriminant));
    return true;
}

int luminaire_span(const struct luminaire *luminaire, const float origin[3], const float direction[3], float *t_near,
                   float *t_far) {
    (void)luminaire;
    return sphere_span(vec3_from(origin), vec3_from(direction), (vec3){0, 0, 0}, 1, t_near, t_far);
}

static inline float line_distance(const float point[3], const float w[3]) { // from the centre
    vec3 p = vec3_from(point), d = vec3_from(w);
    return vec3_length(vec3_mad(d, -vec3_dot(p, d), p));
}

static float cone_cos(vec3 s) { // of the proxy's cone; -1 inside
    float d2 = vec3_dot(s, s);
    return d2 <= 1.0001f ? -1 : sqrtf(1 - 1 / d2);
}

void luminaire_sample(const struct luminaire *luminaire, size_t n, const float (*s)[3], const float (*u)[3],
                      float (*direction)[3], float *pdf_sa) {
    (void)luminaire;
    for (size_t i = 0; i < n; i++) {
        float cos_max = cone_cos(vec3_from(s[i]));
        struct frame frame = frame_from_normal(vec3_normalize(vec3_neg(vec3_from(s[i]))));
        vec3 w = frame_world_from_local(&frame, warp_uniform_cone((vec2){u[i][0], u[i][1]}, cos_max));
        direction[i][0] = w.x;
        direction[i][1] = w.y;
        direction[i][2] = w.z;
        pdf_sa[i] = 1 / (2 * PI_F * (1 - cos_max));
    }
}

void luminaire_pdf(const struct luminaire *luminaire, size_t n, const float (*s)[3], const float (*direction)[3],
                   float *pdf_sa) {
    (void)luminaire;
    for (size_t i = 0; i < n; i++) {
        vec3 p = vec3_from(s[i]);
        float cos_max = cone_cos(p), cos_theta = vec3_dot(vec3_normalize(vec3_neg(p)), vec3_from(direction[i]));
        pdf_sa[i] = cos_theta >= cos_max - 1e-6f ? 1 / (2 * PI_F * (1 - cos_max)) : 0;
    }
}
