#include "luminaire/hull_tree.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "luminaire/mesh_tree.h"

enum { MAX_BOUNCES = 64 };
static const float nudge = 1e-6f; // [extent of the hull]: a ray that left a surface does not meet it again

struct facet {
    vec3 normal; // unit
    uint32_t part;
    uint16_t corners[3];
};

struct corner {
    vec3 p, n; // n: of smooth parts
};

struct hull_tree {
    struct mesh_tree *mesh;
    struct facet *facets;
    struct corner *corners;
    struct hull_part parts[HULL_MAX_PARTS];
    float step; // [length]
};

static enum status fill(struct hull_tree *tree, const struct hull *hull, struct error *error) {
    float(*vertices)[3] = malloc((hull->vertex_count + 1) * sizeof *vertices);
    uint32_t(*triangles)[3] = malloc((hull->triangle_count + 1) * sizeof *triangles);
    tree->facets = malloc((hull->triangle_count + 1) * sizeof *tree->facets);
    tree->corners = malloc((hull->vertex_count + 1) * sizeof *tree->corners);
    enum status status;
    if (!vertices || !triangles || !tree->facets || !tree->corners)
        status = error_set(error, STATUS_MEMORY, "out of memory for the tree of a hull");
    else {
        memcpy(tree->parts, hull->parts, sizeof tree->parts);
        for (int a = 0; a < 3; a++) tree->step = fmaxf(tree->step, (float)HULL_MAX_CODE * hull->step[a] * nudge);
        for (size_t i = 0; i < hull->vertex_count; i++) {
            tree->corners[i] = (struct corner){hull_vertex(hull, i), hull_normal(hull, i)};
            vec3_store(vertices[i], tree->corners[i].p);
        }
        for (size_t k = 0; k < hull->part_count; k++)
            for (size_t i = hull->parts[k].first; i < hull->parts[k].first + hull->parts[k].count; i++) {
                tree->facets[i] = (struct facet){.normal = hull_face_normal(hull, i), .part = (uint32_t)k};
                for (int c = 0; c < 3; c++) triangles[i][c] = tree->facets[i].corners[c] = hull->triangles[i][c];
            }
        status = mesh_tree_create(&tree->mesh, (const float(*)[3])vertices, (const uint32_t(*)[3])triangles,
                                  hull->triangle_count, error);
    }
    free(vertices);
    free(triangles);
    return status;
}

enum status hull_tree_create(struct hull_tree **result, const struct hull *hull, struct error *error) {
    struct hull_tree *tree = *result = calloc(1, sizeof *tree);
    if (!tree) return error_set(error, STATUS_MEMORY, "out of memory for the tree of a hull");
    enum status status = fill(tree, hull, error);
    if (status) {
        hull_tree_destroy(tree);
        *result = NULL;
    }
    return status;
}

void hull_tree_destroy(struct hull_tree *tree) {
    if (!tree) return;
    mesh_tree_destroy(tree->mesh);
    free(tree->facets);
    free(tree->corners);
    free(tree);
}

// --- Crossing ---

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

// Unit, on the side that the light comes from. On smooth parts interpolated, as the lamp's own surface has it, but
// where that would be seen from behind.
static vec3 normal_at(const struct hull_tree *tree, const struct facet *facet, vec3 p, vec3 direction, bool inside) {
    const vec3 outside = inside ? vec3_neg(facet->normal) : facet->normal;
    if (!tree->parts[facet->part].smooth) return outside;
    const struct corner *a = &tree->corners[facet->corners[0]], *b = &tree->corners[facet->corners[1]],
                        *c = &tree->corners[facet->corners[2]];
    const vec3 ab = vec3_sub(b->p, a->p), ac = vec3_sub(c->p, a->p), ap = vec3_sub(p, a->p);
    const vec3 area = vec3_cross(ab, ac);
    const float inverse = 1 / vec3_dot(area, area), u = vec3_dot(vec3_cross(ap, ac), area) * inverse,
                v = vec3_dot(vec3_cross(ab, ap), area) * inverse;
    vec3 n = vec3_mad(a->n, 1 - u - v, vec3_mad(b->n, u, vec3_scale(c->n, v)));
    n = vec3_scale(n, (inside ? -1 : 1) / sqrtf(vec3_dot(n, n)));
    return vec3_dot(n, direction) < 0 ? n : outside; // NaN: outside
}

struct layers {
    const struct hull_tree *tree;
    struct hull_crossing *crossing;
};

static void count_layer(void *user, uint32_t triangle) {
    const struct layers *layers = user;
    const enum hull_kind kind = layers->tree->parts[layers->tree->facets[triangle].part].kind;
    layers->crossing->layers += kind == HULL_TRANSLUCENT;
    layers->crossing->blocked = layers->crossing->blocked || kind == HULL_OPAQUE;
}

static void block(struct hull_crossing *crossing) {
    crossing->answer = HULL_SOLVED;
    vec3_store(crossing->transmittance, (vec3){0, 0, 0});
}

void hull_tree_cross(const struct hull_tree *tree, vec3 origin, vec3 direction, float cos_limit,
                     struct hull_crossing *crossing) {
    *crossing = (struct hull_crossing){.answer = HULL_MISSED, .transmittance = {1, 1, 1}};
    vec3 start = direction;
    for (int i = 0; i < MAX_BOUNCES; i++) {
        float t;
        const uint32_t triangle = mesh_tree_nearest(tree->mesh, origin, direction, i > 0 ? tree->step : 0, &t);
        if (triangle == MESH_MISSED) {
            if (crossing->answer == HULL_SOLVED && vec3_dot(start, direction) < cos_limit) block(crossing);
            return;
        }
        const struct hull_part *part = &tree->parts[tree->facets[triangle].part];
        const bool inside = vec3_dot(tree->facets[triangle].normal, direction) > 0;
        origin = vec3_mad(direction, t, origin);
        if (part->kind == HULL_OPAQUE) {
            block(crossing);
            return;
        }
        const vec3 normal = normal_at(tree, &tree->facets[triangle], origin, direction, inside);
        if (part->kind == HULL_TRANSLUCENT) {
            crossing->answer = HULL_DIFFUSED;
            vec3_store(crossing->point, origin);
            vec3_store(crossing->normal, normal);
            crossing->layers = 1;
            mesh_tree_visit(tree->mesh, origin, direction, tree->step, count_layer, &(struct layers){tree, crossing});
            return;
        }
        crossing->answer = HULL_SOLVED;
        for (int c = 0; c < 3 && inside; c++) crossing->transmittance[c] *= expf(-part->sigma_a[c] * t);
        vec3 refracted = direction;
        float through = refract(direction, normal, inside ? 1 / part->eta : part->eta, &refracted);
        for (int c = 0; c < 3; c++) crossing->transmittance[c] *= through;
        direction = refracted;
        if (!(through > 0)) return;
    }
    block(crossing);
}
