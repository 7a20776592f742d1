// null: an invisible surface, such as the border of a medium.
#include "scene/bsdf/bsdf_parts.h"

static bool null_sample(const struct bsdf *bsdf, const struct bsdf_point *point, vec3 wi, vec3 u,
                        enum transport transport, struct bsdf_sample *sample) {
    (void)bsdf, (void)point, (void)wi, (void)u, (void)transport, (void)sample;
    return false;
}

static rgb null_through(const struct bsdf *bsdf, const struct bsdf_point *point, vec3 wi) {
    (void)bsdf, (void)point, (void)wi;
    return rgb_gray(1);
}

static const struct param null_params[] = {PARAM_END};

const struct bsdf_type bsdf_null = {
    .name = "null",
    .help = "invisible surface: all light goes straight through",
    .params = null_params,
    .size = sizeof(struct bsdf),
    .flags = BSDF_NULL,
    .eval = bsdf_eval_nothing,
    .pdf = bsdf_pdf_nothing,
    .sample = null_sample,
    .through = null_through,
};
