// twosided: gives an opaque BSDF a back. With two children the second is the back.
#include "scene/bsdf/bsdf_parts.h"

struct twosided {
    struct bsdf base;
    const struct bsdf *children[2];
};

static enum status twosided_commit(struct bsdf *bsdf, struct commit_context *context, struct error *error) {
    struct twosided *t = (struct twosided *)bsdf;
    if (!t->children[1]) t->children[1] = t->children[0];
    bsdf->flags = t->children[0]->flags | t->children[1]->flags;
    if (bsdf->flags & BSDF_TRANSMISSION) {
        return error_at(error, context->object->place,
                        "a transmitting bsdf cannot be inside twosided: it has two sides already; remove the twosided");
    }
    return STATUS_OK;
}

static inline const struct bsdf *twosided_child(const struct bsdf *bsdf, vec3 wi) {
    return ((const struct twosided *)bsdf)->children[wi.z < 0];
}

static rgb twosided_eval(const struct bsdf *bsdf, const struct bsdf_point *point, vec3 wi, vec3 wo,
                         enum transport transport) {
    const struct bsdf *child = twosided_child(bsdf, wi);
    if (wi.z >= 0) return bsdf_eval(child, point, wi, wo, transport);
    return bsdf_eval(child, point, direction_flip_z(wi), direction_flip_z(wo), transport);
}

static float twosided_pdf(const struct bsdf *bsdf, const struct bsdf_point *point, vec3 wi, vec3 wo,
                          enum transport transport) {
    const struct bsdf *child = twosided_child(bsdf, wi);
    if (wi.z >= 0) return bsdf_pdf(child, point, wi, wo, transport);
    return bsdf_pdf(child, point, direction_flip_z(wi), direction_flip_z(wo), transport);
}

static bool twosided_sample(const struct bsdf *bsdf, const struct bsdf_point *point, vec3 wi, vec3 u,
                            enum transport transport, struct bsdf_sample *sample) {
    const struct bsdf *child = twosided_child(bsdf, wi);
    if (wi.z >= 0) return bsdf_sample(child, point, wi, u, transport, sample);
    if (!bsdf_sample(child, point, direction_flip_z(wi), u, transport, sample)) return false;
    sample->wo.z = -sample->wo.z;
    return true;
}

static rgb twosided_through(const struct bsdf *bsdf, const struct bsdf_point *point, vec3 wi) {
    return bsdf_through(twosided_child(bsdf, wi), point, wi.z < 0 ? direction_flip_z(wi) : wi);
}

static rgb twosided_albedo(const struct bsdf *bsdf, vec2 uv) {
    return bsdf_albedo(((const struct twosided *)bsdf)->children[0], uv);
}

static const struct param twosided_params[] = {PARAM_END};

const struct bsdf_type bsdf_twosided = {
    .name = "twosided",
    .help = "makes an opaque bsdf two-sided; a second one is the back",
    .params = twosided_params,
    .size = sizeof(struct twosided),
    .min_children = 1,
    .max_children = 2,
    .children_offset = offsetof(struct twosided, children),
    .commit = twosided_commit,
    .eval = twosided_eval,
    .pdf = twosided_pdf,
    .sample = twosided_sample,
    .through = twosided_through,
    .albedo = twosided_albedo,
};
