// Path tracer: the nearest surface on every ray, and whether the path scatters there or goes straight on through it.
#include "trace/path_state.h"

// The nearer of the scene's surfaces and, for a ray that looks at lamps, their hulls.
static bool intersect(const struct path_tracer *tracer, struct path *path) {
    struct lamp_view view = {path->look, path->vertex.live, -1};
    bool hit = lamp_view_intersect(tracer->scene, tracer->hidden, &view, &path->ray, &path->surface);
    if (!path->look || !tracer->scene->hull_count) return hit;
    struct ray ray = path->ray;
    if (hit) ray.t_max = path->surface.t;
    return scene_intersect_hulls(tracer->scene, &ray, path->through, &path->surface) || hit;
}

void path_intersect(const struct path_tracer *tracer, struct path_worker *worker) {
    for (size_t i = 0; i < worker->active_count; i++) {
        struct path *path = &worker->paths[worker->active[i]];
        if (!intersect(tracer, path)) {
            path->status = PATH_MISSES;
            continue;
        }
        path->fork = fork_none();
        if (surface_bsdf_flags(&path->surface) & BSDF_NULL) {
            struct sampler sampler = path_sampler(path, PATH_DIMENSION_FORK);
            path->fork = fork_choose(&path->surface, vec3_neg(path->ray.direction), sampler_1d(&sampler));
        }
        path->status = path->fork.passes ? PATH_PASSES : PATH_SCATTERS;
    }
}
