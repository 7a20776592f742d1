// The verbs `bake` and `evaluate`: from a lamp's geometry to a luminaire file with measured errors.
// Flow: lamp_check -> lamp_proxy -> survey -> (gather <-> train) -> scale -> sampling density -> evaluate -> save.
#pragma once

#include "bake/evaluate.h"
#include "base/run.h"
#include "format/description.h"

enum bake_size { BAKE_SIZE_SMALL, BAKE_SIZE_DEFAULT, BAKE_SIZE_LARGE }; // of the file
// BAKE_PAPER: the published networks, for comparison (luminaire/paper.h); no other size, no resume.
enum bake_preset { BAKE_COMPACT, BAKE_PAPER };
enum bake_view { BAKE_VIEW_HULL, BAKE_VIEW_NONE }; // a hull for appearance=surface, or none
// Groups of emitters with a light field each (scene/emitter_groups.h).
enum bake_groups { BAKE_GROUPS_NONE, BAKE_GROUPS_NAMED, BAKE_GROUPS_EACH };
enum bake_proxy { BAKE_PROXY_AUTO, BAKE_PROXY_SPHERE, BAKE_PROXY_BOX, BAKE_PROXY_CYLINDER, BAKE_PROXY_MESH };

struct bake_options {
    const char *lamp_path, *output_path;
    const struct definition *definitions;
    size_t definition_count;
    bool skip_missing; // a missing mesh is a warning
    enum bake_preset preset;
    enum bake_quality quality;
    enum bake_size size;
    double seconds; // > 0: as much work as fits in this wall time, instead of `quality`
    enum bake_proxy proxy;
    const char *proxy_path; // BAKE_PROXY_MESH: a closed mesh (.obj, .ply) in lamp coordinates that holds the lamp
    enum bake_view view;
    enum bake_groups groups;
    bool resume; // go on from OUTPUT.checkpoint where there is one
};

struct bake_report {
    const char *proxy; // "sphere", ...
    const char *encoding; // what the trial chose: "grid4", "shells", "grid4+shells"
    const char *data; // "camera", "particles", "both"
    size_t anchor_count; // of all groups
    float clear_share; // of the (first group's) flux on lines that pass an emitter
    size_t steps, traced; // optimiser steps; particles and camera lines traced
    float scale[3]; // what the (first) light field was multiplied with in the end, to have the lamp's flux
    size_t bytes; // of the file
    double seconds; // wall time of the bake, over all its runs
    struct evaluation evaluation;
};

// Writes output_path (atomically). STATUS_CANCELLED: run_cancelled said so, the checkpoint OUTPUT.checkpoint holds
// what was done and a later call with `resume` goes on from it.
enum status bake_lamp(const struct bake_options *options, const struct run *run, struct bake_report *report,
                      struct error *error);

// Measures a luminaire file against the lamp it was (or might have been) baked from.
enum status bake_evaluate(const char *luminaire_path, const char *lamp_path, const struct scene_options *lamp_options,
                          enum bake_quality quality, const struct run *run, struct evaluation *evaluation,
                          struct error *error);
