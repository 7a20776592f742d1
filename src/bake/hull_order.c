// Depth first over neighbours, from the first triangle that is left.
#include "bake/hull_order.h"

#include <stdlib.h>
#include <string.h>

struct edge { // of a triangle, from its corner `corner` to the next
    uint32_t key; // first vertex << 16 | second vertex
    uint32_t corner; // 3 * triangle + corner
};

struct walk {
    struct hull *hull;
    struct edge *edges; // of a part, ascending
    size_t edge_count;
    uint32_t *stack; // corners to begin with
    bool *used; // triangles
    uint16_t (*ordered)[3];
    size_t count; // of ordered triangles
};

static int edge_order(const void *a, const void *b) {
    const struct edge *x = a, *y = b;
    if (x->key != y->key) return x->key < y->key ? -1 : 1;
    return (x->corner > y->corner) - (x->corner < y->corner);
}

static uint16_t vertex_at(const struct walk *walk, uint32_t corner, uint32_t step) {
    return walk->hull->triangles[corner / 3][(corner % 3 + step) % 3];
}

static void list_edges(struct walk *walk, const struct hull_part *part) {
    walk->edge_count = 3 * (size_t)part->count;
    for (size_t i = 0; i < walk->edge_count; i++) {
        const uint32_t corner = 3 * part->first + (uint32_t)i;
        const uint32_t key = (uint32_t)vertex_at(walk, corner, 0) << 16 | vertex_at(walk, corner, 1);
        walk->edges[i] = (struct edge){key, corner};
    }
    qsort(walk->edges, walk->edge_count, sizeof *walk->edges, edge_order);
}

// Of the edges with this key the first, or edge_count.
static size_t find_edge(const struct walk *walk, uint32_t key) {
    size_t low = 0, high = walk->edge_count;
    while (low < high) {
        const size_t middle = (low + high) / 2;
        if (walk->edges[middle].key < key)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

static size_t push_neighbours(struct walk *walk, uint16_t from, uint16_t to, size_t depth) {
    const uint32_t key = (uint32_t)to << 16 | from;
    for (size_t i = find_edge(walk, key); i < walk->edge_count && walk->edges[i].key == key; i++)
        if (!walk->used[walk->edges[i].corner / 3]) walk->stack[depth++] = walk->edges[i].corner;
    return depth;
}

static void walk_part(struct walk *walk, const struct hull_part *part) {
    list_edges(walk, part);
    for (uint32_t start = part->first; start < part->first + part->count; start++) {
        size_t depth = 0;
        walk->stack[depth++] = 3 * start;
        while (depth) {
            const uint32_t corner = walk->stack[--depth];
            if (walk->used[corner / 3]) continue;
            walk->used[corner / 3] = true;
            const uint16_t a = vertex_at(walk, corner, 0), b = vertex_at(walk, corner, 1),
                           c = vertex_at(walk, corner, 2);
            uint16_t *to = walk->ordered[walk->count++];
            to[0] = a, to[1] = b, to[2] = c;
            depth = push_neighbours(walk, a, b, depth);
            depth = push_neighbours(walk, c, a, depth);
            depth = push_neighbours(walk, b, c, depth);
        }
    }
}

static void renumber(struct hull *hull, uint32_t (*positions)[3], uint16_t (*normals)[2], uint32_t *number) {
    size_t count = 0;
    memset(number, 0xff, hull->vertex_count * sizeof *number);
    for (size_t t = 0; t < hull->triangle_count; t++)
        for (int k = 0; k < 3; k++) {
            const uint16_t v = hull->triangles[t][k];
            if (number[v] == UINT32_MAX) {
                memcpy(positions[count], hull->vertices[v], sizeof *positions);
                memcpy(normals[count], hull->normals[v], sizeof *normals);
                number[v] = (uint32_t)count++;
            }
            hull->triangles[t][k] = (uint16_t)number[v];
        }
    memcpy(hull->vertices, positions, count * sizeof *positions);
    memcpy(hull->normals, normals, count * sizeof *normals);
    hull->vertex_count = count;
}

enum status hull_order(struct hull *hull, struct error *error) {
    const size_t n = hull->triangle_count, vertices = hull->vertex_count;
    struct walk walk = {.hull = hull,
                        .edges = malloc((3 * n + 1) * sizeof *walk.edges),
                        .stack = malloc((3 * n + 1) * 3 * sizeof *walk.stack),
                        .used = calloc(n + 1, sizeof *walk.used),
                        .ordered = malloc((n + 1) * sizeof *walk.ordered)};
    uint32_t(*positions)[3] = malloc((vertices + 1) * sizeof *positions);
    uint16_t(*normals)[2] = malloc((vertices + 1) * sizeof *normals);
    uint32_t *number = malloc((vertices + 1) * sizeof *number);
    enum status status = STATUS_OK;
    if (walk.edges && walk.stack && walk.used && walk.ordered && positions && normals && number) {
        for (size_t i = 0; i < hull->part_count; i++) walk_part(&walk, &hull->parts[i]);
        memcpy(hull->triangles, walk.ordered, n * sizeof *hull->triangles);
        renumber(hull, positions, normals, number);
    } else
        status = error_set(error, STATUS_MEMORY, "out of memory for a hull of %zu triangles", n);
    free(walk.edges);
    free(walk.stack);
    free(walk.used);
    free(walk.ordered);
    free(positions);
    free(normals);
    free(number);
    return status;
}
