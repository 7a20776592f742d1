// The sampling density of a baked luminaire: relative variance of L cos / p over distance, and nanoseconds a call.
//   bench_density LAMP.safetensors [LAMP.xml MILLIONS]   with a lamp: the density is built anew from that many
//   particles
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bake/survey.h"
#include "luminaire/luminaire_private.h"
#include "math/warp.h"

enum { POINTS = 256, SAMPLES = 4096 };
static float s[SAMPLES][3], u[SAMPLES][3], direction[SAMPLES][3], w[SAMPLES][3], radiance[SAMPLES][3], pdf[SAMPLES];

static enum status rebuild(struct luminaire *luminaire, const char *path, size_t particles, struct error *error) {
    struct scene scene;
    struct run run = {.threads = 1, .seed = 1};
    enum status status =
        scene_load(&scene, path, &(struct scene_options){.threads = 1, .lamp_only = true}, &run, error);
    if (status) return status;
    struct lamp lamp = {
        .scene = &scene, .proxy = luminaire->shape.proxy, .shape = luminaire->shape, .seed = 1, .threads = 1};
    static struct survey survey;
    status = survey_clusters(&survey, &lamp, error);
    if (!status) status = survey_exits(&survey, &lamp, STREAM_SURVEY, particles, &run, error);
    float anchors[SURVEY_CLUSTERS][3];
    for (size_t i = 0; i < survey.cluster_count; i++) vec3_store(anchors[i], survey.clusters[i].center);
    if (!status) {
        sampling_density_destroy(luminaire->emissions[0].density);
        double start = clock_cpu_s();
        status = sampling_density_build(&luminaire->emissions[0].density, &lamp.proxy, (const float(*)[3])anchors,
                                        survey.cluster_count, survey.exits.exits, survey.exits.count, 1, 1, error);
        printf("built from %zu exits in %.2f s\n", survey.exits.count, clock_cpu_s() - start);
    }
    survey_fini(&survey);
    scene_fini(&scene);
    return status;
}

// Relative variance at one point, whose normal faces the centre.
static double variance_at(const struct luminaire *luminaire, vec3 p, vec3 normal, struct sampler *sampler) {
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
    return mean > 0 ? square / (mean * mean) - 1 : 0;
}

int main(int argc, char **argv) {
    struct luminaire *luminaire;
    struct error error;
    if (argc < 2) return fprintf(stderr, "usage: %s LAMP.safetensors [LAMP.xml MILLIONS]\n", argv[0]), 2;
    if (luminaire_load(&luminaire, argv[1], &error)) return fprintf(stderr, "%s\n", error.text), 1;
    if (argc > 3 && rebuild(luminaire, argv[2], (size_t)(1e6 * atof(argv[3])), &error))
        return fprintf(stderr, "%s\n", error.text), 1;
    static const float distances[] = {1.05f, 1.2f, 2, 3.5f, 6, 12};
    float center[3], radius;
    luminaire_bounds(luminaire, center, &radius);
    for (size_t d = 0; d < sizeof distances / sizeof *distances; d++) {
        double sum = 0, worst = 0;
        for (size_t i = 0; i < POINTS; i++) {
            struct sampler sampler = sampler_make(7, d, i);
            vec3 out = warp_uniform_sphere(sampler_2d(&sampler));
            vec3 p = vec3_mad(out, distances[d] * radius, (vec3){center[0], center[1], center[2]});
            double v = variance_at(luminaire, p, vec3_neg(out), &sampler);
            sum += v / POINTS;
            worst = fmax(worst, v);
        }
        printf("at %5.2f radii: variance %7.3f, at worst %8.3f\n", (double)distances[d], sum, worst);
    }
    luminaire_destroy(luminaire);
    return 0;
}
