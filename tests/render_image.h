// For tests of the integrators: renders a scene, from a file or from text, into a mean and a variance per pixel.
#pragma once

#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

#include "trace/integrator.h"

struct rendering {
    int width, height;
    struct image image; // channels R G B, then the variance of each pixel's mean
    double mean[3], error[3]; // of the whole image, and their standard errors
};

static enum status render_file(const char *path, const struct integrator_type *type, int passes, int threads,
                               uint64_t seed, struct rendering *result, struct error *error) {
    struct scene scene;
    struct run run = {.threads = threads, .seed = seed};
    enum status status = scene_load(&scene, path, &(struct scene_options){.threads = 1}, &run, error);
    if (status != STATUS_OK) return status;
    void *state = NULL;
    struct film film = {0};
    status = film_init(&film, scene.sensor, error);
    if (status == STATUS_OK) status = type->create(&scene, &run, &state, error);
    for (int pass = 0; status == STATUS_OK && pass < passes; pass++) {
        status = type->render_pass(state, &film, (uint64_t)pass, &run, error);
        if (status == STATUS_OK) film_end_pass(&film, 1);
    }
    *result = (struct rendering){.width = film.width, .height = film.height};
    if (status == STATUS_OK) status = film_image(&film, &result->image, error);
    if (state) type->destroy(state);
    film_fini(&film);
    scene_fini(&scene);
    size_t count = (size_t)result->width * (size_t)result->height;
    for (size_t i = 0; status == STATUS_OK && i < 3 * count; i++) {
        result->mean[i % 3] += result->image.pixels[i / 3 * 6 + i % 3] / (double)count;
        result->error[i % 3] += result->image.pixels[i / 3 * 6 + 3 + i % 3] / ((double)count * (double)count);
    }
    for (int c = 0; c < 3; c++) result->error[c] = sqrt(result->error[c]);
    return status;
}

static inline enum status render_text(const char *xml, const struct integrator_type *type, int passes, int threads,
                                      uint64_t seed, struct rendering *result, struct error *error) {
    char path[] = "/tmp/sconce_test_render_XXXXXX.xml";
    int descriptor = mkstemps(path, 4);
    FILE *file = descriptor < 0 ? NULL : fdopen(descriptor, "w");
    if (!file) return error_set(error, STATUS_IO, "no temporary file");
    fputs(xml, file);
    fclose(file);
    enum status status = render_file(path, type, passes, threads, seed, result, error);
    unlink(path);
    return status;
}
