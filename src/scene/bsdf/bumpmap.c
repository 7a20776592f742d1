// bumpmap: tilts the shading frame by the slope of a height field (Blinn 1978, "Simulation of wrinkled surfaces").
#include "scene/bsdf/perturbed.h"

#define BUMP_STEP (1.0f / 4096) // of uv, for the central differences; about a texel of a large image

struct bumpmap {
    struct bsdf base;
    const struct bsdf *child;
    const struct texture *texture;
    float scale;
    bool shadowing;
};

static enum status bumpmap_commit(struct bsdf *bsdf, struct commit_context *context, struct error *error) {
    (void)context, (void)error;
    bsdf->flags = ((const struct bumpmap *)bsdf)->child->flags | BSDF_BUMP;
    return STATUS_OK;
}

static struct frame bumpmap_frame(const struct bumpmap *b, const struct bsdf_point *point) {
    vec2 uv = point->uv;
    float scale = b->scale / (2 * BUMP_STEP);
    float du = scale * (texture_eval_scalar(b->texture, (vec2){uv.x + BUMP_STEP, uv.y}) -
                        texture_eval_scalar(b->texture, (vec2){uv.x - BUMP_STEP, uv.y}));
    float dv = scale * (texture_eval_scalar(b->texture, (vec2){uv.x, uv.y + BUMP_STEP}) -
                        texture_eval_scalar(b->texture, (vec2){uv.x, uv.y - BUMP_STEP}));
    float dx = du * point->uv_from_local[0].x + dv * point->uv_from_local[0].y; // d(height) / d(local x)
    float dy = du * point->uv_from_local[1].x + dv * point->uv_from_local[1].y;
    return perturbed_frame(vec3_normalize((vec3){-dx, -dy, 1}));
}

static rgb bumpmap_eval(const struct bsdf *bsdf, const struct bsdf_point *point, vec3 wi, vec3 wo,
                        enum transport transport) {
    const struct bumpmap *b = (const struct bumpmap *)bsdf;
    struct frame frame = bumpmap_frame(b, point);
    return perturbed_eval(b->child, &frame, b->shadowing, point, wi, wo, transport);
}

static float bumpmap_pdf(const struct bsdf *bsdf, const struct bsdf_point *point, vec3 wi, vec3 wo,
                         enum transport transport) {
    const struct bumpmap *b = (const struct bumpmap *)bsdf;
    struct frame frame = bumpmap_frame(b, point);
    return perturbed_pdf(b->child, &frame, point, wi, wo, transport);
}

static bool bumpmap_sample(const struct bsdf *bsdf, const struct bsdf_point *point, vec3 wi, vec3 u,
                           enum transport transport, struct bsdf_sample *sample) {
    const struct bumpmap *b = (const struct bumpmap *)bsdf;
    struct frame frame = bumpmap_frame(b, point);
    return perturbed_sample(b->child, &frame, b->shadowing, point, wi, u, transport, sample);
}

static rgb bumpmap_through(const struct bsdf *bsdf, const struct bsdf_point *point, vec3 wi) {
    const struct bumpmap *b = (const struct bumpmap *)bsdf;
    if (!(b->child->flags & BSDF_NULL)) return rgb_gray(0);
    struct frame frame = bumpmap_frame(b, point);
    return bsdf_through(b->child, point, frame_local_from_world(&frame, wi));
}

static rgb bumpmap_albedo(const struct bsdf *bsdf, vec2 uv) {
    return bsdf_albedo(((const struct bumpmap *)bsdf)->child, uv);
}

static const struct param bumpmap_params[] = {
    {"texture", PARAM_TEXTURE, offsetof(struct bumpmap, texture), NULL, .unit = "scene length",
     .help = "height of the surface; the nested texture may have any name"},
    {"scale", PARAM_FLOAT, offsetof(struct bumpmap, scale), "1", .unit = "1", .help = "factor of the height"},
    {"use_shadowing_function", PARAM_BOOL, offsetof(struct bumpmap, shadowing), "true",
     .help = "soft instead of hard edges of the shade"},
    PARAM_END,
};

const struct bsdf_type bsdf_bumpmap = {
    .name = "bumpmap",
    .help = "roughens another bsdf by a height texture",
    .params = bumpmap_params,
    .size = sizeof(struct bumpmap),
    .flags = BSDF_BUMP,
    .min_children = 1,
    .max_children = 1,
    .children_offset = offsetof(struct bumpmap, child),
    .commit = bumpmap_commit,
    .eval = bumpmap_eval,
    .pdf = bumpmap_pdf,
    .sample = bumpmap_sample,
    .through = bumpmap_through,
    .albedo = bumpmap_albedo,
};
