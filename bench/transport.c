// Speed and efficiency of the integrators on one scene, on one thread:
//   bench_transport SCENE.xml [PASSES [WIDTHxHEIGHT [INTEGRATOR [LAMP]]]]     (LAMP: value of the scene's "lamp")
// prints for each integrator, and for path without any sharing of light ("exact"), paths per CPU second and relMSE x
// CPU seconds (mean over pixels of variance / (mean^2 + 1e-3), times the time it took: what is left does not depend
// much on the number of passes, less is better; the variance is that between two seeds, for a picture's own knows
// nothing of what pixels share), then, unless one integrator is named, for the scene as a lamp its particles per CPU
// second; of the path tracer also the share of each stage in its time. Built on request: ninja bench_transport.
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "trace/integrator.h"
#include "trace/particle_exit.h"
#include "trace/path_state.h"

static enum status render(const struct scene *scene, const struct integrator_type *type, int passes, struct run *run,
                          struct image *image, double *seconds, double stage_s[PATH_STAGES], struct error *error) {
    void *state = NULL;
    struct film film = {0};
    const double begin = clock_cpu_s();
    enum status status = film_init(&film, scene->sensor, error);
    if (!status) status = type->create(scene, run, &state, error);
    for (int pass = 0; !status && pass < passes; pass++) {
        status = type->render_pass(state, &film, (uint64_t)pass, run, error);
        if (!status) film_end_pass(&film, 1);
    }
    if (!status) status = integrator_image(type, state, &film, run, image, error);
    *seconds += clock_cpu_s() - begin;
    for (int i = 0; i < PATH_STAGES && !status && type == &path_integrator; i++)
        stage_s[i] += ((const struct path_tracer *)state)->workers->stage_s[i];
    if (state) type->destroy(state);
    film_fini(&film);
    return status;
}

static enum status measure(const struct scene *scene, const struct integrator_type *type, const char *name, int passes,
                           struct error *error) {
    struct image images[2] = {0};
    double seconds = 0, mean = 0, relative = 0, stage_s[PATH_STAGES] = {0}, stages_s = 0;
    enum status status = STATUS_OK;
    for (int i = 0; i < 2 && !status; i++) {
        struct run run = {.threads = 1, .seed = (uint64_t)i + 1};
        status = render(scene, type, passes, &run, &images[i], &seconds, stage_s, error);
    }
    const size_t count = (size_t)images[0].width * (size_t)images[0].height;
    for (size_t i = 0; i < 3 * count && !status; i++) {
        const double a = (double)images[0].pixels[i / 3 * 6 + i % 3], b = (double)images[1].pixels[i / 3 * 6 + i % 3];
        const double level = 0.5 * (a + b);
        mean += level / (3 * (double)count);
        relative += 0.5 * (a - b) * (a - b) / (level * level + 1e-3) / (3 * (double)count);
    }
    if (!status)
        printf("%-9s %7.3f Mpaths/s   mean %.5g   relMSE x CPU s %.5g\n", name,
               2 * (double)count * passes / seconds * 1e-6, mean, 0.5 * relative * seconds);
    for (int i = 0; i < PATH_STAGES; i++) stages_s += stage_s[i];
    for (int i = 0; i < PATH_STAGES && stages_s > 0; i++)
        printf("  %-10s %5.1f %%\n", path_stages[i].name, 100 * stage_s[i] / stages_s);
    for (int i = 0; i < 2; i++) image_fini(&images[i]);
    return status;
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
    struct scene_options options = {.threads = 1, .skip_missing = true, .share_light = true};
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
            failed = measure(&scene, integrator_table[i], integrator_table[i]->name, passes, &error) != STATUS_OK;
    scene.share_light = false;
    if (scene.sensor && !failed && (!only || strcmp(only, "exact") == 0))
        failed = measure(&scene, &path_integrator, "exact", passes, &error) != STATUS_OK;
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
