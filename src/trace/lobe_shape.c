#include "trace/lobe_shape.h"

#include "math/sampler.h"

enum { SAMPLES = 64 };
static const float cosine_density = 0.2f; // [1/sr] mean density of a lobe that is as broad as a cosine

struct lobe_shape lobe_shape_measure(const struct bsdf *bsdf) {
    if (!(bsdf->flags & BSDF_SMOOTH) || (bsdf->flags & BSDF_TRANSMISSION)) return (struct lobe_shape){0};
    const struct bsdf_point point = {.uv = {0.5f, 0.5f}};
    const vec3 wi = {0.6f, 0, 0.8f};
    float density = 0;
    int smooth = 0, count = 0;
    for (uint64_t i = 0; i < SAMPLES; i++) {
        struct sampler sampler = sampler_make(0x6c6f6265, 0, i);
        const vec2 u = sampler_2d(&sampler);
        struct bsdf_sample sample;
        if (!bsdf_sample(bsdf, &point, wi, (vec3){u.x, u.y, sampler_1d(&sampler)}, TRANSPORT_RADIANCE, &sample))
            continue;
        count++;
        if (sample.delta) continue;
        smooth++;
        density += sample.pdf;
    }
    if (!smooth || !(density > 0)) return (struct lobe_shape){0};
    return (struct lobe_shape){(float)smooth / (float)count, minf(cosine_density * (float)smooth / density, 1)};
}
