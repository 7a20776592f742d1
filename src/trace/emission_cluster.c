// A farthest-point traversal (Gonzalez 1985), then Lloyd's iterations, over points drawn from the emitters in
// proportion to their power.
#include "trace/emission_cluster.h"

#include <stdlib.h>

#include "math/distribution.h"

enum { EMISSION_POINTS = 16384, LLOYD_STEPS = 8 };
static const float cluster_reach = 0.1f, least_radius = 1e-3f; // [lamp radius]
static const float piece_gap = 0.5f;

static float distance2(vec3 a, vec3 b) {
    vec3 d = vec3_sub(a, b);
    return vec3_dot(d, d);
}

static bool emitter_belongs(const struct emitter *emitter, int luminaire) {
    return (emitter->shape ? emitter->shape->luminaire : -1) == luminaire;
}

static enum status draw_points(vec3 *points, const struct scene *scene, int luminaire, struct error *error) {
    float *powers = calloc(scene->emitter_count + 1, sizeof *powers);
    if (!powers) return error_set(error, STATUS_MEMORY, "out of memory for %zu emitters", scene->emitter_count);
    for (size_t i = 0; i < scene->emitter_count; i++)
        if (emitter_belongs(scene->emitters[i], luminaire)) powers[i] = fmaxf(0, rgb_mean(scene->emitters[i]->power));
    struct distribution pick;
    enum status status = distribution_init(&pick, powers, scene->emitter_count, error);
    free(powers);
    if (status != STATUS_OK) return status;
    vec3 last = scene->bounds.center;
    for (size_t i = 0; i < EMISSION_POINTS; i++) {
        struct sampler sampler = sampler_make(0x656d69, 0, i); // the same clusters for every seed
        const struct emitter *emitter = scene->emitters[distribution_sample(&pick, sampler_1d(&sampler), NULL)];
        struct emission_sample sample;
        vec2 u_position = sampler_2d(&sampler), u_direction = sampler_2d(&sampler);
        if (emitter->type->sample_emission(emitter, u_position, u_direction, &sample)) last = sample.ray.origin;
        points[i] = last;
    }
    distribution_fini(&pick);
    return STATUS_OK;
}

static size_t nearest_cluster(const struct emission_cluster *clusters, size_t count, vec3 p) {
    size_t nearest = 0;
    for (size_t c = 1; c < count; c++)
        if (distance2(p, clusters[c].center) < distance2(p, clusters[nearest].center)) nearest = c;
    return nearest;
}

// Farthest-point traversal: after k centres every point is within reaches[k] of one of them.
static void traverse(struct emission_cluster *clusters, size_t count, const vec3 *points, float *d2, float *reaches) {
    size_t next = 0;
    for (size_t i = 0; i < EMISSION_POINTS; i++) d2[i] = INFINITY;
    for (size_t k = 1; k <= count; k++) {
        clusters[k - 1].center = points[next];
        for (size_t i = 0; i < EMISSION_POINTS; i++) d2[i] = fminf(d2[i], distance2(points[i], points[next]));
        for (size_t i = 0; i < EMISSION_POINTS; i++)
            if (d2[i] > d2[next]) next = i;
        reaches[k] = sqrtf(d2[next]);
    }
}

// As many as bring the reach below `reach`, and beyond it as many as the emission has separate pieces: where one more
// centre makes the reach fall at once, from the distance between pieces to the size of a piece.
static size_t spread_clusters(struct emission_cluster *clusters, const vec3 *points, float *d2, float reach) {
    float reaches[EMISSION_CLUSTERS + 1] = {INFINITY};
    size_t count = 0;
    traverse(clusters, EMISSION_CLUSTERS, points, d2, reaches);
    for (size_t k = 1; k <= EMISSION_CLUSTERS; k++) {
        bool separate = reaches[k] < piece_gap * reaches[k - 1];
        if (count == 0 ? reaches[k] <= reach || k == EMISSION_CLUSTERS : separate) count = k;
    }
    return count;
}

static void refine_clusters(struct emission_cluster *clusters, size_t count, const vec3 *points) {
    vec3 sums[EMISSION_BEADS] = {{0, 0, 0}};
    size_t counts[EMISSION_BEADS] = {0};
    for (size_t i = 0; i < EMISSION_POINTS; i++) {
        size_t c = nearest_cluster(clusters, count, points[i]);
        sums[c] = vec3_add(sums[c], vec3_sub(points[i], clusters[c].center));
        counts[c]++;
    }
    for (size_t c = 0; c < count; c++) {
        if (counts[c] == 0) continue;
        clusters[c].center = vec3_mad(sums[c], 1.0f / (float)counts[c], clusters[c].center);
        clusters[c].share = (float)counts[c] / EMISSION_POINTS;
    }
}

enum status emission_clusters_find(struct emission_cluster clusters[EMISSION_CLUSTERS], size_t *count,
                                   const struct scene *scene, int luminaire, float lamp_radius, struct error *error) {
    *count = 0;
    bool emits = false;
    for (size_t i = 0; i < scene->emitter_count; i++)
        emits |= emitter_belongs(scene->emitters[i], luminaire) && rgb_max(scene->emitters[i]->power) > 0;
    if (!emits) return STATUS_OK;
    vec3 *points = malloc(EMISSION_POINTS * sizeof *points);
    float *d2 = malloc(EMISSION_POINTS * sizeof *d2);
    enum status status = points && d2 ? draw_points(points, scene, luminaire, error)
                                      : error_set(error, STATUS_MEMORY, "out of memory for the emission points");
    if (status == STATUS_OK) {
        // A ball of twice the reach may be one cluster: its centre is found by the refinement.
        *count = spread_clusters(clusters, points, d2, 2 * cluster_reach * lamp_radius);
        for (int step = 0; step < LLOYD_STEPS; step++) refine_clusters(clusters, *count, points);
        for (size_t c = 0; c < *count; c++) clusters[c].radius = least_radius * lamp_radius;
        for (size_t i = 0; i < EMISSION_POINTS; i++) {
            struct emission_cluster *cluster = &clusters[nearest_cluster(clusters, *count, points[i])];
            cluster->radius = fmaxf(cluster->radius, sqrtf(distance2(points[i], cluster->center)));
        }
    }
    free(points);
    free(d2);
    return status;
}

enum status emission_beads_find(float (*beads)[3], size_t count, float *reach, const struct scene *scene, int luminaire,
                                struct error *error) {
    vec3 *points = malloc(EMISSION_POINTS * sizeof *points);
    float *d2 = malloc(EMISSION_POINTS * sizeof *d2), reaches[EMISSION_BEADS + 1];
    struct emission_cluster clusters[EMISSION_BEADS];
    enum status status = points && d2 ? draw_points(points, scene, luminaire, error)
                                      : error_set(error, STATUS_MEMORY, "out of memory for the emission points");
    if (status == STATUS_OK) {
        traverse(clusters, count, points, d2, reaches);
        if (reach) *reach = reaches[count];
        for (int step = 0; step < LLOYD_STEPS; step++) refine_clusters(clusters, count, points);
        for (size_t c = 0; c < count; c++) vec3_store(beads[c], clusters[c].center);
    }
    free(points);
    free(d2);
    return status;
}
