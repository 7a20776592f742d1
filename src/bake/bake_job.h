// One bake in progress: what its stages share.
#pragma once

#include "bake/bake.h"
#include "bake/checkpoint.h"
#include "bake/survey.h"
#include "bake/training.h"
#include "bake/view_bake.h"

struct bake_plan { // how much work each stage does
    size_t survey_particles;
    size_t trial_chunks; // of every candidate; 0: no trial
    size_t transparency_chunks, light_chunks;
    int log2_entries; // of the light field's tables
    bool packed; // tables in 4 bits a number
    struct evaluation_effort evaluation;
    struct view_plan view; // chunks 0: no hull
    bool camera_only; // camera lines alone, without a trial; not with checkpoints
    enum light_loss loss;
};

struct bake_job {
    const struct bake_options *options;
    const struct run *run;
    struct bake_plan plan;
    double start_s, deadline_s; // clock_wall_s; deadline only where options->seconds > 0, else infinity
    double survey_s; // what the survey took: a measure of how fast the lamp is traced here
    size_t field_lines, most_field_lines; // of the finished field, for its flux and the sampling density
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
    struct transparency *transparency;
    struct paper *paper; // preset paper: in place of the two above; else NULL
    struct view_result view;
    struct hull_map hull_map; // of view.hull
    uint64_t identity; // of the lamp
};

// What bake_lamp does with these options.
struct bake_plan bake_plan_work(const struct bake_options *options);
// bake_lamp with a plan of one's own (the tests' is small, the ablations' differ in one thing).
enum status bake_lamp_plan(const struct bake_options *options, const struct bake_plan *plan, const struct run *run,
                           struct bake_report *report, struct error *error);

// Fits the plan to what the lamp's particles cost.
enum status bake_pace(struct bake_job *job, struct error *error);
// A point light is never hit by a camera line.
bool bake_camera_sees_all(const struct scene *scene);
// Chooses data source and encoding by short trainings of candidates, scored on held-out light.
enum status bake_choose(struct bake_job *job, struct light_recipe *recipe, struct error *error);
// Trains both networks, writes checkpoints, stops at the deadline. STATUS_CANCELLED after a last checkpoint.
enum status bake_train(struct bake_job *job, struct error *error);
// Preset paper: the same for the three published networks. Lowers the evaluation's effort to what they are fast enough
// for.
enum status bake_train_paper(struct bake_job *job, struct error *error);
bool bake_has_view(const struct bake_job *job); // the file gets a hull, where the lamp allows one
// Hull and view field, where the plan and the options want them.
enum status bake_view_stage(struct bake_job *job, struct error *error);
// The wall time that the stages after the light field's training take of a bake with --seconds.
double bake_reserve_s(const struct bake_job *job);
// Scale, sampling density, assembly, evaluation, file. Consumes the networks.
enum status bake_finish(struct bake_job *job, struct bake_report *report, struct error *error);
