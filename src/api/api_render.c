// sconce_render, sconce_compare, sconce_report.
#include <stdio.h>
#include <string.h>

#include "api/api_run.h"
#include "render/render.h"
#include "report/compare.h"
#include "report/report.h"
#include "trace/integrator.h"

static enum status integrator_choose(struct scene *scene, const char *name, struct error *error) {
    if (!name || integrator_find(&scene->integrator, name)) return STATUS_OK;
    return error_set(error, STATUS_INVALID, "there is no integrator '%s'; use path, bdpt or particle", name);
}

enum sconce_status sconce_render(const struct sconce_render_options *options, const struct sconce_run *run,
                                 struct sconce_render_result *result, struct sconce_error *error) {
    struct api_run api;
    struct error inner = {0};
    struct scene scene = {0};
    struct render_result rendered = {0};
    api_run_init(&api, run);
    struct scene_options load = {.definitions = (const struct definition *)options->definitions,
                                 .definition_count = options->definition_count,
                                 .skip_missing = options->skip_missing,
                                 .share_light = !options->exact,
                                 .unbiased = options->unbiased,
                                 .width = options->width,
                                 .height = options->height,
                                 .threads = api.run.threads};
    double start = clock_wall_s();
    enum status status = scene_load(&scene, options->scene, &load, &api.run, &inner);
    if (status) return api_status(status, &inner, error);
    double load_s = clock_wall_s() - start;
    if (options->max_depth) scene.max_depth = options->max_depth;
    status = integrator_choose(&scene, options->integrator, &inner);
    struct render_options render = {.output = options->output,
                                    .samples = options->samples,
                                    .seconds = options->seconds,
                                    .exposure = options->exposure,
                                    .mask = options->mask,
                                    .png = options->png};
    if (!status) status = render_scene(&scene, &render, &api.run, &rendered, &inner);
    if (result) {
        *result = (struct sconce_render_result){.width = rendered.width,
                                                .height = rendered.height,
                                                .samples = rendered.samples,
                                                .wall_s = rendered.wall_s,
                                                .cpu_s = rendered.cpu_s,
                                                .load_s = load_s};
        snprintf(result->integrator, sizeof result->integrator, "%s", integrator_table[scene.integrator]->name);
        memcpy(result->mean, rendered.mean, sizeof result->mean);
    }
    scene_fini(&scene);
    return api_status(status, &inner, error);
}

_Static_assert(sizeof(struct definition) == sizeof(struct sconce_definition),
               "definitions are passed through as they are");

enum sconce_status sconce_compare(const char *image, const char *reference, const char *mask,
                                  struct sconce_comparison *comparison, struct sconce_error *error) {
    struct error inner = {0};
    struct comparison c = {0};
    enum status status = compare_files(image, reference, mask, &c, &inner);
    const struct metrics *m = &c.metrics;
    *comparison = (struct sconce_comparison){.mse = m->mse,
                                             .rel_mse = m->rel_mse,
                                             .psnr_db = m->psnr_db,
                                             .psnr_log_db = m->psnr_log_db,
                                             .flip = m->flip,
                                             .rel_mse_corrected = c.rel_mse_corrected,
                                             .mean_ratio = {m->mean_ratio[0], m->mean_ratio[1], m->mean_ratio[2]},
                                             .block_error_max = m->block_error_max,
                                             .block_error_mean = m->block_error_mean,
                                             .pixel_count = m->pixel_count};
    return api_status(status, &inner, error);
}

enum sconce_status sconce_report(const struct sconce_report_options *options, struct sconce_error *error) {
    struct error inner = {0};
    struct report_options report = {
        .output = options->output,
        .title = options->title ? options->title : "sconce",
        .reference = {options->reference.name, options->reference.image, options->reference.json},
        .entries = (const struct report_entry *)options->entries,
        .entry_count = options->entry_count,
        .mask_path = options->mask,
        .bake_json_path = options->bake_json};
    return api_status(report_write(&report, &inner), &inner, error);
}

_Static_assert(sizeof(struct report_entry) == sizeof(struct sconce_report_entry),
               "entries are passed through as they are");
