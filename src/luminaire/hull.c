#include "luminaire/hull.h"

#include <math.h>
#include <stdlib.h>

static const float crease_cos = 0.64f; // 50 degrees

enum status hull_allocate(struct hull **hull, size_t vertex_count, size_t triangle_count, struct error *error) {
    struct hull *h = *hull = calloc(1, sizeof *h);
    if (h) {
        h->vertex_count = vertex_count;
        h->triangle_count = triangle_count;
        h->vertices = calloc(vertex_count + 1, sizeof *h->vertices);
        h->triangles = calloc(triangle_count + 1, sizeof *h->triangles);
        if (h->vertices && h->triangles) return STATUS_OK;
    }
    hull_destroy(h);
    *hull = NULL;
    return error_set(error, STATUS_MEMORY, "out of memory for a hull of %zu triangles", triangle_count);
}

void hull_destroy(struct hull *hull) {
    if (!hull) return;
    free(hull->vertices);
    free(hull->triangles);
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
        float upper = hull->lower[a] + 65535 * hull->step[a];
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
    const uint16_t *q = hull->vertices[vertex];
    return vec3_make(hull->lower[0] + (float)q[0] * hull->step[0], hull->lower[1] + (float)q[1] * hull->step[1],
                     hull->lower[2] + (float)q[2] * hull->step[2]);
}

// Not unit: its length is twice the area.
static vec3 face_normal(const struct hull *hull, size_t triangle) {
    const uint16_t *v = hull->triangles[triangle];
    vec3 a = hull_vertex(hull, v[0]);
    return vec3_cross(vec3_sub(hull_vertex(hull, v[1]), a), vec3_sub(hull_vertex(hull, v[2]), a));
}

static float corner_angle(const struct hull *hull, size_t triangle, int corner) {
    const uint16_t *v = hull->triangles[triangle];
    vec3 p = hull_vertex(hull, v[corner]), a = vec3_sub(hull_vertex(hull, v[(corner + 1) % 3]), p),
         b = vec3_sub(hull_vertex(hull, v[(corner + 2) % 3]), p);
    return atan2f(vec3_length(vec3_cross(a, b)), vec3_dot(a, b));
}

static vec3 normalize_or(vec3 v, vec3 otherwise) {
    float length = vec3_length(v);
    return length > 0 ? vec3_scale(v, 1 / length) : otherwise;
}

enum status hull_corner_normals(const struct hull *hull, vec3 *normals, struct error *error) {
    size_t n = hull->triangle_count;
    vec3 *faces = malloc((n + 1) * sizeof *faces);
    uint32_t *starts = calloc(hull->vertex_count + 2, sizeof *starts), *corners = malloc((3 * n + 1) * sizeof *corners);
    if (!faces || !starts || !corners) {
        free(faces);
        free(starts);
        free(corners);
        return error_set(error, STATUS_MEMORY, "out of memory for the hull's normals");
    }
    for (size_t t = 0; t < n; t++) {
        faces[t] = normalize_or(face_normal(hull, t), vec3_make(0, 0, 1));
        for (int k = 0; k < 3; k++) starts[hull->triangles[t][k] + 2]++;
    }
    for (size_t v = 2; v < hull->vertex_count + 2; v++) starts[v] += starts[v - 1];
    for (size_t c = 0; c < 3 * n; c++) corners[starts[hull->triangles[c / 3][c % 3] + 1]++] = (uint32_t)c;
    for (size_t i = 0; i < hull->part_count; i++) {
        const struct hull_part *part = &hull->parts[i];
        size_t end = part->first + part->count;
        for (size_t c = 3 * (size_t)part->first; c < 3 * end; c++) {
            vec3 face = faces[c / 3], sum = vec3_make(0, 0, 0);
            uint16_t v = hull->triangles[c / 3][c % 3];
            for (uint32_t k = starts[v]; part->smooth && k < starts[v + 1]; k++) {
                size_t other = corners[k] / 3;
                if (other < part->first || other >= end || vec3_dot(face, faces[other]) < crease_cos) continue;
                sum = vec3_mad(faces[other], corner_angle(hull, other, (int)(corners[k] % 3)), sum);
            }
            normals[c] = normalize_or(sum, face);
        }
    }
    free(faces);
    free(starts);
    free(corners);
    return STATUS_OK;
}
