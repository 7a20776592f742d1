// One-sample multiple importance sampling over the children (Veach and Guibas 1995): a child is chosen by its weight
// times its mean share of light that does not go through; a smooth sample then gets the density of the whole mixture.
#include "scene/bsdf/mix.h"
#include "scene/bsdf/bsdf_parts.h"

// The probability of choosing each child; their sum before normalisation, 0 where there is nothing to choose.
static float mix_choices(const struct mix *mix, const struct bsdf_point *point, vec3 wi, float choices[MIX_MAX]) {
    float sum = 0;
    for (int i = 0; i < mix->count; ++i) {
        choices[i] = mix->weights[i];
        if (mix->children[i]->flags & BSDF_NULL) choices[i] *= 1 - rgb_mean(bsdf_through(mix->children[i], point, wi));
        choices[i] = maxf(choices[i], 0);
        sum += choices[i];
    }
    for (int i = 0; i < mix->count && sum > 0; ++i) choices[i] /= sum;
    return sum;
}

rgb mix_eval(const struct mix *mix, const struct bsdf_point *point, vec3 wi, vec3 wo, enum transport transport) {
    rgb sum = {0, 0, 0};
    for (int i = 0; i < mix->count; ++i) {
        sum = rgb_add(sum, rgb_scale(bsdf_eval(mix->children[i], point, wi, wo, transport), mix->weights[i]));
    }
    return sum;
}

static float mix_density(const struct mix *mix, const float *choices, const struct bsdf_point *point, vec3 wi, vec3 wo,
                         enum transport transport) {
    float sum = 0;
    for (int i = 0; i < mix->count; ++i) sum += choices[i] * bsdf_pdf(mix->children[i], point, wi, wo, transport);
    return sum;
}

float mix_pdf(const struct mix *mix, const struct bsdf_point *point, vec3 wi, vec3 wo, enum transport transport) {
    float choices[MIX_MAX];
    return mix_choices(mix, point, wi, choices) > 0 ? mix_density(mix, choices, point, wi, wo, transport) : 0;
}

bool mix_sample(const struct mix *mix, const struct bsdf_point *point, vec3 wi, vec3 u, enum transport transport,
                struct bsdf_sample *sample) {
    float choices[MIX_MAX];
    if (mix_choices(mix, point, wi, choices) <= 0) return false;
    int i = 0;
    while (i + 1 < mix->count && u.z >= choices[i]) u.z -= choices[i++];
    while (choices[i] <= 0) --i; // rounding left a rest above the last child that can be chosen
    u.z = minf(u.z / choices[i], 0x1.fffffep-1f);
    const struct bsdf *child = mix->children[i];
    if (!bsdf_sample(child, point, wi, u, transport, sample)) return false;
    rgb through = mix_through(mix, point, wi), value;
    if (sample->delta) {
        rgb blocked = rgb_sub(rgb_gray(1), bsdf_through(child, point, wi));
        value = rgb_scale(rgb_mul(sample->weight, blocked), mix->weights[i] / choices[i]);
        sample->pdf *= choices[i];
    } else {
        sample->pdf = mix_density(mix, choices, point, wi, sample->wo, transport);
        if (!(sample->pdf > 0)) return false;
        value = rgb_scale(mix_eval(mix, point, wi, sample->wo, transport), 1 / sample->pdf);
    }
    sample->weight = rgb_divide_rest(value, through);
    return true;
}

rgb mix_through(const struct mix *mix, const struct bsdf_point *point, vec3 wi) {
    rgb sum = {0, 0, 0};
    for (int i = 0; i < mix->count; ++i) {
        if (!(mix->children[i]->flags & BSDF_NULL)) continue;
        sum = rgb_add(sum, rgb_scale(bsdf_through(mix->children[i], point, wi), mix->weights[i]));
    }
    return sum;
}

rgb mix_albedo(const struct mix *mix, vec2 uv) {
    rgb sum = {0, 0, 0};
    for (int i = 0; i < mix->count; ++i)
        sum = rgb_add(sum, rgb_scale(bsdf_albedo(mix->children[i], uv), mix->weights[i]));
    return sum;
}
