// Path tracer: the cache of radiance. A path that reaches a broadly scattering surface after it has been spread widely
// by an earlier one ends there, with the mean of what other paths found to arrive in its place; only what the surface
// reflects like a mirror is followed on. Some paths, all of them at first, go on instead and tell the cache what they
// find: at the first such surface, and while little is known at later ones. The picture gets the mean from them too,
// where it is known already.
// What is shared is seen by way of a broad scattering only, so that a cell's width is lost in the footprint of the
// path, which has to be wider. The footprint is estimated as by Mueller et al. 2021 ("Real-time Neural Radiance Caching
// for Path Tracing").
#include "trace/path_state.h"

static const float least_broadness = 0.8f; // of a surface whose response to the mean is taken for that to the light
static const float footprint_cells = 4; // a footprint is wider than this number of cells
static const float least_response = 0.01f; // of a channel, relative to the strongest: what is told is divided by it
// Of a path that tells. What lighter ones find is divided by as little, and those that roulette leaves find a thousand
// times what is usual.
static const float least_weight = 0.02f;
static const float least_told = 0.125f; // share of the paths

void path_cache_learn(struct path_tracer *tracer) {
    if (!tracer->cache) return;
    radiance_cache_learn(tracer->cache);
    const float pixels = (float)tracer->film->width * (float)tracer->film->height;
    tracer->tellers = minf(maxf(1 / (float)(tracer->pass + 1), least_told), CACHE_TELLERS / pixels);
}

static bool tells(const struct path_tracer *tracer, const struct path *path) {
    const uint64_t hash = sampler_mix(sampler_mix(tracer->pass) + path->pixel);
    return sampler_float_from_bits((uint32_t)hash) < tracer->tellers;
}

// The width over which the path may have met the surface, were its random numbers others.
static void path_spread(struct path *path) {
    if (!(path->pdf_spread > 0)) return;
    const float cosine = fabsf(vec3_dot(path->surface.ng, path->ray.direction));
    path->spread += path->unfolded / sqrtf(path->pdf_spread * maxf(cosine, 1e-3f));
    path->pdf_spread = 0;
}

static struct cache_place place_of(const struct path_tracer *tracer, const struct path *path) {
    const struct surface *surface = &path->surface;
    const bool inside = vec3_dot(surface->ng, path->ray.direction) > 0;
    return (struct cache_place){.p = surface->p,
                                .n = inside ? vec3_neg(surface->shading.n) : surface->shading.n,
                                .width = path->spread / footprint_cells,
                                .shape = surface->shape->index,
                                .kind = tracer->caustic && path->may_be_caustic};
}

static void end_or_mark(const struct path_tracer *tracer, struct path_worker *worker, struct path *path) {
    const struct cache_place place = place_of(tracer, path);
    float pdf;
    const rgb response = rgb_scale(path_response(path, place.n, &pdf), PI_F);
    const bool teller = tells(tracer, path), mirrors = surface_bsdf_flags(&path->surface) & BSDF_DELTA;
    rgb mean;
    const bool known = radiance_cache_mean(tracer->cache, &place, &mean);
    if (known && (!teller || path->mark_count)) {
        path_add(worker, path, rgb_mul(response, mean));
        path->cached = true;
        if (!mirrors) path->status = PATH_DONE;
        return;
    }
    if (known && !mirrors) {
        path->shows = true;
        path->shown = rgb_add(path->radiance, rgb_mul(response, mean));
    }
    const float least = minf(response.r, minf(response.g, response.b)), most = rgb_max(response);
    if (!teller || path->mark_count == CACHE_TOLD || !(least > least_response * most && most > least_weight)) return;
    struct path_mark *mark = &path->marks[path->mark_count];
    if (!radiance_cache_cells(tracer->cache, &place, &mark->cells)) return;
    mark->before = path->radiance;
    mark->response = response;
    path->mark_count++;
    path->marked = true;
}

void path_cache(const struct path_tracer *tracer, struct path_worker *worker) {
    if (!tracer->cache) return;
    for (size_t i = 0; i < worker->active_count; i++) {
        struct path *path = &worker->paths[worker->active[i]];
        path->cached = path->marked = false;
        if (path->status != PATH_SCATTERS) continue;
        path_spread(path);
        if (!(path->spread > 0) || path->vertex.live >= 0 || path->vertex.kept >= 0) continue;
        if (path_lobes_at(tracer, &path->surface).broadness >= least_broadness) end_or_mark(tracer, worker, path);
    }
}

static void settle(const struct path_tracer *tracer, const struct path *path, const struct path_mark *mark) {
    const rgb gain = rgb_sub(path->radiance, mark->before), response = mark->response;
    const rgb incoming = {gain.r / response.r, gain.g / response.g, gain.b / response.b};
    if (rgb_is_finite(incoming)) radiance_cache_tell(tracer->cache, &mark->cells, incoming);
}

bool path_cache_scatter(const struct path_tracer *tracer, struct path *path, const struct bsdf_sample *sample) {
    if (sample->delta) { // of the surface's broad part the cache has been told all
        if (path->marked) settle(tracer, path, &path->marks[--path->mark_count]);
        return true;
    }
    path->pdf_spread = sample->pdf;
    path->unfolded = 0;
    return !path->cached;
}

rgb path_cache_end(const struct path_tracer *tracer, const struct path *path) {
    for (int i = 0; i < path->mark_count; i++) settle(tracer, path, &path->marks[i]);
    return path->shows ? path->shown : path->radiance;
}
