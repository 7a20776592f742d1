// The path tracer's frame: workers and their memory, the loop over the tiles of a pass and the loop over the stages of
// a block (after Laine, Karras and Aila 2013, "Megakernels Considered Harmful"). Every path draws its random numbers
// from (seed, pixel, pass) and every pixel belongs to one tile, so a pass does not depend on the threads.
#include "trace/path_state.h"

#include <stdlib.h>
#include <string.h>

#include "base/parallel.h"

static void meet_luminaires(const struct path_tracer *tracer, struct path_worker *worker) {
    if (tracer->residual)
        path_luminaire_residual(tracer, worker);
    else if (tracer->scene->luminaire_count)
        path_luminaire(tracer, worker);
}

const struct path_stage path_stages[PATH_STAGES + 1] = {
    {"intersect", path_intersect}, {"luminaire", meet_luminaires}, {"view", path_view},   {"hit", path_hit},
    {"share", path_share},         {"cache", path_cache},          {"light", path_light}, {"shadow", path_shadow},
    {"arrive", path_arrive},       {"scatter", path_scatter},      {NULL, NULL}};

static void worker_fini(struct path_worker *worker) {
    free(worker->paths);
    free(worker->active);
    free(worker->hits);
    free(worker->shadows);
    free(worker->requests);
    free(worker->walks);
    free(worker->responses);
    lamp_draws_fini(&worker->draws);
    crossing_batch_fini(&worker->crossings);
}

static enum status worker_init(struct path_worker *worker, const struct scene *scene, struct error *error) {
    worker->paths = calloc(PATH_BLOCK, sizeof *worker->paths);
    worker->active = calloc(PATH_BLOCK, sizeof *worker->active);
    worker->hits = calloc(PATH_BLOCK, sizeof *worker->hits);
    worker->shadows = calloc(PATH_MOST_SHADOWS, sizeof *worker->shadows);
    worker->requests = calloc(PATH_MOST_SHADOWS, sizeof *worker->requests);
    enum status status = lamp_draws_init(&worker->draws, PATH_MOST_SHADOWS, error);
    if (status == STATUS_OK) status = crossing_batch_init(&worker->crossings, scene, PATH_MOST_SHADOWS, error);
    if (status != STATUS_OK) return status;
    size_t crossings = scene->unbiased ? worker->crossings.capacity : 0;
    worker->walks = calloc(crossings + 1, sizeof *worker->walks);
    worker->responses = calloc(crossings + 1, sizeof *worker->responses);
    if (!worker->paths || !worker->active || !worker->hits || !worker->shadows || !worker->requests || !worker->walks ||
        !worker->responses)
        return error_set(error, STATUS_MEMORY, "out of memory for a block of paths");
    return STATUS_OK;
}

static void tracer_destroy(void *state) {
    struct path_tracer *tracer = state;
    if (!tracer) return;
    for (int i = 0; tracer->workers && i < tracer->worker_count; i++) worker_fini(&tracer->workers[i]);
    free(tracer->workers);
    free(tracer->lobes);
    free(tracer->tile_lights);
    free(tracer->expected);
    path_guide_destroy(tracer->guide);
    radiance_cache_destroy(tracer->cache);
    shared_light_destroy(tracer->shared);
    light_select_destroy(tracer->lights);
    caustic_destroy(tracer->caustic);
    residual_destroy(tracer->residual);
    free(tracer);
}

// What the cache holds knows no longest path.
static bool may_cache(const struct scene *scene) {
    enum { long_enough = 16 };
    return scene->max_depth < 0 || scene->max_depth >= long_enough;
}

enum status path_create(const struct scene *scene, const struct run *run, enum path_strategy strategy, void **state,
                        struct error *error) {
    *state = NULL;
    if (!scene->sensor)
        return error_set(error, STATUS_INVALID,
                         "%s: the scene has no sensor, so there is nothing to render; add a <sensor>", scene->path);
    struct path_tracer *tracer = calloc(1, sizeof *tracer);
    int count = run->threads < 1 ? 1 : run->threads;
    if (tracer) tracer->workers = calloc((size_t)count, sizeof *tracer->workers);
    if (tracer) tracer->lobes = calloc(scene->shape_count + 1, sizeof *tracer->lobes);
    if (!tracer || !tracer->workers || !tracer->lobes) {
        tracer_destroy(tracer);
        return error_set(error, STATUS_MEMORY, "out of memory for the path tracer");
    }
    tracer->scene = scene;
    tracer->strategy = strategy;
    tracer->shares = strategy == PATH_MIS && scene->share_light && !scene->unbiased;
    tracer->hidden = scene_has_hidden_geometry(scene);
    tracer->worker_count = count;
    for (size_t i = 0; i < scene->shape_count; i++) tracer->lobes[i] = lobe_shape_measure(scene->shapes[i]->bsdf);
    enum status status = light_select_create(&tracer->lights, scene, error);
    if (status == STATUS_OK) status = path_guide_create(&tracer->guide, error);
    if (status == STATUS_OK && tracer->shares && may_cache(scene))
        status = radiance_cache_create(&tracer->cache, scene, error);
    if (status == STATUS_OK && scene->unbiased) status = residual_create(&tracer->residual, scene, error);
    if (status == STATUS_OK && strategy == PATH_MIS)
        status = caustic_create(&tracer->caustic, scene, tracer->residual, run, error);
    if (tracer->caustic && !tracer->residual) mirrors_find(&tracer->mirrors, scene, MIRROR_PURE);
    for (int i = 0; status == STATUS_OK && i < count; i++) status = worker_init(&tracer->workers[i], scene, error);
    if (status == STATUS_OK)
        *state = tracer;
    else
        tracer_destroy(tracer);
    return status;
}

size_t path_dropped(const void *state) { return ((const struct path_tracer *)state)->dropped; }

static void trace_tile(void *user, size_t tile, int worker_index) {
    struct path_tracer *tracer = user;
    struct path_worker *worker = &tracer->workers[worker_index];
    if (worker_index == 0 && run_cancelled(tracer->run)) __atomic_store_n(&tracer->cancelled, true, __ATOMIC_RELAXED);
    if (__atomic_load_n(&tracer->cancelled, __ATOMIC_RELAXED)) return;
    path_generate(tracer, worker, (int)tile);
    size_t count = tracer->scene->max_depth == 0 ? 0 : worker->active_count;
    worker->active_count = count;
    double time = clock_wall_s();
    while (worker->active_count)
        for (int i = 0; path_stages[i].name; i++) {
            path_stages[i].run(tracer, worker);
            double now = clock_wall_s();
            worker->stage_s[i] += now - time;
            time = now;
        }
    for (size_t i = 0; i < count; i++) {
        struct path *path = &worker->paths[i];
        path_record_end(tracer, path);
        const rgb radiance = path_cache_end(tracer, path);
        path_share_end(tracer, path, radiance);
        float *pixel = &tracer->film->pass[3 * (size_t)path->pixel];
        pixel[0] = radiance.r;
        pixel[1] = radiance.g;
        pixel[2] = radiance.b;
    }
}

static enum status render_pass(void *state, struct film *film, uint64_t pass, const struct run *run,
                               struct error *error) {
    struct path_tracer *tracer = state;
    tracer->film = film;
    tracer->seed = run->seed;
    tracer->pass = pass;
    tracer->run = run;
    tracer->cancelled = false;
    size_t pixels = (size_t)film->width * (size_t)film->height;
    tracer->tiles_x = (film->width + PATH_TILE - 1) / PATH_TILE;
    tracer->tile_count = tracer->tiles_x * ((film->height + PATH_TILE - 1) / PATH_TILE);
    if (!tracer->expected) tracer->expected = calloc(pixels, sizeof *tracer->expected);
    if (!tracer->tile_lights) tracer->tile_lights = calloc((size_t)tracer->tile_count, sizeof *tracer->tile_lights);
    if (!tracer->expected || !tracer->tile_lights)
        return error_set(error, STATUS_MEMORY, "out of memory for a film of %zu pixels", pixels);
    if (tracer->shares && !tracer->shared) {
        enum status status = shared_light_create(&tracer->shared, film->width, film->height, error);
        if (status) return status;
    }
    path_expect(tracer);
    path_light_learn(tracer);
    path_guide_learn(tracer);
    path_cache_learn(tracer);
    parallel_for(run->threads < tracer->worker_count ? run->threads : tracer->worker_count, (size_t)tracer->tile_count,
                 trace_tile, tracer);
    enum status status = STATUS_OK;
    if (tracer->caustic && !tracer->cancelled)
        status = caustic_render(tracer->caustic, film, tracer->shared, pass, run, &tracer->dropped, error);
    if (status == STATUS_CANCELLED) tracer->cancelled = true;
    for (int i = 0; i < tracer->worker_count; i++) {
        tracer->dropped += tracer->workers[i].dropped;
        tracer->workers[i].dropped = 0;
    }
    if (tracer->dropped && !tracer->dropped_told) {
        tracer->dropped_told = true;
        run_warn(run,
                 "%zu contributions were not finite and were left out (pass %llu; later ones are counted silently)",
                 tracer->dropped, (unsigned long long)pass);
    }
    if (!tracer->cancelled) return status;
    memset(film->pass, 0, 3 * (size_t)film->width * (size_t)film->height * sizeof *film->pass);
    return error_set(error, STATUS_CANCELLED, "cancelled");
}

static enum status finish(const void *state, const struct film *film, struct image *image, const struct run *run,
                          struct error *error) {
    const struct path_tracer *tracer = state;
    if (!tracer->shared || film->pass_count < 2) return STATUS_OK; // of one sample nobody knows how far it may be off
    return shared_light_apply(tracer->shared, film->pass_count, image, run, error);
}

static enum status create(const struct scene *scene, const struct run *run, void **state, struct error *error) {
    return path_create(scene, run, PATH_MIS, state, error);
}

const struct integrator_type path_integrator = {
    .name = "path",
    .help = "unidirectional path tracing with light samples and multiple importance sampling; baked lamps in batches",
    .create = create,
    .render_pass = render_pass,
    .finish = finish,
    .destroy = tracer_destroy,
};
