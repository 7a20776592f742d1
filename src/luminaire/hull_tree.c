// The hierarchy is split where the surface area heuristic (Goldsmith and Salmon 1987) says, of all places along the
// longest axis of the centroids; a leaf holds up to 4 triangles. Ray against triangle: Moeller and Trumbore 1997.
#include "luminaire/hull_tree.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { LEAF = 4, STACK = 64, MAX_BOUNCES = 64 };
static const float nudge = 1e-6f; // [extent of the hull]: a ray that left a surface does not meet it again

struct node {
    float lower[3], upper[3];
    uint32_t first, count; // count 0: children at first and first + 1
};

struct triangle {
    vec3 p, e1, e2;
    uint32_t part;
};

struct hull_tree {
    struct node *nodes;
    struct triangle *triangles;
    size_t node_count, triangle_count;
    struct hull_part parts[HULL_MAX_PARTS];
    float step; // [length]
};

// --- Building ---

struct item {
    float center[3];
    uint32_t index;
};

static float extent_of(const struct item *items, size_t n, int axis) {
    float lower = INFINITY, upper = -INFINITY;
    for (size_t i = 0; i < n; i++) {
        lower = fminf(lower, items[i].center[axis]);
        upper = fmaxf(upper, items[i].center[axis]);
    }
    return upper - lower;
}

#define COMPARE_AXIS(name, axis)                                                                                       \
    static int name(const void *a, const void *b) {                                                                    \
        const struct item *p = a, *q = b;                                                                              \
        if (p->center[axis] != q->center[axis]) return p->center[axis] < q->center[axis] ? -1 : 1;                     \
        return (p->index > q->index) - (p->index < q->index);                                                          \
    }
COMPARE_AXIS(compare_x, 0)
COMPARE_AXIS(compare_y, 1)
COMPARE_AXIS(compare_z, 2)

static void grow(struct node *node, vec3 p) {
    const float v[3] = {p.x, p.y, p.z};
    for (int a = 0; a < 3; a++) {
        node->lower[a] = fminf(node->lower[a], v[a]);
        node->upper[a] = fmaxf(node->upper[a], v[a]);
    }
}

static const struct node nothing = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}, 0, 0};

static void grow_triangle(struct node *node, const struct triangle *t) {
    grow(node, t->p);
    grow(node, vec3_add(t->p, t->e1));
    grow(node, vec3_add(t->p, t->e2));
}

static float half_area(const struct node *node) {
    float x = node->upper[0] - node->lower[0], y = node->upper[1] - node->lower[1], z = node->upper[2] - node->lower[2];
    return x * y + y * z + z * x;
}

struct builder {
    struct hull_tree *tree;
    struct item *items;
    const struct triangle *loose;
    float *areas; // scratch: of the box of the items from one on
};

// How many of the sorted items go to the first child.
static size_t best_split(const struct builder *b, size_t first, size_t count) {
    struct node box = nothing;
    for (size_t i = count; i-- > 1;) {
        grow_triangle(&box, &b->loose[b->items[first + i].index]);
        b->areas[i] = half_area(&box);
    }
    size_t best = count / 2;
    float least_cost = INFINITY;
    box = nothing;
    for (size_t i = 1; i < count; i++) {
        grow_triangle(&box, &b->loose[b->items[first + i - 1].index]);
        float cost = half_area(&box) * (float)i + b->areas[i] * (float)(count - i);
        if (cost < least_cost) {
            least_cost = cost;
            best = i;
        }
    }
    return best;
}

static void build_node(const struct builder *b, size_t at, size_t first, size_t count, int depth) {
    struct node *node = &b->tree->nodes[at];
    struct item *items = b->items + first;
    *node = nothing;
    node->first = (uint32_t)first;
    for (size_t i = 0; i < count; i++) grow_triangle(node, &b->loose[items[i].index]);
    if (count <= LEAF) {
        node->count = (uint32_t)count;
        return;
    }
    float x = extent_of(items, count, 0), y = extent_of(items, count, 1), z = extent_of(items, count, 2);
    qsort(items, count, sizeof *items, x >= y && x >= z ? compare_x : y >= z ? compare_y : compare_z);
    size_t split = depth < STACK / 2 ? best_split(b, first, count) : count / 2, children = b->tree->node_count;
    b->tree->node_count += 2;
    node->first = (uint32_t)children;
    build_node(b, children, first, split, depth + 1);
    build_node(b, children + 1, first + split, count - split, depth + 1);
}

enum status hull_tree_create(struct hull_tree **result, const struct hull *hull, struct error *error) {
    struct hull_tree *tree = *result = calloc(1, sizeof *tree);
    size_t n = hull->triangle_count;
    struct item *items = calloc(n + 1, sizeof *items);
    struct triangle *loose = calloc(n + 1, sizeof *loose);
    float *areas = calloc(n + 1, sizeof *areas);
    if (tree) {
        tree->nodes = calloc(2 * n + 1, sizeof *tree->nodes);
        tree->triangles = calloc(n + 1, sizeof *tree->triangles);
    }
    enum status status = STATUS_OK;
    if (!tree || !items || !loose || !areas || !tree->nodes || !tree->triangles) {
        hull_tree_destroy(tree);
        *result = NULL;
        status = error_set(error, STATUS_MEMORY, "out of memory for the tree of a hull");
    } else {
        memcpy(tree->parts, hull->parts, sizeof tree->parts);
        for (int a = 0; a < 3; a++) tree->step = fmaxf(tree->step, 65535 * hull->step[a] * nudge);
        for (size_t k = 0; k < hull->part_count; k++)
            for (size_t i = hull->parts[k].first; i < hull->parts[k].first + hull->parts[k].count; i++) {
                vec3 a = hull_vertex(hull, hull->triangles[i][0]), b = hull_vertex(hull, hull->triangles[i][1]);
                vec3 c = hull_vertex(hull, hull->triangles[i][2]);
                vec3 middle = vec3_scale(vec3_add(a, vec3_add(b, c)), 1.0f / 3);
                loose[i] = (struct triangle){a, vec3_sub(b, a), vec3_sub(c, a), (uint32_t)k};
                items[i] = (struct item){{middle.x, middle.y, middle.z}, (uint32_t)i};
            }
        tree->node_count = 1;
        build_node(&(struct builder){tree, items, loose, areas}, 0, 0, n, 0);
        for (size_t i = 0; i < n; i++) tree->triangles[i] = loose[items[i].index];
        tree->triangle_count = n;
    }
    free(items);
    free(loose);
    free(areas);
    return status;
}

void hull_tree_destroy(struct hull_tree *tree) {
    if (!tree) return;
    free(tree->nodes);
    free(tree->triangles);
    free(tree);
}

// --- Crossing ---

struct hit {
    float t;
    const struct triangle *triangle;
};

static inline float least(float a, float b) { return a < b ? a : b; } // one instruction each, as fminf is not
static inline float most(float a, float b) { return a > b ? a : b; }

static bool enters(const struct node *node, vec3 origin, vec3 inverse, float t_max, float *t) {
    float x0 = (node->lower[0] - origin.x) * inverse.x, x1 = (node->upper[0] - origin.x) * inverse.x;
    float y0 = (node->lower[1] - origin.y) * inverse.y, y1 = (node->upper[1] - origin.y) * inverse.y;
    float z0 = (node->lower[2] - origin.z) * inverse.z, z1 = (node->upper[2] - origin.z) * inverse.z;
    float near = most(most(least(x0, x1), least(y0, y1)), most(least(z0, z1), 0));
    float far = least(least(most(x0, x1), most(y0, y1)), least(most(z0, z1), t_max));
    *t = near;
    return near <= far * (1 + 4e-7f);
}

static void meet(const struct triangle *triangle, vec3 origin, vec3 direction, float t_min, struct hit *hit) {
    vec3 p = vec3_cross(direction, triangle->e2), s = vec3_sub(origin, triangle->p);
    float determinant = vec3_dot(triangle->e1, p);
    if (determinant == 0) return;
    float inverse = 1 / determinant, u = vec3_dot(s, p) * inverse;
    vec3 q = vec3_cross(s, triangle->e1);
    float v = vec3_dot(direction, q) * inverse, t = vec3_dot(triangle->e2, q) * inverse;
    if (u >= 0 && v >= 0 && u + v <= 1 && t > t_min && t < hit->t) *hit = (struct hit){t, triangle};
}

static bool intersect(const struct hull_tree *tree, vec3 origin, vec3 direction, float t_min, struct hit *hit) {
    const vec3 inverse = {1 / direction.x, 1 / direction.y, 1 / direction.z};
    uint32_t stack[STACK];
    int depth = 0;
    float t;
    *hit = (struct hit){INFINITY, NULL};
    if (!enters(&tree->nodes[0], origin, inverse, INFINITY, &t)) return false;
    stack[depth++] = 0;
    while (depth > 0) {
        const struct node *node = &tree->nodes[stack[--depth]];
        if (node->count > 0) {
            for (uint32_t i = node->first; i < node->first + node->count; i++)
                meet(&tree->triangles[i], origin, direction, t_min, hit);
            continue;
        }
        float t0, t1;
        bool in0 = enters(&tree->nodes[node->first], origin, inverse, hit->t, &t0);
        bool in1 = enters(&tree->nodes[node->first + 1], origin, inverse, hit->t, &t1);
        uint32_t near = t0 <= t1 ? 0u : 1u; // the nearer child is looked at first
        if (near ? in0 : in1) stack[depth++] = node->first + (1 - near);
        if (near ? in1 : in0) stack[depth++] = node->first + near;
    }
    return hit->triangle != NULL;
}

// What Fresnel's equations let through, and the refracted direction. 0: total reflection. `eta`: behind over before.
static float refract(vec3 direction, vec3 normal, float eta, vec3 *refracted) {
    float cos_in = -vec3_dot(direction, normal), cos2 = 1 - (1 - cos_in * cos_in) / (eta * eta);
    if (!(cos2 > 0)) return 0;
    float cos_out = sqrtf(cos2);
    float s = (cos_in - eta * cos_out) / (cos_in + eta * cos_out);
    float p = (eta * cos_in - cos_out) / (eta * cos_in + cos_out);
    *refracted = vec3_normalize(vec3_mad(normal, cos_in / eta - cos_out, vec3_scale(direction, 1 / eta)));
    return 1 - 0.5f * (s * s + p * p);
}

// The straight rest of the line behind the first translucent point, in one walk.
static void count_layers(const struct hull_tree *tree, vec3 origin, vec3 direction, struct hull_crossing *crossing) {
    const vec3 inverse = {1 / direction.x, 1 / direction.y, 1 / direction.z};
    uint32_t stack[STACK] = {0};
    int depth = 1;
    float t;
    crossing->layers = 1;
    while (depth > 0) {
        const struct node *node = &tree->nodes[stack[--depth]];
        for (uint32_t i = node->first; i < node->first + node->count; i++) {
            struct hit hit = {INFINITY, NULL};
            meet(&tree->triangles[i], origin, direction, tree->step, &hit);
            if (!hit.triangle) continue;
            enum hull_kind kind = tree->parts[hit.triangle->part].kind;
            crossing->layers += kind == HULL_TRANSLUCENT;
            crossing->blocked = crossing->blocked || kind == HULL_OPAQUE;
        }
        for (uint32_t child = node->first; node->count == 0 && child < node->first + 2; child++)
            if (enters(&tree->nodes[child], origin, inverse, INFINITY, &t)) stack[depth++] = child;
    }
}

static void store(float to[3], vec3 v) {
    to[0] = v.x;
    to[1] = v.y;
    to[2] = v.z;
}

static void block(struct hull_crossing *crossing) {
    crossing->answer = HULL_SOLVED;
    store(crossing->transmittance, (vec3){0, 0, 0});
}

void hull_tree_cross(const struct hull_tree *tree, vec3 origin, vec3 direction, float cos_limit,
                     struct hull_crossing *crossing) {
    *crossing = (struct hull_crossing){.answer = HULL_MISSED, .transmittance = {1, 1, 1}};
    vec3 start = direction;
    struct hit hit;
    for (int i = 0; i < MAX_BOUNCES; i++) {
        if (!intersect(tree, origin, direction, i > 0 ? tree->step : 0, &hit)) {
            if (crossing->answer == HULL_SOLVED && vec3_dot(start, direction) < cos_limit) block(crossing);
            return;
        }
        const struct hull_part *part = &tree->parts[hit.triangle->part];
        vec3 normal = vec3_normalize(vec3_cross(hit.triangle->e1, hit.triangle->e2));
        bool inside = vec3_dot(normal, direction) > 0;
        if (inside) normal = vec3_neg(normal);
        origin = vec3_mad(direction, hit.t, origin);
        if (part->kind == HULL_OPAQUE) {
            block(crossing);
            return;
        }
        if (part->kind == HULL_TRANSLUCENT) {
            crossing->answer = HULL_DIFFUSED;
            store(crossing->point, origin);
            store(crossing->normal, normal);
            count_layers(tree, origin, direction, crossing);
            return;
        }
        crossing->answer = HULL_SOLVED;
        for (int c = 0; c < 3 && inside; c++) crossing->transmittance[c] *= expf(-part->sigma_a[c] * hit.t);
        vec3 refracted = direction;
        float through = refract(direction, normal, inside ? 1 / part->eta : part->eta, &refracted);
        for (int c = 0; c < 3; c++) crossing->transmittance[c] *= through;
        direction = refracted;
        if (!(through > 0)) return;
    }
    block(crossing);
}
