// Third step of a bake.
#include "bake/survey.h"

#include <stdlib.h>

enum { STATISTICS_EXITS = 200000 };
static const float least_shell_gap = 0.04f, pass_margin = 1.25f;
static const float thin_ratio = 0.6f; // along a line 0.5, over a surface 0.71

static float distance2(vec3 a, vec3 b) {
    vec3 d = vec3_sub(a, b);
    return vec3_dot(d, d);
}

enum status survey_clusters(struct survey *survey, const struct lamp *lamp, struct error *error) {
    const struct scene *scene = lamp->scene;
    enum status status =
        emission_clusters_find(survey->clusters, &survey->cluster_count, scene, -1, lamp->proxy.radius, error);
    const size_t count = survey->cluster_count;
    float beads[EMISSION_BEADS][3], reach = 0, half_reach = 0;
    if (!status && count) status = emission_beads_find(beads, count, &reach, scene, -1, error);
    if (!status && count) status = emission_beads_find(beads, 2 * count, &half_reach, scene, -1, error);
    survey->thin = half_reach < thin_ratio * reach;
    return status;
}

static bool passes_cluster(const struct survey *survey, const struct line_exit *exit) {
    vec3 p = {exit->point[0], exit->point[1], exit->point[2]}, w = {exit->w[0], exit->w[1], exit->w[2]};
    for (size_t c = 0; c < survey->cluster_count; c++) {
        vec3 d = vec3_sub(p, survey->clusters[c].center);
        float along = vec3_dot(d, w);
        if (vec3_dot(d, d) - along * along <= sqrf(pass_margin * survey->clusters[c].radius)) return true;
    }
    return false;
}

struct weighted_radius {
    float radius, weight;
};

static int compare_radii(const void *a, const void *b) {
    const struct weighted_radius *p = a, *q = b;
    return (p->radius > q->radius) - (p->radius < q->radius);
}

// Flux-weighted quantiles of the radius where light left, at least a small gap apart.
static enum status find_shells(struct survey *survey, const struct lamp *lamp, size_t n, struct error *error) {
    struct weighted_radius *radii = malloc((n + 1) * sizeof *radii);
    if (!radii) return error_set(error, STATUS_MEMORY, "out of memory for the survey");
    vec3 center = {lamp->proxy.center[0], lamp->proxy.center[1], lamp->proxy.center[2]};
    double total = 0, passed = 0;
    for (size_t i = 0; i < n; i++) {
        const float *flux = survey->exits.exits[i].flux;
        radii[i].radius = sqrtf(distance2(survey->exits.origin[i], center)) / lamp->proxy.radius;
        radii[i].weight = flux[0] + flux[1] + flux[2];
        total += (double)radii[i].weight;
    }
    qsort(radii, n, sizeof *radii, compare_radii);
    survey->shell_count = 0;
    float least = least_shell_gap;
    for (size_t i = 0, k = 0; i < n && k < SURVEY_SHELLS; i++) {
        passed += (double)radii[i].weight;
        if (passed < total * ((double)k + 0.5) / SURVEY_SHELLS) continue;
        k++;
        float radius = clampf(radii[i].radius, least, 1);
        if (radius > 0.97f) continue;
        survey->shell_radii[survey->shell_count++] = radius;
        least = radius + least_shell_gap;
    }
    free(radii);
    return STATUS_OK;
}

enum status survey_exits(struct survey *survey, const struct lamp *lamp, enum gather_stream stream, size_t particles,
                         const struct run *run, struct error *error) {
    enum status status = gather_exits(&survey->exits, lamp, stream, 0, particles, true, run, error);
    if (status != STATUS_OK) return status;
    const struct exit_list *list = &survey->exits;
    double n = (double)list->emitted, total = 0;
    for (int c = 0; c < 3; c++) {
        double sum = 0, squares = 0;
        for (size_t i = 0; i < list->count; i++) {
            double y = (double)list->exits[i].flux[c];
            sum += y;
            squares += y * y;
        }
        survey->flux[c] = sum / n;
        survey->flux_noise[c] = sum > 0 ? sqrt(fmax(0, squares / n - sum / n * (sum / n)) / n) / (sum / n) : 0;
        total += survey->flux[c];
    }
    if (!(total > 0))
        return error_set(error, STATUS_INVALID,
                         "%s: no light leaves the lamp: of %zu particles none came out; are the emitters enclosed in "
                         "something opaque, or do their normals point inwards?",
                         lamp->scene->path, particles);
    survey->exit_rate = (float)((double)list->count / n);
    size_t subset = list->count < STATISTICS_EXITS ? list->count : STATISTICS_EXITS;
    double passing = 0, all = 0;
    for (size_t i = 0; i < subset; i++) {
        double y = (double)(list->exits[i].flux[0] + list->exits[i].flux[1] + list->exits[i].flux[2]);
        all += y;
        if (passes_cluster(survey, &list->exits[i])) passing += y;
    }
    survey->clear_share = (float)(all > 0 ? passing / all : 0);
    return find_shells(survey, lamp, subset, error);
}

void survey_fini(struct survey *survey) { exit_list_fini(&survey->exits); }
