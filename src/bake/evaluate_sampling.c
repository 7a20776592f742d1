// The noise of one light sample, at shading points 1.2 to 12 radii from the lamp, evenly in the logarithm.
#include <stdlib.h>
#include <string.h>

#include "base/parallel.h"
#include "bake/evaluate_private.h"
#include "math/warp.h"

enum { LIGHT_SAMPLES = 4096 };

struct light_job {
    const struct luminaire *luminaire;
    const struct lamp *lamp;
    float (*variance)[2]; // per shading point: of the luminaire's samples, of uniform ones
};

// Mean and mean square of L cos / p at s, whose normal faces the lamp's centre.
static void light_moments(const struct luminaire *luminaire, const float s[3], vec3 normal,
                          const float (*directions)[3], const float *pdfs, double *mean, double *square) {
    float points[LIGHT_SAMPLES][3], w[LIGHT_SAMPLES][3], radiance[LIGHT_SAMPLES][3];
    for (size_t i = 0; i < LIGHT_SAMPLES; i++) {
        memcpy(points[i], s, sizeof points[i]);
        for (int c = 0; c < 3; c++) w[i][c] = -directions[i][c];
    }
    luminaire_eval(luminaire, LIGHT_SAMPLES, (const float(*)[3])points, (const float(*)[3])w, radiance);
    *mean = *square = 0;
    for (size_t i = 0; i < LIGHT_SAMPLES; i++) {
        float cosine = fmaxf(0, vec3_dot(vec3_from(directions[i]), normal));
        double x = (double)((radiance[i][0] + radiance[i][1] + radiance[i][2]) * cosine / pdfs[i]);
        *mean += x / LIGHT_SAMPLES;
        *square += x * x / LIGHT_SAMPLES;
    }
}

static void light_point(void *user, size_t index, int worker) {
    (void)worker;
    const struct light_job *job = user;
    const struct lamp *lamp = job->lamp;
    struct sampler sampler = sampler_make(lamp->seed, (uint64_t)STREAM_EVALUATION << 56 | 3, index);
    float distance = 1.2f * powf(10, sampler_1d(&sampler)) * lamp->proxy.radius, cos_max, s[LIGHT_SAMPLES][3];
    vec3 out = warp_uniform_sphere(sampler_2d(&sampler)), normal = vec3_neg(out);
    vec3 point = vec3_mad(out, distance, vec3_from(lamp->proxy.center));
    struct frame frame = frame_from_normal(normal);
    float u[LIGHT_SAMPLES][3], directions[LIGHT_SAMPLES][3], pdfs[LIGHT_SAMPLES];
    cos_max = sqrtf(1 - sqrf(lamp->proxy.radius / distance));
    for (size_t i = 0; i < LIGHT_SAMPLES; i++) {
        for (int c = 0; c < 3; c++) u[i][c] = sampler_1d(&sampler);
        memcpy(s[i], &(float[3]){point.x, point.y, point.z}, sizeof s[i]);
    }
    luminaire_sample(job->luminaire, LIGHT_SAMPLES, (const float(*)[3])s, (const float(*)[3])u, directions, pdfs);
    double mean, square, uniform_mean, uniform_square;
    light_moments(job->luminaire, s[0], normal, (const float(*)[3])directions, pdfs, &mean, &square);
    for (size_t i = 0; i < LIGHT_SAMPLES; i++) {
        vec3 d = frame_world_from_local(&frame, warp_uniform_cone((vec2){u[i][0], u[i][1]}, cos_max));
        memcpy(directions[i], &(float[3]){d.x, d.y, d.z}, sizeof directions[i]);
        pdfs[i] = warp_uniform_cone_pdf(cos_max);
    }
    light_moments(job->luminaire, s[0], normal, (const float(*)[3])directions, pdfs, &uniform_mean, &uniform_square);
    job->variance[index][0] = mean > 0 ? (float)(square / (mean * mean) - 1) : 0;
    job->variance[index][1] = mean > 0 ? (float)(uniform_square / (mean * mean) - 1) : 0;
}

enum status evaluate_sampling(const struct luminaire *luminaire, const struct lamp *lamp, size_t points,
                              struct evaluation *evaluation, struct error *error) {
    float(*variance)[2] = calloc(points, sizeof *variance);
    if (!variance) return error_set(error, STATUS_MEMORY, "out of memory for the evaluation");
    struct light_job job = {luminaire, lamp, variance};
    parallel_for(lamp->threads, points, light_point, &job);
    double sums[2] = {0, 0};
    for (size_t i = 0; i < points; i++)
        for (int k = 0; k < 2; k++) sums[k] += (double)variance[i][k];
    evaluation->sample_variance = (float)(sums[0] / (double)points);
    evaluation->sample_variance_uniform = (float)(sums[1] / (double)points);
    free(variance);
    return STATUS_OK;
}
