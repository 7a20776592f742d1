// blendbsdf: the first child where the weight is 0, the second where it is 1.
#include "scene/bsdf/mix.h"

struct blend {
    struct bsdf base;
    const struct bsdf *children[2];
    const struct texture *weight;
};

static enum status blend_commit(struct bsdf *bsdf, struct commit_context *context, struct error *error) {
    const struct blend *b = (const struct blend *)bsdf;
    (void)context, (void)error;
    bsdf->flags = b->children[0]->flags | b->children[1]->flags;
    return STATUS_OK;
}

static inline struct mix blend_mix(const struct bsdf *bsdf, vec2 uv, float weights[2]) {
    const struct blend *b = (const struct blend *)bsdf;
    weights[1] = clampf(texture_eval_scalar(b->weight, uv), 0, 1);
    weights[0] = 1 - weights[1];
    return (struct mix){b->children, weights, 2};
}

static rgb blend_eval(const struct bsdf *bsdf, const struct bsdf_point *point, vec3 wi, vec3 wo,
                      enum transport transport) {
    float weights[2];
    struct mix mix = blend_mix(bsdf, point->uv, weights);
    return mix_eval(&mix, point, wi, wo, transport);
}

static float blend_pdf(const struct bsdf *bsdf, const struct bsdf_point *point, vec3 wi, vec3 wo,
                       enum transport transport) {
    float weights[2];
    struct mix mix = blend_mix(bsdf, point->uv, weights);
    return mix_pdf(&mix, point, wi, wo, transport);
}

static bool blend_sample(const struct bsdf *bsdf, const struct bsdf_point *point, vec3 wi, vec3 u,
                         enum transport transport, struct bsdf_sample *sample) {
    float weights[2];
    struct mix mix = blend_mix(bsdf, point->uv, weights);
    return mix_sample(&mix, point, wi, u, transport, sample);
}

static rgb blend_through(const struct bsdf *bsdf, const struct bsdf_point *point, vec3 wi) {
    float weights[2];
    struct mix mix = blend_mix(bsdf, point->uv, weights);
    return mix_through(&mix, point, wi);
}

static rgb blend_albedo(const struct bsdf *bsdf, vec2 uv) {
    float weights[2];
    struct mix mix = blend_mix(bsdf, uv, weights);
    return mix_albedo(&mix, uv);
}

static const struct param blend_params[] = {
    {"weight", PARAM_TEXTURE, offsetof(struct blend, weight), "0.5", .max = 1, .unit = "1",
     .help = "share of the second nested bsdf"},
    PARAM_END,
};

const struct bsdf_type bsdf_blend = {
    .name = "blendbsdf",
    .help = "mixes two bsdfs by a texture",
    .params = blend_params,
    .size = sizeof(struct blend),
    .min_children = 2,
    .max_children = 2,
    .children_offset = offsetof(struct blend, children),
    .commit = blend_commit,
    .eval = blend_eval,
    .pdf = blend_pdf,
    .sample = blend_sample,
    .through = blend_through,
    .albedo = blend_albedo,
};
