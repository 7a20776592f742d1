// Path tracer: what of each light sample arrives, in two stages. Surfaces block or attenuate; then, of what is left,
// baked lamps are asked: the sampled one how much it sends, those in front of the light how much they let through.
// A sample of a baked lamp is blocked by nothing of that lamp's own kept geometry, up to the event on its chord.
#include "trace/path_state.h"

static bool shadow_is_lit(const struct path_tracer *tracer, const struct path_worker *worker, struct shadow *shadow) {
    const struct path *path = &worker->paths[shadow->path];
    int ignore = shadow->luminaire == UINT32_MAX ? -1 : (int)shadow->luminaire;
    struct lamp_view view = {false, path->vertex.live, ignore};
    rgb visibility = lamp_view_visibility(tracer->scene, tracer->hidden, &view, &shadow->ray);
    shadow->contribution = rgb_mul(shadow->contribution, visibility);
    return !rgb_is_black(shadow->contribution);
}

void path_shadow(const struct path_tracer *tracer, struct path_worker *worker) {
    size_t lit = 0;
    for (size_t i = 0; i < worker->shadow_count; i++)
        if (shadow_is_lit(tracer, worker, &worker->shadows[i])) worker->shadows[lit++] = worker->shadows[i];
    worker->shadow_count = lit;
}

// The sampled lamp's own radiance, on its line from the surface itself, and the transparencies of the others.
static void find_crossings(const struct path_tracer *tracer, struct path_worker *worker, uint32_t index) {
    const struct shadow *shadow = &worker->shadows[index];
    const struct path *path = &worker->paths[shadow->path];
    for (size_t i = 0; i < tracer->scene->luminaire_count; i++) {
        const struct luminaire_instance *instance = &tracer->scene->luminaires[i];
        float t_mid;
        if (i == shadow->luminaire) {
            struct crossing *own =
                crossing_add(&worker->crossings, index, (uint32_t)i, &shadow->ray, shadow->ray.t_max);
            own->viewpoint = shadow->viewpoint;
            own->wants_radiance = true;
            continue;
        }
        if ((int)i == path->vertex.kept || instance->keep == KEEP_ALL) continue;
        if (!crossing_find(instance, &shadow->ray, &t_mid) || t_mid >= shadow->ray.t_max) continue;
        crossing_add(&worker->crossings, index, (uint32_t)i, &shadow->ray, t_mid)->wants_transmittance = true;
    }
}

void path_arrive(const struct path_tracer *tracer, struct path_worker *worker) {
    size_t count = worker->shadow_count;
    size_t lines = tracer->scene->luminaire_count ? crossing_batch_lines(&worker->crossings) : SIZE_MAX;
    for (size_t first = 0, n; tracer->scene->luminaire_count && first < count; first += n) {
        n = count - first < lines ? count - first : lines;
        worker->crossings.count = 0;
        for (size_t i = first; i < first + n; i++) find_crossings(tracer, worker, (uint32_t)i);
        crossing_batch_answer(&worker->crossings, tracer->scene);
        for (size_t i = 0; i < worker->crossings.count; i++) {
            const struct crossing *crossing = &worker->crossings.crossings[i];
            struct shadow *shadow = &worker->shadows[crossing->item];
            rgb factor = crossing->wants_radiance ? crossing->radiance : crossing->transmittance;
            shadow->contribution = rgb_mul(shadow->contribution, factor);
        }
    }
    for (size_t i = 0; i < count; i++) {
        const struct shadow *shadow = &worker->shadows[i];
        struct path *path = &worker->paths[shadow->path];
        if (shadow->sharp) path_record_lamp(path, shadow->contribution, shadow->ray.t_max);
        path_share_light(tracer, path, shadow->contribution, shadow->direction);
        path_add(worker, path, shadow->contribution);
    }
}
