// The choice among the targets: in proportion to the irradiance that a small lamp in the proxy's centre would give.
#include "trace/caustic_target.h"

#include <stdlib.h>

#include "math/warp.h"
#include "trace/luminaire_crossing.h"

static const float least_cos = 0.1f; // of the irradiance's cosine: lamps are not points, and vertex normals bend

static bool shape_is_target(const struct scene *scene, const struct shape *shape, uint32_t luminaire) {
    if (!shape->bsdf || !(shape->bsdf->flags & BSDF_DELTA)) return false;
    struct lamp_view view = {false, -1, (int)luminaire};
    return !lamp_view_hides(scene, &view, shape);
}

static vec3 triangle_area_vector(const struct mesh *mesh, uint32_t triangle, vec3 *middle) {
    const uint32_t *corners = mesh->indices + 3 * (size_t)triangle;
    vec3 a = mesh->positions[corners[0]], b = mesh->positions[corners[1]], c = mesh->positions[corners[2]];
    *middle = vec3_scale(vec3_add(a, vec3_add(b, c)), 1.0f / 3);
    return vec3_scale(vec3_cross(vec3_sub(b, a), vec3_sub(c, a)), 0.5f);
}

static void add(struct caustic_targets *targets, float *weights, struct caustic_target target, float weight) {
    if (!(target.area > 0) || !isfinite(weight)) return;
    weights[targets->count] = weight;
    targets->targets[targets->count++] = target;
    targets->weight += (double)weight;
}

static void add_shape(struct caustic_targets *targets, float *weights, const struct shape *shape, vec3 center,
                      float radius) {
    if (!shape->mesh.triangle_count) {
        vec3 lower, upper;
        shape->type->bounds(shape, &lower, &upper);
        vec3 to = vec3_sub(vec3_scale(vec3_add(lower, upper), 0.5f), center);
        add(targets, weights, (struct caustic_target){shape, 0, shape->area},
            0.5f * shape->area / fmaxf(vec3_dot(to, to), sqrf(radius)));
        return;
    }
    for (uint32_t i = 0; i < shape->mesh.triangle_count; i++) {
        vec3 middle, normal = triangle_area_vector(&shape->mesh, i, &middle), to = vec3_sub(middle, center);
        float area = vec3_length(normal), distance2 = vec3_dot(to, to);
        float facing = fabsf(vec3_dot(normal, to)) / sqrtf(fmaxf(distance2, 1e-30f));
        add(targets, weights, (struct caustic_target){shape, i, area},
            fmaxf(facing, least_cos * area) / fmaxf(distance2, sqrf(radius)));
    }
}

enum status caustic_targets_init(struct caustic_targets *targets, const struct scene *scene, uint32_t luminaire,
                                 struct error *error) {
    const struct luminaire_instance *instance = &scene->luminaires[luminaire];
    *targets = (struct caustic_targets){0};
    size_t count = 0;
    for (size_t i = 0; i < scene->shape_count; i++) {
        const struct shape *shape = scene->shapes[i];
        if (shape_is_target(scene, shape, luminaire))
            count += shape->mesh.triangle_count ? shape->mesh.triangle_count : 1;
    }
    if (!count) return STATUS_OK;
    float *weights = calloc(count, sizeof *weights), local_center[3], local_radius;
    targets->targets = calloc(count, sizeof *targets->targets);
    if (!weights || !targets->targets) {
        free(weights);
        caustic_targets_fini(targets);
        return error_set(error, STATUS_MEMORY, "out of memory for the caustics of %zu surfaces", count);
    }
    luminaire_bounds(instance->luminaire, local_center, &local_radius);
    const float(*m)[4] = instance->to_world.m;
    vec3 center = {m[0][3], m[1][3], m[2][3]}, local = {local_center[0], local_center[1], local_center[2]};
    float distance = vec3_length(local);
    if (distance > 0)
        center = vec3_mad(luminaire_world_direction(instance, vec3_scale(local, 1 / distance)),
                          distance * instance->scale, center);
    for (size_t i = 0; i < scene->shape_count; i++)
        if (shape_is_target(scene, scene->shapes[i], luminaire))
            add_shape(targets, weights, scene->shapes[i], center, local_radius * instance->scale);
    enum status status = STATUS_OK;
    if (targets->count) status = distribution_init(&targets->choice, weights, targets->count, error);
    free(weights);
    if (status != STATUS_OK) caustic_targets_fini(targets);
    return status;
}

void caustic_targets_fini(struct caustic_targets *targets) {
    free(targets->targets);
    distribution_fini(&targets->choice);
    *targets = (struct caustic_targets){0};
}

void caustic_targets_sample(const struct caustic_targets *targets, float u_target, vec2 u_point,
                            struct surface *surface, float *pdf_area) {
    size_t index = distribution_sample(&targets->choice, u_target, NULL);
    const struct caustic_target *target = &targets->targets[index];
    if (target->shape->mesh.triangle_count)
        shape_fill_triangle(target->shape, target->triangle, warp_triangle(u_point), surface);
    else
        shape_sample(target->shape, u_point, surface);
    *pdf_area = distribution_pmf(&targets->choice, index) / target->area;
}
