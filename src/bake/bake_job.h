// One bake in progress: what its stages share.
#pragma once

#include "bake/bake.h"
#include "bake/checkpoint.h"
#include "bake/survey.h"
#include "bake/training.h"
#include "bake/view_bake.h"
#include "scene/emitter_groups.h"

struct bake_plan { // how much work each stage does
    size_t survey_particles;
    size_t trial_chunks; // of every candidate; 0: no trial
    size_t transparency_chunks, light_chunks;
    size_t density_lines; // of the finished field, in the last round of the sampling density; 0: it is not refined
    int log2_entries; // of the light field's tables
    struct evaluation_effort evaluation;
    struct view_plan view; // chunks 0: no hull
    bool camera_only; // camera lines alone, without a trial; not with checkpoints
    enum light_loss loss;
    size_t file_bytes, hull_triangles; // at most; file_bytes: the hull is coarser where it would not fit
};

struct baked_group { // a finished group
    struct light_field *field;
    struct sampling_density *density;
    struct view_field *view;
    float flux[3];
};

struct bake_job {
    const struct bake_options *options;
    const struct run *run;
    struct bake_plan plan;
    double start_s; // clock_wall_s
    struct emitter_groups groups; // count 0: the whole lamp is one
    rgb *powers; // of the scene's emitters when all are on
    struct baked_group baked[LUMINAIRE_MAX_GROUPS];
    struct light_recipe recipe; // of the first group, for the others
    struct bake_report work; // of the groups so far
    struct bake_plan group_plan; // before bake_pace
    int transparency_log2_entries;
    // From here to `view`: of the group that is being baked.
    size_t group;
    double group_start_s, budget_s; // its share of options->seconds
    double deadline_s; // only where options->seconds > 0, else infinity
    double survey_s; // what the survey took: a measure of how fast the lamp is traced here
    size_t field_lines, most_field_lines; // of the finished field, for its flux and the first sampling density
    size_t density_lines; // of its refinement
    double particle_s, line_s; // wall time of one particle, and of one query of the light field (0: not known yet)
    struct arena arena;
    struct scene scene;
    struct lamp lamp;
    struct aim aims[SURVEY_CLUSTERS];
    struct survey survey;
    struct line_guide *guide;
    struct held_out held_out;
    struct checkpoint checkpoint;
    char folder[4096]; // of the checkpoint
    struct light_training light;
    struct view_result view; // the hull is the lamp's
    struct hull_map hull_map; // of view.hull
    struct transparency *transparency;
    struct paper *paper; // preset paper: in place of light field and transparency; else NULL
    uint64_t identity; // of the lamp
};

// What bake_lamp does with these options.
struct bake_plan bake_plan_work(const struct bake_options *options);
// bake_lamp with a plan of one's own (the tests' is small, the ablations' differ in one thing).
enum status bake_lamp_plan(const struct bake_options *options, const struct bake_plan *plan, const struct run *run,
                           struct bake_report *report, struct error *error);

// Fits the plan to what the lamp's particles cost.
enum status bake_pace(struct bake_job *job, struct error *error);

// --- Groups (bake_groups.c) ---
size_t bake_group_count(const struct bake_job *job); // at least 1
// Also gives each group its share of the plan.
enum status bake_groups_find(struct bake_job *job, struct error *error);
void bake_light_group(struct bake_job *job, int group); // the others are dark; -1: all are on
enum status bake_group_begin(struct bake_job *job, size_t group, struct error *error);
void bake_plan_time(struct bake_job *job); // of the group, from its start and that of the bake
// Scales the group's light field to its flux, builds its sampling density and sets the finished group aside.
enum status bake_group_end(struct bake_job *job, struct error *error);
void bake_group_fini(struct bake_job *job);
void bake_groups_fini(struct bake_job *job);
void bake_remove_checkpoints(struct bake_job *job);

// --- The sampling density of the group's finished light field (bake_density.c) ---
// From the exits that the field shows, with cones about the emission clusters.
enum status bake_density_build(const struct bake_job *job, const struct exit_list *exits,
                               struct sampling_density **density, struct error *error);
// In its place one with cones about beads along the emission, where that is long and thin and they pay.
enum status bake_density_thread(const struct bake_job *job, const struct exit_list *exits,
                                struct sampling_density **density, struct error *error);

// A point light is never hit by a camera line.
bool bake_camera_sees_all(const struct scene *scene);
// Chooses data source and encoding by short trainings of candidates, scored on held-out light.
enum status bake_choose(struct bake_job *job, struct light_recipe *recipe, struct error *error);
// Trains both networks, writes checkpoints, stops at the deadline. STATUS_CANCELLED after a last checkpoint.
enum status bake_train(struct bake_job *job, struct error *error);
// Preset paper: the same for the three published networks. Lowers the evaluation's effort to what they are fast enough
// for.
enum status bake_train_paper(struct bake_job *job, struct error *error);
// Hull and transparency of the lamp, for the light field that is about to be trained.
enum status bake_hull_stage(struct bake_job *job, struct error *error);
bool bake_has_view(const struct bake_job *job); // the file gets a hull, where the lamp allows one
// The view field, where there is a hull.
enum status bake_view_stage(struct bake_job *job, struct error *error);
// The wall time that the stages after the light field's training take of a bake with --seconds.
double bake_reserve_s(const struct bake_job *job);
// Assembly, file, evaluation. Consumes the networks.
enum status bake_finish(struct bake_job *job, struct bake_report *report, struct error *error);
