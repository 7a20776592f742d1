#include "luminaire/proxy.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { MAX_TRIANGLES = 1 << 22 };

static bool all_finite(const float *v, size_t n) {
    for (size_t i = 0; i < n; i++)
        if (!isfinite(v[i]) || fabsf(v[i]) > 1e15f) return false;
    return true;
}

static bool inside_bound(const struct proxy *proxy, const float p[3]) {
    float d2 = 0;
    for (int a = 0; a < 3; a++) d2 += (p[a] - proxy->center[a]) * (p[a] - proxy->center[a]);
    return d2 <= proxy->radius * proxy->radius * 1.001f;
}

static enum status proxy_check(const struct proxy *proxy, struct error *error) {
    if (!all_finite(proxy->center, 3) || !(proxy->radius > 1e-15f) || !(proxy->radius < 1e15f))
        return error_set(error, STATUS_INVALID, "the proxy's bounding sphere is not a sphere of positive radius");
    switch (proxy->kind) {
    case PROXY_SPHERE:
        return STATUS_OK;
    case PROXY_BOX:
        if (!all_finite(proxy->lower, 3) || !all_finite(proxy->upper, 3) || !inside_bound(proxy, proxy->lower) ||
            !inside_bound(proxy, proxy->upper))
            return error_set(error, STATUS_INVALID, "the proxy's box is not inside its bounding sphere");
        for (int a = 0; a < 3; a++)
            if (!(proxy->lower[a] < proxy->upper[a]))
                return error_set(error, STATUS_INVALID, "the proxy's box is empty");
        return STATUS_OK;
    case PROXY_CYLINDER: {
        float length2 = 0;
        for (int a = 0; a < 3; a++) length2 += proxy->axis[a] * proxy->axis[a];
        if (!(fabsf(length2 - 1) < 1e-3f) || !(proxy->half_height > 0) || !(proxy->axis_radius > 0) ||
            !(hypotf(proxy->half_height, proxy->axis_radius) <= proxy->radius * 1.001f))
            return error_set(error, STATUS_INVALID,
                             "the proxy's cylinder needs a unit axis and must be inside its bounding sphere");
        return STATUS_OK;
    }
    case PROXY_MESH:
        if (proxy->vertex_count < 4 || proxy->triangle_count < 4 || proxy->triangle_count > MAX_TRIANGLES ||
            proxy->vertex_count > 3 * (size_t)MAX_TRIANGLES)
            return error_set(error, STATUS_INVALID, "the proxy's mesh needs 4 to %d triangles", MAX_TRIANGLES);
        for (size_t i = 0; i < proxy->vertex_count; i++)
            if (!all_finite(proxy->vertices[i], 3) || !inside_bound(proxy, proxy->vertices[i]))
                return error_set(error, STATUS_INVALID, "vertex %zu of the proxy's mesh is outside its bounding sphere",
                                 i);
        for (size_t i = 0; i < 3 * proxy->triangle_count; i++)
            if (proxy->indices[i] >= proxy->vertex_count)
                return error_set(error, STATUS_INVALID, "index %zu of the proxy's mesh is out of range", i);
        return STATUS_OK;
    }
    return error_set(error, STATUS_INVALID, "unknown kind of proxy %d", (int)proxy->kind);
}

enum status proxy_shape_init(struct proxy_shape *shape, const struct proxy *proxy, struct error *error) {
    *shape = (struct proxy_shape){.proxy = *proxy};
    shape->proxy.vertices = NULL;
    shape->proxy.indices = NULL;
    enum status status = proxy_check(proxy, error);
    if (status || proxy->kind != PROXY_MESH) return status;
    size_t vertices = proxy->vertex_count, triangles = proxy->triangle_count;
    shape->proxy.vertices = malloc(vertices * sizeof *shape->proxy.vertices);
    shape->proxy.indices = malloc(3 * triangles * sizeof(uint32_t));
    if (shape->proxy.vertices && shape->proxy.indices) {
        memcpy(shape->proxy.vertices, proxy->vertices, vertices * sizeof *shape->proxy.vertices);
        memcpy(shape->proxy.indices, proxy->indices, 3 * triangles * sizeof(uint32_t));
        status = mesh_tree_create(&shape->tree, (const float(*)[3])shape->proxy.vertices,
                                  (const uint32_t(*)[3])shape->proxy.indices, triangles, error);
    } else
        status = error_set(error, STATUS_MEMORY, "out of memory for the proxy's mesh");
    if (status) proxy_shape_fini(shape);
    return status;
}

void proxy_shape_fini(struct proxy_shape *shape) {
    free(shape->proxy.vertices);
    free(shape->proxy.indices);
    mesh_tree_destroy(shape->tree);
    *shape = (struct proxy_shape){.proxy = {.kind = PROXY_SPHERE}};
}

// --- Spans ---

static float dot(const float a[3], const float b[3]) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

static bool span_sphere(const float relative[3], const float direction[3], float radius, float *t_near, float *t_far) {
    float along = dot(relative, direction), p[3];
    for (int a = 0; a < 3; a++) p[a] = relative[a] - along * direction[a];
    float half2 = radius * radius - dot(p, p);
    if (!(half2 >= 0)) return false;
    float half = sqrtf(half2);
    *t_near = -along - half;
    *t_far = -along + half;
    return true;
}

static bool clip_slab(float origin, float direction, float lower, float upper, float *t_near, float *t_far) {
    if (direction == 0) return origin >= lower && origin <= upper;
    float a = (lower - origin) / direction, b = (upper - origin) / direction;
    *t_near = fmaxf(*t_near, fminf(a, b));
    *t_far = fminf(*t_far, fmaxf(a, b));
    return *t_near <= *t_far;
}

static bool span_box(const float lower[3], const float upper[3], const float origin[3], const float direction[3],
                     float *t_near, float *t_far) {
    *t_near = -INFINITY, *t_far = INFINITY;
    for (int a = 0; a < 3; a++)
        if (!clip_slab(origin[a], direction[a], lower[a], upper[a], t_near, t_far)) return false;
    return true;
}

static bool span_cylinder(const struct proxy *proxy, const float relative[3], const float direction[3], float *t_near,
                          float *t_far) {
    float height = dot(relative, proxy->axis), rise = dot(direction, proxy->axis), p[3], d[3];
    for (int a = 0; a < 3; a++) {
        p[a] = relative[a] - height * proxy->axis[a];
        d[a] = direction[a] - rise * proxy->axis[a];
    }
    float d2 = dot(d, d), radius2 = proxy->axis_radius * proxy->axis_radius;
    *t_near = -INFINITY, *t_far = INFINITY;
    if (d2 > 1e-14f) {
        float middle = -dot(p, d) / d2, q[3];
        for (int a = 0; a < 3; a++) q[a] = p[a] + middle * d[a];
        float half2 = (radius2 - dot(q, q)) / d2;
        if (!(half2 >= 0)) return false;
        *t_near = middle - sqrtf(half2);
        *t_far = middle + sqrtf(half2);
    } else if (!(dot(p, p) <= radius2))
        return false;
    return clip_slab(height, rise, -proxy->half_height, proxy->half_height, t_near, t_far);
}

bool proxy_shape_span(const struct proxy_shape *shape, const float origin[3], const float direction[3], float *t_near,
                      float *t_far) {
    const struct proxy *proxy = &shape->proxy;
    float relative[3];
    for (int a = 0; a < 3; a++) relative[a] = origin[a] - proxy->center[a];
    if (proxy->kind == PROXY_BOX) return span_box(proxy->lower, proxy->upper, origin, direction, t_near, t_far);
    if (proxy->kind == PROXY_CYLINDER) return span_cylinder(proxy, relative, direction, t_near, t_far);
    if (!span_sphere(relative, direction, proxy->radius, t_near, t_far)) return false;
    if (proxy->kind == PROXY_SPHERE) return true;
    // The mesh from the line's entry into its bounding sphere, so that a far origin costs no precision.
    const vec3 along = {direction[0], direction[1], direction[2]};
    const vec3 entry = vec3_mad(along, *t_near, (vec3){origin[0], origin[1], origin[2]});
    const float shift = *t_near;
    if (!mesh_tree_span(shape->tree, entry, along, *t_far - shift, t_near, t_far)) return false;
    *t_near += shift;
    *t_far += shift;
    return true;
}
