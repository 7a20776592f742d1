// Points on shapes: filling in a triangle hit, uniform sampling by area. Positions are computed in double precision, so
// that they lie within half a unit in the last place of the triangle's plane and surface_spawn_ray's offset is enough.
#include "scene/shape.h"

#include "math/distribution.h"
#include "math/warp.h"
#include "scene/shape/shape_common.h"

struct frame shape_frame(vec3 n, vec3 dp_du) {
    vec3 s = vec3_mad(n, -vec3_dot(n, dp_du), dp_du);
    float length = vec3_length(s);
    if (!(length > 1e-6f * vec3_length(dp_du)) || !(length > 1e-30f)) return frame_from_normal(n);
    s = vec3_scale(s, 1 / length);
    return (struct frame){s, vec3_cross(n, s), n};
}

static float interpolate(float a, float b, float c, vec2 w) {
    return (float)((double)a + (double)w.x * ((double)b - (double)a) + (double)w.y * ((double)c - (double)a));
}

// dp/du and dp/dv of the triangle's linear uv map; zero where the uvs are degenerate.
static void fill_uv_derivatives(vec3 e1, vec3 e2, vec2 uv0, vec2 uv1, vec2 uv2, struct surface *surface) {
    float du1 = uv1.x - uv0.x, dv1 = uv1.y - uv0.y, du2 = uv2.x - uv0.x, dv2 = uv2.y - uv0.y;
    float determinant = du1 * dv2 - dv1 * du2;
    if (fabsf(determinant) > 1e-6f * (fabsf(du1 * dv2) + fabsf(dv1 * du2))) {
        float inverse = 1 / determinant;
        surface->dp_du = vec3_scale(vec3_sub(vec3_scale(e1, dv2), vec3_scale(e2, dv1)), inverse);
        surface->dp_dv = vec3_scale(vec3_sub(vec3_scale(e2, du1), vec3_scale(e1, du2)), inverse);
    }
}

void shape_fetch_triangle(const struct shape *shape, uint32_t primitive) {
    __builtin_prefetch(shape->mesh.indices + 3 * (size_t)primitive);
}

void shape_fetch_vertices(const struct shape *shape, uint32_t primitive) {
    const struct mesh *mesh = &shape->mesh;
    const uint32_t *v = mesh->indices + 3 * (size_t)primitive;
    for (int i = 0; i < 3; i++) {
        __builtin_prefetch(mesh->positions + v[i]);
        if (mesh->uvs) __builtin_prefetch(mesh->uvs + v[i]);
        if (mesh->normals) __builtin_prefetch(mesh->normals + v[i]);
    }
}

void shape_fill_triangle(const struct shape *shape, uint32_t primitive, vec2 barycentric, struct surface *surface) {
    const struct mesh *mesh = &shape->mesh;
    const uint32_t *v = mesh->indices + 3 * (size_t)primitive;
    vec3 p0 = mesh->positions[v[0]], p1 = mesh->positions[v[1]], p2 = mesh->positions[v[2]];
    vec2 b = barycentric;
    surface->shape = shape;
    surface->primitive = primitive;
    surface->p =
        (vec3){interpolate(p0.x, p1.x, p2.x, b), interpolate(p0.y, p1.y, p2.y, b), interpolate(p0.z, p1.z, p2.z, b)};
    vec3 e1 = vec3_sub(p1, p0), e2 = vec3_sub(p2, p0), n = vec3_cross(e1, e2);
    float length = vec3_length(n);
    surface->ng = length > 0 ? vec3_scale(n, 1 / length) : vec3_make(0, 0, 1);
    surface->uv = b;
    surface->dp_du = surface->dp_dv = vec3_make(0, 0, 0);
    if (mesh->uvs) {
        vec2 uv0 = mesh->uvs[v[0]], uv1 = mesh->uvs[v[1]], uv2 = mesh->uvs[v[2]];
        surface->uv = (vec2){interpolate(uv0.x, uv1.x, uv2.x, b), interpolate(uv0.y, uv1.y, uv2.y, b)};
        fill_uv_derivatives(e1, e2, uv0, uv1, uv2, surface);
    }
    vec3 shading = surface->ng;
    if (mesh->normals) {
        vec3 n0 = mesh->normals[v[0]], n1 = mesh->normals[v[1]], n2 = mesh->normals[v[2]];
        vec3 mean = {interpolate(n0.x, n1.x, n2.x, b), interpolate(n0.y, n1.y, n2.y, b),
                     interpolate(n0.z, n1.z, n2.z, b)};
        float size = vec3_length(mean);
        if (size > 1e-3f) {
            shading = vec3_scale(mean, 1 / size);
            if (vec3_dot(shading, surface->ng) < 0) surface->ng = vec3_neg(surface->ng);
        }
    }
    surface->shading = shape_frame(shading, surface->dp_du);
}

void shape_sample(const struct shape *shape, vec2 u, struct surface *surface) {
    *surface = (struct surface){.shape = shape};
    if (shape->mesh.triangle_count == 0) {
        shape->type->sample(shape, u, surface);
        return;
    }
    size_t triangle = distribution_sample(shape->triangles, u.x, &u.x);
    shape_fill_triangle(shape, (uint32_t)triangle, warp_triangle(u), surface);
}
