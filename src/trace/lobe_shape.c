#include "trace/lobe_shape.h"

#include "math/sampler.h"

enum { SAMPLES = 64, PLACES = 64 };
static const float cosine_density = 0.2f; // [1/sr] mean density of a lobe that is as broad as a cosine
static const vec3 from = {0.6f, 0, 0.8f};

// Spread evenly over the textures, the middle first (Roberts 2018, "The unreasonable effectiveness of quasirandom
// sequences": the generalised golden ratio of two dimensions).
static struct bsdf_point place(int i) {
    const float u = 0.5f + 0.7548777f * (float)i, v = 0.5f + 0.5698403f * (float)i;
    return (struct bsdf_point){.uv = {u - floorf(u), v - floorf(v)}};
}

static struct lobe_shape measure_at(const struct bsdf *bsdf, const struct bsdf_point *point) {
    float density = 0;
    int smooth = 0, count = 0;
    for (uint64_t i = 0; i < SAMPLES; i++) {
        struct sampler sampler = sampler_make(0x6c6f6265, 0, i);
        const vec2 u = sampler_2d(&sampler);
        struct bsdf_sample sample;
        if (!bsdf_sample(bsdf, point, from, (vec3){u.x, u.y, sampler_1d(&sampler)}, TRANSPORT_RADIANCE, &sample))
            continue;
        count++;
        if (sample.delta) continue;
        smooth++;
        density += sample.pdf;
    }
    if (!smooth || !(density > 0)) return (struct lobe_shape){0};
    return (struct lobe_shape){(float)smooth / (float)count, minf(cosine_density * (float)smooth / density, 1)};
}

// Textures of roughness, of weights or of metal: the gloss changes from place to place.
static bool varies(const struct bsdf *bsdf) {
    const vec3 mirrored = {-0.6f, 0, 0.8f};
    const struct bsdf_point middle = place(0);
    const float density = bsdf_pdf(bsdf, &middle, from, mirrored, TRANSPORT_RADIANCE);
    for (int i = 1; i < PLACES; i++) {
        const struct bsdf_point point = place(i);
        if (bsdf_pdf(bsdf, &point, from, mirrored, TRANSPORT_RADIANCE) != density) return true;
    }
    return false;
}

struct lobe_shape lobe_shape_measure(const struct bsdf *bsdf) {
    if (!(bsdf->flags & BSDF_SMOOTH) || (bsdf->flags & BSDF_TRANSMISSION)) return (struct lobe_shape){0};
    struct lobe_shape least = {1, 1};
    for (int i = 0, count = varies(bsdf) ? PLACES : 1; i < count; i++) {
        const struct bsdf_point point = place(i);
        const struct lobe_shape here = measure_at(bsdf, &point);
        least.smooth = minf(least.smooth, here.smooth);
        least.broadness = minf(least.broadness, here.broadness);
    }
    return least;
}
