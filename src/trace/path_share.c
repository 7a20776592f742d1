// Path tracer: what a path tells of the light that pixels share (shared_light.h): what reaches the first surface that
// the camera sees, or sees in a mirror. Apart are what comes from lights, directly or by way of mirrors, and what comes
// from other surfaces, for the patterns of the one are sharper than those of the other; and each in two: what the
// surface would reflect were its BSDF nowhere more than in a direction far from its gloss, divided by its colour, and
// the gloss, which is what is left.
#include "trace/path_state.h"

enum { BROAD_DIRECT, GLOSS_DIRECT, BROAD_INDIRECT, GLOSS_INDIRECT };
_Static_assert(GLOSS_INDIRECT + 1 == SHARED_PARTS, "every part is told");
static const float all_broad = 0.8f; // least broadness of a surface that has no gloss
static const float least_broad = 0.02f; // of the light that arrives evenly, reflected: less is all gloss
static const float aside_cosine = 0.5f, aside_sine = 0.8660254f; // of the direction far from the gloss

// On the side where the light comes from, so far from the mirror direction.
static vec3 aside(vec3 n, vec3 wi) {
    const vec3 along = vec3_mad(n, -vec3_dot(n, wi), wi);
    const float length = vec3_length(along);
    const vec3 unit = length > 1e-4f ? vec3_scale(along, 1 / length) : frame_from_normal(n).s;
    return vec3_mad(unit, aside_sine, vec3_scale(n, aside_cosine));
}

static void begin(const struct path_tracer *tracer, struct path *path) {
    enum { mirrors_told_apart = 8 };
    const struct surface *surface = &path->surface;
    const vec3 wi = vec3_neg(path->ray.direction);
    const vec3 n = vec3_dot(surface->ng, wi) < 0 ? vec3_neg(surface->shading.n) : surface->shading.n;
    const uint32_t mirrors = (uint32_t)path->depth % mirrors_told_apart;
    float pdf;
    rgb broad = rgb_scale(path_response(path, aside(n, wi), &pdf), PI_F / aside_cosine);
    if (!(rgb_luminance(broad) > least_broad)) broad = rgb_gray(0);
    struct path_share *share = &path->share;
    share->state = SHARE_HERE;
    share->glossy = path_lobes_at(tracer, surface).broadness < all_broad;
    share->samples[share->count++] =
        (struct shared_sample){.surface = 1 + mirrors_told_apart * surface->shape->index + mirrors,
                               .p = surface->p,
                               .n = n,
                               .weight = {broad, path->beta, broad, path->beta}};
}

static struct shared_sample *last_sample(struct path_share *share) { return &share->samples[share->count - 1]; }

static rgb ratio(rgb a, rgb b) {
    return (rgb){b.r > 0 ? a.r / b.r : 0, b.g > 0 ? a.g / b.g : 0, b.b > 0 ? a.b / b.b : 0};
}

// Of what the surface reflects from a direction.
static rgb broad_share(struct path *path, vec3 wo) {
    struct path_share *share = &path->share;
    const struct shared_sample *sample = last_sample(share);
    if (!share->glossy) return rgb_gray(1);
    const float cosine = maxf(vec3_dot(sample->n, wo), 0) * INV_PI_F;
    float pdf;
    const rgb part = ratio(rgb_scale(sample->weight[BROAD_DIRECT], cosine), path_response(path, wo, &pdf));
    return (rgb){minf(part.r, 1), minf(part.g, 1), minf(part.b, 1)};
}

static void tell(struct path_share *share, int broad_part, rgb gain, rgb broad) {
    struct shared_sample *sample = last_sample(share);
    rgb *light = &sample->light[broad_part]; // the gloss is next to it
    const rgb smooth = rgb_mul(gain, broad);
    light[0] = rgb_add(light[0], ratio(smooth, sample->weight[broad_part]));
    light[1] = rgb_add(light[1], ratio(rgb_sub(gain, smooth), sample->weight[broad_part + 1]));
}

void path_share(const struct path_tracer *tracer, struct path_worker *worker) {
    if (!tracer->shared) return;
    for (size_t i = 0; i < worker->active_count; i++) {
        struct path *path = &worker->paths[worker->active[i]];
        struct path_share *share = &path->share;
        if (path->status != PATH_SCATTERS || !(surface_bsdf_flags(&path->surface) & BSDF_SMOOTH)) continue;
        if (share->state == SHARE_LEAVES) {
            tell(share, BROAD_DIRECT, rgb_sub(path->radiance, share->before), share->broad);
            share->state = SHARE_ARRIVED;
            share->before = path->radiance;
        }
        if (share->state == SHARE_HERE) share->state = SHARE_NONE; // it was not scattered there but mirrored
        if (share->state != SHARE_NONE || share->count == SHARED_LAYERS || !path->look) continue;
        if (!path->surface.shape->hull && path->surface.shape->luminaire < 0) begin(tracer, path);
    }
}

void path_share_light(const struct path_tracer *tracer, struct path *path, rgb contribution, vec3 direction) {
    if (!tracer->shared || path->share.state != SHARE_HERE) return;
    tell(&path->share, BROAD_DIRECT, contribution, broad_share(path, direction));
}

void path_share_scatter(const struct path_tracer *tracer, struct path *path, const struct bsdf_sample *sample) {
    struct path_share *share = &path->share;
    if (!tracer->shared || share->state != SHARE_HERE || sample->delta) return;
    share->state = SHARE_LEAVES;
    share->before = path->radiance;
    share->broad = broad_share(path, sample->wo);
}

void path_share_end(const struct path_tracer *tracer, struct path *path, rgb radiance) {
    if (!tracer->shared) return;
    struct path_share *share = &path->share;
    if (share->state == SHARE_LEAVES || share->state == SHARE_ARRIVED)
        tell(share, share->state == SHARE_LEAVES ? BROAD_DIRECT : BROAD_INDIRECT, rgb_sub(radiance, share->before),
             share->broad);
    shared_light_add(tracer->shared, path->pixel, share->samples, share->count);
}
