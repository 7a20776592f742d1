// The long stage: transparency first, then the light field, chunk by chunk. Tracing and training both use all threads,
// one after the other within a chunk, so that no core waits and the order of everything is fixed.
#include <stdio.h>

#include <stdlib.h>

#include "bake/bake_job.h"

static const double checkpoint_period_s = 25, score_period_s = 4;
static const double transparency_time_share = 0.15; // of a bake with --seconds
static const double view_time_share = 0.2; // the same
static const double finish_surveys = 3.5; // the last stage takes about as long as so many surveys
static const double finish_margin = 1.3; // for what it does besides
enum { SAMPLING_LINES = 8192 }; // queries of a shading point

static enum status save_checkpoint(struct bake_job *job, struct error *error) {
    job->checkpoint.traced = job->light.traced;
    job->checkpoint.seconds = clock_wall_s() - job->group_start_s;
    return checkpoint_save(&job->checkpoint, job->folder, job->light.field, job->group ? NULL : job->transparency,
                           error);
}

// After every chunk: cancelled, or time for a checkpoint.
static enum status between_chunks(struct bake_job *job, double *last_checkpoint_s, struct error *error) {
    if (run_cancelled(job->run)) {
        enum status status = save_checkpoint(job, error);
        if (status != STATUS_OK) return status;
        return error_set(error, STATUS_CANCELLED, "cancelled; the same command with --resume goes on from %s",
                         job->folder);
    }
    double now = clock_wall_s();
    if (now - *last_checkpoint_s < checkpoint_period_s) return STATUS_OK;
    *last_checkpoint_s = now;
    return save_checkpoint(job, error);
}

static enum status train_transparency(struct bake_job *job, double *last_checkpoint_s, struct error *error) {
    struct line_sample *samples = malloc((size_t)CHUNK_STEPS * TRANSPARENCY_BATCH * sizeof *samples);
    if (!samples) return error_set(error, STATUS_MEMORY, "out of memory for the transparency's lines");
    const double start = clock_wall_s(), limit = transparency_time_share * job->options->seconds;
    const size_t planned = job->plan.transparency_chunks;
    const bool timed = job->options->seconds > 0;
    size_t done_here = 0;
    enum status status = STATUS_OK;
    while (status == STATUS_OK && job->checkpoint.transparency_chunks < planned) {
        double loss, elapsed = clock_wall_s() - start;
        if (timed && elapsed > limit) break;
        if (timed && done_here > 0) {
            double left = (limit - elapsed) * (double)done_here / elapsed;
            transparency_plan(job->transparency,
                              (job->checkpoint.transparency_chunks + (size_t)left + 1) * CHUNK_STEPS);
        }
        done_here++;
        if (transparency_training_chunk(job->transparency, &job->lamp, job->checkpoint.transparency_chunks++, samples,
                                        &loss) == 0)
            break; // nothing of the lamp is translucent: its hull knows everything
        char detail[64];
        snprintf(detail, sizeof detail, "loss %.5f", loss);
        double fraction =
            job->options->seconds > 0 ? elapsed / limit : (double)job->checkpoint.transparency_chunks / (double)planned;
        run_progress(job->run, "transparency", fraction, elapsed, detail);
        status = between_chunks(job, last_checkpoint_s, error);
    }
    free(samples);
    return status;
}

// Known by the light field's lines, the flux's and the evaluation's, which cost as much again to draw. Else (the
// published networks) by a rule of thumb.
double bake_reserve_s(const struct bake_job *job) {
    const struct evaluation_effort *effort = &job->plan.evaluation;
    double lines = (double)(2 * effort->lines + effort->light_points * SAMPLING_LINES +
                            2 * (job->field_lines + 2 * job->density_lines));
    double known = job->particle_s * (double)effort->particles + job->line_s * lines;
    return fmin(job->line_s > 0 ? finish_margin * known : finish_surveys * job->survey_s, 0.4 * job->budget_s);
}

bool bake_has_view(const struct bake_job *job) {
    return job->options->view == BAKE_VIEW_HULL && job->plan.view.chunks > 0;
}

static double view_time(const struct bake_job *job) { return bake_has_view(job) ? view_time_share * job->budget_s : 0; }

static enum status train_light(struct bake_job *job, double *last_checkpoint_s, struct error *error) {
    const bool timed = job->options->seconds > 0;
    const double start = clock_wall_s();
    double stop = job->deadline_s - bake_reserve_s(job) - view_time(job);
    double last_score_s = -score_period_s, score = NAN;
    size_t done_here = 0;
    enum status status = STATUS_OK;
    while (status == STATUS_OK && job->checkpoint.light_chunks < job->checkpoint.recipe.chunks) {
        double now = clock_wall_s(), elapsed = now - start;
        if (timed && now >= stop && done_here > 0) break;
        if (timed && done_here > 0) { // the learning rate falls towards the end that the clock will set
            double left = (stop - now) * (double)done_here / elapsed;
            light_field_plan(job->light.field, (job->checkpoint.light_chunks + (size_t)left + 1) * CHUNK_STEPS);
        }
        status = light_training_chunk(&job->light, job->checkpoint.light_chunks, error);
        if (status != STATUS_OK) break;
        job->checkpoint.light_chunks++;
        done_here++;
        if (now - last_score_s >= score_period_s) {
            last_score_s = now;
            double begun = clock_wall_s();
            status = held_out_score(&job->held_out, job->light.field, &job->lamp, &score, error);
            if (status != STATUS_OK) break;
            double queries = (double)(job->held_out.line_count + job->held_out.exits.count);
            job->line_s = (clock_wall_s() - begun) / queries;
            stop = job->deadline_s - bake_reserve_s(job) - view_time(job);
        }
        char detail[96];
        snprintf(detail, sizeof detail, "loss %.4f, held-out %.4f", job->light.loss, score);
        double fraction = timed ? elapsed / (stop - start)
                                : (double)job->checkpoint.light_chunks / (double)job->checkpoint.recipe.chunks;
        run_progress(job->run, "training", fraction < 1 ? fraction : 1, clock_wall_s() - start, detail);
        status = between_chunks(job, last_checkpoint_s, error);
    }
    return status;
}

enum status bake_train(struct bake_job *job, struct error *error) {
    double last_checkpoint_s = clock_wall_s();
    enum status status = STATUS_OK;
    if (job->group == 0 && job->checkpoint.light_chunks == 0) // the light field's training comes after it
        status = train_transparency(job, &last_checkpoint_s, error);
    if (status == STATUS_OK) status = train_light(job, &last_checkpoint_s, error);
    if (status != STATUS_OK || bake_group_count(job) == 1) return status;
    job->checkpoint.recipe.chunks = job->checkpoint.light_chunks; // done: a resumed bake goes on with the next group
    return save_checkpoint(job, error);
}

// Not in the checkpoint: a resumed bake does this stage anew, with the same result.
enum status bake_view_stage(struct bake_job *job, struct error *error) {
    if (!bake_has_view(job)) return STATUS_OK;
    struct view_plan plan = job->plan.view;
    plan.data = job->checkpoint.recipe.data;
    if (job->options->seconds > 0) plan.seconds = fmax(1, job->deadline_s - bake_reserve_s(job) - clock_wall_s());
    enum status status = view_bake(&job->view, &job->hull_map, &job->lamp, &plan, job->run, error);
    if (status == STATUS_CANCELLED) {
        enum status saved = save_checkpoint(job, error);
        if (saved != STATUS_OK) return saved;
        return error_set(error, STATUS_CANCELLED, "cancelled; the same command with --resume goes on from %s",
                         job->folder);
    }
    if (status == STATUS_OK && !job->view.hull)
        run_note(job->run, "nothing of this lamp can be seen as a hull; appearance=surface will not be possible");
    return status;
}
