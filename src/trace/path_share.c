// Path tracer: what a path tells of the light that pixels share (shared_light.h): what reaches the first surface that
// the camera sees, or sees in a mirror. Apart are what comes from lights, directly or by way of mirrors, and what comes
// from other surfaces, for the patterns of the one are sharper than those of the other; and each in two by how the
// surface reflects it (shared_view.h).
#include "trace/path_state.h"

static const float all_broad = 0.8f; // least broadness of a surface that has no gloss

static void begin(const struct path_tracer *tracer, struct path *path) {
    const struct surface *surface = &path->surface;
    struct path_share *share = &path->share;
    share->view = shared_view_of(surface, vec3_neg(path->ray.direction), path->depth);
    share->state = SHARE_HERE;
    share->glossy = path_lobes_at(tracer, surface).broadness < all_broad;
    const rgb broad = rgb_scale(rgb_mul(path->beta, share->view.broad), path->fork.inverse_share);
    share->samples[share->count++] =
        (struct shared_sample){.surface = share->view.surface,
                               .p = surface->p,
                               .n = share->view.n,
                               .weight = {[SHARED_BROAD] = broad, [SHARED_GLOSS] = path->beta}};
}

static struct shared_sample *last_sample(struct path_share *share) { return &share->samples[share->count - 1]; }

// Of what the surface reflects from a direction.
static rgb broad_share(const struct path *path, vec3 wo) {
    if (!path->share.glossy) return rgb_gray(1);
    return shared_view_share(&path->share.view, &path->surface, vec3_neg(path->ray.direction), wo);
}

static void tell(struct path_share *share, int part, rgb gain, rgb broad) {
    struct shared_sample *sample = last_sample(share);
    rgb *light = &sample->light[part];
    const rgb smooth = rgb_mul(gain, broad);
    light[SHARED_BROAD] = rgb_add(light[SHARED_BROAD], shared_ratio(smooth, sample->weight[SHARED_BROAD]));
    light[SHARED_GLOSS] =
        rgb_add(light[SHARED_GLOSS], shared_ratio(rgb_sub(gain, smooth), sample->weight[SHARED_GLOSS]));
}

void path_share(const struct path_tracer *tracer, struct path_worker *worker) {
    if (!tracer->shared) return;
    for (size_t i = 0; i < worker->active_count; i++) {
        struct path *path = &worker->paths[worker->active[i]];
        struct path_share *share = &path->share;
        if (path->status != PATH_SCATTERS || !(surface_bsdf_flags(&path->surface) & BSDF_SMOOTH)) continue;
        if (share->state == SHARE_LEAVES) {
            tell(share, SHARED_DIRECT, rgb_sub(path->radiance, share->before), share->broad);
            share->state = SHARE_ARRIVED;
            share->before = path->radiance;
        }
        if (share->state == SHARE_HERE) share->state = SHARE_NONE; // it was not scattered there but mirrored
        if (share->state != SHARE_NONE || share->count == SHARED_LAYERS || !path->look) continue;
        if (shared_view_exists(&path->surface)) begin(tracer, path);
    }
}

void path_share_light(const struct path_tracer *tracer, struct path *path, rgb contribution, vec3 direction) {
    if (!tracer->shared || path->share.state != SHARE_HERE) return;
    tell(&path->share, SHARED_DIRECT, contribution, broad_share(path, direction));
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
        tell(share, share->state == SHARE_LEAVES ? SHARED_DIRECT : SHARED_INDIRECT, rgb_sub(radiance, share->before),
             share->broad);
    shared_light_add(tracer->shared, path->pixel, share->samples, share->count);
}
