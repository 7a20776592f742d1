// Planes count once a triangle, not by area, so that the square root of the error is a bound of the distance to every
// plane that was merged. Open edges get a plane of their own at right angles, which holds the border. An edge is not
// collapsed where a triangle would turn over or where more than the edge's own triangles would vanish.
#include "bake/hull_simplify.h"

#include <stdlib.h>
#include <string.h>

enum { NONE = -1 };
static const double least_turn_cos = 0.5;

struct quadric { // sum of (n.p + d)^2: upper triangle of n n^T, n d, d d
    double nn[6], nd[3], dd;
};

struct edge {
    double cost;
    double p[3];
    uint32_t a, b, stamp_a, stamp_b;
};

struct simplifier {
    struct loose_mesh *mesh;
    double (*p)[3];
    struct quadric *quadrics;
    uint32_t *stamps; // of the vertex's last change
    int64_t *first; // first corner of a vertex, corners are linked
    int64_t *next; // [3 * triangles]
    uint8_t *dead; // triangles
    uint32_t *marks, mark;
    struct edge *heap;
    size_t heap_count, heap_room, triangles, vertices; // triangles, vertices: in use
    bool out_of_memory;
};

void loose_mesh_fini(struct loose_mesh *mesh) {
    free(mesh->positions);
    free(mesh->vertex_part);
    free(mesh->triangles);
    *mesh = (struct loose_mesh){0};
}

// --- Joining ---

struct keyed {
    vec3 p;
    uint32_t part, index;
};

static int keyed_order(const void *a, const void *b) {
    const struct keyed *x = a, *y = b;
    if (x->part != y->part) return x->part < y->part ? -1 : 1;
    if (x->p.x != y->p.x) return x->p.x < y->p.x ? -1 : 1;
    if (x->p.y != y->p.y) return x->p.y < y->p.y ? -1 : 1;
    if (x->p.z != y->p.z) return x->p.z < y->p.z ? -1 : 1;
    return (x->index > y->index) - (x->index < y->index);
}

enum status loose_mesh_join(struct loose_mesh *mesh, struct error *error) {
    size_t n = mesh->vertex_count;
    struct keyed *keyed = malloc((n + 1) * sizeof *keyed);
    uint32_t *to = malloc((n + 1) * sizeof *to);
    if (!keyed || !to) {
        free(keyed);
        free(to);
        return error_set(error, STATUS_MEMORY, "out of memory for the hull's %zu vertices", n);
    }
    for (size_t i = 0; i < n; i++) keyed[i] = (struct keyed){mesh->positions[i], mesh->vertex_part[i], (uint32_t)i};
    qsort(keyed, n, sizeof *keyed, keyed_order);
    for (size_t i = 0; i < n; i++) {
        const struct keyed *k = &keyed[i], *before = i ? k - 1 : k;
        bool same =
            i && k->part == before->part && k->p.x == before->p.x && k->p.y == before->p.y && k->p.z == before->p.z;
        to[k->index] = same ? to[before->index] : k->index;
    }
    size_t kept = 0;
    for (size_t t = 0; t < mesh->triangle_count; t++) {
        uint32_t *v = mesh->triangles[t];
        uint32_t joined[3] = {to[v[0]], to[v[1]], to[v[2]]};
        if (joined[0] == joined[1] || joined[1] == joined[2] || joined[2] == joined[0]) continue;
        memcpy(mesh->triangles[kept++], joined, sizeof joined);
    }
    mesh->triangle_count = kept;
    free(keyed);
    free(to);
    return STATUS_OK;
}

// --- Quadrics ---

static void cross(const double a[3], const double b[3], double out[3]) {
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}
static double dot(const double a[3], const double b[3]) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
static void subtract(const double a[3], const double b[3], double out[3]) {
    for (int i = 0; i < 3; i++) out[i] = a[i] - b[i];
}

static void triangle_normal(const double a[3], const double b[3], const double c[3], double n[3]) {
    double e1[3], e2[3];
    subtract(b, a, e1);
    subtract(c, a, e2);
    cross(e1, e2, n);
}

static void add_plane(struct quadric *q, const double n[3], double d, double weight) {
    static const int row[6] = {0, 0, 0, 1, 1, 2}, column[6] = {0, 1, 2, 1, 2, 2};
    for (int i = 0; i < 6; i++) q->nn[i] += weight * n[row[i]] * n[column[i]];
    for (int i = 0; i < 3; i++) q->nd[i] += weight * n[i] * d;
    q->dd += weight * d * d;
}

static struct quadric quadric_sum(const struct quadric *a, const struct quadric *b) {
    struct quadric sum = *a;
    for (int i = 0; i < 6; i++) sum.nn[i] += b->nn[i];
    for (int i = 0; i < 3; i++) sum.nd[i] += b->nd[i];
    sum.dd += b->dd;
    return sum;
}

static double quadric_error(const struct quadric *q, const double p[3]) {
    const double *m = q->nn;
    double x = p[0], y = p[1], z = p[2];
    double e = m[0] * x * x + m[3] * y * y + m[5] * z * z + 2 * (m[1] * x * y + m[2] * x * z + m[4] * y * z) +
               2 * dot(q->nd, p) + q->dd;
    return e > 0 ? e : 0;
}

// The point of least error, where the planes determine one.
static bool quadric_best(const struct quadric *q, double p[3]) {
    const double *m = q->nn;
    double c[3] = {m[3] * m[5] - m[4] * m[4], m[2] * m[4] - m[1] * m[5], m[1] * m[4] - m[2] * m[3]};
    double determinant = m[0] * c[0] + m[1] * c[1] + m[2] * c[2], size = m[0] + m[3] + m[5];
    if (!(determinant > 1e-4 * size * size * size)) return false;
    double i11 = m[0] * m[5] - m[2] * m[2], i12 = m[1] * m[2] - m[0] * m[4], i22 = m[0] * m[3] - m[1] * m[1];
    const double *d = q->nd;
    p[0] = -(c[0] * d[0] + c[1] * d[1] + c[2] * d[2]) / determinant;
    p[1] = -(c[1] * d[0] + i11 * d[1] + i12 * d[2]) / determinant;
    p[2] = -(c[2] * d[0] + i12 * d[1] + i22 * d[2]) / determinant;
    return true;
}

// --- The heap of edges, cheapest first; ties by vertices, so that the order is fixed ---

static bool edge_before(const struct edge *x, const struct edge *y) {
    if (x->cost != y->cost) return x->cost < y->cost;
    return x->a != y->a ? x->a < y->a : x->b < y->b;
}

static void heap_push(struct simplifier *s, const struct edge *edge) {
    if (s->heap_count == s->heap_room) {
        size_t room = 2 * s->heap_room + 1024;
        struct edge *larger = realloc(s->heap, room * sizeof *larger);
        if (!larger) {
            s->out_of_memory = true;
            return;
        }
        s->heap = larger;
        s->heap_room = room;
    }
    size_t i = s->heap_count++;
    for (; i && edge_before(edge, &s->heap[(i - 1) / 2]); i = (i - 1) / 2) s->heap[i] = s->heap[(i - 1) / 2];
    s->heap[i] = *edge;
}

static struct edge heap_pop(struct simplifier *s) {
    struct edge top = s->heap[0], last = s->heap[--s->heap_count];
    size_t i = 0;
    for (size_t child; (child = 2 * i + 1) < s->heap_count; i = child) {
        if (child + 1 < s->heap_count && edge_before(&s->heap[child + 1], &s->heap[child])) child++;
        if (!edge_before(&s->heap[child], &last)) break;
        s->heap[i] = s->heap[child];
    }
    if (s->heap_count) s->heap[i] = last;
    return top;
}

static void push_edge(struct simplifier *s, uint32_t a, uint32_t b) {
    if (a > b) {
        uint32_t c = a;
        a = b;
        b = c;
    }
    struct edge edge = {.a = a, .b = b, .stamp_a = s->stamps[a], .stamp_b = s->stamps[b]};
    struct quadric q = quadric_sum(&s->quadrics[a], &s->quadrics[b]);
    double candidates[4][3], length2 = 0;
    int count = 3;
    for (int i = 0; i < 3; i++) {
        candidates[0][i] = s->p[a][i];
        candidates[1][i] = s->p[b][i];
        candidates[2][i] = 0.5 * (s->p[a][i] + s->p[b][i]);
        length2 += (s->p[a][i] - s->p[b][i]) * (s->p[a][i] - s->p[b][i]);
    }
    if (quadric_best(&q, candidates[3])) { // not far away, where the planes nearly agree
        double away[3];
        subtract(candidates[3], candidates[2], away);
        count = dot(away, away) <= length2 ? 4 : 3;
    }
    edge.cost = INFINITY;
    for (int k = 0; k < count; k++) {
        double cost = quadric_error(&q, candidates[k]);
        if (cost >= edge.cost) continue;
        edge.cost = cost;
        memcpy(edge.p, candidates[k], sizeof edge.p);
    }
    edge.cost += 1e-12 * length2; // of equal errors, the short edge first
    heap_push(s, &edge);
}

// --- Collapsing ---

#define FOR_CORNERS(s, c, v)                                                                                           \
    for (int64_t c = (s)->first[v]; c != NONE; c = (s)->next[c])                                                       \
        if (!(s)->dead[c / 3])

static uint32_t around(const struct simplifier *s, int64_t corner, int step) {
    return s->mesh->triangles[corner / 3][(corner % 3 + step) % 3];
}

static bool turns_over(const struct simplifier *s, uint32_t v, uint32_t other, const double p[3]) {
    FOR_CORNERS(s, c, v) {
        uint32_t b = around(s, c, 1), d = around(s, c, 2);
        if (b == other || d == other) continue;
        double before[3], after[3];
        triangle_normal(s->p[v], s->p[b], s->p[d], before);
        triangle_normal(p, s->p[b], s->p[d], after);
        double size = sqrt(dot(before, before) * dot(after, after));
        if (!(dot(before, after) >= least_turn_cos * size) || !(size > 0)) return true;
    }
    return false;
}

// Neighbours that both ends have in common are the tips of the edge's triangles, and there are one or two of these.
static bool is_simple(struct simplifier *s, uint32_t a, uint32_t b) {
    uint32_t mark = s->mark += 2;
    size_t shared = 0, common = 0;
    FOR_CORNERS(s, c, a) {
        uint32_t x = around(s, c, 1), y = around(s, c, 2);
        shared += x == b || y == b;
        s->marks[x] = s->marks[y] = mark;
    }
    FOR_CORNERS(s, c, b) {
        for (int k = 1; k < 3; k++) {
            uint32_t x = around(s, c, k);
            if (s->marks[x] != mark || x == a) continue;
            s->marks[x] = mark + 1;
            common++;
        }
    }
    return shared >= 1 && shared <= 2 && common == shared;
}

static bool is_used(const struct simplifier *s, uint32_t v) {
    FOR_CORNERS(s, c, v) return true;
    return false;
}

static void collapse(struct simplifier *s, const struct edge *edge) {
    uint32_t a = edge->a, b = edge->b, tips[2]; // of the one or two triangles that vanish
    size_t tip_count = 0;
    s->vertices--;
    memcpy(s->p[a], edge->p, sizeof edge->p);
    s->quadrics[a] = quadric_sum(&s->quadrics[a], &s->quadrics[b]);
    s->stamps[a]++;
    s->stamps[b]++;
    int64_t tail = NONE;
    for (int64_t c = s->first[b]; c != NONE; c = s->next[c]) {
        tail = c;
        if (s->dead[c / 3]) continue;
        const uint32_t next = around(s, c, 1), last = around(s, c, 2);
        if (next == a || last == a) {
            s->dead[c / 3] = 1;
            s->triangles--;
            tips[tip_count++] = next == a ? last : next;
        } else
            s->mesh->triangles[c / 3][c % 3] = a;
    }
    if (tail != NONE) {
        s->next[tail] = s->first[a];
        s->first[a] = s->first[b];
        s->first[b] = NONE;
    }
    for (size_t i = 0; i < tip_count; i++) s->vertices -= !is_used(s, tips[i]);
    s->vertices -= !is_used(s, a);
    FOR_CORNERS(s, c, a) {
        push_edge(s, a, around(s, c, 1));
        push_edge(s, a, around(s, c, 2));
    }
}

static void add_triangle_planes(struct simplifier *s, const float *stiffness) {
    const struct loose_mesh *mesh = s->mesh;
    for (size_t t = 0; t < mesh->triangle_count; t++) {
        const uint32_t *v = mesh->triangles[t];
        double n[3], weight = (double)(stiffness[mesh->vertex_part[v[0]]] * stiffness[mesh->vertex_part[v[0]]]);
        triangle_normal(s->p[v[0]], s->p[v[1]], s->p[v[2]], n);
        double length = sqrt(dot(n, n));
        if (!(length > 0)) continue;
        for (int i = 0; i < 3; i++) n[i] /= length;
        for (int k = 0; k < 3; k++) {
            add_plane(&s->quadrics[v[k]], n, -dot(n, s->p[v[0]]), weight);
            uint32_t from = v[k], to = v[(k + 1) % 3];
            size_t owners = 0;
            FOR_CORNERS(s, c, from) owners += around(s, c, 1) == to || around(s, c, 2) == to;
            if (owners != 1) continue;
            double along[3], across[3];
            subtract(s->p[to], s->p[from], along);
            cross(along, n, across);
            double size = sqrt(dot(across, across));
            if (!(size > 0)) continue;
            for (int i = 0; i < 3; i++) across[i] /= size;
            add_plane(&s->quadrics[from], across, -dot(across, s->p[from]), weight);
            add_plane(&s->quadrics[to], across, -dot(across, s->p[from]), weight);
        }
    }
}

static enum status simplifier_init(struct simplifier *s, struct loose_mesh *mesh, struct error *error) {
    size_t n = mesh->vertex_count, corners = 3 * mesh->triangle_count;
    *s = (struct simplifier){.mesh = mesh, .triangles = mesh->triangle_count};
    s->p = malloc((n + 1) * sizeof *s->p);
    s->quadrics = calloc(n + 1, sizeof *s->quadrics);
    s->stamps = calloc(n + 1, sizeof *s->stamps);
    s->first = malloc((n + 1) * sizeof *s->first);
    s->marks = calloc(n + 1, sizeof *s->marks);
    s->next = malloc((corners + 1) * sizeof *s->next);
    s->dead = calloc(mesh->triangle_count + 1, 1);
    if (!s->p || !s->quadrics || !s->stamps || !s->first || !s->marks || !s->next || !s->dead)
        return error_set(error, STATUS_MEMORY, "out of memory for a hull of %zu triangles", mesh->triangle_count);
    for (size_t i = 0; i < n; i++) {
        s->first[i] = NONE;
        s->p[i][0] = (double)mesh->positions[i].x;
        s->p[i][1] = (double)mesh->positions[i].y;
        s->p[i][2] = (double)mesh->positions[i].z;
    }
    for (size_t c = 0; c < corners; c++) {
        uint32_t v = mesh->triangles[c / 3][c % 3];
        s->vertices += s->first[v] == NONE;
        s->next[c] = s->first[v];
        s->first[v] = (int64_t)c;
    }
    return STATUS_OK;
}

static void simplifier_fini(struct simplifier *s) {
    free(s->p);
    free(s->quadrics);
    free(s->stamps);
    free(s->first);
    free(s->marks);
    free(s->next);
    free(s->dead);
    free(s->heap);
}

// The living triangles and the vertices that they use, back into the mesh.
static void gather_mesh(struct simplifier *s) {
    struct loose_mesh *mesh = s->mesh;
    size_t triangles = 0, vertices = 0;
    for (size_t t = 0; t < mesh->triangle_count; t++)
        if (!s->dead[t]) memmove(mesh->triangles[triangles++], mesh->triangles[t], sizeof *mesh->triangles);
    mesh->triangle_count = triangles;
    memset(s->marks, 0, mesh->vertex_count * sizeof *s->marks);
    for (size_t c = 0; c < 3 * triangles; c++) s->marks[mesh->triangles[c / 3][c % 3]] = 1;
    for (size_t i = 0; i < mesh->vertex_count; i++) {
        if (!s->marks[i]) continue;
        mesh->positions[vertices] = vec3_make((float)s->p[i][0], (float)s->p[i][1], (float)s->p[i][2]);
        mesh->vertex_part[vertices] = mesh->vertex_part[i];
        s->marks[i] = (uint32_t)vertices++;
    }
    mesh->vertex_count = vertices;
    for (size_t c = 0; c < 3 * triangles; c++) mesh->triangles[c / 3][c % 3] = s->marks[mesh->triangles[c / 3][c % 3]];
}

enum status loose_mesh_simplify(struct loose_mesh *mesh, const float *stiffness, float tolerance,
                                const struct mesh_limit *most, struct error *error) {
    struct simplifier s;
    enum status status = simplifier_init(&s, mesh, error);
    if (status == STATUS_OK) {
        add_triangle_planes(&s, stiffness);
        for (size_t c = 0; c < 3 * mesh->triangle_count; c++)
            push_edge(&s, mesh->triangles[c / 3][c % 3], mesh->triangles[c / 3][(c % 3 + 1) % 3]);
        double limit = (double)tolerance * (double)tolerance;
        while (s.heap_count && !s.out_of_memory) {
            struct edge edge = heap_pop(&s);
            if (edge.stamp_a != s.stamps[edge.a] || edge.stamp_b != s.stamps[edge.b]) continue;
            if (edge.cost > limit && s.vertices <= most->vertices && s.triangles <= most->triangles) break;
            if (!is_simple(&s, edge.a, edge.b) || turns_over(&s, edge.a, edge.b, edge.p) ||
                turns_over(&s, edge.b, edge.a, edge.p))
                continue;
            collapse(&s, &edge);
        }
        if (s.out_of_memory)
            status = error_set(error, STATUS_MEMORY, "out of memory while a hull was simplified");
        else
            gather_mesh(&s);
    }
    simplifier_fini(&s);
    return status;
}
