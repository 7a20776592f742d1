// Path tracer: the nearest surface on every ray, and whether the path scatters there or goes straight on through it.
// The memory is asked for triangles and vertices some paths before they are needed.
#include "trace/path_state.h"

enum { AHEAD = 8 }; // paths

static struct lamp_view view_of(const struct path *path) {
    return (struct lamp_view){path->look, path->vertex.live, -1};
}

// Not with hidden geometry: the hits then stay as they are made, empty.
static void trace_all(const struct path_tracer *tracer, struct path_worker *worker) {
    for (size_t i = 0; i < worker->active_count; i++) {
        const struct path *path = &worker->paths[worker->active[i]];
        const struct lamp_view view = view_of(path);
        struct scene_hit *hit = &worker->hits[i];
        *hit = scene_trace(tracer->scene, &path->ray, view.ignore);
        if (hit->shape && hit->shape->mesh.triangle_count) shape_fetch_triangle(hit->shape, hit->primitive);
    }
}

static void fetch_vertices(const struct path_worker *worker, size_t i) {
    if (i >= worker->active_count) return;
    const struct scene_hit *hit = &worker->hits[i];
    if (hit->shape && hit->shape->mesh.triangle_count) shape_fetch_vertices(hit->shape, hit->primitive);
}

// Among the scene's surfaces.
static bool intersect_scene(const struct path_tracer *tracer, struct path *path, const struct scene_hit *hit) {
    if (!tracer->hidden) {
        if (hit->shape) scene_fill(&path->ray, hit, &path->surface);
        return hit->shape;
    }
    const struct lamp_view view = view_of(path);
    return lamp_view_intersect(tracer->scene, true, &view, &path->ray, &path->surface);
}

// The nearer of the scene's surfaces and, for a ray that looks at lamps, their hulls.
static bool intersect(const struct path_tracer *tracer, struct path *path, const struct scene_hit *hit) {
    bool found = intersect_scene(tracer, path, hit);
    if (!path->look || !tracer->scene->hull_count) return found;
    struct ray ray = path->ray;
    if (found) ray.t_max = path->surface.t;
    return scene_intersect_hulls(tracer->scene, &ray, path->through, &path->surface) || found;
}

void path_intersect(const struct path_tracer *tracer, struct path_worker *worker) {
    if (!tracer->hidden) trace_all(tracer, worker);
    for (size_t i = 0; i < AHEAD; i++) fetch_vertices(worker, i);
    for (size_t i = 0; i < worker->active_count; i++) {
        struct path *path = &worker->paths[worker->active[i]];
        fetch_vertices(worker, i + AHEAD);
        if (!intersect(tracer, path, &worker->hits[i])) {
            path->status = PATH_MISSES;
            continue;
        }
        bsdf_fetch(path->surface.shape->bsdf, path->surface.uv);
        path->fork = fork_none();
        if (surface_bsdf_flags(&path->surface) & BSDF_NULL) {
            struct sampler sampler = path_sampler(path, PATH_DIMENSION_FORK);
            path->fork = fork_choose(&path->surface, vec3_neg(path->ray.direction), sampler_1d(&sampler));
        }
        path->status = path->fork.passes ? PATH_PASSES : PATH_SCATTERS;
    }
}
