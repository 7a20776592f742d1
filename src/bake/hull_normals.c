// A little within each corner of a triangle the nearest surface of its part along the triangle's normal is asked for
// its own. Corners of one vertex whose normals differ little share their mean, others get vertices of their own.
#include "bake/hull_normals.h"

#include <stdlib.h>
#include <string.h>

#include "base/parallel.h"

enum { BLOCK = 256, MAX_PASSES = 16 };
static const float within = 0.05f; // towards the triangle's middle: on one side of a crease
static const float reach = 0.005f; // [proxy radius] from a triangle to the surface that it stands for
static const float alike_cos = 0.985f; // 10 degrees
static const float least_cos = 0.5f; // between the triangle and the surface

struct asking {
    const struct hull *hull;
    const struct hull_map *map;
    const struct lamp *lamp;
    uint32_t part;
    vec3 *normals; // of every corner
};

static vec3 corner_normal(const struct asking *asking, size_t triangle, int corner) {
    const uint16_t *v = asking->hull->triangles[triangle];
    const vec3 p = hull_vertex(asking->hull, v[corner]), face = hull_face_normal(asking->hull, triangle);
    const vec3 others =
        vec3_add(hull_vertex(asking->hull, v[(corner + 1) % 3]), hull_vertex(asking->hull, v[(corner + 2) % 3]));
    const float length = reach * asking->lamp->proxy.radius;
    const vec3 inner = vec3_mad(vec3_sub(vec3_scale(others, 0.5f), p), within, p);
    struct ray ray = {vec3_mad(face, length, inner), vec3_neg(face), 0, 2 * length};
    vec3 nearest = face;
    float distance = INFINITY, travelled = 0;
    for (int i = 0; i < MAX_PASSES; i++) {
        struct surface surface;
        if (!scene_intersect(asking->lamp->scene, &ray, -1, &surface)) break;
        const float off = fabsf(vec3_dot(vec3_sub(surface.p, inner), face));
        const bool lies_alike = fabsf(vec3_dot(surface.ng, face)) > least_cos;
        if (asking->map->part[surface.shape->index] == asking->part && off < distance && lies_alike) {
            distance = off;
            nearest = vec3_dot(surface.shading.n, face) < 0 ? vec3_neg(surface.shading.n) : surface.shading.n;
        }
        travelled += surface.t;
        ray = surface_spawn_ray(&surface, ray.direction);
        ray.t_max = 2 * length - travelled;
    }
    return nearest;
}

static void ask_block(void *user, size_t block, int worker) {
    (void)worker;
    const struct asking *asking = user;
    const struct hull_part *part = &asking->hull->parts[asking->part];
    const size_t begin = part->first + block * BLOCK, last = part->first + part->count;
    for (size_t t = begin; t < begin + BLOCK && t < last; t++)
        for (int k = 0; k < 3; k++) asking->normals[3 * t + (size_t)k] = corner_normal(asking, t, k);
}

struct splitting { // vertices, of which some are other copies of others
    struct hull *hull;
    size_t room;
    vec3 *sums; // of the normals of every vertex
    uint32_t *copy; // the next copy of a vertex, or NONE
};
#define NONE UINT32_MAX

static bool is_alike(vec3 sum, vec3 n) {
    const float length2 = vec3_dot(sum, sum);
    return !(length2 > 0) || vec3_dot(sum, n) >= alike_cos * sqrtf(length2);
}

// The copy of a vertex that has this normal, about; the vertex itself where no room is left for another.
static uint16_t vertex_with(struct splitting *s, uint16_t vertex, vec3 n) {
    uint32_t at = vertex, last = vertex;
    for (; at != NONE; at = s->copy[at]) {
        if (is_alike(s->sums[at], n)) return (uint16_t)at;
        last = at;
    }
    if (s->hull->vertex_count == s->room) return vertex;
    at = (uint32_t)s->hull->vertex_count++;
    memcpy(s->hull->vertices[at], s->hull->vertices[vertex], sizeof *s->hull->vertices);
    s->sums[at] = vec3_make(0, 0, 0);
    s->copy[at] = NONE;
    s->copy[last] = at;
    return (uint16_t)at;
}

static void split(struct splitting *s, const struct hull_part *part, const vec3 *normals) {
    for (size_t c = 3 * (size_t)part->first; c < 3 * (size_t)(part->first + part->count); c++) {
        uint16_t *corner = &s->hull->triangles[c / 3][c % 3];
        *corner = vertex_with(s, *corner, normals[c]);
        s->sums[*corner] = vec3_add(s->sums[*corner], normals[c]);
    }
}

static void set_normals(struct splitting *s) {
    for (size_t v = 0; v < s->hull->vertex_count; v++) {
        const float length = vec3_length(s->sums[v]);
        if (length > 0) hull_set_normal(s->hull, v, vec3_scale(s->sums[v], 1 / length));
    }
}

static size_t smooth_corners(const struct hull *hull) {
    size_t corners = 0;
    for (size_t i = 0; i < hull->part_count; i++)
        if (hull->parts[i].smooth) corners += 3 * (size_t)hull->parts[i].count;
    return corners;
}

// Room for a vertex at each corner of the smooth parts, as far as indices go.
static bool make_room(struct splitting *s) {
    const size_t most = s->hull->vertex_count + smooth_corners(s->hull);
    s->room = most < HULL_MAX_VERTICES ? most : HULL_MAX_VERTICES;
    void *vertices = realloc(s->hull->vertices, (s->room + 1) * sizeof *s->hull->vertices);
    if (vertices) s->hull->vertices = vertices;
    free(s->hull->normals);
    s->hull->normals = calloc(s->room + 1, sizeof *s->hull->normals);
    s->sums = calloc(s->room + 1, sizeof *s->sums);
    s->copy = malloc((s->room + 1) * sizeof *s->copy);
    if (s->copy) memset(s->copy, 0xff, (s->room + 1) * sizeof *s->copy);
    return vertices && s->hull->normals && s->sums && s->copy;
}

enum status hull_take_normals(struct hull *hull, const struct hull_map *map, const struct lamp *lamp,
                              struct error *error) {
    struct splitting splitting = {.hull = hull};
    struct asking asking = {.hull = hull, .map = map, .lamp = lamp};
    asking.normals = malloc((3 * hull->triangle_count + 1) * sizeof *asking.normals);
    enum status status = STATUS_OK;
    if (asking.normals && make_room(&splitting)) {
        for (uint32_t i = 0; i < hull->part_count; i++) {
            if (!hull->parts[i].smooth) continue;
            asking.part = i;
            parallel_for(lamp->threads, (hull->parts[i].count + BLOCK - 1) / BLOCK, ask_block, &asking);
            split(&splitting, &hull->parts[i], asking.normals);
        }
        set_normals(&splitting);
    } else
        status = error_set(error, STATUS_MEMORY, "out of memory for the hull's normals");
    free(asking.normals);
    free(splitting.sums);
    free(splitting.copy);
    return status;
}
