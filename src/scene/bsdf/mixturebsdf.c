// mixturebsdf: a sum of several BSDFs with constant weights (Mitsuba 0.5). What the weights lack to 1 is absorbed.
#include <stdlib.h>
#include <string.h>

#include "scene/bsdf/mix.h"

struct mixture {
    struct bsdf base;
    const struct bsdf *children[MIX_MAX];
    const char *weights_text;
    float weights[MIX_MAX];
    int count;
};

static enum status mixture_commit(struct bsdf *bsdf, struct commit_context *context, struct error *error) {
    struct mixture *m = (struct mixture *)bsdf;
    while (m->count < MIX_MAX && m->children[m->count]) bsdf->flags |= m->children[m->count++]->flags;
    const char *text = m->weights_text;
    float sum = 0;
    int n = 0;
    for (text += strspn(text, " ,\t\r\n"); *text; text += strspn(text, " ,\t\r\n")) {
        char *end;
        float weight = strtof(text, &end);
        if (end == text || !(weight >= 0) || !isfinite(weight)) {
            return error_at(error, context->object->place, "weights \"%s\" are not a list of numbers >= 0",
                            m->weights_text);
        }
        if (n < MIX_MAX) m->weights[n] = weight;
        ++n;
        sum += weight;
        text = end;
    }
    if (n != m->count) {
        return error_at(error, context->object->place, "%d weights for %d nested bsdfs; give one for each", n,
                        m->count);
    }
    if (sum > 1) {
        if (sum > 1.001f && context->run) {
            run_warn(context->run, "%s:%d:%d: the weights of mixturebsdf sum to %g, they are scaled down to 1",
                     context->object->place.file, context->object->place.line, context->object->place.column,
                     (double)sum);
        }
        for (int i = 0; i < n; ++i) m->weights[i] /= sum;
    }
    return STATUS_OK;
}

static inline struct mix mixture_mix(const struct bsdf *bsdf) {
    const struct mixture *m = (const struct mixture *)bsdf;
    return (struct mix){m->children, m->weights, m->count};
}

static rgb mixture_eval(const struct bsdf *bsdf, const struct bsdf_point *point, vec3 wi, vec3 wo,
                        enum transport transport) {
    struct mix mix = mixture_mix(bsdf);
    return mix_eval(&mix, point, wi, wo, transport);
}

static float mixture_pdf(const struct bsdf *bsdf, const struct bsdf_point *point, vec3 wi, vec3 wo,
                         enum transport transport) {
    struct mix mix = mixture_mix(bsdf);
    return mix_pdf(&mix, point, wi, wo, transport);
}

static bool mixture_sample(const struct bsdf *bsdf, const struct bsdf_point *point, vec3 wi, vec3 u,
                           enum transport transport, struct bsdf_sample *sample) {
    struct mix mix = mixture_mix(bsdf);
    return mix_sample(&mix, point, wi, u, transport, sample);
}

static rgb mixture_through(const struct bsdf *bsdf, const struct bsdf_point *point, vec3 wi) {
    struct mix mix = mixture_mix(bsdf);
    return mix_through(&mix, point, wi);
}

static rgb mixture_albedo(const struct bsdf *bsdf, vec2 uv) {
    struct mix mix = mixture_mix(bsdf);
    return mix_albedo(&mix, uv);
}

static const struct param mixture_params[] = {
    {"weights", PARAM_STRING, offsetof(struct mixture, weights_text), NULL,
     .help = "one number for each nested bsdf, separated by commas or spaces"},
    PARAM_END,
};

const struct bsdf_type bsdf_mixture = {
    .name = "mixturebsdf",
    .help = "mixes bsdfs by constant weights",
    .params = mixture_params,
    .size = sizeof(struct mixture),
    .min_children = 1,
    .max_children = MIX_MAX,
    .children_offset = offsetof(struct mixture, children),
    .commit = mixture_commit,
    .eval = mixture_eval,
    .pdf = mixture_pdf,
    .sample = mixture_sample,
    .through = mixture_through,
    .albedo = mixture_albedo,
};
