// Speed and efficiency of the integrators on one scene, on one thread:
//   bench_transport SCENE.xml [PASSES [WIDTHxHEIGHT [INTEGRATOR [LAMP]]]]     (LAMP: value of the scene's "lamp")
// prints for each integrator, and for path without the cache of radiance ("exact"), paths per CPU second and relMSE x
// CPU seconds (mean over pixels of variance / (mean^2 + 1e-3), times the time it took: what is left does not depend on
// the number of passes, less is better), then, unless one integrator is named, for the scene as a lamp its particles
// per CPU second; of the path tracer also the share of each stage in its time. Built on request: ninja bench_transport.
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "trace/integrator.h"
#include "trace/particle_exit.h"
#include "trace/path_state.h"

static int render(const struct scene *scene, const struct integrator_type *type, const char *name, int passes,
                  const struct run *run, struct error *error) {
    void *state = NULL;
    struct film film = {0};
    struct image image = {0};
    double begin = clock_cpu_s(), relative = 0, mean = 0;
    if (film_init(&film, scene->sensor, error) || type->create(scene, run, &state, error)) return 1;
    for (int pass = 0; pass < passes; pass++) {
        if (type->render_pass(state, &film, (uint64_t)pass, run, error)) return 1;
        film_end_pass(&film, 1);
    }
    double seconds = clock_cpu_s() - begin;
    if (film_image(&film, &image, error)) return 1;
    size_t count = (size_t)film.width * (size_t)film.height;
    for (size_t i = 0; i < 3 * count; i++) {
        const float *pixel = image.pixels + i / 3 * 6;
        double value = (double)pixel[i % 3];
        mean += value / (3 * (double)count);
        relative += (double)pixel[3 + i % 3] / (value * value + 1e-3) / (3 * (double)count);
    }
    printf("%-9s %7.3f Mpaths/s   mean %.5g   relMSE x CPU s %.5g\n", name, (double)count * passes / seconds * 1e-6,
           mean, relative * seconds);
    if (type == &path_integrator) {
        const struct path_worker *worker = ((const struct path_tracer *)state)->workers;
        double sum = 0;
        for (int i = 0; i < PATH_STAGES; i++) sum += worker->stage_s[i];
        for (int i = 0; i < PATH_STAGES; i++)
            printf("  %-10s %5.1f %%\n", path_stages[i].name, 100 * worker->stage_s[i] / sum);
    }
    image_fini(&image);
    type->destroy(state);
    film_fini(&film);
    return 0;
}

static void exits(const struct scene *scene) {
    enum { particles = 500000 };
    double begin = clock_cpu_s(), flux = 0;
    size_t escaped = 0;
    for (int i = 0; i < particles; i++) {
        struct sampler sampler = sampler_make(1, (uint64_t)i, 0);
        struct particle_exit e;
        trace_particle(scene, &sampler, -1, &e);
        flux += (double)rgb_mean(e.flux) / particles;
        escaped += e.escaped;
    }
    printf("exits     %7.3f M/s   escaped %.4f   flux %.6g\n", particles / (clock_cpu_s() - begin) * 1e-6,
           (double)escaped / particles, flux);
}

int main(int argument_count, char **arguments) {
    if (argument_count < 2) {
        fprintf(stderr, "usage: bench_transport SCENE.xml [PASSES [WIDTHxHEIGHT [INTEGRATOR [LAMP]]]]\n");
        return 2;
    }
    struct scene scene;
    struct run run = {.threads = 1, .seed = 1};
    struct error error = {0};
    int passes = argument_count > 2 ? atoi(arguments[2]) : 64, failed = 0;
    const char *only = argument_count > 4 ? arguments[4] : NULL;
    struct definition lamp = {"lamp", argument_count > 5 ? arguments[5] : ""};
    struct scene_options options = {.threads = 1, .skip_missing = true, .cache_radiance = true};
    if (argument_count > 3) sscanf(arguments[3], "%dx%d", &options.width, &options.height);
    if (argument_count > 5) {
        options.definitions = &lamp;
        options.definition_count = 1;
    }
    if (scene_load(&scene, arguments[1], &options, &run, &error)) {
        fprintf(stderr, "%s\n", error.text);
        return 1;
    }
    for (size_t i = 0; scene.sensor && integrator_table[i] && !failed; i++)
        if (!only || strcmp(only, integrator_table[i]->name) == 0)
            failed = render(&scene, integrator_table[i], integrator_table[i]->name, passes, &run, &error);
    scene.cache_radiance = false;
    if (scene.sensor && !failed && (!only || strcmp(only, "exact") == 0))
        failed = render(&scene, &path_integrator, "exact", passes, &run, &error);
    scene_fini(&scene);
    if (only && !failed) return 0;
    if (!failed &&
        !scene_load(&scene, arguments[1], &(struct scene_options){.threads = 1, .lamp_only = true}, &run, &error)) {
        exits(&scene);
        scene_fini(&scene);
    } else {
        fprintf(stderr, "%s\n", error.text);
        failed = 1;
    }
    return failed;
}
