// The hull, as fine as is of use and the file has room for, and the transparency that is learned with it or without.
// How much room there is depends on the transparency's tables, and these on what the hull can tell.
#include "bake/bake_job.h"
#include "luminaire/hull.h"
#include "luminaire/sampling.h"

enum { SMALL_THINGS = 16384 }; // bytes of a file besides its large tensors
enum { LEAST_TRIANGLES = 2000, MOST_TRIES = 8 };

// A file's tensors besides the hull.
static size_t other_bytes(const struct bake_job *job) {
    size_t group = light_field_bytes(job->light.field) +
                   sampling_density_bytes(job->survey.thin ? EMISSION_BEADS : job->survey.cluster_count) +
                   view_field_bytes(job->plan.view.log2_entries, job->lamp.aim_count);
    return bake_group_count(job) * group + transparency_bytes(job->transparency) + SMALL_THINGS;
}

static enum status create_transparency(struct bake_job *job, bool *fits, struct error *error) {
    struct transparency_options options = {
        .proxy = &job->lamp.proxy,
        .hull = bake_camera_sees_all(&job->scene) ? job->view.hull : NULL, // else the file's hull may be left out
        .log2_entries = job->transparency_log2_entries,
        .steps = job->plan.transparency_chunks * CHUNK_STEPS,
        .seed = job->lamp.seed};
    transparency_destroy(job->transparency);
    enum status status = transparency_create(&job->transparency, &options, error);
    *fits = true;
    if (status == STATUS_OK && options.hull)
        status = transparency_fits_hull(job->transparency, &job->lamp, fits, error);
    if (status != STATUS_OK || *fits) return status;
    transparency_destroy(job->transparency);
    options.hull = NULL;
    return transparency_create(&job->transparency, &options, error);
}

enum status bake_hull_stage(struct bake_job *job, struct error *error) {
    bool fits = true;
    size_t triangles = job->plan.hull_triangles;
    for (int tries = 0; tries < MOST_TRIES; tries++) {
        if (bake_has_view(job)) {
            hull_destroy(job->view.hull);
            hull_map_fini(&job->hull_map);
            enum status status = hull_build(&job->view.hull, &job->hull_map, &job->lamp, triangles, error);
            if (status != STATUS_OK) return status;
        }
        enum status status = create_transparency(job, &fits, error);
        if (status != STATUS_OK) return status;
        const size_t others = other_bytes(job), bytes = job->view.hull ? job->view.hull->packed_bytes : 0;
        const size_t left = others < job->plan.file_bytes ? job->plan.file_bytes - others : 0;
        if (bytes <= left || triangles <= LEAST_TRIANGLES) break;
        triangles = (size_t)(0.95 * (double)job->view.hull->triangle_count * fmax(0.1, (double)left / (double)bytes));
        if (triangles < LEAST_TRIANGLES) triangles = LEAST_TRIANGLES;
    }
    if (!fits)
        run_warn(job->run,
                 "the lamp is too fine for a hull of %zu triangles; its transparency is learned without, and "
                 "appearance=surface will miss parts of it",
                 job->view.hull->triangle_count);
    return STATUS_OK;
}
