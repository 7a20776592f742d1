// The lamp's groups of emitters, baked one after the other: while one is on the others are dark, but everything that
// they are made of stays. Proxy, hull and transparency are the lamp's and made once, with the first group, whose recipe
// serves all. Without groups the whole lamp is one.
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bake/bake_job.h"
#include "luminaire/group_setting.h"

enum { LEAST_LOG2_ENTRIES = 10 };

size_t bake_group_count(const struct bake_job *job) { return job->groups.count > 0 ? job->groups.count : 1; }

// The groups share the file and, as the time of a fixed quality grows with the root of their number, the work.
static void share_plan(struct bake_plan *plan, size_t groups) {
    const double part = 1 / sqrt((double)groups);
    int less = 0;
    while ((size_t)1 << less < groups) less++;
    plan->survey_particles = (size_t)(part * (double)plan->survey_particles);
    plan->density_lines = (size_t)(part * (double)plan->density_lines);
    plan->light_chunks = (size_t)ceil(part * (double)plan->light_chunks);
    plan->view.chunks = (size_t)ceil(part * (double)plan->view.chunks);
    plan->log2_entries =
        plan->log2_entries - less > LEAST_LOG2_ENTRIES ? plan->log2_entries - less : LEAST_LOG2_ENTRIES;
    plan->view.log2_entries =
        plan->view.log2_entries - less > LEAST_LOG2_ENTRIES ? plan->view.log2_entries - less : LEAST_LOG2_ENTRIES;
}

enum status bake_groups_find(struct bake_job *job, struct error *error) {
    struct scene *scene = &job->scene;
    job->powers = arena_alloc(&job->arena, scene->emitter_count, sizeof *job->powers);
    if (!job->powers) return error_set(error, STATUS_MEMORY, "out of memory for the emitters");
    for (size_t i = 0; i < scene->emitter_count; i++) job->powers[i] = scene->emitters[i]->power;
    job->group_plan = job->plan;
    if (job->options->groups == BAKE_GROUPS_NONE) return STATUS_OK;
    if (job->options->preset == BAKE_PAPER)
        return error_set(error, STATUS_UNSUPPORTED, "the preset 'paper' bakes one light field; leave out --groups");
    enum status status =
        emitter_groups_find(&job->groups, scene->emitters, scene->emitter_count,
                            job->options->groups == BAKE_GROUPS_EACH ? GROUP_EACH : GROUP_NAMED, &job->arena, error);
    if (status != STATUS_OK) return status;
    if (job->groups.count > LUMINAIRE_MAX_GROUPS)
        return error_set(error, STATUS_INVALID,
                         "%s: the lamp has %zu groups of emitters, at most %d are possible; give emitters that go "
                         "together ids that begin alike (bulb.001, bulb.002), and bake with --groups named",
                         scene->path, job->groups.count, LUMINAIRE_MAX_GROUPS);
    rgb power[LUMINAIRE_MAX_GROUPS] = {{0, 0, 0}};
    for (size_t i = 0; i < scene->emitter_count; i++)
        power[job->groups.of_emitter[i]] = rgb_add(power[job->groups.of_emitter[i]], job->powers[i]);
    for (size_t g = 0; g < job->groups.count; g++)
        if (!(rgb_max(power[g]) > 0))
            return error_set(error, STATUS_INVALID, "%s: the emitters of the group '%s' have no power", scene->path,
                             job->groups.names[g]);
    share_plan(&job->group_plan, job->groups.count);
    return STATUS_OK;
}

void bake_light_group(struct bake_job *job, int group) {
    for (size_t i = 0; i < job->scene.emitter_count && job->groups.count; i++) {
        struct emitter *emitter = job->scene.emitters[i];
        bool on = group < 0 || job->groups.of_emitter[i] == (size_t)group;
        emitter->factor = rgb_gray(on ? 1 : 0);
        emitter->power = on ? job->powers[i] : rgb_gray(0);
    }
}

void bake_plan_time(struct bake_job *job) {
    if (!(job->options->seconds > 0)) return;
    const double end_s = job->start_s + job->options->seconds;
    job->budget_s = (end_s - job->group_start_s) / (double)(bake_group_count(job) - job->group);
    job->deadline_s = job->group_start_s + job->budget_s;
}

static enum status bake_folder(struct bake_job *job, size_t group, struct error *error) {
    char number[24] = "";
    if (group) snprintf(number, sizeof number, ".%zu", group);
    int length = snprintf(job->folder, sizeof job->folder, "%s.checkpoint%s", job->options->output_path, number);
    if ((size_t)length < sizeof job->folder) return STATUS_OK;
    return error_set(error, STATUS_INVALID, "the output's path is too long");
}

enum status bake_group_begin(struct bake_job *job, size_t group, struct error *error) {
    job->group = group;
    job->plan = job->group_plan;
    job->group_start_s = clock_wall_s();
    if (group == 0) job->group_start_s = job->start_s;
    bake_plan_time(job);
    bake_light_group(job, (int)group);
    job->checkpoint = (struct checkpoint){.recipe = job->recipe};
    if (job->groups.count) run_note(job->run, "group %s", job->groups.names[group]);
    return bake_folder(job, group, error);
}

static void scale_light(struct bake_job *job, const double flux[3], const double noise[3], float scale[3]) {
    for (int c = 0; c < 3; c++) {
        scale[c] = flux[c] > 0 ? (float)(job->survey.flux[c] / flux[c]) : 1;
        if (job->survey.flux[c] > 0 && fabs((double)scale[c] - 1) > 0.25)
            run_warn(job->run,
                     "channel %d of the light field had %.0f %% of the traced flux before it was scaled; bake longer",
                     c, 100 / (double)scale[c]);
        if (noise[c] > 0.003 || job->survey.flux_noise[c] > 0.003)
            run_warn(job->run, "the flux of channel %d is known to %.2f %% only (of the lamp: %.2f %%)", c,
                     100 * noise[c], 100 * job->survey.flux_noise[c]);
    }
    light_field_set_scale(job->light.field, scale);
}

// Ceiling, scale and sampling density of the trained field. The density is of the light field, not of the lamp: where
// the field is blurred, light is drawn there too, and where it has glints that no exit has shown.
static enum status finish_light(struct bake_job *job, struct baked_group *baked, float scale[3], struct error *error) {
    const struct sampling_refinement plan = {job->density_lines, job->lamp.seed, job->run->threads};
    struct light_field *field = job->light.field;
    struct exit_list exits = {0}; // lines as the field shows them
    double flux[3], noise[3], left[3]; // left: of the flux, by the ceiling
    enum status status = light_field_finish(field, error);
    if (status == STATUS_OK)
        status = light_field_exits(field, &job->lamp, job->guide, job->field_lines, job->most_field_lines, &exits, flux,
                                   noise, error);
    if (status == STATUS_OK) status = bake_density_build(job, &exits, &baked->density, error);
    if (status == STATUS_OK)
        status =
            light_field_fit_ceiling(field, baked->density, exits.exits, exits.count, job->run->threads, left, error);
    if (status == STATUS_OK) {
        for (int c = 0; c < 3; c++) flux[c] *= left[c];
        scale_light(job, flux, noise, scale);
        status = bake_density_thread(job, &exits, &baked->density, error);
    }
    if (status == STATUS_OK) status = sampling_density_refine(&baked->density, field, &job->lamp.shape, &plan, error);
    exit_list_fini(&exits);
    return status;
}

enum status bake_group_end(struct bake_job *job, struct error *error) {
    struct baked_group *baked = &job->baked[job->group];
    float scale[3] = {1, 1, 1};
    enum status status =
        job->paper ? STATUS_OK : finish_light(job, baked, scale, error); // the published stay as they are
    if (status != STATUS_OK) return status;
    if (job->group == 0) job->recipe = job->light.recipe;
    for (int c = 0; c < 3; c++) baked->flux[c] = (float)job->survey.flux[c];
    baked->field = job->light.field;
    baked->view = job->view.field;
    job->light.field = NULL;
    job->view.field = NULL;
    job->work.anchor_count += job->survey.cluster_count;
    job->work.traced += job->light.traced + job->survey.exits.emitted;
    job->work.steps += job->checkpoint.light_chunks * CHUNK_STEPS;
    if (job->group == 0) job->work.clear_share = job->survey.clear_share;
    if (job->group == 0) memcpy(job->work.scale, scale, sizeof scale);
    bake_group_fini(job);
    return STATUS_OK;
}

void bake_group_fini(struct bake_job *job) {
    light_training_destroy(&job->light);
    view_field_destroy(job->view.field);
    held_out_destroy(&job->held_out);
    line_guide_destroy(job->guide);
    survey_fini(&job->survey);
    job->view.field = NULL;
    job->guide = NULL;
    job->survey = (struct survey){0};
}

void bake_groups_fini(struct bake_job *job) {
    for (size_t g = 0; g < LUMINAIRE_MAX_GROUPS; g++) {
        light_field_destroy(job->baked[g].field);
        sampling_density_destroy(job->baked[g].density);
        view_field_destroy(job->baked[g].view);
        job->baked[g] = (struct baked_group){0};
    }
}

void bake_remove_checkpoints(struct bake_job *job) {
    for (size_t g = 0; g < bake_group_count(job); g++)
        if (!bake_folder(job, g, NULL)) checkpoint_remove(job->folder);
}
