// Path tracer: light samples for every path that stands on a surface with a smooth part (next-event estimation): one
// or, where the camera looks, as many as path_light_count.c says. Those of baked lamps are drawn in one batch for each
// lamp; their light field is asked when it is known which arrive.
#include "trace/path_state.h"

static void shadow_add(struct path_worker *worker, uint32_t index, uint32_t luminaire, const struct ray *ray,
                       rgb contribution, float pdf_bsdf) {
    worker->shadows[worker->shadow_count++] = (struct shadow){index,
                                                              luminaire,
                                                              *ray,
                                                              contribution,
                                                              worker->paths[index].surface.p,
                                                              ray->direction,
                                                              path_pdf_is_sharp(pdf_bsdf)};
}

rgb path_response(const struct path *path, vec3 direction, float *pdf_bsdf) {
    vec3 wi = vec3_neg(path->ray.direction);
    rgb f = surface_eval_pdf_bsdf(&path->surface, wi, direction, pdf_bsdf);
    if (rgb_is_black(f)) return f;
    return rgb_scale(rgb_mul(path->beta, f), path->fork.inverse_share);
}

static void sample_emitter(const struct path_tracer *tracer, struct path_worker *worker, uint32_t index,
                           const struct light_choice *choice, int number) {
    struct path *path = &worker->paths[index];
    const struct emitter *emitter = choice->emitter;
    struct sampler sampler = path_light_sampler(path, PATH_DIMENSION_LIGHT, number);
    struct light_sample light;
    if (!emitter->type->sample_light(emitter, path->surface.p, sampler_2d(&sampler), &light) || !(light.pdf_sa > 0))
        return;
    if (rgb_is_black(light.radiance)) return;
    float pdf_bsdf, pdf_light = light.pdf_sa * choice->pmf;
    rgb response = path_response(path, light.direction, &pdf_bsdf);
    if (rgb_is_black(response)) return;
    bool delta = emitter->flags & (EMITTER_DELTA_POSITION | EMITTER_DELTA_DIRECTION);
    float weight = path_light_weight(tracer, pdf_light, pdf_bsdf, delta);
    if (weight == 0) return;
    struct ray ray;
    if (isfinite(light.distance)) {
        float distance;
        ray = surface_spawn_segment(&path->surface, vec3_mad(light.direction, light.distance, path->surface.p),
                                    &distance);
        const struct surface *end = emitter->shape ? &light.surface : NULL;
        response = rgb_mul(response, segment_absorption(&path->surface, end, light.direction, light.distance));
    } else {
        ray = surface_spawn_ray(&path->surface, light.direction);
    }
    shadow_add(worker, index, UINT32_MAX, &ray, rgb_scale(rgb_mul(response, light.radiance), weight / pdf_light),
               pdf_bsdf);
}

static void sample_direct(const struct path_tracer *tracer, struct path_worker *worker,
                          const struct luminaire_request *request, vec3 direction, float pdf_light) {
    const struct path *path = &worker->paths[request->path];
    float pdf_bsdf, t_mid;
    rgb response = path_response(path, direction, &pdf_bsdf);
    if (rgb_is_black(response)) return;
    float weight = path_light_weight(tracer, pdf_light, pdf_bsdf, false);
    if (weight == 0) return;
    struct ray line = {path->surface.p, direction, 0, INFINITY};
    if (!crossing_find(&tracer->scene->luminaires[request->luminaire], &line, &t_mid)) return;
    struct ray ray = surface_spawn_ray(&path->surface, direction);
    ray.t_max = t_mid;
    response = rgb_mul(response, segment_absorption(&path->surface, NULL, direction, t_mid));
    shadow_add(worker, request->path, request->luminaire, &ray, rgb_scale(response, weight / pdf_light), pdf_bsdf);
}

// The samples of one lamp: draw directions, leave the shadow rays where the surface responds.
static void sample_luminaire(const struct path_tracer *tracer, struct path_worker *worker, uint32_t luminaire,
                             const struct luminaire_request *requests, size_t count) {
    const struct luminaire_instance *instance = &tracer->scene->luminaires[luminaire];
    for (size_t i = 0; i < count; i++) {
        const struct path *path = &worker->paths[requests[i].path];
        const struct mirror *mirror = requests[i].mirror;
        const vec3 from = mirror ? mirror_image(mirror, path->surface.p) : path->surface.p;
        const int number = requests[i].number;
        struct sampler sampler =
            path_light_sampler(path, mirror ? PATH_DIMENSION_MIRROR + 1 : PATH_DIMENSION_LIGHT, number);
        struct sampler third =
            path_light_sampler(path, mirror ? PATH_DIMENSION_MIRROR + 2 : PATH_DIMENSION_LIGHT_THIRD, number);
        lamp_draws_ask(&worker->draws, i, instance, from, sampler_2d(&sampler), sampler_1d(&third));
    }
    lamp_draws_answer(&worker->draws, count, instance);
    if (tracer->residual) {
        path_light_residual(tracer, worker, luminaire, requests, count);
        return;
    }
    for (size_t i = 0; i < count; i++) {
        const float pdf_light = worker->draws.pdfs[i] * requests[i].pmf;
        const vec3 direction = lamp_draws_direction(&worker->draws, i, instance);
        if (!(pdf_light > 0)) continue;
        if (requests[i].mirror)
            path_mirror_sample(tracer, worker, &requests[i], direction, pdf_light);
        else
            sample_direct(tracer, worker, &requests[i], direction, pdf_light);
    }
}

// A light of the room: samples an emitter at once, leaves a request for a lamp.
static void choose_light(const struct path_tracer *tracer, struct path_worker *worker, uint32_t index, int number) {
    const struct path *path = &worker->paths[index];
    struct sampler sampler = path_light_sampler(path, PATH_DIMENSION_LIGHT_CHOICE, number);
    struct light_choice choice;
    if (!light_select_sample(tracer->lights, &path->vertex, sampler_1d(&sampler), &choice)) return;
    choice.pmf *= (float)path_light_count(path);
    if (choice.emitter)
        sample_emitter(tracer, worker, index, &choice, number);
    else if (tracer->strategy != PATH_BSDF_ONLY)
        worker->requests[worker->request_count++] =
            (struct luminaire_request){index, choice.luminaire, NULL, choice.pmf, number};
}

void path_light(const struct path_tracer *tracer, struct path_worker *worker) {
    worker->shadow_count = worker->request_count = 0;
    for (size_t i = 0; i < worker->active_count; i++) {
        const uint32_t index = worker->active[i];
        const struct path *path = &worker->paths[index];
        if (path->cached || path->status != PATH_SCATTERS || !(surface_bsdf_flags(&path->surface) & BSDF_SMOOTH))
            continue;
        const int count = path_light_count(path);
        for (int number = 0; number < count; number++) choose_light(tracer, worker, index, number);
        if (path_samples_mirrors(tracer, path))
            worker->requests[worker->request_count++] = path_mirror_request(tracer, path, index);
    }
    // Requests of one lamp to the front, lamp after lamp: lamps are few.
    for (size_t first = 0, n; first < worker->request_count; first += n) {
        uint32_t luminaire = worker->requests[first].luminaire;
        n = 1;
        for (size_t i = first + 1; i < worker->request_count; i++) {
            if (worker->requests[i].luminaire != luminaire) continue;
            struct luminaire_request request = worker->requests[i];
            worker->requests[i] = worker->requests[first + n];
            worker->requests[first + n++] = request;
        }
        sample_luminaire(tracer, worker, luminaire, worker->requests + first, n);
    }
}
