// One pass of caustics: blocks of particles for every lamp, as many as its share of the light that meets mirrors and
// glass, traced in parallel; their splats are added in block order.
#include "trace/caustic_trace.h"

#include <stdlib.h>

#include "base/parallel.h"

enum { CAUSTIC_WAVE = 64 }; // blocks traced before their splats are added, which bounds their memory
static const double particles_per_pixel = 0.25;
static const double emitted_per_pixel = 2; // of an unbiased rendering

struct caustic {
    const struct scene *scene;
    const struct residual *residual; // or NULL
    struct camera camera;
    bool hidden;
    struct caustic_targets *targets; // for every lamp; empty with a residual
    struct caustic_block *blocks;
    size_t block_count;
    struct caustic_worker *workers;
    int worker_count;
    struct splat_list lists[CAUSTIC_WAVE];
    struct caustic_views views[CAUSTIC_WAVE]; // of what the lists hold
    // of the running wave
    const struct run *run;
    uint64_t pass;
    size_t first;
    struct shared_light *shared; // or NULL
};

static void worker_fini(struct caustic_worker *worker) {
    free(worker->particles);
    free(worker->active);
    free(worker->links);
    lamp_draws_fini(&worker->draws);
    crossing_batch_fini(&worker->crossings);
}

static enum status worker_init(struct caustic_worker *worker, const struct scene *scene, struct error *error) {
    worker->particles = calloc(CAUSTIC_BLOCK, sizeof *worker->particles);
    worker->active = calloc(CAUSTIC_BLOCK, sizeof *worker->active);
    worker->links = calloc(CAUSTIC_BLOCK, sizeof *worker->links);
    if (!worker->particles || !worker->active || !worker->links)
        return error_set(error, STATUS_MEMORY, "out of memory for a block of particles");
    const enum status status = lamp_draws_init(&worker->draws, CAUSTIC_BLOCK, error);
    return status ? status
                  : crossing_batch_init(&worker->crossings, scene, CAUSTIC_BLOCK * scene->luminaire_count, error);
}

static double lamp_weight(const struct caustic *caustic, size_t luminaire) {
    const struct luminaire_instance *instance = &caustic->scene->luminaires[luminaire];
    if (caustic->residual) return residual_power(caustic->residual, (int)luminaire);
    return caustic->targets[luminaire].weight * (double)rgb_mean(luminaire_power(instance));
}

// Every lamp that lights a target gets its share, and at least one block.
static enum status plan_blocks(struct caustic *caustic, struct error *error) {
    const struct scene *scene = caustic->scene;
    const struct sensor *sensor = scene->sensor;
    double wanted =
               (caustic->residual ? emitted_per_pixel : particles_per_pixel) * sensor->crop_width * sensor->crop_height,
           sum = 0;
    for (size_t i = 0; i < scene->luminaire_count; i++) sum += lamp_weight(caustic, i);
    if (!(sum > 0)) return STATUS_OK;
    caustic->blocks = calloc((size_t)(wanted / CAUSTIC_BLOCK) + 2 * scene->luminaire_count, sizeof *caustic->blocks);
    if (!caustic->blocks) return error_set(error, STATUS_MEMORY, "out of memory for the plan of particles");
    for (uint32_t i = 0; i < scene->luminaire_count; i++) {
        double share = lamp_weight(caustic, i) / sum;
        if (!(share > 0)) continue;
        size_t count = (size_t)ceil(share * wanted / CAUSTIC_BLOCK);
        for (size_t k = 0; k < count; k++)
            caustic->blocks[caustic->block_count++] =
                (struct caustic_block){i, (uint64_t)k * CAUSTIC_BLOCK, CAUSTIC_BLOCK, (uint64_t)count * CAUSTIC_BLOCK};
    }
    return STATUS_OK;
}

static enum status caustic_init(struct caustic *caustic, const struct run *run, struct error *error) {
    const struct scene *scene = caustic->scene;
    caustic->targets = calloc(scene->luminaire_count, sizeof *caustic->targets);
    if (!caustic->targets) return error_set(error, STATUS_MEMORY, "out of memory for the caustics");
    enum status status = STATUS_OK;
    for (uint32_t i = 0; status == STATUS_OK && !caustic->residual && i < scene->luminaire_count; i++)
        status = caustic_targets_init(&caustic->targets[i], scene, i, error);
    if (status == STATUS_OK) status = plan_blocks(caustic, error);
    if (status != STATUS_OK || !caustic->block_count) return status;
    caustic->worker_count = run->threads < 1 ? 1 : run->threads;
    caustic->workers = calloc((size_t)caustic->worker_count, sizeof *caustic->workers);
    if (!caustic->workers) return error_set(error, STATUS_MEMORY, "out of memory for the caustics");
    for (int i = 0; status == STATUS_OK && i < caustic->worker_count; i++)
        status = worker_init(&caustic->workers[i], scene, error);
    return status;
}

enum status caustic_create(struct caustic **result, const struct scene *scene, const struct residual *residual,
                           const struct run *run, struct error *error) {
    *result = NULL;
    bool deep_enough = scene->max_depth < 0 || scene->max_depth >= (residual ? 2 : 3);
    if (!scene->luminaire_count || !deep_enough) return STATUS_OK;
    struct caustic *caustic = calloc(1, sizeof *caustic);
    if (!caustic) return error_set(error, STATUS_MEMORY, "out of memory for the caustics");
    caustic->scene = scene;
    caustic->residual = residual;
    caustic->hidden = scene_has_hidden_geometry(scene);
    camera_init(&caustic->camera, scene);
    enum status status = caustic_init(caustic, run, error);
    if (status == STATUS_OK && caustic->block_count)
        *result = caustic;
    else
        caustic_destroy(caustic);
    return status;
}

void caustic_destroy(struct caustic *caustic) {
    if (!caustic) return;
    for (size_t i = 0; caustic->targets && i < caustic->scene->luminaire_count; i++)
        caustic_targets_fini(&caustic->targets[i]);
    for (int i = 0; caustic->workers && i < caustic->worker_count; i++) worker_fini(&caustic->workers[i]);
    for (size_t i = 0; i < CAUSTIC_WAVE; i++) {
        splat_list_fini(&caustic->lists[i]);
        free(caustic->views[i].items);
    }
    free(caustic->targets);
    free(caustic->workers);
    free(caustic->blocks);
    free(caustic);
}

static void trace_block(void *user, size_t index, int worker) {
    struct caustic *caustic = user;
    splat_list_clear(&caustic->lists[index]);
    caustic->views[index].count = 0;
    if (run_cancelled(caustic->run)) return;
    const struct caustic_block *block = &caustic->blocks[caustic->first + index];
    struct caustic_job job = {
        caustic->scene,  caustic->residual,  &caustic->camera, &caustic->targets[block->luminaire],
        caustic->hidden, caustic->run->seed, caustic->pass};
    caustic_trace_block(&job, block, &caustic->workers[worker], &caustic->lists[index],
                        caustic->shared ? &caustic->views[index] : NULL);
}

struct telling {
    const struct caustic *caustic;
    size_t list_count, pixel_count, band_count;
    float scale;
};

static void tell_band(void *user, size_t band, int worker) {
    (void)worker;
    const struct telling *t = user;
    const size_t begin = band * t->pixel_count / t->band_count, end = (band + 1) * t->pixel_count / t->band_count;
    for (size_t l = 0; l < t->list_count; l++) {
        const struct splat_list *list = &t->caustic->lists[l];
        for (size_t i = 0; i < list->count; i++) {
            const struct splat *splat = &list->items[i];
            const struct shared_splat *view = &t->caustic->views[l].items[splat->source];
            if (splat->pixel >= begin && splat->pixel < end)
                shared_light_splat(t->caustic->shared, splat->pixel, view, rgb_scale(splat->value, t->scale));
        }
    }
}

enum status caustic_render(struct caustic *caustic, struct film *film, struct shared_light *shared, uint64_t pass,
                           const struct run *run, size_t *dropped, struct error *error) {
    const struct sensor *sensor = caustic->scene->sensor;
    const float scale = (float)sensor->width * (float)sensor->height;
    int threads = run->threads < caustic->worker_count ? run->threads : caustic->worker_count;
    caustic->run = run;
    caustic->pass = pass;
    caustic->shared = shared;
    for (caustic->first = 0; caustic->first < caustic->block_count; caustic->first += CAUSTIC_WAVE) {
        size_t left = caustic->block_count - caustic->first, count = left < CAUSTIC_WAVE ? left : CAUSTIC_WAVE;
        parallel_for(threads, count, trace_block, caustic);
        if (run_cancelled(run)) return error_set(error, STATUS_CANCELLED, "cancelled");
        splat_merge(caustic->lists, count, scale, film->pass, (size_t)film->width * (size_t)film->height, threads);
        struct telling telling = {caustic, count, (size_t)film->width * (size_t)film->height, (size_t)threads, scale};
        if (shared) parallel_for(threads, telling.band_count, tell_band, &telling);
        for (size_t i = 0; i < count; i++) {
            *dropped += caustic->lists[i].dropped;
            if (caustic->lists[i].out_of_memory)
                return error_set(error, STATUS_MEMORY, "out of memory for the particles' splats");
        }
    }
    return STATUS_OK;
}
