// Measures a luminaire through the calls that a renderer uses, against particles and lines traced with random numbers
// that no training has used.
#include "bake/evaluate.h"

#include <jansson.h>
#include <stdlib.h>
#include <string.h>

#include "bake/evaluate_private.h"
#include "bake/line_bins.h"
#include "bake/survey.h"
#include "base/parallel.h"

const struct evaluation_effort evaluation_efforts[] = {
    [BAKE_DRAFT] = {4000000, 8000000, 128, 4096, 32, 4},
    [BAKE_STANDARD] = {16000000, 64000000, 128, 4096, 128, 64},
    [BAKE_HIGH] = {16000000, 64000000, 128, 4096, 128, 512},
};
const struct evaluation_effort evaluation_effort_paper = {16000000, 1000000, 32, 4096, 8, 4};

static const double particle_us = 2, line_us = 0.6, view_line_us = 1.3; // of one core, about: for the progress

enum { EVAL_BATCH = 1 << 16, BATCHES = 8 }; // noise is measured by how the batches differ
enum { GUIDE_EXITS = 2000000 }; // of its own lamp's light: few leave gaps that make the luminaire's lines noisy

struct eval_job { // lines [i * 4096 ...) of a batch
    const struct luminaire *luminaire;
    size_t n;
    const struct line_sample *lines;
    float (*value)[3];
};

enum { EVAL_BLOCK = 4096 };

static void eval_block(void *user, size_t block, int worker) {
    (void)worker;
    const struct eval_job *job = user;
    float point[EVAL_BLOCK][3], w[EVAL_BLOCK][3];
    size_t begin = block * EVAL_BLOCK, n = job->n - begin < EVAL_BLOCK ? job->n - begin : EVAL_BLOCK;
    for (size_t i = 0; i < n; i++) {
        memcpy(point[i], job->lines[begin + i].point, sizeof point[i]);
        memcpy(w[i], job->lines[begin + i].w, sizeof w[i]);
    }
    luminaire_eval(job->luminaire, n, (const float(*)[3])point, (const float(*)[3])w, job->value + begin);
}

struct flux_sums { // of batches of one size
    double sum[3], squares[3];
    size_t batches;
};

static void flux_sums_add(struct flux_sums *sums, const double flux[3]) { // the mean of a batch
    for (int c = 0; c < 3; c++) {
        sums->sum[c] += flux[c];
        sums->squares[c] += flux[c] * flux[c];
    }
    sums->batches++;
}

static double flux_mean(const struct flux_sums *sums, int c) { return sums->sum[c] / (double)sums->batches; }

static double flux_noise(const struct flux_sums *sums, int c) { // relative standard error
    double n = (double)sums->batches, mean = flux_mean(sums, c);
    return mean > 0 && n > 1 ? sqrt(fmax(0, sums->squares[c] / n - mean * mean) / (n - 1)) / mean : 0;
}

static void add_lines(const struct line_sample *lines, const float (*value)[3], struct line_bins *bins,
                      double flux[3]) {
    for (size_t i = 0; i < EVAL_BATCH; i++) {
        const struct line_sample *line = &lines[i];
        if (!(line->mass > 0)) continue;
        float y[3];
        for (int c = 0; c < 3; c++) {
            y[c] = value[i][c] * line->mass;
            flux[c] += (double)y[c];
        }
        line_bins_add(bins, vec3_from(line->point), vec3_from(line->w), (y[0] + y[1] + y[2]) * (1.0f / 3));
    }
}

// The luminaire's light by lines from the guide: its flux, and its bins.
static enum status bin_luminaire(const struct luminaire *luminaire, const struct lamp *lamp,
                                 const struct line_guide *guide, size_t line_count, struct line_bins *bins,
                                 struct flux_sums *sums, struct error *error) {
    struct line_sample *lines = malloc(EVAL_BATCH * sizeof *lines);
    float(*value)[3] = malloc(EVAL_BATCH * sizeof *value);
    size_t pieces = (line_count + BATCHES * EVAL_BATCH - 1) / (BATCHES * EVAL_BATCH), at = 0;
    for (int batch = 0; batch < BATCHES && lines && value; batch++) {
        double flux[3] = {0, 0, 0};
        for (size_t piece = 0; piece < pieces; piece++, at += EVAL_BATCH) {
            gather_lines(lines, lamp, guide, STREAM_EVALUATION, at, EVAL_BATCH, false);
            struct eval_job job = {luminaire, EVAL_BATCH, lines, value};
            parallel_for(lamp->threads, EVAL_BATCH / EVAL_BLOCK, eval_block, &job);
            add_lines(lines, (const float(*)[3])value, bins, flux);
        }
        line_bins_close_batch(bins, pieces * EVAL_BATCH);
        for (int c = 0; c < 3; c++) flux[c] /= (double)(pieces * EVAL_BATCH);
        flux_sums_add(sums, flux);
    }
    enum status status =
        lines && value ? STATUS_OK : error_set(error, STATUS_MEMORY, "out of memory for the evaluation");
    free(lines);
    free(value);
    return status;
}

static void add_exits(const struct exit_list *list, struct line_bins *bins, struct flux_sums *sums) {
    double flux[3] = {0, 0, 0};
    for (size_t i = 0; i < list->count; i++) {
        const struct line_exit *x = &list->exits[i];
        for (int c = 0; c < 3; c++) flux[c] += (double)x->flux[c] / (double)list->emitted;
        line_bins_add(bins, vec3_from(x->point), vec3_from(x->w), (x->flux[0] + x->flux[1] + x->flux[2]) * (1.0f / 3));
    }
    line_bins_close_batch(bins, list->emitted);
    flux_sums_add(sums, flux);
}

static enum status keep_exits(struct exit_list *kept, const struct exit_list *list, struct error *error) {
    size_t count = kept->count + list->count;
    struct line_exit *exits = realloc(kept->exits, (count + 1) * sizeof *exits);
    if (!exits) return error_set(error, STATUS_MEMORY, "out of memory for %zu exits", count);
    memcpy(exits + kept->count, list->exits, list->count * sizeof *exits);
    kept->exits = exits;
    kept->count = count;
    return STATUS_OK;
}

void evaluation_report(const struct evaluation_progress *progress, double fraction) {
    run_progress(progress->run, "evaluating", progress->first + (progress->last - progress->first) * fraction,
                 clock_wall_s() - progress->start, NULL);
}

// The lamp's particles, batch by batch: no more of them are held at once than a batch and `kept`, the first GUIDE_EXITS
// or so. The first batch is the survey's.
static enum status bin_particles(const struct lamp *lamp, const struct survey *survey,
                                 const struct evaluation_progress *progress, struct line_bins *bins, struct wall *wall,
                                 struct flux_sums *sums, struct exit_list *kept, struct error *error) {
    const size_t n = survey->exits.emitted;
    for (size_t batch = 0; batch < BATCHES; batch++) {
        struct exit_list list = {0};
        if (batch > 0) {
            enum status status =
                gather_exits(&list, lamp, STREAM_EVALUATION, batch * n, n, false, progress->run, error);
            if (status != STATUS_OK) return status;
        }
        const struct exit_list *exits = batch > 0 ? &list : &survey->exits;
        add_exits(exits, bins, sums);
        wall_add(wall, exits, batch & 1);
        enum status status = kept->count < GUIDE_EXITS ? keep_exits(kept, exits, error) : STATUS_OK;
        exit_list_fini(&list);
        if (status != STATUS_OK) return status;
        evaluation_report(progress, 0.6 * (double)(batch + 1) / BATCHES);
    }
    return STATUS_OK;
}

static enum status compare_light(const struct luminaire *luminaire, const struct lamp *lamp,
                                 const struct survey *survey, size_t lines, const struct evaluation_progress *progress,
                                 struct wall *wall, struct evaluation *evaluation, struct error *error) {
    vec3 center = vec3_from(lamp->proxy.center);
    struct line_guide *guide = NULL;
    struct line_bins reference = {0}, model = {0};
    struct flux_sums flux_reference = {0}, flux_model = {0};
    struct exit_list kept = {0};
    enum status status = line_bins_init(&reference, center, lamp->proxy.radius, error);
    if (status == STATUS_OK) status = line_bins_init(&model, center, lamp->proxy.radius, error);
    if (status == STATUS_OK)
        status = bin_particles(lamp, survey, progress, &reference, wall, &flux_reference, &kept, error);
    struct line_guide_options options = {.center = center,
                                         .radius = lamp->proxy.radius,
                                         .exits = kept.exits,
                                         .exit_count = kept.count,
                                         .exponent = 0.75f,
                                         .clusters = survey->clusters,
                                         .cluster_count = survey->cluster_count,
                                         .cluster_share = 0.5f * survey->clear_share};
    if (status == STATUS_OK) status = line_guide_create(&guide, &options, error);
    if (status == STATUS_OK) status = bin_luminaire(luminaire, lamp, guide, lines, &model, &flux_model, error);
    if (status == STATUS_OK) {
        for (int c = 0; c < 3; c++) {
            double flux = flux_mean(&flux_reference, c), model_flux = flux_mean(&flux_model, c);
            evaluation->flux[c] = (float)flux;
            evaluation->flux_noise[c] = (float)hypot(flux_noise(&flux_reference, c), flux_noise(&flux_model, c));
            evaluation->flux_error[c] = flux > 0 ? (float)(model_flux / flux - 1) : (float)model_flux;
        }
        for (int k = 0; k < EVALUATION_DISTANCES; k++)
            line_bins_irradiance_error(&model, &reference, k, &evaluation->irradiance_error[k],
                                       &evaluation->irradiance_noise[k]);
        evaluation->light_field_error = line_bins_radiance_error(&model, &reference);
    }
    line_guide_destroy(guide);
    exit_list_fini(&kept);
    line_bins_fini(&reference);
    line_bins_fini(&model);
    return status;
}

enum status evaluate_luminaire(const struct luminaire *luminaire, const struct scene *scene,
                               const struct evaluation_effort *effort, const struct run *run,
                               struct evaluation *evaluation, struct error *error) {
    *evaluation = (struct evaluation){0};
    struct lamp lamp = {.scene = scene, .proxy = {.kind = PROXY_SPHERE}, .seed = run->seed, .threads = run->threads};
    luminaire_bounds(luminaire, lamp.proxy.center, &lamp.proxy.radius);
    const int pixels = EVALUATION_VIEWS * EVALUATION_PIXELS * EVALUATION_PIXELS;
    const double views = (double)pixels * effort->view_samples * view_line_us;
    const double others = (double)effort->particles * particle_us + (double)effort->lines * line_us;
    const double before = others / (others + views);
    struct evaluation_progress progress = {run, clock_wall_s(), 0, before};
    evaluation_report(&progress, 0);
    struct wall wall = {0};
    struct survey *survey = calloc(1, sizeof *survey);
    enum status status = survey ? STATUS_OK : error_set(error, STATUS_MEMORY, "out of memory for the evaluation");
    if (status == STATUS_OK) status = proxy_shape_init(&lamp.shape, &lamp.proxy, error);
    if (status == STATUS_OK) status = wall_init(&wall, &lamp, error);
    if (status == STATUS_OK) status = survey_clusters(survey, &lamp, error);
    struct aim aims[SURVEY_CLUSTERS];
    for (size_t i = 0; status == STATUS_OK && i < survey->cluster_count; i++)
        aims[i] = (struct aim){survey->clusters[i].center, 1.05f * survey->clusters[i].radius};
    lamp.aims = aims;
    lamp.aim_count = survey ? survey->cluster_count : 0;
    if (status == STATUS_OK)
        status = survey_exits(survey, &lamp, STREAM_EVALUATION, effort->particles / BATCHES, run, error);
    if (status == STATUS_OK)
        status = compare_light(luminaire, &lamp, survey, effort->lines, &progress, &wall, evaluation, error);
    evaluation_report(&progress, 0.85);
    if (status == STATUS_OK && effort->wall_samples > 0)
        status = wall_compare(&wall, luminaire, &lamp, effort->wall_samples, evaluation, error);
    evaluation->transparency_measured = effort->transparency_lines > 0;
    evaluation->sampling_measured = effort->light_points > 0;
    if (status == STATUS_OK && evaluation->transparency_measured)
        status = evaluate_transparency(luminaire, &lamp, effort->transparency_lines, evaluation, error);
    evaluation_report(&progress, 0.95);
    if (status == STATUS_OK && evaluation->sampling_measured)
        status = evaluate_sampling(luminaire, &lamp, effort->light_points, evaluation, error);
    progress.first = before;
    progress.last = 1;
    if (status == STATUS_OK && effort->view_samples > 0)
        status = evaluate_views(luminaire, &lamp, effort->view_samples, &progress, evaluation, error);
    evaluation_report(&progress, 1);
    if (survey) survey_fini(survey);
    free(survey);
    wall_fini(&wall);
    proxy_shape_fini(&lamp.shape);
    return status;
}

static json_t *json_floats(const float *values, int n) {
    json_t *array = json_array();
    for (int i = 0; i < n; i++) json_array_append_new(array, json_real((double)values[i]));
    return array;
}

char *evaluation_json(const struct evaluation *e) {
    json_t *root = json_object();
    json_object_set_new(root, "flux", json_floats(e->flux, 3));
    json_object_set_new(root, "flux_noise", json_floats(e->flux_noise, 3));
    json_object_set_new(root, "flux_error", json_floats(e->flux_error, 3));
    json_object_set_new(root, "distance_radii", json_floats(evaluation_distance_radii, EVALUATION_DISTANCES));
    json_object_set_new(root, "irradiance_error", json_floats(e->irradiance_error, EVALUATION_DISTANCES));
    json_object_set_new(root, "irradiance_noise", json_floats(e->irradiance_noise, EVALUATION_DISTANCES));
    json_object_set_new(root, "light_field_error", json_real((double)e->light_field_error));
    if (e->transparency_measured) {
        json_object_set_new(root, "transparency_error", json_real((double)e->transparency_error));
        json_object_set_new(root, "transparency_error_opaque", json_real((double)e->transparency_error_opaque));
        json_object_set_new(root, "transparency_noise", json_real((double)e->transparency_noise));
    }
    if (e->sampling_measured) {
        json_object_set_new(root, "sample_variance", json_real((double)e->sample_variance));
        json_object_set_new(root, "sample_variance_uniform", json_real((double)e->sample_variance_uniform));
    }
    if (e->wall_measured)
        json_object_set_new(root, "wall",
                            json_pack("{s:f, s:f, s:f, s:f}", "relmse", (double)e->wall_relmse, "relmse_noise",
                                      (double)e->wall_relmse_noise, "flip", (double)e->wall_flip, "flip_noise",
                                      (double)e->wall_flip_noise));
    if (e->view_measured)
        json_object_set_new(root, "view",
                            json_pack("{s:i, s:f, s:f, s:f, s:f}", "samples", e->view_samples, "gain_db",
                                      (double)e->view_gain_db, "flip", (double)e->view_flip, "flip_black",
                                      (double)e->view_flip_black, "flip_noise", (double)e->view_flip_noise));
    if (e->surface_measured)
        json_object_set_new(
            root, "surface",
            json_pack("{s:f, s:f}", "gain_db", (double)e->surface_gain_db, "flip", (double)e->surface_flip));
    char *text = root ? json_dumps(root, JSON_COMPACT | JSON_REAL_PRECISION(6)) : NULL;
    json_decref(root);
    return text;
}
