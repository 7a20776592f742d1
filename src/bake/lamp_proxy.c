// Second step of a bake: the proxy is fitted to points on every surface of the lamp and widened by 1 %, so that no
// surface touches it and the 33 x 33 points that stand for an analytic surface miss nothing.
// The sphere is the smallest one up to 0.1 % by the iteration of Badoiu and Clarkson 2003 ("Smaller core-sets for
// balls"): step i moves the centre by 1/(i+1) of the way to the farthest point.
#include "bake/lamp_proxy.h"
#include "bake/lamp_check.h"

#include <stdlib.h>
#include <string.h>

static const float widening = 1.01f;
static const float sphere_preference = 0.85f; // another proxy must have less than this share of the sphere's area
static const float far_share = 0.8f; // of the farthest distance: beyond, a point may yet be the farthest
enum { BALL_STEPS = 400, COARSE_STEPS = 40, SAMPLE_GRID = 33 };

struct point_list {
    vec3 *points;
    size_t count;
};

static enum status collect_points(struct point_list *list, const struct scene *scene, struct error *error) {
    size_t limit = scene->emitter_count;
    for (size_t i = 0; i < scene->shape_count; i++)
        limit += scene->shapes[i]->mesh.triangle_count ? scene->shapes[i]->mesh.vertex_count
                                                       : (size_t)SAMPLE_GRID * SAMPLE_GRID;
    *list = (struct point_list){malloc((limit + 1) * sizeof(vec3)), 0};
    if (!list->points) return error_set(error, STATUS_MEMORY, "out of memory for the lamp's %zu vertices", limit);
    for (size_t i = 0; i < scene->shape_count; i++) {
        const struct shape *shape = scene->shapes[i];
        if (shape->mesh.triangle_count) {
            memcpy(list->points + list->count, shape->mesh.positions, shape->mesh.vertex_count * sizeof(vec3));
            list->count += shape->mesh.vertex_count;
            continue;
        }
        for (int y = 0; y < SAMPLE_GRID; y++)
            for (int x = 0; x < SAMPLE_GRID; x++) {
                struct surface surface;
                shape_sample(shape, (vec2){(float)x / (SAMPLE_GRID - 1), (float)y / (SAMPLE_GRID - 1)}, &surface);
                list->points[list->count++] = surface.p;
            }
    }
    for (size_t i = 0; i < scene->emitter_count; i++) { // point lights have no surface
        const struct emitter *emitter = scene->emitters[i];
        struct emission_sample sample;
        if (emitter->flags & EMITTER_DELTA_POSITION &&
            emitter->type->sample_emission(emitter, (vec2){0.5f, 0.5f}, (vec2){0.5f, 0.5f}, &sample))
            list->points[list->count++] = sample.ray.origin;
    }
    if (list->count == 0) return error_set(error, STATUS_INVALID, "%s: the lamp has no surfaces", scene->path);
    return STATUS_OK;
}

static float across2(vec3 p, vec3 c, vec3 axis, vec3 *offset) {
    vec3 d = vec3_sub(p, c);
    *offset = d = vec3_mad(axis, -vec3_dot(d, axis), d);
    return vec3_dot(d, d);
}

// The smallest ball round the points with their component along `axis` (unit, or zero for none) left out. The first
// steps find nearly the centre; the others look only at points that are far from there, and the radius at all again.
static float fit_ball(const struct point_list *list, vec3 axis, vec3 *center) {
    vec3 c = vec3_mad(axis, -vec3_dot(list->points[0], axis), list->points[0]), towards = {0, 0, 0}, d;
    size_t *far = malloc((list->count + 1) * sizeof *far);
    size_t count = list->count;
    bool all = true;
    for (int step = 1; step < BALL_STEPS; step++) {
        float farthest = -1;
        for (size_t i = 0; i < count; i++) {
            float d2 = across2(list->points[all ? i : far[i]], c, axis, &d);
            if (d2 > farthest) {
                farthest = d2;
                towards = d;
            }
        }
        if (step == COARSE_STEPS && far) {
            all = false;
            count = 0;
            for (size_t i = 0; i < list->count; i++)
                if (across2(list->points[i], c, axis, &d) >= sqrf(far_share) * farthest) far[count++] = i;
        }
        c = vec3_mad(towards, 1.0f / (float)(step + 1), c);
    }
    float radius2 = 0;
    for (size_t i = 0; i < list->count; i++) radius2 = fmaxf(radius2, across2(list->points[i], c, axis, &d));
    free(far);
    *center = c;
    return sqrtf(radius2);
}

static void fit_sphere(struct proxy *proxy, const struct point_list *list) {
    vec3 c;
    float radius = fit_ball(list, (vec3){0, 0, 0}, &c);
    *proxy = (struct proxy){.kind = PROXY_SPHERE, .center = {c.x, c.y, c.z}, .radius = radius * widening};
}

static void fit_box(struct proxy *proxy, const struct point_list *list, float least_width) {
    vec3 lower = list->points[0], upper = lower;
    for (size_t i = 1; i < list->count; i++) {
        vec3 p = list->points[i];
        lower = (vec3){fminf(lower.x, p.x), fminf(lower.y, p.y), fminf(lower.z, p.z)};
        upper = (vec3){fmaxf(upper.x, p.x), fmaxf(upper.y, p.y), fmaxf(upper.z, p.z)};
    }
    vec3 center = vec3_scale(vec3_add(lower, upper), 0.5f), half = vec3_scale(vec3_sub(upper, lower), 0.5f * widening);
    half = (vec3){fmaxf(half.x, least_width), fmaxf(half.y, least_width), fmaxf(half.z, least_width)};
    *proxy = (struct proxy){.kind = PROXY_BOX,
                            .center = {center.x, center.y, center.z},
                            .radius = vec3_length(half),
                            .lower = {center.x - half.x, center.y - half.y, center.z - half.z},
                            .upper = {center.x + half.x, center.y + half.y, center.z + half.z}};
}

static void fit_cylinder(struct proxy *proxy, const struct point_list *list, vec3 axis, float least_width) {
    vec3 center;
    float radius = fmaxf(fit_ball(list, axis, &center) * widening, least_width);
    float low = INFINITY, high = -INFINITY;
    for (size_t i = 0; i < list->count; i++) {
        float t = vec3_dot(list->points[i], axis);
        low = fminf(low, t);
        high = fmaxf(high, t);
    }
    center = vec3_mad(axis, 0.5f * (low + high), center);
    float half_height = fmaxf(0.5f * (high - low) * widening, least_width);
    *proxy = (struct proxy){.kind = PROXY_CYLINDER,
                            .center = {center.x, center.y, center.z},
                            .radius = hypotf(radius, half_height),
                            .axis = {axis.x, axis.y, axis.z},
                            .half_height = half_height,
                            .axis_radius = radius};
}

static float proxy_area(const struct proxy *p) {
    if (p->kind == PROXY_SPHERE) return 4 * PI_F * sqrf(p->radius);
    if (p->kind == PROXY_CYLINDER) return 2 * PI_F * p->axis_radius * (p->axis_radius + 2 * p->half_height);
    float x = p->upper[0] - p->lower[0], y = p->upper[1] - p->lower[1], z = p->upper[2] - p->lower[2];
    return 2 * (x * y + y * z + z * x);
}

static void fit_best_cylinder(struct proxy *proxy, const struct point_list *list, float least_width) {
    static const vec3 axes[3] = {{0, 1, 0}, {0, 0, 1}, {1, 0, 0}};
    fit_cylinder(proxy, list, axes[0], least_width);
    for (int i = 1; i < 3; i++) {
        struct proxy other;
        fit_cylinder(&other, list, axes[i], least_width);
        if (proxy_area(&other) < proxy_area(proxy)) *proxy = other;
    }
}

static void fit_auto(struct proxy *proxy, const struct point_list *list) {
    fit_sphere(proxy, list);
    struct proxy others[2];
    float limit = sphere_preference * proxy_area(proxy), least_width = 0.01f * proxy->radius;
    fit_box(&others[0], list, least_width);
    fit_best_cylinder(&others[1], list, least_width);
    for (int i = 0; i < 2; i++)
        if (proxy_area(&others[i]) < limit) {
            limit = proxy_area(&others[i]);
            *proxy = others[i];
        }
}

// How many triangles a ray from p crosses (Moeller and Trumbore 1997).
static size_t count_crossings(const struct proxy *proxy, vec3 p, vec3 direction) {
    size_t count = 0;
    for (size_t t = 0; t < proxy->triangle_count; t++) {
        vec3 v[3];
        for (int i = 0; i < 3; i++) {
            const float *q = proxy->vertices[proxy->indices[3 * t + (size_t)i]];
            v[i] = (vec3){q[0], q[1], q[2]};
        }
        vec3 e1 = vec3_sub(v[1], v[0]), e2 = vec3_sub(v[2], v[0]), h = vec3_cross(direction, e2);
        float det = vec3_dot(e1, h);
        if (det == 0) continue;
        vec3 s = vec3_sub(p, v[0]), q = vec3_cross(s, e1);
        float a = vec3_dot(s, h) / det, b = vec3_dot(direction, q) / det;
        count += a >= 0 && b >= 0 && a + b <= 1 && vec3_dot(e2, q) / det > 0;
    }
    return count;
}

// By the majority of three rays, because one may graze an edge.
static bool mesh_contains(const struct proxy *proxy, vec3 p) {
    static const vec3 directions[3] = {{0.48f, 0.64f, 0.6f}, {-0.6f, 0.48f, 0.64f}, {0.28f, -0.96f, 0.0f}};
    int inside = 0;
    for (int i = 0; i < 3; i++) inside += (int)(count_crossings(proxy, p, directions[i]) & 1);
    return inside >= 2;
}

static enum status load_mesh_proxy(struct proxy *proxy, const struct point_list *list, const char *path,
                                   struct arena *arena, struct error *error) {
    if (!path) return error_set(error, STATUS_INVALID, "the proxy mesh's file is not given");
    struct mesh mesh;
    size_t length = strlen(path);
    enum status status = length > 4 && strcmp(path + length - 4, ".ply") == 0
                             ? mesh_load_ply(&mesh, arena, path, error)
                             : mesh_load_obj(&mesh, arena, path, error);
    if (status != STATUS_OK) return status;
    size_t open = mesh_open_edges(&mesh);
    if (open == SIZE_MAX) return error_set(error, STATUS_MEMORY, "out of memory while checking %s", path);
    if (open > 0)
        return error_set(error, STATUS_INVALID,
                         "%s: the proxy mesh is open (%zu edges belong to one triangle only); close it", path, open);
    *proxy = (struct proxy){.kind = PROXY_MESH,
                            .vertex_count = mesh.vertex_count,
                            .triangle_count = mesh.triangle_count,
                            .vertices = arena_alloc(arena, mesh.vertex_count, sizeof(float[3])),
                            .indices = mesh.indices};
    if (!proxy->vertices) return error_set(error, STATUS_MEMORY, "out of memory for %s", path);
    double volume = 0;
    for (size_t i = 0; i < mesh.vertex_count; i++) memcpy(proxy->vertices[i], &mesh.positions[i], sizeof(float[3]));
    for (size_t t = 0; t < mesh.triangle_count; t++) {
        const uint32_t *v = mesh.indices + 3 * t;
        vec3 a = vec3_sub(mesh.positions[v[0]], list->points[0]), b = vec3_sub(mesh.positions[v[1]], list->points[0]);
        volume += (double)vec3_dot(a, vec3_cross(b, vec3_sub(mesh.positions[v[2]], list->points[0])));
    }
    for (size_t t = 0; volume < 0 && t < mesh.triangle_count; t++) {
        uint32_t *v = proxy->indices + 3 * t, first = v[0];
        v[0] = v[1];
        v[1] = first;
    }
    vec3 center;
    proxy->radius =
        1.001f * fit_ball(&(struct point_list){mesh.positions, mesh.vertex_count}, (vec3){0, 0, 0}, &center);
    memcpy(proxy->center, &center, sizeof proxy->center);
    for (size_t i = 0; i < list->count; i++)
        if (!mesh_contains(proxy, list->points[i])) {
            vec3 p = list->points[i];
            return error_set(error, STATUS_INVALID,
                             "%s: the proxy cuts the lamp: the lamp's point (%g, %g, %g) is outside; make the proxy "
                             "larger, or leave it to --proxy auto",
                             path, (double)p.x, (double)p.y, (double)p.z);
        }
    return STATUS_OK;
}

enum status lamp_proxy_fit(struct proxy *proxy, const struct scene *scene, enum bake_proxy kind, const char *path,
                           struct arena *arena, struct error *error) {
    struct point_list list;
    enum status status = collect_points(&list, scene, error);
    if (status == STATUS_OK) {
        struct proxy sphere;
        fit_sphere(&sphere, &list);
        float least_width = 0.01f * sphere.radius;
        if (kind == BAKE_PROXY_AUTO) fit_auto(proxy, &list);
        if (kind == BAKE_PROXY_SPHERE) *proxy = sphere;
        if (kind == BAKE_PROXY_BOX) fit_box(proxy, &list, least_width);
        if (kind == BAKE_PROXY_CYLINDER) fit_best_cylinder(proxy, &list, least_width);
        if (kind == BAKE_PROXY_MESH) status = load_mesh_proxy(proxy, &list, path, arena, error);
    }
    free(list.points);
    if (status == STATUS_OK && !(proxy->radius > 0 && isfinite(proxy->radius)))
        return error_set(error, STATUS_INVALID, "%s: the lamp has no extent", scene->path);
    return status;
}

const char *proxy_kind_name(enum proxy_kind kind) {
    static const char *const names[] = {"sphere", "box", "cylinder", "mesh"};
    return names[kind];
}
