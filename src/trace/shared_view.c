#include "trace/shared_view.h"

static const float least_broad = 0.02f; // less is all gloss
static const float aside_cosine = 0.5f, aside_sine = 0.8660254f; // of the direction far from the gloss

bool shared_view_exists(const struct surface *surface) {
    return !surface->shape->hull && surface->shape->luminaire < 0;
}

// On the side where the light comes from, so far from the mirror direction.
static vec3 aside(vec3 n, vec3 wi) {
    const vec3 along = vec3_mad(n, -vec3_dot(n, wi), wi);
    const float length = vec3_length(along);
    const vec3 unit = length > 1e-4f ? vec3_scale(along, 1 / length) : frame_from_normal(n).s;
    return vec3_mad(unit, aside_sine, vec3_scale(n, aside_cosine));
}

struct shared_view shared_view_of(const struct surface *surface, vec3 wi, int mirrors) {
    enum { mirrors_told_apart = 8 };
    const vec3 n = vec3_dot(surface->ng, wi) < 0 ? vec3_neg(surface->shading.n) : surface->shading.n;
    const rgb response = surface_eval_bsdf(surface, wi, aside(n, wi), TRANSPORT_RADIANCE);
    const rgb broad = rgb_scale(response, PI_F / aside_cosine);
    return (struct shared_view){.surface = 1 + mirrors_told_apart * surface->shape->index +
                                           (uint32_t)mirrors % mirrors_told_apart,
                                .n = n,
                                .broad = rgb_luminance(broad) > least_broad ? broad : rgb_gray(0)};
}

rgb shared_view_share(const struct shared_view *view, const struct surface *surface, vec3 wi, vec3 wo) {
    const float cosine = maxf(vec3_dot(view->n, wo), 0) * INV_PI_F;
    const rgb whole = surface_eval_bsdf(surface, wi, wo, TRANSPORT_RADIANCE);
    const rgb share = shared_ratio(rgb_scale(view->broad, cosine), whole);
    return (rgb){minf(share.r, 1), minf(share.g, 1), minf(share.b, 1)};
}
