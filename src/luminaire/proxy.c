#include "luminaire/proxy.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { LEAF_TRIANGLES = 4, MAX_TRIANGLES = 1 << 22, STACK = 64 };

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

// --- Hierarchy of a mesh: median splits along the longest axis of the centroids ---

struct builder {
    const struct proxy *proxy;
    struct proxy_node *nodes;
    uint32_t *order, node_count;
    int axis;
};

static float centroid(const struct proxy *proxy, uint32_t triangle, int axis) {
    const uint32_t *index = proxy->indices + 3 * (size_t)triangle;
    return proxy->vertices[index[0]][axis] + proxy->vertices[index[1]][axis] + proxy->vertices[index[2]][axis];
}

static int compare_centroids(const void *a, const void *b, void *user) {
    const struct builder *builder = user;
    uint32_t ta = *(const uint32_t *)a, tb = *(const uint32_t *)b;
    float ca = centroid(builder->proxy, ta, builder->axis), cb = centroid(builder->proxy, tb, builder->axis);
    return ca < cb ? -1 : ca > cb ? 1 : ta < tb ? -1 : ta > tb;
}

static void build_node(struct builder *builder, uint32_t node, uint32_t first, uint32_t count) {
    struct proxy_node *at = &builder->nodes[node];
    float low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY};
    for (int a = 0; a < 3; a++) at->lower[a] = INFINITY, at->upper[a] = -INFINITY;
    for (uint32_t i = first; i < first + count; i++)
        for (int a = 0; a < 3; a++) {
            float c = centroid(builder->proxy, builder->order[i], a);
            low[a] = fminf(low[a], c), high[a] = fmaxf(high[a], c);
            for (int k = 0; k < 3; k++) {
                float v =
                    builder->proxy->vertices[builder->proxy->indices[3 * (size_t)builder->order[i] + (size_t)k]][a];
                at->lower[a] = fminf(at->lower[a], v), at->upper[a] = fmaxf(at->upper[a], v);
            }
        }
    at->first = first, at->count = count;
    if (count <= LEAF_TRIANGLES) return;
    builder->axis = 0;
    for (int a = 1; a < 3; a++)
        if (high[a] - low[a] > high[builder->axis] - low[builder->axis]) builder->axis = a;
    qsort_r(builder->order + first, count, sizeof(uint32_t), compare_centroids, builder);
    at->first = builder->node_count, at->count = 0;
    builder->node_count += 2;
    uint32_t left = at->first;
    build_node(builder, left, first, count / 2);
    build_node(builder, left + 1, first + count / 2, count - count / 2);
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
    shape->nodes = calloc(2 * triangles, sizeof *shape->nodes);
    shape->order = malloc(triangles * sizeof(uint32_t));
    if (!shape->proxy.vertices || !shape->proxy.indices || !shape->nodes || !shape->order) {
        proxy_shape_fini(shape);
        return error_set(error, STATUS_MEMORY, "out of memory for the proxy's mesh");
    }
    memcpy(shape->proxy.vertices, proxy->vertices, vertices * sizeof *shape->proxy.vertices);
    memcpy(shape->proxy.indices, proxy->indices, 3 * triangles * sizeof(uint32_t));
    for (uint32_t i = 0; i < triangles; i++) shape->order[i] = i;
    struct builder builder = {&shape->proxy, shape->nodes, shape->order, 1, 0};
    build_node(&builder, 0, 0, (uint32_t)triangles);
    return STATUS_OK;
}

void proxy_shape_fini(struct proxy_shape *shape) {
    free(shape->proxy.vertices);
    free(shape->proxy.indices);
    free(shape->nodes);
    free(shape->order);
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

// Moeller and Trumbore 1997; edges belong to both of their triangles.
static bool hit_triangle(const struct proxy *proxy, uint32_t triangle, const float o[3], const float w[3], float *t) {
    const uint32_t *index = proxy->indices + 3 * (size_t)triangle;
    const float *v0 = proxy->vertices[index[0]], *v1 = proxy->vertices[index[1]], *v2 = proxy->vertices[index[2]];
    float e1[3], e2[3], from[3];
    for (int a = 0; a < 3; a++) e1[a] = v1[a] - v0[a], e2[a] = v2[a] - v0[a], from[a] = o[a] - v0[a];
    float p[3] = {w[1] * e2[2] - w[2] * e2[1], w[2] * e2[0] - w[0] * e2[2], w[0] * e2[1] - w[1] * e2[0]};
    float determinant = dot(e1, p);
    if (determinant == 0) return false;
    float q[3] = {from[1] * e1[2] - from[2] * e1[1], from[2] * e1[0] - from[0] * e1[2],
                  from[0] * e1[1] - from[1] * e1[0]};
    float u = dot(from, p) / determinant, v = dot(w, q) / determinant;
    if (!(u >= -1e-6f && v >= -1e-6f && u + v <= 1 + 2e-6f)) return false;
    *t = dot(e2, q) / determinant;
    return isfinite(*t);
}

static bool span_mesh(const struct proxy_shape *shape, const float origin[3], const float direction[3], float *t_near,
                      float *t_far) {
    uint32_t stack[STACK];
    int top = 0;
    float first = INFINITY, last = -INFINITY, t, a, b;
    stack[top++] = 0;
    while (top > 0) {
        const struct proxy_node *node = &shape->nodes[stack[--top]];
        if (!span_box(node->lower, node->upper, origin, direction, &a, &b)) continue;
        if (a >= first && b <= last) continue; // cannot widen the span
        if (node->count == 0) {
            stack[top++] = node->first;
            stack[top++] = node->first + 1;
            continue;
        }
        for (uint32_t i = node->first; i < node->first + node->count; i++)
            if (hit_triangle(&shape->proxy, shape->order[i], origin, direction, &t))
                first = fminf(first, t), last = fmaxf(last, t);
    }
    *t_near = first, *t_far = last;
    return first <= last;
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
    float entry[3], shift = *t_near;
    for (int a = 0; a < 3; a++) entry[a] = origin[a] + shift * direction[a];
    if (!span_mesh(shape, entry, direction, t_near, t_far)) return false;
    *t_near += shift;
    *t_far += shift;
    return true;
}
