// The verbs. Stages: load and check, proxy, survey, choice, training, finish; one file each.
#include "bake/bake.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bake/bake_job.h"
#include "bake/lamp_check.h"
#include "bake/lamp_proxy.h"
#include "luminaire/hull.h"
#include "luminaire/paper.h"
#include "scene/lamp_identity.h"

// By quality, aims at 20 s, 2 minutes and half an hour on 2 cores; bake_pace makes it less for a lamp that costs more.
static const struct bake_plan plans[] = {
    [BAKE_DRAFT] = {1000000, 0, 16, 36, 0, 0, {1000000, 2000000, 64, 512, 0, 0}, {.chunks = 12}},
    [BAKE_STANDARD] = {3000000, 4, 100, 240, 16000000, 0, {4000000, 4000000, 128, 1024, 0, 0}, {.chunks = 120}},
    [BAKE_HIGH] = {8000000, 24, 1500, 5000, 32000000, 0, {16000000, 8000000, 128, 2048, 0, 0}, {.chunks = 1500}},
};

enum { HULL_TRIANGLES = 60000 }; // more take time where light passes the lamp

static const struct {
    size_t file_bytes;
    int log2_entries, view_log2_entries;
} sizes[] = {[BAKE_SIZE_SMALL] = {600000, 13, 11},
             [BAKE_SIZE_DEFAULT] = {2000000, 15, 13},
             [BAKE_SIZE_LARGE] = {8000000, 18, 16}};

struct bake_plan bake_plan_work(const struct bake_options *options) {
    struct bake_plan plan = plans[options->quality];
    if (options->seconds > 0) {
        plan = plans[options->seconds < 80 ? BAKE_DRAFT : options->seconds < 600 ? BAKE_STANDARD : BAKE_HIGH];
        plan.light_chunks = (size_t)1 << 32; // until the clock says stop
        plan.transparency_chunks = (size_t)1 << 32;
    }
    plan.log2_entries = sizes[options->size].log2_entries;
    plan.file_bytes = sizes[options->size].file_bytes;
    plan.hull_triangles = HULL_TRIANGLES;
    plan.view.log2_entries = sizes[options->size].view_log2_entries;
    return plan;
}

static enum status survey_lamp(struct bake_job *job, struct error *error) {
    run_progress(job->run, "surveying", 0, 0, NULL);
    double start = clock_wall_s();
    enum status status = survey_clusters(&job->survey, &job->lamp, error);
    if (status != STATUS_OK) return status;
    for (size_t i = 0; i < job->survey.cluster_count; i++)
        job->aims[i] = (struct aim){job->survey.clusters[i].center, 1.05f * job->survey.clusters[i].radius};
    job->lamp.aims = job->aims;
    job->lamp.aim_count = job->survey.cluster_count;
    status = bake_pace(job, error);
    if (status != STATUS_OK) return status;
    status = survey_exits(&job->survey, &job->lamp, STREAM_SURVEY, job->plan.survey_particles, job->run, error);
    if (status != STATUS_OK) return status;
    const struct proxy *proxy = &job->lamp.proxy;
    struct line_guide_options options = {.center = {proxy->center[0], proxy->center[1], proxy->center[2]},
                                         .radius = proxy->radius,
                                         .exits = job->survey.exits.exits,
                                         .exit_count = job->survey.exits.count,
                                         .exponent = 0.5f,
                                         .clusters = job->survey.clusters,
                                         .cluster_count = job->survey.cluster_count,
                                         .cluster_share = 0.5f * job->survey.clear_share};
    status = line_guide_create(&job->guide, &options, error);
    if (status == STATUS_OK) status = held_out_create(&job->held_out, &job->lamp, job->guide, 1 << 17, error);
    job->survey_s = clock_wall_s() - start;
    run_progress(job->run, "surveying", 1, job->survey_s, NULL);
    return status;
}

static void describe_job(const struct bake_job *job, char text[80]) {
    const struct bake_options *o = job->options;
    snprintf(text, 80, "%016llx seed %llu quality %d size %d seconds %g proxy %d", (unsigned long long)job->identity,
             (unsigned long long)job->run->seed, (int)o->quality, (int)o->size, o->seconds,
             (int)o->proxy + 16 * (int)o->view + 256 * (int)o->groups);
}

static enum status start_training(struct bake_job *job, struct error *error) {
    char identity[80];
    bool resumed = false;
    describe_job(job, identity);
    enum status status = STATUS_OK;
    if (job->options->resume) {
        status = checkpoint_load(&job->checkpoint, &resumed, job->folder, identity, error);
        if (status == STATUS_OK && !resumed)
            run_warn(job->run, "%s: there is no checkpoint to resume; baking from the start", job->folder);
    }
    if (status == STATUS_OK && !resumed) {
        checkpoint_remove(job->folder);
        memcpy(job->checkpoint.identity, identity, sizeof identity);
        status = bake_choose(job, &job->checkpoint.recipe, error);
    }
    if (status != STATUS_OK) return status;
    job->checkpoint.recipe.loss = job->plan.loss;
    job->start_s -= job->checkpoint.seconds;
    job->group_start_s -= job->checkpoint.seconds;
    bake_plan_time(job);
    status = light_training_create(&job->light, &job->lamp, &job->survey, job->guide, &job->checkpoint.recipe,
                                   STREAM_TRAINING, error);
    if (status == STATUS_OK && job->group == 0) status = bake_hull_stage(job, error);
    if (status == STATUS_OK && resumed) {
        job->light.traced = job->checkpoint.traced;
        status = checkpoint_load_networks(&job->checkpoint, job->folder, job->light.field,
                                          job->group ? NULL : job->transparency, error);
        run_note(job->run, "resumed %s after %zu of %zu chunks", job->folder, job->checkpoint.light_chunks,
                 job->checkpoint.recipe.chunks);
    }
    return status;
}

static enum status bake_group(struct bake_job *job, size_t group, struct error *error) {
    enum status status = bake_group_begin(job, group, error);
    if (status == STATUS_OK) status = survey_lamp(job, error);
    if ((status == STATUS_OK && run_cancelled(job->run)) || status == STATUS_CANCELLED)
        return error_set(error, STATUS_CANCELLED,
                         group ? "cancelled; the same command with --resume goes on after the groups that are done"
                               : "cancelled before anything was learned");
    if (job->options->preset == BAKE_PAPER) {
        if (status == STATUS_OK) status = bake_train_paper(job, error);
    } else {
        if (status == STATUS_OK) status = start_training(job, error);
        if (status == STATUS_OK) status = bake_train(job, error);
        if (status == STATUS_OK) status = bake_view_stage(job, error);
    }
    return status == STATUS_OK ? bake_group_end(job, error) : status;
}

static enum status bake_scene(struct bake_job *job, struct bake_report *report, struct error *error) {
    enum status status = lamp_check(&job->scene, job->run, error);
    if (status == STATUS_OK) status = lamp_identity(&job->scene, &job->identity, error);
    if (status != STATUS_OK) return status;
    job->lamp = (struct lamp){.scene = &job->scene, .seed = job->run->seed, .threads = job->run->threads};
    status = lamp_proxy_fit(&job->lamp.proxy, &job->scene, job->options->proxy, job->options->proxy_path, &job->arena,
                            error);
    if (status == STATUS_OK) status = proxy_shape_init(&job->lamp.shape, &job->lamp.proxy, error);
    job->transparency_log2_entries = job->plan.log2_entries;
    if (status == STATUS_OK) status = bake_groups_find(job, error);
    for (size_t g = 0; status == STATUS_OK && g < bake_group_count(job); g++) status = bake_group(job, g, error);
    bake_light_group(job, -1);
    if (status == STATUS_OK) status = bake_finish(job, report, error);
    if (status == STATUS_OK) bake_remove_checkpoints(job);
    return status;
}

enum status bake_lamp(const struct bake_options *options, const struct run *run, struct bake_report *report,
                      struct error *error) {
    struct bake_plan plan = bake_plan_work(options);
    return bake_lamp_plan(options, &plan, run, report, error);
}

enum status bake_lamp_plan(const struct bake_options *options, const struct bake_plan *plan, const struct run *run,
                           struct bake_report *report, struct error *error) {
    struct bake_job *job = calloc(1, sizeof *job);
    if (!job) return error_set(error, STATUS_MEMORY, "out of memory for a bake");
    *report = (struct bake_report){0};
    job->options = options;
    job->run = run;
    job->plan = *plan;
    job->start_s = clock_wall_s();
    job->deadline_s = (double)INFINITY;
    enum status status = STATUS_OK;
    struct scene_options scene_options = {.definitions = options->definitions,
                                          .definition_count = options->definition_count,
                                          .skip_missing = options->skip_missing,
                                          .lamp_only = true,
                                          .threads = run->threads};
    if (status == STATUS_OK && options->preset == BAKE_PAPER && (options->resume || options->size != BAKE_SIZE_DEFAULT))
        status = error_set(error, STATUS_UNSUPPORTED,
                           "the preset 'paper' has one size and writes no checkpoints to resume from; bake without "
                           "these options, or with the preset 'compact'");
    if (status == STATUS_OK) status = scene_load(&job->scene, options->lamp_path, &scene_options, run, error);
    if (status == STATUS_OK) {
        status = bake_scene(job, report, error);
        bake_group_fini(job);
        bake_groups_fini(job);
        transparency_destroy(job->transparency);
        paper_destroy(job->paper);
        hull_destroy(job->view.hull);
        hull_map_fini(&job->hull_map);
        proxy_shape_fini(&job->lamp.shape);
        scene_fini(&job->scene);
        arena_fini(&job->arena);
    }
    free(job);
    return status;
}

enum status bake_evaluate(const char *luminaire_path, const char *lamp_path, const struct scene_options *lamp_options,
                          enum bake_quality quality, const struct run *run, struct evaluation *evaluation,
                          struct error *error) {
    struct luminaire *luminaire;
    enum status status = luminaire_load(&luminaire, luminaire_path, error);
    if (status != STATUS_OK) return status;
    const char *preset = luminaire_metadata(luminaire, "bake.preset");
    const struct evaluation_effort *effort =
        preset && !strcmp(preset, "paper") ? &evaluation_effort_paper : &evaluation_efforts[quality];
    struct scene scene;
    struct scene_options options = *lamp_options;
    options.lamp_only = true;
    options.threads = run->threads;
    status = scene_load(&scene, lamp_path, &options, run, error);
    if (status == STATUS_OK) {
        status = lamp_check(&scene, run, error);
        if (status == STATUS_OK) status = evaluate_luminaire(luminaire, &scene, effort, run, evaluation, error);
        scene_fini(&scene);
    }
    luminaire_destroy(luminaire);
    return status;
}
