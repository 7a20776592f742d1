// normalmap: tilts the shading frame by a texture of normals in tangent space, (n + 1) / 2, read `raw`.
#include "scene/bsdf/perturbed.h"

struct normalmap {
    struct bsdf base;
    const struct bsdf *child;
    const struct texture *normalmap;
    bool shadowing;
};

static enum status normalmap_commit(struct bsdf *bsdf, struct commit_context *context, struct error *error) {
    (void)context, (void)error;
    bsdf->flags = ((const struct normalmap *)bsdf)->child->flags;
    return STATUS_OK;
}

static struct frame normalmap_frame(const struct normalmap *n, vec2 uv) {
    rgb v = texture_eval(n->normalmap, uv);
    vec3 normal = {2 * v.r - 1, 2 * v.g - 1, 2 * v.b - 1};
    if (normal.z < 0) normal = vec3_neg(normal); // as Mitsuba 3.7 does with invalid normals
    normal.z = maxf(normal.z, 1e-3f);
    return perturbed_frame(vec3_normalize(normal));
}

static rgb normalmap_eval(const struct bsdf *bsdf, const struct bsdf_point *point, vec3 wi, vec3 wo,
                          enum transport transport) {
    const struct normalmap *n = (const struct normalmap *)bsdf;
    struct frame frame = normalmap_frame(n, point->uv);
    return perturbed_eval(n->child, &frame, n->shadowing, point, wi, wo, transport);
}

static float normalmap_pdf(const struct bsdf *bsdf, const struct bsdf_point *point, vec3 wi, vec3 wo,
                           enum transport transport) {
    const struct normalmap *n = (const struct normalmap *)bsdf;
    struct frame frame = normalmap_frame(n, point->uv);
    return perturbed_pdf(n->child, &frame, point, wi, wo, transport);
}

static bool normalmap_sample(const struct bsdf *bsdf, const struct bsdf_point *point, vec3 wi, vec3 u,
                             enum transport transport, struct bsdf_sample *sample) {
    const struct normalmap *n = (const struct normalmap *)bsdf;
    struct frame frame = normalmap_frame(n, point->uv);
    return perturbed_sample(n->child, &frame, n->shadowing, point, wi, u, transport, sample);
}

static rgb normalmap_through(const struct bsdf *bsdf, const struct bsdf_point *point, vec3 wi) {
    const struct normalmap *n = (const struct normalmap *)bsdf;
    if (!(n->child->flags & BSDF_NULL)) return rgb_gray(0);
    struct frame frame = normalmap_frame(n, point->uv);
    return bsdf_through(n->child, point, frame_local_from_world(&frame, wi));
}

static rgb normalmap_albedo(const struct bsdf *bsdf, vec2 uv) {
    return bsdf_albedo(((const struct normalmap *)bsdf)->child, uv);
}

static const struct param normalmap_params[] = {
    {"normalmap", PARAM_TEXTURE, offsetof(struct normalmap, normalmap), NULL,
     .help = "normals in tangent space as (n + 1) / 2; a bitmap with raw = true"},
    {"use_shadowing_function", PARAM_BOOL, offsetof(struct normalmap, shadowing), "true",
     .help = "soft instead of hard edges of the shade"},
    PARAM_END,
};

const struct bsdf_type bsdf_normalmap = {
    .name = "normalmap",
    .help = "tilts another bsdf by a texture of normals",
    .params = normalmap_params,
    .size = sizeof(struct normalmap),
    .min_children = 1,
    .max_children = 1,
    .children_offset = offsetof(struct normalmap, child),
    .commit = normalmap_commit,
    .eval = normalmap_eval,
    .pdf = normalmap_pdf,
    .sample = normalmap_sample,
    .through = normalmap_through,
    .albedo = normalmap_albedo,
};
