// Rendering, from a committed scene to an image file: passes of one sample per pixel until the samples or the seconds
// are used up, then mean and variance to disk.
#include "render/render.h"

#include <stdio.h>

#include "image/metric.h"
#include "trace/film.h"
#include "trace/integrator.h"

static enum status render_save(const struct image *image, const struct render_options *options,
                               struct render_result *result, struct error *error) {
    double sum[3] = {0};
    size_t pixels = (size_t)image->width * (size_t)image->height;
    for (size_t i = 0; i < pixels; i++)
        for (int c = 0; c < 3; c++) sum[c] += image->pixels[i * (size_t)image->channels + (size_t)c];
    for (int c = 0; c < 3; c++) result->mean[c] = (float)(sum[c] / (double)pixels);
    float exposure = options->exposure > 0 ? options->exposure : image_auto_exposure(image);
    enum status status = image_save(image, options->output, exposure, error);
    if (!status && options->png) status = image_save(image, options->png, exposure, error);
    return status;
}

enum status render_scene(const struct scene *scene, const struct render_options *options, const struct run *run,
                         struct render_result *result, struct error *error) {
    if (!scene->sensor)
        return error_set(error, STATUS_INVALID,
                         "%s: the scene has no sensor; add <sensor type=\"perspective\"> to render it", scene->path);
    const struct integrator_type *type = integrator_table[scene->integrator];
    struct film film = {0};
    struct image image = {0};
    void *state = NULL;
    enum status status = film_init(&film, scene->sensor, error);
    if (!status && options->mask) status = render_mask(scene, options->mask, run, error);
    double wall = clock_wall_s(), cpu = clock_cpu_s();
    if (!status) status = type->create(scene, run, &state, error);
    int samples = options->samples > 0 ? options->samples : scene->sensor->sample_count;
    int done = 0;
    while (!status) {
        double elapsed = clock_wall_s() - wall;
        double limit = options->cpu_seconds > 0 ? options->cpu_seconds : options->seconds;
        double spent = options->cpu_seconds > 0 ? clock_cpu_s() - cpu : elapsed;
        double fraction = limit > 0 ? spent / limit : (double)done / samples;
        // A pass that would end more than half of itself late is not begun.
        double late = limit > 0 && done ? 0.5 * spent / done / limit : 0;
        if (done && fraction + late >= 1) break;
        char detail[64];
        snprintf(detail, sizeof detail, "%d spp", done);
        run_progress(run, type->name, fraction < 1 ? fraction : 1, elapsed, detail);
        if (run_cancelled(run)) status = STATUS_CANCELLED;
        if (status) break;
        status = type->render_pass(state, &film, (uint64_t)done, run, error);
        if (!status) {
            film_end_pass(&film, run->threads);
            done++;
        }
    }
    if (!status) run_progress(run, type->name, 1, clock_wall_s() - wall, NULL);
    const bool picture = done && (!status || status == STATUS_CANCELLED);
    enum status saved = STATUS_OK;
    if (picture) saved = integrator_image(type, state, &film, run, &image, status ? NULL : error);
    *result = (struct render_result){.width = film.width,
                                     .height = film.height,
                                     .samples = done,
                                     .wall_s = clock_wall_s() - wall,
                                     .cpu_s = clock_cpu_s() - cpu};
    if (status == STATUS_CANCELLED)
        error_set(error, STATUS_CANCELLED, "stopped after %d samples per pixel%s%s", done,
                  done ? "; the picture so far is in " : "", done ? options->output : "");
    if (picture && !saved) saved = render_save(&image, options, result, status ? NULL : error);
    if (!status) status = saved;
    image_fini(&image);
    if (state) type->destroy(state);
    film_fini(&film);
    return status;
}
