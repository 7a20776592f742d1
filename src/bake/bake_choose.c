// Which data and which encoding: measured on the lamp itself. First the data sources compete with the encoding that the
// survey suggests, then the encodings compete on the best data. All candidates do the same number of optimiser steps
// and are scored on the same held-out light. (Measured before: clear lamps with small bulbs want the 4D grid and camera
// lines, frosted ones shells and particles; but lamps mix both.)
#include "bake/bake_job.h"

static const float clear_limit = 0.3f; // share of the flux that passes an emitter on a clear lamp

static enum status try_recipe(struct bake_job *job, const struct light_recipe *recipe, double *score,
                              struct error *error) {
    struct light_training trial;
    enum status status =
        light_training_create(&trial, &job->lamp, &job->survey, job->guide, recipe, STREAM_TRIAL, error);
    if (status != STATUS_OK) return status;
    for (size_t chunk = 0; chunk < recipe->chunks && status == STATUS_OK; chunk++) {
        status = light_training_chunk(&trial, chunk, error);
        if (status == STATUS_OK && run_cancelled(job->run))
            status = error_set(error, STATUS_CANCELLED, "cancelled before the training began");
    }
    if (status == STATUS_OK) status = held_out_score(&job->held_out, trial.field, &job->lamp, score, error);
    light_training_destroy(&trial);
    return status;
}

bool bake_camera_sees_all(const struct scene *scene) {
    for (size_t i = 0; i < scene->emitter_count; i++)
        if (scene->emitters[i]->flags & (EMITTER_DELTA_POSITION | EMITTER_DELTA_DIRECTION)) return false;
    return true;
}

enum status bake_choose(struct bake_job *job, struct light_recipe *recipe, struct error *error) {
    const bool camera = bake_camera_sees_all(&job->scene), clear = job->survey.clear_share > clear_limit;
    const enum data_source untried = camera ? DATA_BOTH : DATA_PARTICLES;
    struct light_recipe best = {.data = job->plan.camera_only ? DATA_CAMERA : untried,
                                .encoding = ENCODING_CHOICES - 1,
                                .log2_entries = job->plan.log2_entries,
                                .packed = job->plan.packed,
                                .loss = job->plan.loss,
                                .chunks = job->plan.trial_chunks};
    if (job->plan.trial_chunks > 0) {
        double start = clock_wall_s(), best_score = (double)INFINITY, score;
        struct light_recipe candidate = best;
        candidate.encoding = clear ? 0 : 1;
        const int trials = 3 + ENCODING_CHOICES - 1;
        int done = 0;
        for (int data = 0; data < 3; data++, done++) {
            run_progress(job->run, "choosing", (double)done / trials, clock_wall_s() - start, data_source_names[data]);
            if (!camera && data != DATA_PARTICLES) continue;
            candidate.data = (enum data_source)data;
            enum status status = try_recipe(job, &candidate, &score, error);
            if (status != STATUS_OK) return status;
            run_note(job->run, "trial: %s, %s: held-out %.4f", data_source_names[data],
                     encoding_choices[candidate.encoding].name, score);
            if (score < best_score) {
                best_score = score;
                best = candidate;
            }
        }
        candidate = best;
        for (int encoding = 0; encoding < ENCODING_CHOICES; encoding++) {
            if (encoding == (clear ? 0 : 1)) continue;
            run_progress(job->run, "choosing", (double)done++ / trials, clock_wall_s() - start,
                         encoding_choices[encoding].name);
            candidate.encoding = encoding;
            enum status status = try_recipe(job, &candidate, &score, error);
            if (status != STATUS_OK) return status;
            run_note(job->run, "trial: %s, %s: held-out %.4f", data_source_names[candidate.data],
                     encoding_choices[encoding].name, score);
            if (score < best_score) {
                best_score = score;
                best = candidate;
            }
        }
        run_progress(job->run, "choosing", 1, clock_wall_s() - start, NULL);
    }
    best.chunks = job->plan.light_chunks;
    *recipe = best;
    return STATUS_OK;
}
