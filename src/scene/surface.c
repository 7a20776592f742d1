// Scattering and emission at a surface point in world directions, rays that leave it, and what lies along a segment.
// Sides and the shading-normal correction: Veach 1997, section 5.3; ray offsets: Waechter and Binder 2019, Ray Tracing
// Gems ch. 6. docs/conventions.md defines both.
#include <string.h>

#include "scene/scene.h"
#include "scene/scene_embree.h"

static float float_offset_by(float p, float n) {
    int32_t bits, steps = (int32_t)(256.0f * n);
    memcpy(&bits, &p, sizeof bits);
    bits += p < 0 ? -steps : steps;
    memcpy(&p, &bits, sizeof p);
    return p;
}

static float coordinate_offset(float p, float n) {
    return fabsf(p) < 1.0f / 32 ? p + n * (1.0f / 65536) : float_offset_by(p, n);
}

static vec3 surface_offset_point(const struct surface *surface, vec3 direction) {
    vec3 n = vec3_dot(direction, surface->ng) < 0 ? vec3_neg(surface->ng) : surface->ng, p = surface->p;
    return (vec3){coordinate_offset(p.x, n.x), coordinate_offset(p.y, n.y), coordinate_offset(p.z, n.z)};
}

struct ray surface_spawn_ray(const struct surface *surface, vec3 direction) {
    return (struct ray){surface_offset_point(surface, direction), direction, 0, INFINITY};
}

struct ray surface_spawn_segment(const struct surface *surface, vec3 target, float *distance) {
    vec3 origin = surface_offset_point(surface, vec3_sub(target, surface->p));
    vec3 way = vec3_sub(target, origin);
    *distance = vec3_length(way);
    vec3 direction = *distance > 0 ? vec3_scale(way, 1 / *distance) : surface->ng;
    return (struct ray){origin, direction, 0, *distance * (1 - 1e-4f)};
}

static struct bsdf_point surface_bsdf_point(const struct surface *surface) {
    struct bsdf_point point = {.uv = surface->uv};
    if (!(surface->shape->bsdf->flags & BSDF_BUMP)) return point;
    const struct frame *f = &surface->shading;
    float x_u = vec3_dot(f->s, surface->dp_du), x_v = vec3_dot(f->s, surface->dp_dv);
    float y_u = vec3_dot(f->t, surface->dp_du), y_v = vec3_dot(f->t, surface->dp_dv);
    float determinant = x_u * y_v - x_v * y_u;
    if (determinant != 0 && isfinite(1 / determinant)) {
        point.uv_from_local[0] = (vec2){y_v / determinant, -y_u / determinant};
        point.uv_from_local[1] = (vec2){-x_v / determinant, x_u / determinant};
    }
    return point;
}

// True where w is on the same side of the surface by its geometric and its shading normal.
static bool sides_agree(const struct surface *surface, vec3 w, vec3 local) {
    return vec3_dot(w, surface->ng) * local.z > 0;
}

// Veach's eq. 5.19 with the cosines of f |cos wo| exchanged: |wi.ns| |wo.ng| / (|wi.ng| |wo.ns|).
static float importance_correction(const struct surface *surface, vec3 wi, vec3 local_wi, vec3 wo, vec3 local_wo) {
    return fabsf(local_wi.z * vec3_dot(wo, surface->ng) / (vec3_dot(wi, surface->ng) * local_wo.z));
}

rgb surface_eval_bsdf(const struct surface *surface, vec3 wi, vec3 wo, enum transport transport) {
    vec3 local_wi = frame_local_from_world(&surface->shading, wi),
         local_wo = frame_local_from_world(&surface->shading, wo);
    if (!sides_agree(surface, wi, local_wi) || !sides_agree(surface, wo, local_wo)) return rgb_gray(0);
    struct bsdf_point point = surface_bsdf_point(surface);
    rgb value = bsdf_eval(surface->shape->bsdf, &point, local_wi, local_wo, transport);
    if (transport == TRANSPORT_IMPORTANCE)
        value = rgb_scale(value, importance_correction(surface, wi, local_wi, wo, local_wo));
    return value;
}

float surface_pdf_bsdf(const struct surface *surface, vec3 wi, vec3 wo, enum transport transport) {
    vec3 local_wi = frame_local_from_world(&surface->shading, wi),
         local_wo = frame_local_from_world(&surface->shading, wo);
    if (!sides_agree(surface, wi, local_wi) || !sides_agree(surface, wo, local_wo)) return 0;
    struct bsdf_point point = surface_bsdf_point(surface);
    return bsdf_pdf(surface->shape->bsdf, &point, local_wi, local_wo, transport);
}

rgb surface_eval_pdf_bsdf(const struct surface *surface, vec3 wi, vec3 wo, float *pdf) {
    vec3 local_wi = frame_local_from_world(&surface->shading, wi),
         local_wo = frame_local_from_world(&surface->shading, wo);
    *pdf = 0;
    if (!sides_agree(surface, wi, local_wi) || !sides_agree(surface, wo, local_wo)) return rgb_gray(0);
    struct bsdf_point point = surface_bsdf_point(surface);
    rgb value = bsdf_eval(surface->shape->bsdf, &point, local_wi, local_wo, TRANSPORT_RADIANCE);
    if (!rgb_is_black(value)) *pdf = bsdf_pdf(surface->shape->bsdf, &point, local_wi, local_wo, TRANSPORT_RADIANCE);
    return value;
}

bool surface_sample_bsdf(const struct surface *surface, vec3 wi, vec3 u, enum transport transport,
                         struct bsdf_sample *sample) {
    vec3 local_wi = frame_local_from_world(&surface->shading, wi);
    if (!sides_agree(surface, wi, local_wi)) return false;
    struct bsdf_point point = surface_bsdf_point(surface);
    if (!bsdf_sample(surface->shape->bsdf, &point, local_wi, u, transport, sample)) return false;
    vec3 local_wo = sample->wo;
    sample->wo = vec3_normalize(frame_world_from_local(&surface->shading, local_wo));
    if (!sides_agree(surface, sample->wo, local_wo)) return false;
    if (transport == TRANSPORT_IMPORTANCE)
        sample->weight = rgb_scale(sample->weight, importance_correction(surface, wi, local_wi, sample->wo, local_wo));
    return true;
}

rgb surface_through(const struct surface *surface, vec3 wi) {
    if (!(surface->shape->bsdf->flags & BSDF_NULL)) return rgb_gray(0);
    struct bsdf_point point = surface_bsdf_point(surface);
    return bsdf_through(surface->shape->bsdf, &point, frame_local_from_world(&surface->shading, wi));
}

bool surface_is_hole(const struct surface *surface, vec3 wi) {
    if (!(surface->shape->bsdf->flags & BSDF_NULL)) return false;
    const rgb through = surface_through(surface, wi);
    return through.r >= 1 && through.g >= 1 && through.b >= 1;
}

unsigned surface_bsdf_flags(const struct surface *surface) { return surface->shape->bsdf->flags; }

rgb surface_emission(const struct surface *surface, vec3 w) {
    const struct emitter *emitter = surface->shape->emitter;
    return emitter ? emitter->type->eval(emitter, surface, w) : rgb_gray(0);
}

rgb segment_absorption(const struct surface *from, const struct surface *to, vec3 direction, float distance) {
    const struct shape *medium = NULL;
    if (from && from->shape->has_interior && vec3_dot(direction, from->ng) < 0) medium = from->shape;
    if (to && to->shape->has_interior && vec3_dot(direction, to->ng) > 0) medium = to->shape;
    if (!medium || rgb_is_black(medium->sigma_a)) return rgb_gray(1);
    rgb depth = rgb_scale(medium->sigma_a, -distance);
    return rgb_make(expf(medium->sigma_a.r > 0 ? depth.r : 0), expf(medium->sigma_a.g > 0 ? depth.g : 0),
                    expf(medium->sigma_a.b > 0 ? depth.b : 0));
}

rgb scene_visibility(const struct scene *scene, const struct ray *ray, int ignore_luminaire) {
    if (!embree_scene_occluded(scene->embree, ray, ignore_luminaire)) return rgb_gray(1);
    rgb visibility = rgb_gray(embree_scene_has_through(scene->embree) ? 1 : 0);
    struct ray rest = *ray;
    struct surface surface;
    while (!rgb_is_black(visibility) && scene_intersect(scene, &rest, ignore_luminaire, &surface)) {
        visibility = rgb_mul(visibility, surface_through(&surface, vec3_neg(ray->direction)));
        struct ray next = surface_spawn_ray(&surface, ray->direction);
        next.t_max = rest.t_max - vec3_dot(vec3_sub(next.origin, rest.origin), ray->direction);
        if (!(next.t_max > 0)) break;
        rest = next;
    }
    return visibility;
}
