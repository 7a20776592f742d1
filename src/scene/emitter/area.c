// Light from a surface: the same radiance in all directions of its outside, where the outside is told by both the
// shading and the geometric normal (they differ only on facets that a smooth shading normal turns away). Spheres are
// sampled by their visible cone (Shirley et al. 1996, section 3.2), everything else uniformly by area.
#include "math/warp.h"
#include "scene/emitter.h"
#include "scene/scene.h"
#include "scene/shape/sphere.h"

struct area_emitter {
    struct emitter base;
    const struct texture *radiance;
};

static const struct param area_params[] = {{.name = "radiance",
                                            .type = PARAM_TEXTURE,
                                            .offset = offsetof(struct area_emitter, radiance),
                                            .fallback = "1 1 1",
                                            .min = 0,
                                            .max = 1e30,
                                            .unit = "W m^-2 sr^-1",
                                            .help = "emitted radiance, over uv"},
                                           PARAM_END};

static enum status area_ready(struct emitter *emitter, struct commit_context *context, struct error *error) {
    (void)context, (void)error;
    const struct area_emitter *self = (const struct area_emitter *)emitter;
    emitter->power = rgb_scale(rgb_mul(emitter->factor, self->radiance->value), PI_F * emitter->shape->area);
    return STATUS_OK;
}

static rgb area_eval(const struct emitter *emitter, const struct surface *surface, vec3 w) {
    const struct area_emitter *self = (const struct area_emitter *)emitter;
    bool outside = vec3_dot(w, surface->shading.n) > 0 && vec3_dot(w, surface->ng) > 0;
    return outside ? rgb_mul(emitter->factor, texture_eval(self->radiance, surface->uv)) : rgb_gray(0);
}

// 1 - cos of the cone in which a sphere is seen from p, or 0 where it is sampled by area: from inside and very near.
static float sphere_cone_height(const struct sphere *sphere, vec3 p) {
    double x = (double)p.x - (double)sphere->center.x, y = (double)p.y - (double)sphere->center.y;
    double z = (double)p.z - (double)sphere->center.z, r = (double)sphere->radius, d2 = x * x + y * y + z * z;
    if (d2 < r * r * 1.0001) return 0;
    double sine2 = r * r / d2;
    return (float)(sine2 / (1 + sqrt(1 - sine2)));
}

static const struct sphere *visible_sphere(const struct emitter *emitter, vec3 p, float *height) {
    if (emitter->shape->type != &shape_sphere) return NULL;
    const struct sphere *sphere = (const struct sphere *)emitter->shape;
    *height = sphere_cone_height(sphere, p);
    return *height > 0 ? sphere : NULL;
}

// A point of the visible cap: a direction uniform in the cone, where it meets the sphere, as an angle about the centre.
// `uvs`: whether they matter, for they take most of the time.
static void sample_visible_cap(const struct sphere *sphere, vec3 p, float height, vec2 u, bool uvs,
                               struct surface *surface) {
    double x = (double)p.x - (double)sphere->center.x, y = (double)p.y - (double)sphere->center.y;
    double z = (double)p.z - (double)sphere->center.z, d = sqrt(x * x + y * y + z * z), r = (double)sphere->radius;
    double drop = (double)u.x * (double)height, sine2 = drop * (2 - drop); // drop = 1 - cos of the angle at p
    double cos_alpha = d / r * sine2 + (1 - drop) * sqrt(fmax(0, 1 - d * d / (r * r) * sine2));
    double sin_alpha = sqrt(fmax(0, 1 - cos_alpha * cos_alpha));
    struct frame frame = frame_from_normal(vec3_make((float)(x / d), (float)(y / d), (float)(z / d)));
    float phi = 2 * PI_F * u.y;
    vec3 local = {(float)sin_alpha * cosf(phi), (float)sin_alpha * sinf(phi), (float)cos_alpha};
    vec3 n = frame_world_from_local(&frame, local);
    *surface = (struct surface){.shape = &sphere->base, .p = vec3_mad(n, sphere->radius, sphere->center)};
    if (uvs) {
        sphere->base.type->fill(&sphere->base, u, surface);
    } else {
        surface->ng = sphere->inward ? vec3_neg(n) : n;
        surface->shading = frame_from_normal(surface->ng);
    }
}

static float area_pdf_light(const struct emitter *emitter, vec3 p, const struct surface *surface, vec3 direction) {
    float height;
    if (visible_sphere(emitter, p, &height)) return 1 / (2 * PI_F * height);
    vec3 way = vec3_sub(surface->p, p);
    float cosine = fabsf(vec3_dot(direction, surface->ng));
    return cosine > 0 ? vec3_dot(way, way) / (cosine * emitter->shape->area) : 0;
}

static bool area_sample_light(const struct emitter *emitter, vec3 p, vec2 u, struct light_sample *sample) {
    float height;
    const struct sphere *sphere = visible_sphere(emitter, p, &height);
    if (sphere) {
        bool uvs = ((const struct area_emitter *)emitter)->radiance->type;
        sample_visible_cap(sphere, p, height, u, uvs, &sample->surface);
    } else {
        shape_sample(emitter->shape, u, &sample->surface);
    }
    vec3 way = vec3_sub(sample->surface.p, p);
    sample->distance = vec3_length(way);
    if (!(sample->distance > 0)) return false;
    sample->direction = vec3_scale(way, 1 / sample->distance);
    sample->n = sample->surface.ng;
    sample->radiance = area_eval(emitter, &sample->surface, vec3_neg(sample->direction));
    sample->pdf_sa = area_pdf_light(emitter, p, &sample->surface, sample->direction);
    return sample->pdf_sa > 0 && !rgb_is_black(sample->radiance);
}

static bool area_sample_emission(const struct emitter *emitter, vec2 u_position, vec2 u_direction,
                                 struct emission_sample *sample) {
    struct surface *surface = &sample->surface;
    shape_sample(emitter->shape, u_position, surface);
    vec3 local = warp_cosine_hemisphere(u_direction);
    struct frame frame = frame_from_normal(surface->ng);
    vec3 w = vec3_normalize(frame_world_from_local(&frame, local));
    sample->n = surface->ng;
    sample->cos_theta = vec3_dot(w, surface->ng);
    sample->radiance = area_eval(emitter, surface, w);
    sample->pdf_position = 1 / emitter->shape->area;
    sample->pdf_direction = maxf(sample->cos_theta, 0) * INV_PI_F;
    sample->ray = surface_spawn_ray(surface, w);
    return sample->pdf_direction > 0 && !rgb_is_black(sample->radiance);
}

static void area_pdf_emission(const struct emitter *emitter, const struct surface *surface, vec3 direction,
                              float *pdf_position, float *pdf_direction) {
    *pdf_position = 1 / emitter->shape->area;
    *pdf_direction = maxf(vec3_dot(direction, surface->ng), 0) * INV_PI_F;
}

const struct emitter_type emitter_area = {
    .name = "area",
    .help = "a surface that shines on its outside",
    .params = area_params,
    .size = sizeof(struct area_emitter),
    .needs_shape = true,
    .ready = area_ready,
    .eval = area_eval,
    .sample_light = area_sample_light,
    .pdf_light = area_pdf_light,
    .sample_emission = area_sample_emission,
    .pdf_emission = area_pdf_emission,
};
