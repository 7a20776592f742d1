// The noise of a density's light samples before there is a luminaire: for the baker, which chooses between densities.
#include <string.h>

#include "base/parallel.h"
#include "luminaire/proxy.h"
#include "luminaire/sampling.h"
#include "math/sampler.h"
#include "math/warp.h"

enum { POINTS = 256, SAMPLES = 1024 };
static const float nearest = 1.2f, farthest = 12; // [radii]

struct noise_job {
    const struct sampling_density *density;
    const struct light_field *field;
    const struct proxy_shape *shape;
    double mean[POINTS], square[POINTS]; // of L cos / p
};

static void measure_point(void *user, size_t index, int worker) {
    (void)worker;
    struct noise_job *job = user;
    const struct sampling_density *density = job->density;
    float s[SAMPLES][3], u[SAMPLES][3], direction[SAMPLES][3], w[SAMPLES][3], radiance[SAMPLES][3], pdf_sa[SAMPLES];
    struct sampler sampler = sampler_make(0, 0x6e6f6973, index);
    const vec3 out = warp_uniform_sphere(sampler_2d(&sampler));
    const float distance = nearest * powf(farthest / nearest, sampler_1d(&sampler));
    for (size_t i = 0; i < SAMPLES; i++) {
        vec3_store(s[i], vec3_mad(out, distance * density->radius, density->center));
        for (int c = 0; c < 3; c++) u[i][c] = sampler_1d(&sampler);
    }
    sampling_sample_batch(density, SAMPLES, (const float(*)[3])s, (const float(*)[3])u, direction, pdf_sa);
    for (size_t i = 0; i < SAMPLES; i++) vec3_store(w[i], vec3_neg(vec3_from(direction[i])));
    light_field_eval(job->field, SAMPLES, (const float(*)[3])s, (const float(*)[3])w, radiance);
    for (size_t i = 0; i < SAMPLES; i++) {
        float t_near, t_far;
        const float cosine = vec3_dot(vec3_from(w[i]), out);
        if (!(cosine > 0) || !(pdf_sa[i] > 0) || !proxy_shape_span(job->shape, s[i], direction[i], &t_near, &t_far))
            continue;
        const double x =
            (double)((radiance[i][0] + radiance[i][1] + radiance[i][2]) * cosine / pdf_sa[i] * sqrf(distance));
        job->mean[index] += x / SAMPLES;
        job->square[index] += x * x / SAMPLES;
    }
}

double sampling_density_noise(const struct sampling_density *density, const struct light_field *field,
                              const struct proxy_shape *shape, int threads) {
    struct noise_job job = {density, field, shape, {0}, {0}};
    parallel_for(threads, POINTS, measure_point, &job);
    double squares = 0, means = 0;
    for (size_t i = 0; i < POINTS; i++) {
        squares += job.square[i];
        means += job.mean[i] * job.mean[i];
    }
    return means > 0 ? squares / means - 1 : 0;
}
