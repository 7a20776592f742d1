// Parts are told apart by their material and by whether they emit. A triangle belongs to the hull if a ray from it gets
// out of the lamp, straight through clear glass: what can be seen only by refraction is nearly always visible from
// somewhere else without.
#include "bake/hull_build.h"

#include <stdlib.h>
#include <string.h>

#include "bake/hull_cutout.h"
#include "bake/hull_normals.h"
#include "bake/hull_order.h"
#include "bake/hull_simplify.h"
#include "base/parallel.h"
#include "luminaire/hull_pack.h"
#include "math/warp.h"

enum { LEAST_COLUMNS = 24, MOST_COLUMNS = 128, LEAST_TRIES = 4, MOST_TRIES = 64, MAX_PASSES = 64, BLOCK = 256 };
static const float tolerance = 3e-4f, chord_tolerance = 7e-4f; // [proxy radius]
static const float glass_stiffness = 4;
static const float finest_cut = 4e-3f; // [proxy radius]
static const size_t most_cut = 1000000; // triangles of cut-outs; where there are more they are cut more coarsely
static const double look_rays = 8e6; // at most, of all triangles together

struct builder {
    const struct lamp *lamp;
    const struct hull_map *map;
    struct hull_part parts[HULL_MAX_PARTS];
    const struct bsdf *part_bsdf[HULL_MAX_PARTS];
    bool part_emits[HULL_MAX_PARTS];
    bool *cutout; // of every shape
    size_t part_count;
    struct loose_mesh mesh;
    uint32_t *shape, *primitive; // of every triangle; primitive UINT32_MAX: of an analytic shape
    uint8_t *visible;
};

// Clear smooth glass: the only material that a hull can stand for by itself.
static bool is_clear_glass(const struct shape *shape, float *eta) {
    const struct bsdf *bsdf = shape->bsdf;
    if (shape->emitter || bsdf->flags != (BSDF_DELTA | BSDF_TRANSMISSION)) return false;
    struct bsdf_point point = {.uv = {0.5f, 0.5f}};
    static const vec3 from_outside = {0, 0, 1};
    struct bsdf_sample through, back;
    if (!bsdf_sample(bsdf, &point, from_outside, (vec3){0.5f, 0.5f, 0.9999f}, TRANSPORT_RADIANCE, &through) ||
        !bsdf_sample(bsdf, &point, from_outside, (vec3){0.5f, 0.5f, 0}, TRANSPORT_RADIANCE, &back))
        return false;
    float whole = through.weight.r * sqrf(through.eta);
    rgb t = through.weight, r = back.weight;
    *eta = through.eta;
    return through.wo.z < 0 && fabsf(whole - 1) < 1e-3f && t.r == t.g && t.g == t.b && r.r == 1 && r.g == 1 && r.b == 1;
}

static uint32_t part_of(struct builder *b, const struct shape *shape, bool cutout, bool *glass) {
    struct hull_part part = {.kind = HULL_OPAQUE, .eta = 1};
    *glass = is_clear_glass(shape, &part.eta);
    if (*glass) {
        part.kind = HULL_GLASS;
        if (shape->has_interior) memcpy(part.sigma_a, &shape->sigma_a, sizeof part.sigma_a);
    } else {
        part.eta = 1;
        if (shape->bsdf->flags & (cutout ? BSDF_TRANSMISSION : BSDF_TRANSMISSION | BSDF_NULL))
            part.kind = HULL_TRANSLUCENT;
    }
    part.smooth = shape->mesh.triangle_count == 0 || shape->mesh.normals;
    size_t alike = HULL_MAX_PARTS; // the last resort of a lamp of very many materials
    for (size_t i = 0; i < b->part_count; i++) {
        const struct hull_part *other = &b->parts[i];
        if (other->kind != part.kind || other->smooth != part.smooth || other->eta != part.eta ||
            memcmp(other->sigma_a, part.sigma_a, sizeof part.sigma_a) != 0)
            continue;
        alike = i;
        if (*glass || (b->part_bsdf[i] == shape->bsdf && b->part_emits[i] == (shape->emitter != NULL)))
            return (uint32_t)i;
    }
    if (b->part_count >= HULL_MAX_PARTS - 8 && alike < HULL_MAX_PARTS) return (uint32_t)alike;
    if (b->part_count == HULL_MAX_PARTS) return HULL_MAX_PARTS;
    b->parts[b->part_count] = part;
    b->part_bsdf[b->part_count] = shape->bsdf;
    b->part_emits[b->part_count] = shape->emitter != NULL;
    return (uint32_t)b->part_count++;
}

static void add_vertex(struct builder *b, vec3 p, uint32_t part) {
    b->mesh.positions[b->mesh.vertex_count] = p;
    b->mesh.vertex_part[b->mesh.vertex_count++] = part;
}

// Wound so that its normal is on the side of `outside`.
static void add_triangle(struct builder *b, uint32_t v0, uint32_t v1, uint32_t v2, vec3 outside, uint32_t shape,
                         uint32_t primitive) {
    const vec3 *p = b->mesh.positions;
    bool turned = vec3_dot(vec3_cross(vec3_sub(p[v1], p[v0]), vec3_sub(p[v2], p[v0])), outside) < 0;
    uint32_t *v = b->mesh.triangles[b->mesh.triangle_count];
    v[0] = v0;
    v[1] = turned ? v2 : v1;
    v[2] = turned ? v1 : v2;
    b->shape[b->mesh.triangle_count] = shape;
    b->primitive[b->mesh.triangle_count++] = primitive;
}

static void add_mesh(struct builder *b, const struct shape *shape, uint32_t index) {
    uint32_t first = (uint32_t)b->mesh.vertex_count;
    for (size_t i = 0; i < shape->mesh.vertex_count; i++) add_vertex(b, shape->mesh.positions[i], b->map->part[index]);
    for (uint32_t t = 0; t < shape->mesh.triangle_count; t++) {
        const uint32_t *v = shape->mesh.indices + 3 * (size_t)t;
        struct surface surface;
        shape_fill_triangle(shape, t, (vec2){1.0f / 3, 1.0f / 3}, &surface);
        add_triangle(b, first + v[0], first + v[1], first + v[2], surface.ng, index, t);
    }
}

// So many that the chords of an analytic shape are near to it.
static int analytic_columns(const struct builder *b, const struct shape *shape) {
    struct surface front, back;
    shape_sample(shape, (vec2){0, 0.5f}, &front);
    shape_sample(shape, (vec2){0.5f, 0.5f}, &back);
    const float radius = 0.5f * vec3_length(vec3_sub(front.p, back.p)) / b->lamp->proxy.radius;
    const float columns = PI_F * sqrtf(0.5f * radius / chord_tolerance); // sagitta = r (1 - cos(pi / columns))
    return 2 * (int)ceilf(0.5f * clampf(columns, LEAST_COLUMNS, MOST_COLUMNS));
}

// Rows at equal angles on a sphere, where uv is uniform by area.
static void add_analytic(struct builder *b, const struct shape *shape, uint32_t index) {
    const uint32_t first = (uint32_t)b->mesh.vertex_count;
    const int columns = analytic_columns(b, shape), rows = columns / 2;
    vec3 normals[(MOST_COLUMNS / 2 + 1) * (MOST_COLUMNS + 1)];
    for (int y = 0, at = 0; y <= rows; y++)
        for (int x = 0; x <= columns; x++, at++) {
            struct surface surface;
            float v = 0.5f - 0.5f * cosf(PI_F * (float)y / (float)rows);
            shape_sample(shape, (vec2){(float)(x % columns) / (float)columns, v}, &surface);
            add_vertex(b, surface.p, b->map->part[index]);
            normals[at] = surface.ng;
        }
    for (int y = 0; y < rows; y++)
        for (int x = 0; x < columns; x++) {
            int at = y * (columns + 1) + x, below = at + columns + 1;
            vec3 outside =
                vec3_add(vec3_add(normals[at], normals[at + 1]), vec3_add(normals[below], normals[below + 1]));
            uint32_t v[4] = {first + (uint32_t)at, first + (uint32_t)at + 1, first + (uint32_t)below,
                             first + (uint32_t)below + 1};
            if (y > 0) add_triangle(b, v[0], v[1], v[3], outside, index, UINT32_MAX);
            if (y < rows - 1) add_triangle(b, v[0], v[3], v[2], outside, index, UINT32_MAX);
        }
}

// --- Cut-outs ---
static void count_cut(void *user, const struct cutout_piece *piece) {
    (void)piece;
    ++*(size_t *)user;
}

static size_t count_cuts(const struct builder *b, float finest) {
    const struct scene *scene = b->lamp->scene;
    size_t count = 0;
    for (size_t i = 0; i < scene->shape_count; i++)
        if (b->cutout[i]) hull_cut(scene->shapes[i], finest, count_cut, &count);
    return count;
}

struct cut_builder {
    struct builder *builder;
    uint32_t index; // of the shape
};

static void add_cut(void *user, const struct cutout_piece *piece) {
    const struct cut_builder *cut = user;
    struct builder *b = cut->builder;
    const uint32_t first = (uint32_t)b->mesh.vertex_count;
    for (int k = 0; k < 3; k++) add_vertex(b, piece->p[k], b->map->part[cut->index]);
    add_triangle(b, first, first + 1, first + 2, piece->normal, cut->index, piece->primitive);
}

static enum status collect(struct builder *b, struct error *error) {
    const struct scene *scene = b->lamp->scene;
    float finest = finest_cut * b->lamp->proxy.radius;
    size_t triangles = count_cuts(b, finest);
    while (triangles > most_cut) {
        finest *= 2;
        triangles = count_cuts(b, finest);
    }
    size_t vertices = 3 * triangles;
    for (size_t i = 0; i < scene->shape_count; i++) {
        if (b->cutout[i]) continue;
        const struct mesh *mesh = &scene->shapes[i]->mesh;
        const size_t columns = mesh->triangle_count ? 0 : (size_t)analytic_columns(b, scene->shapes[i]);
        vertices += columns ? (columns / 2 + 1) * (columns + 1) : mesh->vertex_count;
        triangles += columns ? columns * columns : mesh->triangle_count;
    }
    b->mesh.positions = malloc((vertices + 1) * sizeof *b->mesh.positions);
    b->mesh.vertex_part = malloc((vertices + 1) * sizeof *b->mesh.vertex_part);
    b->mesh.triangles = malloc((triangles + 1) * sizeof *b->mesh.triangles);
    b->shape = malloc((triangles + 1) * sizeof *b->shape);
    b->primitive = malloc((triangles + 1) * sizeof *b->primitive);
    b->visible = calloc(triangles + scene->shape_count + 1, 1);
    if (!b->mesh.positions || !b->mesh.vertex_part || !b->mesh.triangles || !b->shape || !b->primitive || !b->visible ||
        vertices > UINT32_MAX)
        return error_set(error, STATUS_MEMORY, "out of memory for a hull of %zu triangles", triangles);
    for (size_t i = 0; i < scene->shape_count; i++)
        if (b->cutout[i])
            hull_cut(scene->shapes[i], finest, add_cut, &(struct cut_builder){b, (uint32_t)i});
        else if (scene->shapes[i]->mesh.triangle_count)
            add_mesh(b, scene->shapes[i], (uint32_t)i);
        else
            add_analytic(b, scene->shapes[i], (uint32_t)i);
    return STATUS_OK;
}

// --- What can be seen ---

static bool gets_out(const struct builder *b, struct ray ray) {
    struct surface surface;
    for (int i = 0; i < MAX_PASSES; i++) {
        if (!scene_intersect(b->lamp->scene, &ray, -1, &surface)) return true;
        if (!b->map->glass[surface.shape->index] && !surface_is_hole(&surface, vec3_neg(ray.direction))) return false;
        ray = surface_spawn_ray(&surface, ray.direction);
    }
    return false;
}

// A point of triangle t, or of the analytic shape that it stands for.
static void look_block(void *user, size_t block, int worker) {
    (void)worker;
    struct builder *b = user;
    const int tries = (int)fmin(MOST_TRIES, fmax(LEAST_TRIES, look_rays / (double)b->mesh.triangle_count));
    size_t end = (block + 1) * BLOCK < b->mesh.triangle_count ? (block + 1) * BLOCK : b->mesh.triangle_count;
    for (size_t t = block * BLOCK; t < end; t++) {
        const struct shape *shape = b->lamp->scene->shapes[b->shape[t]];
        struct sampler sampler = sampler_make(b->lamp->seed, (uint64_t)STREAM_HULL << 56, t);
        for (int k = 0; k < tries && !b->visible[t]; k++) {
            struct surface surface;
            if (b->primitive[t] == UINT32_MAX) {
                surface = (struct surface){.shape = shape};
                shape_sample(shape, sampler_2d(&sampler), &surface);
            } else
                shape_fill_triangle(shape, b->primitive[t], warp_triangle(sampler_2d(&sampler)), &surface);
            vec3 direction = warp_uniform_sphere(sampler_2d(&sampler));
            b->visible[t] = gets_out(b, surface_spawn_ray(&surface, direction));
        }
    }
}

static void keep_visible(struct builder *b) {
    parallel_for(b->lamp->threads, (b->mesh.triangle_count + BLOCK - 1) / BLOCK, look_block, b);
    size_t kept = 0;
    for (size_t t = 0; t < b->mesh.triangle_count; t++)
        if (b->visible[t]) memmove(b->mesh.triangles[kept++], b->mesh.triangles[t], sizeof *b->mesh.triangles);
    b->mesh.triangle_count = kept;
}

// --- The finished mesh ---

static void quantise(struct hull *hull, const struct loose_mesh *mesh) {
    vec3 lower = mesh->positions[0], upper = lower;
    for (size_t i = 1; i < mesh->vertex_count; i++) {
        vec3 p = mesh->positions[i];
        lower = (vec3){fminf(lower.x, p.x), fminf(lower.y, p.y), fminf(lower.z, p.z)};
        upper = (vec3){fmaxf(upper.x, p.x), fmaxf(upper.y, p.y), fmaxf(upper.z, p.z)};
    }
    memcpy(hull->lower, &lower, sizeof hull->lower);
    vec3 step = vec3_scale(vec3_sub(upper, lower), 1.0f / HULL_MAX_CODE);
    memcpy(hull->step, &step, sizeof hull->step);
    for (size_t i = 0; i < mesh->vertex_count; i++) hull_set_vertex(hull, i, mesh->positions[i]);
}

// Triangles by part; parts of which nothing is seen get none, which the file does not allow: they are left out, and the
// map follows.
static enum status finish(struct hull **result, struct builder *b, struct hull_map *map, struct error *error) {
    const struct loose_mesh *mesh = &b->mesh;
    struct hull *hull;
    enum status status = hull_allocate(&hull, mesh->vertex_count, mesh->triangle_count, error);
    if (status) return status;
    quantise(hull, mesh);
    uint32_t renamed[HULL_MAX_PARTS];
    for (uint32_t i = 0, at = 0; i < b->part_count; i++) {
        struct hull_part part = b->parts[i];
        part.first = at;
        for (size_t t = 0; t < mesh->triangle_count; t++) {
            const uint32_t *v = mesh->triangles[t];
            if (mesh->vertex_part[v[0]] != i) continue;
            for (int k = 0; k < 3; k++) hull->triangles[at][k] = (uint16_t)v[k];
            at++;
        }
        part.count = at - part.first;
        renamed[i] = part.count ? (uint32_t)hull->part_count : 0;
        if (part.count) hull->parts[hull->part_count++] = part;
    }
    for (size_t i = 0; i < b->lamp->scene->shape_count; i++) map->part[i] = renamed[map->part[i]];
    status = hull_take_normals(hull, map, b->lamp, error);
    if (!status) status = hull_order(hull, error);
    if (!status) status = hull_pack(hull, error);
    if (status)
        hull_destroy(hull);
    else
        *result = hull;
    return status;
}

void hull_map_fini(struct hull_map *map) {
    free(map->part);
    free(map->glass);
    *map = (struct hull_map){0};
}

static enum status build(struct hull **hull, struct builder *b, struct hull_map *map, size_t triangles,
                         struct error *error) {
    const struct scene *scene = b->lamp->scene;
    float stiffness[HULL_MAX_PARTS];
    for (size_t i = 0; i < scene->shape_count; i++) b->cutout[i] = hull_shape_is_cutout(scene->shapes[i]);
    for (size_t i = 0; i < scene->shape_count; i++)
        if ((map->part[i] = part_of(b, scene->shapes[i], b->cutout[i], &map->glass[i])) == HULL_MAX_PARTS)
            return STATUS_OK;
    for (size_t i = 0; i < b->part_count; i++) stiffness[i] = b->parts[i].kind == HULL_GLASS ? glass_stiffness : 1;
    enum status status = collect(b, error);
    if (status) return status;
    keep_visible(b);
    if (!b->mesh.triangle_count) return STATUS_OK;
    status = loose_mesh_join(&b->mesh, error);
    const struct mesh_limit most = {HULL_MAX_VERTICES, triangles};
    if (!status) status = loose_mesh_simplify(&b->mesh, stiffness, tolerance * b->lamp->proxy.radius, &most, error);
    bool fits = b->mesh.triangle_count > 0 && b->mesh.vertex_count <= HULL_MAX_VERTICES &&
                b->mesh.triangle_count <= HULL_MAX_TRIANGLES;
    return status || !fits ? status : finish(hull, b, map, error);
}

enum status hull_build(struct hull **hull, struct hull_map *map, const struct lamp *lamp, size_t triangles,
                       struct error *error) {
    *hull = NULL;
    size_t shapes = lamp->scene->shape_count;
    *map = (struct hull_map){calloc(shapes + 1, sizeof *map->part), calloc(shapes + 1, sizeof *map->glass)};
    struct builder *b = calloc(1, sizeof *b);
    enum status status = STATUS_OK;
    if (!map->part || !map->glass || !b)
        status = error_set(error, STATUS_MEMORY, "out of memory for a hull");
    else {
        b->lamp = lamp;
        b->map = map;
        b->cutout = calloc(shapes + 1, sizeof *b->cutout);
        status = !b->cutout ? error_set(error, STATUS_MEMORY, "out of memory for a hull")
                            : build(hull, b, map, triangles, error);
        loose_mesh_fini(&b->mesh);
        free(b->shape);
        free(b->primitive);
        free(b->visible);
        free(b->cutout);
    }
    free(b);
    if (status) hull_map_fini(map);
    return status;
}
