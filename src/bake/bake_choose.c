// Which data and which encoding: measured on the lamp itself. The data source follows from the noise of camera lines,
// traced twice each; the encodings compete in short trainings that are scored on the same held-out light. (Measured
// before: clear lamps with small bulbs want the 4D grid and camera lines, frosted ones shells and particles; but lamps
// mix both.)
#include <stdlib.h>
#include <string.h>

#include "bake/bake_job.h"

enum { PILOT_LINES = 1 << 15 };
static const float clear_limit = 0.3f; // share of the flux that passes an emitter on a clear lamp
static const double least_ratio = 0.1; // of C to S

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

// Noise of a step's gradient at a perfect fit, in squared fluxes and of one line: a camera line brings C, the variance
// of its radiance between tracings; an exit beside an untraced line brings X, the exit's square, and M, the line's
// squared radiance. With S = X + M, steps of n camera lines, of n / 2 lines and n / 2 exits, of n / 2 camera lines and
// n / 2 exits at half the weight each have 2 C, 4 S and S + C, over 2 n. Camera lines alone must be clearly better:
// what they miss nothing else brings (measured: at C = S / 5 both were still as good).
static enum status choose_data(struct bake_job *job, enum data_source *data, struct error *error) {
    const struct exit_list *exits = &job->survey.exits;
    struct line_sample *lines = malloc(2 * PILOT_LINES * sizeof *lines);
    if (!lines) return error_set(error, STATUS_MEMORY, "out of memory for the choice of the data");
    struct line_sample *again = lines + PILOT_LINES;
    gather_lines(lines, &job->lamp, job->guide, STREAM_TRIAL, 0, PILOT_LINES, true);
    memcpy(again, lines, PILOT_LINES * sizeof *lines);
    gather_again(again, &job->lamp, STREAM_TRIAL, PILOT_LINES);
    double camera = 0, particles = 0, share = (double)job->survey.exit_rate;
    for (int c = 0; c < 3; c++) {
        for (size_t i = 0; i < PILOT_LINES; i++) {
            double a = (double)lines[i].target[c], b = (double)again[i].target[c];
            camera += (a - b) * (a - b) / (2 * PILOT_LINES);
            particles += a * b / PILOT_LINES;
        }
        for (size_t i = 0; i < exits->count; i++) {
            double y = (double)exits->exits[i].flux[c] * share;
            particles += y * y / (double)exits->count;
        }
    }
    free(lines);
    *data = camera < least_ratio * particles ? DATA_CAMERA : camera < 3 * particles ? DATA_BOTH : DATA_PARTICLES;
    run_note(job->run, "a camera line is %.2f times as noisy as an exit: data from %s", camera / particles,
             data_source_names[*data]);
    return STATUS_OK;
}

enum status bake_choose(struct bake_job *job, struct light_recipe *recipe, struct error *error) {
    if (job->group > 0) { // the lamp's glass is the same, and so is what suits it
        *recipe = job->recipe;
        recipe->chunks = job->plan.light_chunks;
        return STATUS_OK;
    }
    const bool clear = job->survey.clear_share > clear_limit;
    struct light_recipe best = {.data = job->plan.camera_only ? DATA_CAMERA : DATA_PARTICLES,
                                .encoding = ENCODING_CHOICES - 1,
                                .log2_entries = job->plan.log2_entries,
                                .loss = job->plan.loss,
                                .chunks = job->plan.trial_chunks};
    if (!job->plan.camera_only && bake_camera_sees_all(&job->scene)) {
        enum status status = choose_data(job, &best.data, error);
        if (status != STATUS_OK) return status;
    }
    if (job->plan.trial_chunks > 0) {
        double start = clock_wall_s(), best_score = (double)INFINITY, score;
        struct light_recipe candidate = best;
        for (int k = 0; k < ENCODING_CHOICES; k++) {
            candidate.encoding = (k + (clear ? 0 : 1)) % ENCODING_CHOICES; // the likelier one first: it wins a tie
            const char *name = encoding_choices[candidate.encoding].name;
            run_progress(job->run, "choosing", (double)k / ENCODING_CHOICES, clock_wall_s() - start, name);
            enum status status = try_recipe(job, &candidate, &score, error);
            if (status != STATUS_OK) return status;
            run_note(job->run, "trial: %s, %s: held-out %.4f", data_source_names[candidate.data], name, score);
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
