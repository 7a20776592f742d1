// The sampling density of a baked luminaire: relative variance of L cos / p over distance, as the mean over the points
// and by the square of their light (dark points, where little is seen of the lamp, make most of the former).
//   bench_density LAMP.safetensors [MILLIONS]   MILLIONS: made anew from so many lines of the light field
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/parallel.h"
#include "base/run.h"
#include "luminaire/luminaire_private.h"
#include "math/sampler.h"
#include "math/warp.h"

enum { POINTS = 512, SAMPLES = 4096 };
static float s[SAMPLES][3], u[SAMPLES][3], direction[SAMPLES][3], w[SAMPLES][3], radiance[SAMPLES][3], pdf[SAMPLES];

static enum status refine(struct luminaire *luminaire, double millions, struct error *error) {
    const struct sampling_refinement plan = {(size_t)(1e6 * millions), 1, parallel_cores()};
    const double start = clock_cpu_s();
    enum status status = sampling_density_refine(&luminaire->emissions[0].density, luminaire->emissions[0].light,
                                                 &luminaire->shape, &plan, error);
    printf("refined by %g M lines in %.1f CPU s\n", millions, clock_cpu_s() - start);
    return status;
}

// Relative variance at one point, whose normal faces the centre, and the mean.
static double variance_at(const struct luminaire *luminaire, vec3 p, vec3 normal, struct sampler *sampler,
                          double *light) {
    for (size_t i = 0; i < SAMPLES; i++) {
        vec3_store(s[i], p);
        for (int c = 0; c < 3; c++) u[i][c] = sampler_1d(sampler);
    }
    luminaire_sample(luminaire, SAMPLES, (const float(*)[3])s, (const float(*)[3])u, direction, pdf);
    for (size_t i = 0; i < SAMPLES; i++)
        for (int c = 0; c < 3; c++) w[i][c] = -direction[i][c];
    luminaire_eval(luminaire, SAMPLES, (const float(*)[3])s, (const float(*)[3])w, radiance);
    double mean = 0, square = 0;
    for (size_t i = 0; i < SAMPLES; i++) {
        float cosine = fmaxf(0, vec3_dot((vec3){direction[i][0], direction[i][1], direction[i][2]}, normal));
        double x = (double)((radiance[i][0] + radiance[i][1] + radiance[i][2]) * cosine / pdf[i]);
        mean += x / SAMPLES;
        square += x * x / SAMPLES;
    }
    *light = mean;
    return mean > 0 ? square / (mean * mean) - 1 : 0;
}

int main(int argc, char **argv) {
    struct luminaire *luminaire;
    struct error error;
    if (argc < 2) return fprintf(stderr, "usage: %s LAMP.safetensors [MILLIONS]\n", argv[0]), 2;
    if (luminaire_load(&luminaire, argv[1], &error)) return fprintf(stderr, "%s\n", error.text), 1;
    if (argc > 2 && refine(luminaire, atof(argv[2]), &error)) return fprintf(stderr, "%s\n", error.text), 1;
    static const float distances[] = {1.05f, 1.2f, 2, 3.5f, 6, 12};
    float center[3], radius;
    luminaire_bounds(luminaire, center, &radius);
    for (size_t d = 0; d < sizeof distances / sizeof *distances; d++) {
        double sum = 0, worst = 0, squares = 0, lights = 0;
        for (size_t i = 0; i < POINTS; i++) {
            struct sampler sampler = sampler_make(7, d, i);
            vec3 out = warp_uniform_sphere(sampler_2d(&sampler));
            vec3 p = vec3_mad(out, distances[d] * radius, (vec3){center[0], center[1], center[2]});
            double light, v = variance_at(luminaire, p, vec3_neg(out), &sampler, &light);
            sum += v / POINTS;
            squares += v * light * light;
            lights += light * light;
            worst = fmax(worst, v);
        }
        printf("at %5.2f radii: variance %7.3f, at worst %8.3f, by light %7.3f\n", (double)distances[d], sum, worst,
               lights > 0 ? squares / lights : 0);
    }
    luminaire_destroy(luminaire);
    return 0;
}
