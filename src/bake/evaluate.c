// Measures a luminaire through the calls that a renderer uses, against particles and lines traced with random numbers
// that no training has used.
#include "bake/evaluate.h"

#include <jansson.h>
#include <stdlib.h>
#include <string.h>

#include "bake/line_bins.h"
#include "bake/survey.h"
#include "base/parallel.h"
#include "math/warp.h"

const struct evaluation_effort evaluation_effort_full = {4000000, 4000000, 128, 1024};

enum { EVAL_BATCH = 1 << 16, LIGHT_SAMPLES = 4096, LINE_REPEATS = 64 };

static vec3 vec3_from(const float v[3]) { return (vec3){v[0], v[1], v[2]}; }

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

// The luminaire's light by lines from the guide: its flux, and its bins.
static enum status bin_luminaire(const struct luminaire *luminaire, const struct lamp *lamp,
                                 const struct line_guide *guide, size_t line_count, struct line_bins *bins,
                                 double flux[3], double noise[3], struct error *error) {
    struct line_sample *lines = malloc(EVAL_BATCH * sizeof *lines);
    float(*value)[3] = malloc(EVAL_BATCH * sizeof *value);
    size_t batches = (line_count + EVAL_BATCH - 1) / EVAL_BATCH;
    double squares[3] = {0, 0, 0};
    for (size_t b = 0; b < batches && lines && value; b++) {
        gather_lines(lines, lamp, guide, STREAM_EVALUATION, b * EVAL_BATCH, EVAL_BATCH, false);
        struct eval_job job = {luminaire, EVAL_BATCH, lines, value};
        parallel_for(lamp->threads, EVAL_BATCH / EVAL_BLOCK, eval_block, &job);
        for (size_t i = 0; i < EVAL_BATCH; i++) {
            const struct line_sample *line = &lines[i];
            if (!(line->mass > 0)) continue;
            float y[3];
            for (int c = 0; c < 3; c++) {
                y[c] = value[i][c] * line->mass;
                flux[c] += (double)y[c];
                squares[c] += (double)y[c] * (double)y[c];
            }
            line_bins_add(bins, vec3_from(line->point), vec3_from(line->w), (y[0] + y[1] + y[2]) * (1.0f / 3));
        }
    }
    bins->samples = batches * EVAL_BATCH;
    for (int c = 0; c < 3; c++) {
        double n = (double)bins->samples;
        flux[c] /= n;
        noise[c] = flux[c] > 0 ? sqrt(fmax(0, squares[c] / n - flux[c] * flux[c]) / n) / flux[c] : 0;
    }
    enum status status =
        lines && value ? STATUS_OK : error_set(error, STATUS_MEMORY, "out of memory for the evaluation");
    free(lines);
    free(value);
    return status;
}

static void bin_exits(const struct exit_list *list, struct line_bins *bins) {
    for (size_t i = 0; i < list->count; i++) {
        const struct line_exit *x = &list->exits[i];
        line_bins_add(bins, vec3_from(x->point), vec3_from(x->w), (x->flux[0] + x->flux[1] + x->flux[2]) * (1.0f / 3));
    }
    bins->samples = list->emitted;
}

static enum status compare_light(const struct luminaire *luminaire, const struct lamp *lamp,
                                 const struct survey *survey, size_t lines, struct evaluation *evaluation,
                                 struct error *error) {
    vec3 center = vec3_from(lamp->proxy.center);
    struct line_guide_options options = {.center = center,
                                         .radius = lamp->proxy.radius,
                                         .exits = survey->exits.exits,
                                         .exit_count = survey->exits.count,
                                         .exponent = 0.75f,
                                         .clusters = survey->clusters,
                                         .cluster_count = survey->cluster_count,
                                         .cluster_share = 0.5f * survey->clear_share};
    struct line_guide *guide = NULL;
    struct line_bins reference = {0}, model = {0};
    double flux[3] = {0, 0, 0}, noise[3] = {0, 0, 0};
    enum status status = line_guide_create(&guide, &options, error);
    if (status == STATUS_OK) status = line_bins_init(&reference, center, lamp->proxy.radius, error);
    if (status == STATUS_OK) status = line_bins_init(&model, center, lamp->proxy.radius, error);
    if (status == STATUS_OK) status = bin_luminaire(luminaire, lamp, guide, lines, &model, flux, noise, error);
    if (status == STATUS_OK) {
        bin_exits(&survey->exits, &reference);
        for (int c = 0; c < 3; c++) {
            evaluation->flux[c] = (float)survey->flux[c];
            evaluation->flux_noise[c] = (float)hypot(survey->flux_noise[c], noise[c]);
            evaluation->flux_error[c] = survey->flux[c] > 0 ? (float)(flux[c] / survey->flux[c] - 1) : (float)flux[c];
        }
        for (int k = 0; k < EVALUATION_DISTANCES; k++)
            line_bins_irradiance_error(&model, &reference, k, &evaluation->irradiance_error[k],
                                       &evaluation->irradiance_noise[k]);
        evaluation->light_field_error = line_bins_radiance_error(&model, &reference);
    }
    line_guide_destroy(guide);
    line_bins_fini(&reference);
    line_bins_fini(&model);
    return status;
}

// Mean absolute error of T over uniform lines. A line's reference is the mean of 64 traces.
static enum status compare_transparency(const struct luminaire *luminaire, const struct lamp *lamp, size_t count,
                                        struct evaluation *evaluation, struct error *error) {
    struct line_sample *lines = malloc(count * sizeof *lines);
    if (!lines) return error_set(error, STATUS_MEMORY, "out of memory for the evaluation");
    gather_transmittance(lines, lamp, STREAM_EVALUATION, 0, count, LINE_REPEATS);
    double error_sum = 0, reference_sum = 0;
    for (size_t i = 0; i < count; i++) {
        float t[3];
        luminaire_transmittance(luminaire, 1, (const float(*)[3])lines[i].point, (const float(*)[3])lines[i].w, &t);
        for (int c = 0; c < 3; c++) {
            error_sum += fabs((double)(t[c] - lines[i].target[c]));
            reference_sum += (double)lines[i].target[c];
        }
    }
    evaluation->transparency_error = (float)(error_sum / (3 * (double)count));
    evaluation->transparency_error_opaque = (float)(reference_sum / (3 * (double)count));
    free(lines);
    return STATUS_OK;
}

struct light_job {
    const struct luminaire *luminaire;
    const struct lamp *lamp;
    float (*variance)[2]; // per shading point: of the luminaire's samples, of uniform ones
};

// Mean and mean square of L cos / p at s, whose normal faces the lamp's centre.
static void light_moments(const struct luminaire *luminaire, const float s[3], vec3 normal,
                          const float (*directions)[3], const float *pdfs, double *mean, double *square) {
    float points[LIGHT_SAMPLES][3], w[LIGHT_SAMPLES][3], radiance[LIGHT_SAMPLES][3];
    for (size_t i = 0; i < LIGHT_SAMPLES; i++) {
        memcpy(points[i], s, sizeof points[i]);
        for (int c = 0; c < 3; c++) w[i][c] = -directions[i][c];
    }
    luminaire_eval(luminaire, LIGHT_SAMPLES, (const float(*)[3])points, (const float(*)[3])w, radiance);
    *mean = *square = 0;
    for (size_t i = 0; i < LIGHT_SAMPLES; i++) {
        float cosine = fmaxf(0, vec3_dot(vec3_from(directions[i]), normal));
        double x = (double)((radiance[i][0] + radiance[i][1] + radiance[i][2]) * cosine / pdfs[i]);
        *mean += x / LIGHT_SAMPLES;
        *square += x * x / LIGHT_SAMPLES;
    }
}

static void light_point(void *user, size_t index, int worker) {
    (void)worker;
    const struct light_job *job = user;
    const struct lamp *lamp = job->lamp;
    struct sampler sampler = sampler_make(lamp->seed, (uint64_t)STREAM_EVALUATION << 56 | 3, index);
    float distance = 1.2f * powf(4, sampler_1d(&sampler)) * lamp->proxy.radius, cos_max, s[LIGHT_SAMPLES][3];
    vec3 out = warp_uniform_sphere(sampler_2d(&sampler)), normal = vec3_neg(out);
    vec3 point = vec3_mad(out, distance, vec3_from(lamp->proxy.center));
    struct frame frame = frame_from_normal(normal);
    float u[LIGHT_SAMPLES][3], directions[LIGHT_SAMPLES][3], pdfs[LIGHT_SAMPLES];
    cos_max = sqrtf(1 - sqrf(lamp->proxy.radius / distance));
    for (size_t i = 0; i < LIGHT_SAMPLES; i++) {
        for (int c = 0; c < 3; c++) u[i][c] = sampler_1d(&sampler);
        memcpy(s[i], &(float[3]){point.x, point.y, point.z}, sizeof s[i]);
    }
    luminaire_sample(job->luminaire, LIGHT_SAMPLES, (const float(*)[3])s, (const float(*)[3])u, directions, pdfs);
    double mean, square, uniform_mean, uniform_square;
    light_moments(job->luminaire, s[0], normal, (const float(*)[3])directions, pdfs, &mean, &square);
    for (size_t i = 0; i < LIGHT_SAMPLES; i++) {
        vec3 d = frame_world_from_local(&frame, warp_uniform_cone((vec2){u[i][0], u[i][1]}, cos_max));
        memcpy(directions[i], &(float[3]){d.x, d.y, d.z}, sizeof directions[i]);
        pdfs[i] = warp_uniform_cone_pdf(cos_max);
    }
    light_moments(job->luminaire, s[0], normal, (const float(*)[3])directions, pdfs, &uniform_mean, &uniform_square);
    job->variance[index][0] = mean > 0 ? (float)(square / (mean * mean) - 1) : 0;
    job->variance[index][1] = mean > 0 ? (float)(uniform_square / (mean * mean) - 1) : 0;
}

static enum status measure_sampling(const struct luminaire *luminaire, const struct lamp *lamp, size_t points,
                                    struct evaluation *evaluation, struct error *error) {
    float(*variance)[2] = calloc(points, sizeof *variance);
    if (!variance) return error_set(error, STATUS_MEMORY, "out of memory for the evaluation");
    struct light_job job = {luminaire, lamp, variance};
    parallel_for(lamp->threads, points, light_point, &job);
    double sums[2] = {0, 0};
    for (size_t i = 0; i < points; i++)
        for (int k = 0; k < 2; k++) sums[k] += (double)variance[i][k];
    evaluation->sample_variance = (float)(sums[0] / (double)points);
    evaluation->sample_variance_uniform = (float)(sums[1] / (double)points);
    free(variance);
    return STATUS_OK;
}

enum status evaluate_luminaire(const struct luminaire *luminaire, const struct scene *scene,
                               const struct evaluation_effort *effort, const struct run *run,
                               struct evaluation *evaluation, struct error *error) {
    *evaluation = (struct evaluation){0};
    struct lamp lamp = {.scene = scene, .proxy = {.kind = PROXY_SPHERE}, .seed = run->seed, .threads = run->threads};
    luminaire_bounds(luminaire, lamp.proxy.center, &lamp.proxy.radius);
    double start = clock_wall_s();
    run_progress(run, "evaluating", 0, 0, NULL);
    enum status status = proxy_shape_init(&lamp.shape, &lamp.proxy, error);
    if (status != STATUS_OK) return status;
    struct survey *survey = calloc(1, sizeof *survey);
    if (!survey) status = error_set(error, STATUS_MEMORY, "out of memory for the evaluation");
    if (status == STATUS_OK) status = survey_clusters(survey, &lamp, error);
    if (status == STATUS_OK) status = survey_exits(survey, &lamp, STREAM_EVALUATION, effort->particles, run, error);
    run_progress(run, "evaluating", 0.4, clock_wall_s() - start, NULL);
    if (status == STATUS_OK) status = compare_light(luminaire, &lamp, survey, effort->lines, evaluation, error);
    run_progress(run, "evaluating", 0.8, clock_wall_s() - start, NULL);
    if (status == STATUS_OK)
        status = compare_transparency(luminaire, &lamp, effort->transparency_lines, evaluation, error);
    if (status == STATUS_OK) status = measure_sampling(luminaire, &lamp, effort->light_points, evaluation, error);
    run_progress(run, "evaluating", 1, clock_wall_s() - start, NULL);
    if (survey) survey_fini(survey);
    free(survey);
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
    json_object_set_new(root, "transparency_error", json_real((double)e->transparency_error));
    json_object_set_new(root, "transparency_error_opaque", json_real((double)e->transparency_error_opaque));
    json_object_set_new(root, "sample_variance", json_real((double)e->sample_variance));
    json_object_set_new(root, "sample_variance_uniform", json_real((double)e->sample_variance_uniform));
    char *text = root ? json_dumps(root, JSON_COMPACT | JSON_REAL_PRECISION(6)) : NULL;
    json_decref(root);
    return text;
}
