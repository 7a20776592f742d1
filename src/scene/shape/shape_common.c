// From a mesh in its own coordinates to a shape in the world, and checks of to_world. Conventions are Mitsuba 3's
// (docs/conventions.md): without vertex normals the outside follows the winding after to_world; vertex normals turn by
// the inverse transpose, are computed where the file has none, and then decide the outside.
#include "scene/shape/shape_common.h"

#include <string.h>

enum status shape_check_transform(struct shape *shape, struct commit_context *context, struct error *error) {
    const struct transform *t = &shape->to_world;
    if (t->m[3][0] != 0 || t->m[3][1] != 0 || t->m[3][2] != 0 || t->m[3][3] == 0)
        return error_at(error, context->object->place,
                        "to_world of this %s is a projection; use translate, rotate, scale or an affine matrix",
                        shape->type->name);
    double m[3][3], row_product = 1;
    for (int i = 0; i < 3; ++i) {
        double sum = 0;
        for (int j = 0; j < 3; ++j) {
            m[i][j] = (double)t->m[i][j];
            sum += m[i][j] * m[i][j];
        }
        row_product *= sqrt(sum);
    }
    double determinant = m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) -
                         m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
                         m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
    bool finite = true;
    for (int i = 0; i < 4; ++i)
        for (int j = 0; j < 4; ++j) finite = finite && isfinite(t->m[i][j]) && isfinite(t->inverse[i][j]);
    if (!finite || !(fabs(determinant) > 1e-9 * row_product))
        return error_at(error, context->object->place,
                        "to_world of this %s is singular: it flattens the shape; give every axis a scale other than 0",
                        shape->type->name);
    return STATUS_OK;
}

float shape_similarity_scale(const struct transform *t) {
    if (!transform_flips_handedness(t)) return transform_uniform_scale(t);
    struct transform mirror = transform_scale(vec3_make(-1, 1, 1)), proper = transform_multiply(t, &mirror);
    return transform_uniform_scale(&proper);
}

static enum status out_of_memory(struct commit_context *context, struct error *error) {
    return error_at(error, context->object->place, "out of memory for this mesh; use a coarser one");
}

static vec3 normalize_or_zero(vec3 n) {
    float length = vec3_length(n);
    return length > 1e-20f && isfinite(length) ? vec3_scale(n, 1 / length) : vec3_make(0, 0, 0);
}

static double mesh_area(const struct mesh *mesh) {
    double area = 0;
    for (size_t i = 0; i < mesh->triangle_count; ++i) {
        const uint32_t *v = mesh->indices + 3 * i;
        vec3 a = mesh->positions[v[0]];
        area += 0.5 *
                (double)vec3_length(vec3_cross(vec3_sub(mesh->positions[v[1]], a), vec3_sub(mesh->positions[v[2]], a)));
    }
    return area;
}

// The result has 16 readable bytes after the last position, as Embree asks of a shared vertex buffer.
static bool mesh_transform(struct mesh *mesh, const struct transform *t, struct arena *arena) {
    vec3 *positions = arena_alloc(arena, mesh->vertex_count + 2, sizeof *positions);
    vec3 *normals = mesh->normals ? arena_alloc(arena, mesh->vertex_count, sizeof *normals) : NULL;
    if (!positions || (mesh->normals && !normals)) return false;
    for (size_t i = 0; i < mesh->vertex_count; ++i) {
        positions[i] = transform_point(t, mesh->positions[i]);
        if (normals) normals[i] = transform_normal(t, mesh->normals[i]);
    }
    mesh->positions = positions;
    mesh->normals = normals;
    return true;
}

static void mesh_flip_winding(struct mesh *mesh) {
    for (size_t i = 0; i < mesh->triangle_count; ++i) {
        uint32_t *v = mesh->indices + 3 * i, swap = v[1];
        v[1] = v[2];
        v[2] = swap;
    }
}

enum status shape_finish_mesh(struct shape *shape, struct commit_context *context, struct error *error) {
    struct mesh *mesh = &shape->mesh;
    if (mesh->triangle_count == 0)
        return error_at(error, context->object->place, "this %s has no triangles", shape->type->name);
    if (mesh->triangle_count > UINT32_MAX / 3 || mesh->vertex_count > UINT32_MAX - 2)
        return error_at(error, context->object->place,
                        "this %s has more triangles than 32-bit indices can serve; split it", shape->type->name);
    if (shape->face_normals) mesh->normals = NULL;
    if (!mesh_transform(mesh, &shape->to_world, context->arena)) return out_of_memory(context, error);
    if (!mesh->normals && !shape->face_normals) {
        enum status status = mesh_compute_normals(mesh, context->arena, error);
        if (status != STATUS_OK) return status;
    }
    if (shape->flip_normals) mesh_flip_winding(mesh);
    for (size_t i = 0; mesh->normals && i < mesh->vertex_count; ++i) {
        vec3 n = normalize_or_zero(mesh->normals[i]);
        mesh->normals[i] = shape->flip_normals ? vec3_neg(n) : n;
    }
    double area = mesh_area(mesh);
    if (!(area > 0) || !isfinite((float)area))
        return error_at(error, context->object->place, "the area of this %s is %g; it needs a positive, finite one",
                        shape->type->name, area);
    shape->area = (float)area;
    return STATUS_OK;
}

enum status shape_finish_quads(struct shape *shape, const vec3 *corners, size_t quad_count,
                               struct commit_context *context, struct error *error) {
    static const vec2 corner_uvs[4] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    static const uint32_t halves[6] = {0, 1, 2, 2, 3, 0};
    enum status status = shape_check_transform(shape, context, error);
    if (status != STATUS_OK) return status;
    struct mesh *mesh = &shape->mesh;
    mesh->vertex_count = 4 * quad_count;
    mesh->triangle_count = 2 * quad_count;
    mesh->positions = arena_alloc(context->arena, mesh->vertex_count, sizeof *mesh->positions);
    mesh->uvs = arena_alloc(context->arena, mesh->vertex_count, sizeof *mesh->uvs);
    mesh->indices = arena_alloc(context->arena, 3 * mesh->triangle_count, sizeof *mesh->indices);
    if (!mesh->positions || !mesh->uvs || !mesh->indices) return out_of_memory(context, error);
    memcpy(mesh->positions, corners, mesh->vertex_count * sizeof *corners);
    for (size_t i = 0; i < mesh->vertex_count; ++i) mesh->uvs[i] = corner_uvs[i % 4];
    for (size_t i = 0; i < 6 * quad_count; ++i) mesh->indices[i] = (uint32_t)(4 * (i / 6)) + halves[i % 6];
    shape->face_normals = true;
    if (transform_flips_handedness(&shape->to_world)) mesh_flip_winding(mesh);
    return shape_finish_mesh(shape, context, error);
}
