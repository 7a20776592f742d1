// The two classes of residual.h, and what each lamp is asked.
#include "trace/residual.h"

#include <stdlib.h>

#include "math/warp.h"
#include "trace/emission_cluster.h"
#include "trace/luminaire_crossing.h"

enum { FIRST_DIMENSION = 1 << 16, DIMENSIONS_PER_DRAW = 1 << 14, TRIALS = 4096 };
static const float traced_share = 0.5f; // q
static const float aim_margin = 1.05f;
static const float noise_limit = 2.5f; // of R' on near lines: its mean square over the square of its mean

struct residual_lamp {
    struct aim aims[EMISSION_CLUSTERS];
    size_t aim_count, near_count; // near_count: aim_count or 0
    float power;
    struct distribution by_power; // of the scene's emitters: those of other shapes have no share
};

struct residual {
    const struct scene *scene;
    struct residual_lamp *lamps; // of scene->luminaires
};

static enum status choose_by_power(struct residual_lamp *lamp, const struct scene *scene, int luminaire,
                                   struct error *error) {
    float *weights = calloc(scene->emitter_count, sizeof *weights);
    if (!weights) return error_set(error, STATUS_MEMORY, "out of memory for %zu emitters", scene->emitter_count);
    for (size_t i = 0; i < scene->emitter_count; i++) {
        const struct emitter *emitter = scene->emitters[i];
        if (emitter->shape && emitter->shape->luminaire == luminaire) weights[i] = fmaxf(rgb_mean(emitter->power), 0);
        lamp->power += weights[i];
    }
    enum status status = distribution_init(&lamp->by_power, weights, scene->emitter_count, error);
    free(weights);
    return status;
}

// Lines towards uniform points of the clusters' balls from a sphere round the lamp.
static bool near_lines_are_calm(const struct residual_lamp *lamp, const struct scene *scene, int luminaire, vec3 center,
                                float radius) {
    double sum = 0, squares = 0, met = 0;
    for (uint32_t i = 0; i < TRIALS; i++) {
        struct sampler sampler = sampler_make(0x726573, (uint64_t)luminaire, i);
        vec3 w = warp_uniform_sphere(sampler_2d(&sampler));
        vec3 offset = vec3_scale(warp_uniform_sphere(sampler_2d(&sampler)), sqrtf(sampler_1d(&sampler)));
        const struct aim *aim = &lamp->aims[i % lamp->aim_count];
        struct ray ray = {.t_max = INFINITY};
        ray.origin = vec3_mad(w, 1.01f * radius, center);
        ray.direction = vec3_normalize(vec3_sub(vec3_mad(offset, aim->radius, aim->center), ray.origin));
        struct line_walk walk;
        struct line_hit hit;
        if (!line_walk_begin(&walk, scene, luminaire, &ray, NULL)) continue;
        met++;
        line_walk_radiance(&walk, &sampler, lamp->aims, lamp->aim_count, scene->max_depth, &hit);
        double value = (double)rgb_mean(hit.radiance);
        sum += value;
        squares += value * value;
    }
    return squares * met <= (double)noise_limit * sum * sum;
}

static enum status lamp_init(struct residual_lamp *lamp, const struct scene *scene, int luminaire,
                             struct error *error) {
    const struct luminaire_instance *instance = &scene->luminaires[luminaire];
    struct emission_cluster clusters[EMISSION_CLUSTERS];
    float local[3], radius;
    luminaire_bounds(instance->luminaire, local, &radius);
    vec3 center = transform_point(&instance->to_world, (vec3){local[0], local[1], local[2]});
    radius *= instance->scale;
    enum status status = emission_clusters_find(clusters, &lamp->aim_count, scene, luminaire, radius, error);
    if (status != STATUS_OK || !lamp->aim_count) return status;
    for (size_t i = 0; i < lamp->aim_count; i++)
        lamp->aims[i] = (struct aim){clusters[i].center, aim_margin * clusters[i].radius};
    if (near_lines_are_calm(lamp, scene, luminaire, center, radius)) lamp->near_count = lamp->aim_count;
    return choose_by_power(lamp, scene, luminaire, error);
}

enum status residual_create(struct residual **result, const struct scene *scene, struct error *error) {
    struct residual *residual = *result = calloc(1, sizeof *residual);
    if (residual) residual->lamps = calloc(scene->luminaire_count + 1, sizeof *residual->lamps);
    enum status status = STATUS_OK;
    if (!residual || !residual->lamps)
        status = error_set(error, STATUS_MEMORY, "out of memory for the lamps' emitters");
    if (residual) residual->scene = scene;
    for (size_t i = 0; status == STATUS_OK && i < scene->luminaire_count; i++)
        status = lamp_init(&residual->lamps[i], scene, (int)i, error);
    if (status == STATUS_OK) return status;
    residual_destroy(residual);
    *result = NULL;
    return status;
}

void residual_destroy(struct residual *residual) {
    if (!residual) return;
    for (size_t i = 0; residual->lamps && i < residual->scene->luminaire_count; i++)
        distribution_fini(&residual->lamps[i].by_power);
    free(residual->lamps);
    free(residual);
}

bool residual_line_is_near(const struct residual *residual, int luminaire, vec3 p, vec3 w) {
    const struct residual_lamp *lamp = &residual->lamps[luminaire];
    for (size_t i = 0; i < lamp->near_count; i++) {
        vec3 to = vec3_sub(lamp->aims[i].center, p), across = vec3_mad(w, -vec3_dot(to, w), to);
        if (vec3_dot(across, across) <= sqrf(lamp->aims[i].radius)) return true;
    }
    return false;
}

rgb residual_correct(const struct residual *residual, const struct line_walk *walk, rgb model, bool looks,
                     struct sampler sampler, uint32_t draw, int max_depth) {
    sampler.dimension = FIRST_DIMENSION + draw * DIMENSIONS_PER_DRAW;
    float share = looks ? 1 : traced_share;
    if (sampler_1d(&sampler) >= share) return model;
    const struct residual_lamp *lamp = &residual->lamps[walk->luminaire];
    struct line_hit traced;
    line_walk_radiance(walk, &sampler, lamp->aims, lamp->aim_count, max_depth, &traced);
    return rgb_add(model, rgb_scale(rgb_sub(traced.radiance, model), 1 / share));
}

float residual_power(const struct residual *residual, int luminaire) { return residual->lamps[luminaire].power; }

bool residual_emit(const struct residual *residual, int luminaire, float u_emitter, struct sampler *sampler,
                   struct emission_sample *emission, rgb *beta) {
    const struct distribution *by_power = &residual->lamps[luminaire].by_power;
    if (!by_power->n) return false;
    size_t index = distribution_sample(by_power, u_emitter, NULL);
    const struct emitter *emitter = residual->scene->emitters[index];
    vec2 u_position = sampler_2d(sampler), u_direction = sampler_2d(sampler);
    if (!emitter->type->sample_emission(emitter, u_position, u_direction, emission)) return false;
    float pdf = emission->pdf_position * emission->pdf_direction * distribution_pmf(by_power, index);
    *beta = rgb_scale(emission->radiance, emission->cos_theta / pdf);
    return rgb_is_finite(*beta) && rgb_max(*beta) > 0;
}
