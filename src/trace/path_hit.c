// Path tracer: light that the ray meets at its end, from a surface or the environment; then the path goes on through
// the surface, becomes ready to scatter, or is done.
// Emitters of kept lamp geometry are dark, for their light is in the lamp's L, except to paths that are live in the
// lamp: a ray that looks at a lamp with appearance=geometry makes its path live until it reaches a surface of the room.
#include "trace/path_state.h"

static int live_at_surface(const struct path_tracer *tracer, const struct path *path) {
    int i = path->surface.shape->luminaire;
    if (i < 0) return -1;
    bool looks = path->look && tracer->scene->luminaires[i].appearance == APPEARANCE_GEOMETRY;
    return looks || path->vertex.live == i ? i : -1;
}

static bool shows_emitters(const struct path_tracer *tracer, const struct path *path) {
    return !(tracer->scene->hide_emitters && path->depth == 0);
}

static void meet_environment(const struct path_tracer *tracer, struct path_worker *worker, struct path *path) {
    const struct emitter *environment = tracer->scene->environment;
    if (!environment || !shows_emitters(tracer, path)) return;
    rgb radiance = environment->type->eval(environment, NULL, vec3_neg(path->ray.direction));
    float pdf_light = 0;
    if (path->pdf > 0)
        pdf_light = environment->type->pdf_light(environment, path->vertex.p, NULL, path->ray.direction) *
                    light_select_pmf_emitter(tracer->lights, &path->vertex, environment);
    path_add(worker, path, rgb_scale(rgb_mul(path->beta, radiance), path_hit_weight(tracer, path, pdf_light)));
}

static void meet_emitter(const struct path_tracer *tracer, struct path_worker *worker, struct path *path, int live) {
    const struct shape *shape = path->surface.shape;
    const struct emitter *emitter = shape->emitter;
    if (!emitter || !shows_emitters(tracer, path) || (shape->luminaire >= 0 && live != shape->luminaire)) return;
    rgb radiance = surface_emission(&path->surface, vec3_neg(path->ray.direction));
    if (rgb_is_black(radiance)) return;
    float pdf_light = 0;
    if (path->pdf > 0)
        pdf_light = emitter->type->pdf_light(emitter, path->vertex.p, &path->surface, path->ray.direction) *
                    light_select_pmf_emitter(tracer->lights, &path->vertex, emitter);
    const rgb contribution = rgb_scale(rgb_mul(path->beta, radiance), path_hit_weight(tracer, path, pdf_light));
    path_record_lamp(path, contribution, path->surface.t);
    path_add(worker, path, contribution);
}

void path_hit(const struct path_tracer *tracer, struct path_worker *worker) {
    for (size_t i = 0; i < worker->active_count; i++) {
        struct path *path = &worker->paths[worker->active[i]];
        if (path->status == PATH_DONE) continue;
        if (path->status == PATH_MISSES) {
            meet_environment(tracer, worker, path);
            path->status = PATH_DONE;
            continue;
        }
        path->beta = rgb_mul(path->beta, segment_absorption(path->has_from ? &path->from : NULL, &path->surface,
                                                            path->ray.direction, path->surface.t));
        path->unfolded += path->surface.t;
        int live = live_at_surface(tracer, path);
        meet_emitter(tracer, worker, path, live);
        path_record_hit(path);
        if (path->status == PATH_PASSES) continue;
        path->vertex = (struct light_point){path->surface.p, path->surface.shape->luminaire, live};
        if (!path_may_scatter(tracer, path) || rgb_is_black(path->beta)) path->status = PATH_DONE;
    }
}
