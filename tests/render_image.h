// For tests of the integrators: renders a scene, from a file or from text, into a mean and a variance per pixel.
#pragma once

#include "scene_from_text.h"
#include "trace/integrator.h"

struct rendering {
    int width, height;
    struct image image; // channels R G B, then the variance of each pixel's mean
    double mean[3], error[3]; // of the whole image, and their standard errors
};

static inline enum status rendering_from_film(struct rendering *result, const struct integrator_type *type,
                                              const void *state, const struct film *film, const struct run *run,
                                              struct error *error) {
    *result = (struct rendering){.width = film->width, .height = film->height};
    enum status status = integrator_image(type, state, film, run, &result->image, error);
    size_t count = (size_t)result->width * (size_t)result->height;
    for (size_t i = 0; status == STATUS_OK && i < 3 * count; i++) {
        result->mean[i % 3] += result->image.pixels[i / 3 * 6 + i % 3] / (double)count;
        result->error[i % 3] += result->image.pixels[i / 3 * 6 + 3 + i % 3] / ((double)count * (double)count);
    }
    for (int c = 0; c < 3; c++) result->error[c] = sqrt(result->error[c]);
    return status;
}

// Ends the scene.
static inline enum status render_scene(struct scene *scene, const struct integrator_type *type, int passes, int threads,
                                       uint64_t seed, struct rendering *result, struct error *error) {
    struct run run = {.threads = threads, .seed = seed};
    void *state = NULL;
    struct film film = {0};
    enum status status = film_init(&film, scene->sensor, error);
    if (status == STATUS_OK) status = type->create(scene, &run, &state, error);
    for (int pass = 0; status == STATUS_OK && pass < passes; pass++) {
        status = type->render_pass(state, &film, (uint64_t)pass, &run, error);
        if (status == STATUS_OK) film_end_pass(&film, 1);
    }
    if (status == STATUS_OK) status = rendering_from_film(result, type, state, &film, &run, error);
    if (state) type->destroy(state);
    film_fini(&film);
    scene_fini(scene);
    return status;
}

static inline enum status render_file(const char *path, const struct integrator_type *type, int passes, int threads,
                                      uint64_t seed, struct rendering *result, struct error *error) {
    struct scene scene;
    struct run run = {.threads = threads, .seed = seed};
    enum status status = scene_load(&scene, path, &(struct scene_options){.threads = 1}, &run, error);
    return status ? status : render_scene(&scene, type, passes, threads, seed, result, error);
}

static inline enum status render_text(const char *xml, const struct integrator_type *type, int passes, int threads,
                                      uint64_t seed, struct rendering *result, struct error *error) {
    struct scene scene;
    enum status status = scene_from_document(&scene, xml, error);
    return status ? status : render_scene(&scene, type, passes, threads, seed, result, error);
}
