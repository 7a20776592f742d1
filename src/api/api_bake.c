// sconce_bake, sconce_evaluate.
#include <string.h>

#include "api/api_run.h"
#include "bake/bake.h"

static void figures_fill(struct sconce_figures *figures, const struct evaluation *e) {
    *figures = (struct sconce_figures){.distance_count = EVALUATION_DISTANCES,
                                       .light_field_error = e->light_field_error,
                                       .light_field_error_black = 1,
                                       .transparency_error = e->transparency_error,
                                       .transparency_error_black = e->transparency_error_opaque,
                                       .transparency_noise = e->transparency_noise,
                                       .wall_measured = e->wall_measured,
                                       .wall_relmse = e->wall_relmse,
                                       .wall_relmse_noise = e->wall_relmse_noise,
                                       .wall_flip = e->wall_flip,
                                       .wall_flip_noise = e->wall_flip_noise,
                                       .view_measured = e->view_measured,
                                       .view_gain_db = e->view_gain_db,
                                       .view_samples = e->view_samples,
                                       .view_flip = e->view_flip,
                                       .view_flip_black = e->view_flip_black,
                                       .view_flip_noise = e->view_flip_noise,
                                       .surface_measured = e->surface_measured,
                                       .surface_gain_db = e->surface_gain_db,
                                       .surface_flip = e->surface_flip,
                                       .sample_variance = e->sample_variance,
                                       .sample_variance_uniform = e->sample_variance_uniform};
    memcpy(figures->flux, e->flux, sizeof figures->flux);
    memcpy(figures->flux_error, e->flux_error, sizeof figures->flux_error);
    memcpy(figures->flux_noise, e->flux_noise, sizeof figures->flux_noise);
    for (int i = 0; i < EVALUATION_DISTANCES; i++) {
        figures->distance_radii[i] = evaluation_distance_radii[i];
        figures->irradiance_error[i] = e->irradiance_error[i];
        figures->irradiance_noise[i] = e->irradiance_noise[i];
    }
}

static enum status choice_parse(int *choice, const char *const names[3], const char *what, const char *name,
                                struct error *error) {
    for (*choice = 0; *choice < 3; ++*choice)
        if (!strcmp(name, names[*choice])) return STATUS_OK;
    return error_set(error, STATUS_INVALID, "there is no %s '%s'; use %s, %s or %s", what, name, names[0], names[1],
                     names[2]);
}

static enum status quality_parse(int *quality, const char *name, struct error *error) {
    static const char *const qualities[] = {[BAKE_DRAFT] = "draft", [BAKE_STANDARD] = "standard", [BAKE_HIGH] = "high"};
    return choice_parse(quality, qualities, "quality", name ? name : "standard", error);
}

static enum status choices_parse(struct bake_options *bake, const struct sconce_bake_options *options,
                                 struct error *error) {
    static const char *const sizes[] = {
        [BAKE_SIZE_SMALL] = "small", [BAKE_SIZE_DEFAULT] = "default", [BAKE_SIZE_LARGE] = "large"};
    const char *view = options->view ? options->view : "hull";
    static const char *const groupings[] = {
        [BAKE_GROUPS_NONE] = "none", [BAKE_GROUPS_NAMED] = "named", [BAKE_GROUPS_EACH] = "each"};
    int quality, size, groups;
    enum status status = quality_parse(&quality, options->quality, error);
    if (!status) status = choice_parse(&size, sizes, "size", options->size ? options->size : "default", error);
    if (!status)
        status = choice_parse(&groups, groupings, "grouping", options->groups ? options->groups : "none", error);
    if (!status && strcmp(view, "hull") && strcmp(view, "none"))
        status = error_set(error, STATUS_INVALID, "there is no view '%s'; use hull or none", view);
    if (status) return status;
    bake->quality = (enum bake_quality)quality;
    bake->size = (enum bake_size)size;
    bake->view = strcmp(view, "none") ? BAKE_VIEW_HULL : BAKE_VIEW_NONE;
    bake->groups = (enum bake_groups)groups;
    return STATUS_OK;
}

static enum status preset_parse(struct bake_options *bake, const char *name, struct error *error) {
    if (strcmp(name, "compact") && strcmp(name, "paper"))
        return error_set(error, STATUS_INVALID, "there is no preset '%s'; use compact or paper", name);
    bake->preset = strcmp(name, "paper") ? BAKE_COMPACT : BAKE_PAPER;
    return STATUS_OK;
}

static void proxy_parse(struct bake_options *bake, const char *name) {
    if (!strcmp(name, "auto"))
        bake->proxy = BAKE_PROXY_AUTO;
    else if (!strcmp(name, "sphere"))
        bake->proxy = BAKE_PROXY_SPHERE;
    else if (!strcmp(name, "box"))
        bake->proxy = BAKE_PROXY_BOX;
    else if (!strcmp(name, "cylinder"))
        bake->proxy = BAKE_PROXY_CYLINDER;
    else {
        bake->proxy = BAKE_PROXY_MESH;
        bake->proxy_path = name;
    }
}

enum sconce_status sconce_bake(const struct sconce_bake_options *options, const struct sconce_run *run,
                               struct sconce_figures *figures, struct sconce_error *error) {
    struct api_run api;
    struct error inner = {0};
    struct bake_report report = {0};
    api_run_init(&api, run);
    struct bake_options bake = {.lamp_path = options->lamp,
                                .output_path = options->output,
                                .definitions = (const struct definition *)options->definitions,
                                .definition_count = options->definition_count,
                                .skip_missing = options->skip_missing,
                                .seconds = options->seconds,
                                .resume = options->resume};
    proxy_parse(&bake, options->proxy ? options->proxy : "auto");
    enum status status = choices_parse(&bake, options, &inner);
    if (!status) status = preset_parse(&bake, options->preset ? options->preset : "compact", &inner);
    if (!status) status = bake_lamp(&bake, &api.run, &report, &inner);
    if (!status && figures) {
        figures_fill(figures, &report.evaluation);
        figures->bytes = report.bytes;
        figures->seconds = report.seconds;
    }
    return api_status(status, &inner, error);
}

enum sconce_status sconce_evaluate(const struct sconce_evaluate_options *options, const struct sconce_run *run,
                                   struct sconce_figures *figures, struct sconce_error *error) {
    struct api_run api;
    struct error inner = {0};
    struct evaluation evaluation = {0};
    api_run_init(&api, run);
    double start = clock_wall_s();
    const struct scene_options lamp = {.definitions = (const struct definition *)options->definitions,
                                       .definition_count = options->definition_count,
                                       .skip_missing = options->skip_missing};
    int quality;
    enum status status = quality_parse(&quality, options->quality, &inner);
    if (!status)
        status = bake_evaluate(options->luminaire, options->lamp, &lamp, (enum bake_quality)quality, &api.run,
                               &evaluation, &inner);
    if (!status && figures) {
        figures_fill(figures, &evaluation);
        figures->seconds = clock_wall_s() - start;
        struct luminaire *file;
        if (!luminaire_load(&file, options->luminaire, NULL)) {
            figures->bytes = luminaire_bytes(file);
            luminaire_destroy(file);
        }
    }
    return api_status(status, &inner, error);
}
