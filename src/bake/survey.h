// What a first look by tracing tells about a lamp: its flux, where it emits, where its light leaves.
#pragma once

#include "bake/gather.h"
#include "bake/line_guide.h"

enum { SURVEY_CLUSTERS = EMISSION_CLUSTERS, SURVEY_SHELLS = 4 };

struct survey {
    double flux[3], flux_noise[3]; // per channel, and its relative standard error
    struct exit_list exits;
    float exit_rate; // exits per emitted particle
    struct emission_cluster clusters[SURVEY_CLUSTERS];
    size_t cluster_count;
    bool thin; // the emission is long and thin: twice as many clusters would be about half as large
    float clear_share; // of the flux on lines that pass an emission cluster
    float shell_radii[SURVEY_SHELLS]; // [fraction of the proxy's radius] ascending: where light was scattered last
    size_t shell_count;
};

// The lamp's emission clusters (trace/emission_cluster.h).
enum status survey_clusters(struct survey *survey, const struct lamp *lamp, struct error *error);
// Traces `particles` particles of the stream and fills the rest. STATUS_INVALID: no light leaves the lamp.
enum status survey_exits(struct survey *survey, const struct lamp *lamp, enum gather_stream stream, size_t particles,
                         const struct run *run, struct error *error);
void survey_fini(struct survey *survey);
