#include "luminaire/hull.h"

#include <math.h>
#include <stdlib.h>

#include "math/warp.h"

enum status hull_allocate(struct hull **hull, size_t vertex_count, size_t triangle_count, struct error *error) {
    struct hull *h = *hull = calloc(1, sizeof *h);
    if (h) {
        h->vertex_count = vertex_count;
        h->triangle_count = triangle_count;
        h->vertices = calloc(vertex_count + 1, sizeof *h->vertices);
        h->normals = calloc(vertex_count + 1, sizeof *h->normals);
        h->triangles = calloc(triangle_count + 1, sizeof *h->triangles);
        if (h->vertices && h->normals && h->triangles) return STATUS_OK;
    }
    hull_destroy(h);
    *hull = NULL;
    return error_set(error, STATUS_MEMORY, "out of memory for a hull of %zu triangles", triangle_count);
}

void hull_destroy(struct hull *hull) {
    if (!hull) return;
    free(hull->vertices);
    free(hull->normals);
    free(hull->triangles);
    free(hull->packed);
    free(hull);
}

static bool part_is_valid(const struct hull_part *part, size_t first) {
    if (part->kind > HULL_GLASS || part->first != first || part->count < 1 || part->count > HULL_MAX_TRIANGLES)
        return false;
    if (part->kind == HULL_GLASS && !(part->eta > 0.1f && part->eta < 10)) return false;
    for (int c = 0; c < 3; c++)
        if (!(part->sigma_a[c] >= 0) || !isfinite(part->sigma_a[c])) return false;
    return true;
}

enum status hull_check(const struct hull *hull, const float center[3], float radius, struct error *error) {
    for (int a = 0; a < 3; a++) {
        float upper = hull->lower[a] + (float)HULL_MAX_CODE * hull->step[a];
        if (!(hull->step[a] >= 0) || !(fabsf(hull->lower[a] - center[a]) <= 2 * radius) ||
            !(fabsf(upper - center[a]) <= 2 * radius))
            return error_set(error, STATUS_INVALID, "the hull reaches beyond the proxy");
    }
    size_t triangles = 0;
    for (size_t i = 0; i < hull->part_count; i++) {
        if (!part_is_valid(&hull->parts[i], triangles))
            return error_set(error, STATUS_INVALID, "part %zu of the hull is out of range", i);
        triangles += hull->parts[i].count;
    }
    if (triangles != hull->triangle_count)
        return error_set(error, STATUS_INVALID, "the hull's parts do not cover its triangles");
    for (size_t i = 0; i < hull->triangle_count; i++)
        for (int k = 0; k < 3; k++)
            if (hull->triangles[i][k] >= hull->vertex_count)
                return error_set(error, STATUS_INVALID, "triangle %zu of the hull has no such vertex", i);
    return STATUS_OK;
}

vec3 hull_vertex(const struct hull *hull, size_t vertex) {
    const uint32_t *q = hull->vertices[vertex];
    return vec3_make(hull->lower[0] + (float)q[0] * hull->step[0], hull->lower[1] + (float)q[1] * hull->step[1],
                     hull->lower[2] + (float)q[2] * hull->step[2]);
}

void hull_set_vertex(struct hull *hull, size_t vertex, vec3 p) {
    const float at[3] = {p.x, p.y, p.z};
    for (int a = 0; a < 3; a++) {
        double code = hull->step[a] > 0 ? (double)(at[a] - hull->lower[a]) / (double)hull->step[a] : 0;
        hull->vertices[vertex][a] = (uint32_t)lrint(fmin(fmax(code, 0), HULL_MAX_CODE));
    }
}

vec3 hull_normal(const struct hull *hull, size_t vertex) {
    const uint16_t *q = hull->normals[vertex];
    return direction_from_octahedral(
        (vec2){(float)q[0] * (1.0f / HULL_MAX_NORMAL), (float)q[1] * (1.0f / HULL_MAX_NORMAL)});
}

void hull_set_normal(struct hull *hull, size_t vertex, vec3 n) {
    const vec2 square = octahedral_from_direction(n);
    hull->normals[vertex][0] = (uint16_t)lrintf(clampf(square.x, 0, 1) * HULL_MAX_NORMAL);
    hull->normals[vertex][1] = (uint16_t)lrintf(clampf(square.y, 0, 1) * HULL_MAX_NORMAL);
}

vec3 hull_face_normal(const struct hull *hull, size_t triangle) {
    const uint16_t *v = hull->triangles[triangle];
    const vec3 a = hull_vertex(hull, v[0]);
    const vec3 twice_area = vec3_cross(vec3_sub(hull_vertex(hull, v[1]), a), vec3_sub(hull_vertex(hull, v[2]), a));
    const float length = vec3_length(twice_area);
    return length > 0 ? vec3_scale(twice_area, 1 / length) : vec3_make(0, 0, 1);
}
