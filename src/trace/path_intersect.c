// Path tracer: the nearest surface on every ray, and whether the path scatters there or goes straight on through it.
#include "trace/path_state.h"

void path_intersect(const struct path_tracer *tracer, struct path_worker *worker) {
    for (size_t i = 0; i < worker->active_count; i++) {
        struct path *path = &worker->paths[worker->active[i]];
        struct lamp_view view = {path->look, path->vertex.live, -1};
        if (!lamp_view_intersect(tracer->scene, tracer->hidden, &view, &path->ray, &path->surface)) {
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
