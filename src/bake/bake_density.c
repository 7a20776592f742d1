// The sampling density of a group's finished light field. Its cones stand about the emission clusters or, where the
// emission is long and thin (tubes, filaments, rows of diodes), about beads along it: as many as pay for the time that
// each takes of every light sample.
#include "bake/bake_job.h"

enum { FEWEST_BEADS = 32, TRIAL_EXITS = 1000000 };
// A path of the path tracer, and its queries of one bead; the variance of a path besides its light sample's, relative
// to the lamp's light.
static const double path_ns = 2500, bead_ns = 3, other_variance = 2;

static enum status build(const struct bake_job *job, const struct exit_list *exits, size_t exit_count,
                         const float (*anchors)[3], size_t anchor_count, struct sampling_density **density,
                         struct error *error) {
    return sampling_density_build(density, &job->lamp.proxy, anchors, anchor_count, exits->exits, exit_count,
                                  job->lamp.seed, job->run->threads, error);
}

static enum status try_anchors(const struct bake_job *job, const struct exit_list *exits, const float (*anchors)[3],
                               size_t count, double *cost, struct error *error) {
    struct sampling_density *density;
    const size_t exit_count = exits->count < TRIAL_EXITS ? exits->count : TRIAL_EXITS;
    enum status status = build(job, exits, exit_count, anchors, count, &density, error);
    if (status) return status;
    const double noise = sampling_density_noise(density, job->light.field, &job->lamp.shape, job->run->threads);
    *cost = (noise + other_variance) * (path_ns + bead_ns * (double)count);
    sampling_density_destroy(density);
    return STATUS_OK;
}

static size_t copy_clusters(const struct survey *survey, float (*anchors)[3]) {
    for (size_t i = 0; i < survey->cluster_count; i++) vec3_store(anchors[i], survey->clusters[i].center);
    return survey->cluster_count;
}

enum status bake_density_build(const struct bake_job *job, const struct exit_list *exits,
                               struct sampling_density **density, struct error *error) {
    float anchors[SURVEY_CLUSTERS][3];
    const size_t count = copy_clusters(&job->survey, anchors);
    return build(job, exits, exits->count, (const float(*)[3])anchors, count, density, error);
}

enum status bake_density_thread(const struct bake_job *job, const struct exit_list *exits,
                                struct sampling_density **density, struct error *error) {
    if (!job->survey.thin) return STATUS_OK;
    float anchors[EMISSION_BEADS][3];
    const size_t clusters = copy_clusters(&job->survey, anchors);
    double least;
    size_t best = clusters;
    enum status status = try_anchors(job, exits, (const float(*)[3])anchors, clusters, &least, error);
    for (size_t count = FEWEST_BEADS; !status && count <= EMISSION_BEADS; count *= 2) {
        double cost;
        if (count <= clusters) continue;
        status = emission_beads_find(anchors, count, NULL, job->lamp.scene, -1, error);
        if (!status) status = try_anchors(job, exits, (const float(*)[3])anchors, count, &cost, error);
        if (!status && cost < least) least = cost, best = count;
    }
    if (status || best == clusters) return status;
    struct sampling_density *beads;
    status = emission_beads_find(anchors, best, NULL, job->lamp.scene, -1, error);
    if (!status) status = build(job, exits, exits->count, (const float(*)[3])anchors, best, &beads, error);
    if (status) return status;
    sampling_density_destroy(*density);
    *density = beads;
    run_note(job->run, "long and thin emission: light samples aim at %zu beads along it", best);
    return STATUS_OK;
}
