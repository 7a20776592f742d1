// mask: a cut-out; light goes straight through where the opacity is below 1.
#include "scene/bsdf/bsdf_parts.h"

struct mask {
    struct bsdf base;
    const struct bsdf *child;
    const struct texture *opacity;
};

static enum status mask_commit(struct bsdf *bsdf, struct commit_context *context, struct error *error) {
    (void)context, (void)error;
    bsdf->flags = ((const struct mask *)bsdf)->child->flags | BSDF_NULL;
    return STATUS_OK;
}

static rgb mask_opacity(const struct mask *m, vec2 uv) {
    rgb o = texture_eval(m->opacity, uv);
    return (rgb){clampf(o.r, 0, 1), clampf(o.g, 0, 1), clampf(o.b, 0, 1)};
}

static rgb mask_eval(const struct bsdf *bsdf, const struct bsdf_point *point, vec3 wi, vec3 wo,
                     enum transport transport) {
    const struct mask *m = (const struct mask *)bsdf;
    return rgb_mul(bsdf_eval(m->child, point, wi, wo, transport), mask_opacity(m, point->uv));
}

static float mask_pdf(const struct bsdf *bsdf, const struct bsdf_point *point, vec3 wi, vec3 wo,
                      enum transport transport) {
    return bsdf_pdf(((const struct mask *)bsdf)->child, point, wi, wo, transport);
}

static bool mask_sample(const struct bsdf *bsdf, const struct bsdf_point *point, vec3 wi, vec3 u,
                        enum transport transport, struct bsdf_sample *sample) {
    return bsdf_sample(((const struct mask *)bsdf)->child, point, wi, u, transport, sample);
}

static rgb mask_through(const struct bsdf *bsdf, const struct bsdf_point *point, vec3 wi) {
    const struct mask *m = (const struct mask *)bsdf;
    rgb blocked = rgb_sub(rgb_gray(1), bsdf_through(m->child, point, wi));
    return rgb_sub(rgb_gray(1), rgb_mul(mask_opacity(m, point->uv), blocked));
}

static rgb mask_albedo(const struct bsdf *bsdf, vec2 uv) {
    const struct mask *m = (const struct mask *)bsdf;
    rgb opacity = mask_opacity(m, uv);
    return rgb_add(rgb_mul(opacity, bsdf_albedo(m->child, uv)), rgb_sub(rgb_gray(1), opacity));
}

static const struct param mask_params[] = {
    {"opacity", PARAM_TEXTURE, offsetof(struct mask, opacity), "0.5", .max = 1, .unit = "1",
     .help = "share of light that meets the nested bsdf; the rest goes straight through"},
    PARAM_END,
};

const struct bsdf_type bsdf_mask = {
    .name = "mask",
    .help = "cut-out: lets light straight through by an opacity texture",
    .params = mask_params,
    .size = sizeof(struct mask),
    .flags = BSDF_NULL,
    .min_children = 1,
    .max_children = 1,
    .children_offset = offsetof(struct mask, child),
    .commit = mask_commit,
    .eval = mask_eval,
    .pdf = mask_pdf,
    .sample = mask_sample,
    .through = mask_through,
    .albedo = mask_albedo,
};
