// Where a luminaire's transparency is wrong: bench_transparency LAMP.safetensors LAMP.xml [lines] [traces]
// Uniform lines through the proxy, sorted by what lies on the straight line: nothing, something opaque, or how many
// surfaces of glass. For every class its share of the lines, the mean of T, the mean absolute error of the luminaire
// and what the class adds to the whole error, beside the error that noise of the reference alone would give.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "luminaire/luminaire.h"
#include "luminaire/proxy.h"
#include "math/sampler.h"
#include "math/warp.h"
#include "scene/scene.h"
#include "trace/line_radiance.h"

enum { CLASSES = 7, MAX_DEPTH = 100 };
static const char *const names[CLASSES] = {"nothing",   "opaque",   "glass 1-2", "glass 3-4",
                                           "glass 5-8", "glass 9-", "all"};
static const float straight_cos = 0.866f;

static int classify(const struct scene *scene, struct ray ray) {
    struct surface surface;
    for (int crossed = 0; crossed < 64; crossed++) {
        if (!scene_intersect(scene, &ray, -1, &surface))
            return crossed == 0 ? 0 : crossed <= 2 ? 2 : crossed <= 4 ? 3 : crossed <= 8 ? 4 : 5;
        if (!(surface_bsdf_flags(&surface) & (BSDF_TRANSMISSION | BSDF_NULL))) return 1;
        ray = surface_spawn_ray(&surface, ray.direction);
    }
    return 5;
}

int main(int argc, char **argv) {
    if (argc < 3) return fprintf(stderr, "usage: %s LAMP.safetensors LAMP.xml [lines] [traces]\n", argv[0]), 2;
    size_t lines = argc > 3 ? strtoull(argv[3], NULL, 10) : 4096, traces = argc > 4 ? strtoull(argv[4], NULL, 10) : 256;
    struct luminaire *luminaire;
    struct error error;
    struct scene scene;
    struct run run = {.threads = 1, .seed = 1};
    struct scene_options options = {.lamp_only = true, .threads = 1};
    if (luminaire_load(&luminaire, argv[1], &error) || scene_load(&scene, argv[2], &options, &run, &error))
        return fprintf(stderr, "%s\n", error.text), 1;
    float center[3], radius, t_near, t_far;
    luminaire_bounds(luminaire, center, &radius);
    double count[CLASSES] = {0}, sum_t[CLASSES] = {0}, sum_error[CLASSES] = {0}, sum_noise[CLASSES] = {0};
    for (size_t i = 0; i < lines; i++) {
        struct sampler sampler = sampler_make(77, 1, i);
        vec3 w, point;
        do {
            w = warp_uniform_sphere(sampler_2d(&sampler));
            vec2 disk = warp_concentric_disk(sampler_2d(&sampler));
            struct frame frame = frame_from_normal(w);
            point = vec3_mad(frame.s, disk.x * radius,
                             vec3_mad(frame.t, disk.y * radius, vec3_make(center[0], center[1], center[2])));
            point = vec3_mad(w, radius * 1.01f, point);
        } while (!luminaire_span(luminaire, (float[3]){point.x, point.y, point.z}, (float[3]){w.x, w.y, w.z}, &t_near,
                                 &t_far));
        struct ray ray = {point, vec3_neg(w), 0, INFINITY};
        double sum = 0, squares = 0;
        for (size_t k = 0; k < traces; k++) {
            struct sampler again = sampler_make(77, (uint64_t)(i + 1) << 8 | 2, k);
            double t = (double)rgb_mean(trace_line_transmittance(&scene, &ray, &again, MAX_DEPTH, straight_cos));
            sum += t;
            squares += t * t;
        }
        double n = (double)traces, mean = sum / n,
               noise = sqrt(fmax(0, squares / n - mean * mean) / (n - 1) * 2 / M_PI);
        float model[1][3], at[1][3] = {{point.x, point.y, point.z}}, along[1][3] = {{w.x, w.y, w.z}};
        luminaire_transmittance(luminaire, 1, (const float(*)[3])at, (const float(*)[3])along, model);
        double e = fabs((double)(model[0][0] + model[0][1] + model[0][2]) / 3 - mean);
        int class = classify(&scene, ray);
        for (int k = class;; k = CLASSES - 1) {
            count[k]++;
            sum_t[k] += mean;
            sum_error[k] += e;
            sum_noise[k] += noise;
            if (k == CLASSES - 1) break;
        }
    }
    printf("%-10s %8s %8s %8s %8s %8s\n", "class", "share", "mean T", "error", "noise", "adds");
    for (int k = 0; k < CLASSES; k++) {
        if (!(count[k] > 0)) continue;
        printf("%-10s %8.4f %8.4f %8.4f %8.4f %8.4f\n", names[k], count[k] / (double)lines, sum_t[k] / count[k],
               sum_error[k] / count[k], sum_noise[k] / count[k], sum_error[k] / (double)lines);
    }
    scene_fini(&scene);
    luminaire_destroy(luminaire);
    return 0;
}
