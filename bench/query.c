// Queries per second of a baked luminaire on one core: bench_query LAMP.safetensors [lines]
// Lines pass through the bounding sphere at random; shading points lie at 1.1 to 6 radii.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "luminaire/luminaire.h"
#include "math/sampler.h"
#include "math/warp.h"

enum { BATCH = 4096 };
static float point[BATCH][3], w[BATCH][3], s[BATCH][3], u[BATCH][3], result[BATCH][3], pdf[BATCH];

static void report(const char *name, size_t n, double start) {
    double seconds = clock_cpu_s() - start;
    printf("%-14s %8.3f M/s %8.1f ns\n", name, (double)n / seconds * 1e-6, seconds / (double)n * 1e9);
}

int main(int argc, char **argv) {
    if (argc < 2) return fprintf(stderr, "usage: %s LAMP.safetensors [lines]\n", argv[0]), 2;
    struct luminaire *luminaire;
    struct error error;
    if (luminaire_load(&luminaire, argv[1], &error)) return fprintf(stderr, "%s\n", error.text), 1;
    size_t rounds = (argc > 2 ? strtoull(argv[2], NULL, 10) : 2000000) / BATCH + 1;
    float center[3], radius;
    luminaire_bounds(luminaire, center, &radius);
    vec3 middle = {center[0], center[1], center[2]};
    for (size_t i = 0; i < BATCH; i++) {
        struct sampler sampler = sampler_make(1, 0, i);
        vec3 in = warp_uniform_sphere(sampler_2d(&sampler)), out = warp_uniform_sphere(sampler_2d(&sampler));
        vec3_store(point[i], vec3_mad(in, 0.9f * radius * cbrtf(sampler_1d(&sampler)), middle));
        vec3_store(w[i], out);
        vec3_store(s[i], vec3_mad(in, radius * (1.1f + 5 * sampler_1d(&sampler)), middle));
        for (int a = 0; a < 3; a++) u[i][a] = sampler_1d(&sampler);
    }
    double start = clock_cpu_s();
    for (size_t k = 0; k < rounds; k++)
        luminaire_eval(luminaire, BATCH, (const float(*)[3])point, (const float(*)[3])w, result);
    report("eval", rounds * BATCH, start);
    start = clock_cpu_s();
    for (size_t k = 0; k < rounds; k++)
        luminaire_transmittance(luminaire, BATCH, (const float(*)[3])point, (const float(*)[3])w, result);
    report("transmittance", rounds * BATCH, start);
    start = clock_cpu_s();
    for (size_t k = 0; k < rounds; k++)
        luminaire_sample(luminaire, BATCH, (const float(*)[3])s, (const float(*)[3])u, result, pdf);
    report("sample", rounds * BATCH, start);
    start = clock_cpu_s();
    for (size_t k = 0; k < rounds; k++)
        luminaire_pdf(luminaire, BATCH, (const float(*)[3])s, (const float(*)[3])result, pdf);
    report("pdf", rounds * BATCH, start);
    luminaire_destroy(luminaire);
    return 0;
}
