// Path tracer, last stage of a bounce: a new direction from the BSDF, Russian roulette, and the list of paths that go
// on. Roulette is played with beta * eta^2: radiance is compressed inside a refracting body and expands again when it
// leaves, so beta alone would end paths there that matter (van Antwerpen 2011, in the form Mitsuba has it).
// path_roulette.c has the probability.
#include "trace/path_state.h"

static const float least_survival_of_tellers = 0.25f; // for they tell of more than their pixel

static bool path_play_roulette(const struct path_tracer *tracer, struct path *path, float incoming) {
    float survival = path_survival(tracer, path, incoming);
    if (path->mark_count) survival = maxf(survival, least_survival_of_tellers);
    if (survival >= 1) return true;
    struct sampler sampler = path_sampler(path, PATH_DIMENSION_ROULETTE);
    if (sampler_1d(&sampler) >= survival) return false;
    path->beta = rgb_scale(path->beta, 1 / survival);
    return true;
}

static bool path_bounce(const struct path_tracer *tracer, struct path_worker *worker, struct path *path,
                        vec3 *direction) {
    struct bsdf_sample sample;
    float incoming;
    if (!path_scatter_sample(tracer, path, &sample, &incoming)) return false;
    path_share_scatter(tracer, path, &sample);
    if (!path_cache_scatter(tracer, path, &sample)) return false;
    path->beta = rgb_mul(path->beta, sample.weight);
    if (!rgb_is_finite(path->beta)) {
        worker->dropped++;
        return false;
    }
    path->eta *= sample.eta;
    path_mirror_scatter(tracer, path, &sample);
    path->pdf = sample.delta ? 0 : sample.pdf;
    path->light_count = (float)path_light_count(path);
    path->look = path->look && sample.delta;
    path->through = -1;
    if (path->depth == 0) path->may_be_caustic = !sample.delta && path->vertex.live < 0;
    if (!sample.delta) path->from_sheet = path_is_at_sheet(tracer, path);
    if (path->from_sheet) path->may_be_caustic = false; // for no particle meets a sheet
    path->depth++;
    *direction = sample.wo;
    if (rgb_is_black(path->beta) || !path_play_roulette(tracer, path, incoming)) return false;
    path_record_scatter(tracer, path, &sample);
    return true;
}

void path_scatter(const struct path_tracer *tracer, struct path_worker *worker) {
    size_t kept = 0;
    for (size_t i = 0; i < worker->active_count; i++) {
        struct path *path = &worker->paths[worker->active[i]];
        vec3 direction = path->ray.direction;
        switch (path->status) {
        case PATH_SCATTERS:
            if (!path_bounce(tracer, worker, path, &direction)) continue;
            path->passed = false;
            break;
        case PATH_PASSES:
            path->beta = rgb_mul(path->beta, path->fork.weight);
            if (rgb_is_black(path->beta)) continue;
            path->passed = true;
            break;
        default:
            continue;
        }
        path->ray = surface_spawn_ray(&path->surface, direction);
        path->from = path->surface;
        path->has_from = true;
        path->edge++;
        worker->active[kept++] = worker->active[i];
    }
    worker->active_count = kept;
}
