// First step of a bake: checks that need no tracing.
#include "bake/lamp_check.h"

#include <stdlib.h>
#include <string.h>

struct numbered_point {
    vec3 p;
    uint32_t index;
};

struct edge {
    uint32_t low, high;
};

static int compare_points(const void *a, const void *b) {
    const struct numbered_point *p = a, *q = b;
    if (p->p.x != q->p.x) return p->p.x < q->p.x ? -1 : 1;
    if (p->p.y != q->p.y) return p->p.y < q->p.y ? -1 : 1;
    if (p->p.z != q->p.z) return p->p.z < q->p.z ? -1 : 1;
    return 0;
}

static int compare_edges(const void *a, const void *b) {
    const struct edge *p = a, *q = b;
    if (p->low != q->low) return p->low < q->low ? -1 : 1;
    return (p->high > q->high) - (p->high < q->high);
}

// joined[i]: one index for all vertices at the position of vertex i.
static bool join_vertices(const struct mesh *mesh, uint32_t *joined) {
    struct numbered_point *points = malloc(mesh->vertex_count * sizeof *points);
    if (!points) return false;
    for (size_t i = 0; i < mesh->vertex_count; i++)
        points[i] = (struct numbered_point){mesh->positions[i], (uint32_t)i};
    qsort(points, mesh->vertex_count, sizeof *points, compare_points);
    uint32_t current = 0;
    for (size_t i = 0; i < mesh->vertex_count; i++) {
        if (i == 0 || compare_points(&points[i - 1], &points[i]) != 0) current = points[i].index;
        joined[points[i].index] = current;
    }
    free(points);
    return true;
}

size_t mesh_open_edges(const struct mesh *mesh) {
    uint32_t *joined = malloc((mesh->vertex_count + 1) * sizeof *joined);
    struct edge *edges = malloc((3 * mesh->triangle_count + 1) * sizeof *edges);
    size_t open = SIZE_MAX;
    if (joined && edges && join_vertices(mesh, joined)) {
        size_t count = 0;
        for (size_t t = 0; t < mesh->triangle_count; t++) {
            uint32_t v[3];
            for (int i = 0; i < 3; i++) v[i] = joined[mesh->indices[3 * t + (size_t)i]];
            if (v[0] == v[1] || v[1] == v[2] || v[2] == v[0]) continue; // degenerate
            for (int i = 0; i < 3; i++) {
                uint32_t a = v[i], b = v[(i + 1) % 3];
                edges[count++] = a < b ? (struct edge){a, b} : (struct edge){b, a};
            }
        }
        qsort(edges, count, sizeof *edges, compare_edges);
        open = 0;
        for (size_t i = 0; i < count;) {
            size_t next = i + 1;
            while (next < count && compare_edges(&edges[i], &edges[next]) == 0) next++;
            open += (next - i) & 1;
            i = next;
        }
    }
    free(joined);
    free(edges);
    return open;
}

static const char *shape_name(const struct shape *shape) { return shape->id[0] ? shape->id : shape->type->name; }

static enum status check_glass(const struct scene *scene, const struct run *run, struct error *error) {
    for (size_t i = 0; i < scene->shape_count; i++) {
        const struct shape *shape = scene->shapes[i];
        if (!shape->bsdf || shape->mesh.triangle_count == 0) continue;
        const char *bsdf = shape->bsdf->type->name;
        if (strcmp(bsdf, "dielectric") != 0 && strcmp(bsdf, "roughdielectric") != 0) continue;
        size_t open = mesh_open_edges(&shape->mesh);
        if (open == SIZE_MAX) return error_set(error, STATUS_MEMORY, "out of memory while checking meshes");
        if (open > 0)
            run_warn(run,
                     "%s:%d:%d: the mesh of '%s' is open (%zu edges belong to one triangle only) but its bsdf is a "
                     "%s: light that enters it may never leave; close the mesh, or use a thindielectric",
                     shape->place.file ? shape->place.file : scene->path, shape->place.line, shape->place.column,
                     shape_name(shape), open, bsdf);
    }
    return STATUS_OK;
}

enum status lamp_check(const struct scene *scene, const struct run *run, struct error *error) {
    if (scene->emitter_count == 0)
        return error_set(error, STATUS_INVALID,
                         "%s: the lamp has no emitter; give one of its shapes an <emitter type=\"area\">", scene->path);
    size_t dark = 0, points = 0;
    for (size_t i = 0; i < scene->emitter_count; i++) {
        const struct emitter *emitter = scene->emitters[i];
        points += (emitter->flags & EMITTER_DELTA_POSITION) != 0;
        if (!rgb_is_finite(emitter->power) || rgb_max(emitter->power) > 0) continue;
        dark++;
        if (emitter->shape)
            run_warn(run, "%s:%d:%d: the emitter of '%s' has no power",
                     emitter->shape->place.file ? emitter->shape->place.file : scene->path, emitter->shape->place.line,
                     emitter->shape->place.column, shape_name(emitter->shape));
    }
    if (dark == scene->emitter_count)
        return error_set(error, STATUS_INVALID, "%s: all emitters of the lamp have no power; set their radiance",
                         scene->path);
    if (points > 0)
        run_warn(run,
                 "%s: %zu of the lamp's emitters are points, which have no radiance: what is seen of them directly or "
                 "through glass becomes a small spot that lights walls less sharply; spheres of the bulbs' sizes are "
                 "exact",
                 scene->path, points);
    return check_glass(scene, run, error);
}
