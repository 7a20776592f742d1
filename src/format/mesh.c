// What all mesh loaders share: the checks that make a mesh safe for the ray tracer, and vertex normals.
#include "format/mesh.h"

// Angle weights (Thuermer and Wuethrich 1998) do not depend on how a polygon was cut into triangles.
enum status mesh_compute_normals(struct mesh *mesh, struct arena *arena, struct error *error) {
    vec3 *normals = arena_alloc(arena, mesh->vertex_count, sizeof *normals);
    if (!normals) return error_set(error, STATUS_MEMORY, "out of memory for %zu vertex normals", mesh->vertex_count);
    for (size_t t = 0; t < mesh->triangle_count; ++t) {
        const uint32_t *index = mesh->indices + 3 * t;
        for (int k = 0; k < 3; ++k) {
            vec3 corner = mesh->positions[index[k]];
            vec3 a = vec3_sub(mesh->positions[index[(k + 1) % 3]], corner);
            vec3 b = vec3_sub(mesh->positions[index[(k + 2) % 3]], corner);
            vec3 cross = vec3_cross(a, b);
            float sine = vec3_length(cross);
            if (!(sine > 0) || !isfinite(sine)) continue;
            vec3 *sum = &normals[index[k]];
            *sum = vec3_mad(cross, atan2f(sine, vec3_dot(a, b)) / sine, *sum);
        }
    }
    for (size_t v = 0; v < mesh->vertex_count; ++v) {
        float length = vec3_length(normals[v]);
        normals[v] =
            length > 0 ? vec3_scale(normals[v], 1 / length) : vec3_make(0, 0, 1); // no triangle has an area here
    }
    mesh->normals = normals;
    return STATUS_OK;
}

static bool normal_usable(vec3 n) {
    float length = vec3_length(n);
    return isfinite(length) && length > 1e-12f;
}

// Exporters write zero normals at vertices of degenerate triangles: those alone are computed.
static enum status normals_repair(struct mesh *mesh, struct arena *arena, struct error *error) {
    struct mesh computed = *mesh;
    bool have_computed = false;
    for (size_t v = 0; v < mesh->vertex_count; ++v) {
        if (normal_usable(mesh->normals[v])) {
            mesh->normals[v] = vec3_normalize(mesh->normals[v]);
            continue;
        }
        enum status status = have_computed ? STATUS_OK : mesh_compute_normals(&computed, arena, error);
        if (status != STATUS_OK) return status;
        have_computed = true;
        mesh->normals[v] = computed.normals[v];
    }
    return STATUS_OK;
}

enum status mesh_finish(struct mesh *mesh, struct arena *arena, const char *name, struct error *error) {
    if (mesh->triangle_count == 0 || mesh->vertex_count == 0) {
        return error_set(error, STATUS_INVALID, "%s: holds no triangles", name);
    }
    for (size_t v = 0; v < mesh->vertex_count; ++v) {
        if (!vec3_is_finite(mesh->positions[v])) {
            return error_set(error, STATUS_INVALID, "%s: vertex %zu is not finite; export the mesh again", name, v);
        }
        if (mesh->uvs && !(isfinite(mesh->uvs[v].x) && isfinite(mesh->uvs[v].y))) {
            return error_set(error, STATUS_INVALID, "%s: the texture coordinate of vertex %zu is not finite", name, v);
        }
    }
    for (size_t i = 0; i < 3 * mesh->triangle_count; ++i) {
        if (mesh->indices[i] >= mesh->vertex_count) {
            return error_set(error, STATUS_INVALID, "%s: triangle %zu refers to vertex %u of %zu", name, i / 3,
                             mesh->indices[i], mesh->vertex_count);
        }
    }
    return mesh->normals ? normals_repair(mesh, arena, error) : STATUS_OK;
}
