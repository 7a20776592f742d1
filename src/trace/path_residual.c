// Path tracer, unbiased (residual.h): light of baked lamps that a ray meets by chance, in place of path_luminaire.c,
// and by light samples. A ray brings a lamp's own light only where the first surface on it that stops it, or the first
// of several that do not, is of that lamp; elsewhere the model is not asked.
#include "trace/path_state.h"

static uint32_t draw_of(const struct path *path, bool light_sample) { return 2 * path->edge + light_sample; }

static int depth_left(const struct path_tracer *tracer, int edges) {
    return tracer->scene->max_depth < 0 ? -1 : tracer->scene->max_depth - edges;
}

// Light along a line that is not near, which the particles of caustic.h bring to the camera's first vertex if that
// scatters by no delta.
static bool is_for_particles(const struct path_tracer *tracer, const struct path *path, bool light_sample,
                             int luminaire, vec3 direction) {
    bool found = path->may_be_caustic || (light_sample && path->depth == 0);
    return tracer->caustic && found && !residual_line_is_near(tracer->residual, luminaire, path->vertex.p, direction);
}

static void add_crossing(const struct path_tracer *tracer, struct path_worker *worker, uint32_t index) {
    const struct path *path = &worker->paths[index];
    struct line_walk *walk = &worker->walks[worker->crossings.count];
    int luminaire = walk->luminaire;
    walk->particles_too = tracer->caustic && path->depth == 0;
    struct crossing *crossing = crossing_add(&worker->crossings, index, (uint32_t)luminaire, &path->ray, 0);
    crossing->viewpoint = path->vertex.p;
    crossing->wants_radiance = true;
    crossing->wants_pdf = path->pdf > 0 && tracer->strategy != PATH_BSDF_ONLY;
}

static void find_crossings(const struct path_tracer *tracer, struct path_worker *worker, uint32_t index) {
    const struct path *path = &worker->paths[index];
    if (path->status == PATH_MISSES || path->passed || path_is_caustic(tracer, path)) return;
    const struct surface *from = path->has_from ? &path->from : NULL;
    if (!(surface_bsdf_flags(&path->surface) & BSDF_NULL)) {
        int i = path->surface.shape->luminaire;
        if (i < 0 || i == path->vertex.kept || is_for_particles(tracer, path, false, i, path->ray.direction)) return;
        line_walk_begin_at(&worker->walks[worker->crossings.count], tracer->scene, &path->ray, from, &path->surface);
        add_crossing(tracer, worker, index);
        return;
    }
    for (int i = 0; i < (int)tracer->scene->luminaire_count; i++)
        if (i != path->vertex.kept && !is_for_particles(tracer, path, false, i, path->ray.direction) &&
            line_walk_begin(&worker->walks[worker->crossings.count], tracer->scene, i, &path->ray, from))
            add_crossing(tracer, worker, index);
}

void path_luminaire_residual(const struct path_tracer *tracer, struct path_worker *worker) {
    size_t lines = crossing_batch_lines(&worker->crossings);
    for (size_t first = 0; first < worker->active_count; first += lines) {
        worker->crossings.count = 0;
        for (size_t i = first; i < worker->active_count && i - first < lines; i++)
            find_crossings(tracer, worker, worker->active[i]);
        crossing_batch_answer(&worker->crossings, tracer->scene);
        for (size_t i = 0; i < worker->crossings.count; i++) {
            const struct crossing *crossing = &worker->crossings.crossings[i];
            struct path *path = &worker->paths[crossing->item];
            float weight = path_crossing_weight(tracer, path, crossing);
            if (weight == 0) continue;
            rgb radiance = residual_correct(tracer->residual, &worker->walks[i], crossing->radiance, path->look,
                                            path->sampler, draw_of(path, false), depth_left(tracer, path->depth));
            path_add(worker, path, rgb_scale(rgb_mul(path->beta, radiance), weight));
        }
    }
}

void path_light_residual(const struct path_tracer *tracer, struct path_worker *worker, uint32_t luminaire,
                         const struct luminaire_request *requests, size_t count) {
    const struct luminaire_instance *instance = &tracer->scene->luminaires[luminaire];
    struct crossing_batch *batch = &worker->crossings;
    size_t lines = crossing_batch_lines(batch);
    for (size_t first = 0; first < count; first += lines) {
        batch->count = 0;
        for (size_t i = first; i < count && i - first < lines; i++) {
            const struct path *path = &worker->paths[requests[i].path];
            const vec3 direction = lamp_draws_direction(&worker->draws, i, instance);
            float pdf_bsdf, pdf_light = worker->draws.pdfs[i] * requests[i].pmf;
            if (!(pdf_light > 0) || is_for_particles(tracer, path, true, (int)luminaire, direction)) continue;
            rgb response = path_response(path, direction, &pdf_bsdf);
            if (rgb_is_black(response)) continue;
            float weight = path_light_weight(tracer, pdf_light, pdf_bsdf, false);
            struct ray ray = surface_spawn_ray(&path->surface, direction);
            if (weight == 0 ||
                !line_walk_begin(&worker->walks[batch->count], tracer->scene, (int)luminaire, &ray, &path->surface))
                continue;
            worker->responses[batch->count] = rgb_scale(response, weight / pdf_light);
            struct crossing *crossing = crossing_add(batch, requests[i].path, luminaire, &ray, 0);
            crossing->viewpoint = path->surface.p;
            crossing->wants_radiance = true;
        }
        crossing_batch_answer(batch, tracer->scene);
        for (size_t i = 0; i < batch->count; i++) {
            struct path *path = &worker->paths[batch->crossings[i].item];
            rgb radiance = residual_correct(tracer->residual, &worker->walks[i], batch->crossings[i].radiance, false,
                                            path->sampler, draw_of(path, true), depth_left(tracer, path->depth + 1));
            path_add(worker, path, rgb_mul(worker->responses[i], radiance));
        }
    }
}
