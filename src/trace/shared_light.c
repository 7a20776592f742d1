#include "trace/shared_light.h"

#include <stdlib.h>

#include "base/pages.h"
#include "trace/shared_filter.h"

enum status shared_light_create(struct shared_light **result, int width, int height, struct error *error) {
    const size_t count = (size_t)width * (size_t)height;
    struct shared_light *shared = calloc(1, sizeof *shared);
    *result = shared;
    bool ready = shared;
    if (ready) {
        shared->width = width;
        shared->height = height;
        shared->paths = calloc(count, sizeof *shared->paths);
        ready = shared->paths;
    }
    for (int k = 0; ready && k < SHARED_LAYERS; k++) {
        // Every pixel has a first surface; later ones that are never met cost no memory.
        const size_t size = sizeof *shared->layers[k];
        shared->layers[k] = k == 0 ? pages_alloc(count, size) : calloc(count, size);
        ready = shared->layers[k];
    }
    if (ready) return STATUS_OK;
    return error_set(error, STATUS_MEMORY, "out of memory for the shared light of %d x %d pixels", width, height);
}

void shared_light_destroy(struct shared_light *shared) {
    if (!shared) return;
    for (int k = 0; k < SHARED_LAYERS; k++) free(shared->layers[k]);
    free(shared->paths);
    free(shared);
}

static void add_to(float sums[3], float x, float y, float z) {
    sums[0] += x;
    sums[1] += y;
    sums[2] += z;
}

static void end_batch(struct shared_surface *surface) {
    for (int i = 0; i < SHARED_PARTS; i++) {
        struct shared_part *part = &surface->parts[i];
        part->batch_squares += sqrf(part->batch);
        part->batch = 0;
    }
}

static bool is_finite(const struct shared_sample *sample) {
    for (int i = 0; i < SHARED_PARTS; i++)
        if (!rgb_is_finite(sample->light[i]) || !rgb_is_finite(sample->weight[i % SHARED_WEIGHTS])) return false;
    return true;
}

static void add_light(struct shared_part *part, rgb light, rgb product) {
    add_to(part->light, light.r, light.g, light.b);
    add_to(part->product, product.r, product.g, product.b);
    part->squares += rgb_luminance(rgb_mul(light, light));
    part->batch += rgb_luminance(light);
}

static void add_sample(struct shared_surface *surface, const struct shared_sample *sample) {
    surface->surface = sample->surface;
    surface->count += 1;
    add_to(surface->p, sample->p.x, sample->p.y, sample->p.z);
    add_to(surface->n, sample->n.x, sample->n.y, sample->n.z);
    for (int i = 0; i < SHARED_WEIGHTS; i++)
        add_to(surface->weights[i], sample->weight[i].r, sample->weight[i].g, sample->weight[i].b);
    for (int i = 0; i < SHARED_PARTS; i++)
        add_light(&surface->parts[i], sample->light[i], rgb_mul(sample->weight[i % SHARED_WEIGHTS], sample->light[i]));
}

// It bends little: what a pixel sees of the sides of a box are different surfaces.
static bool same_surface(const struct shared_surface *surface, uint32_t number, vec3 normal) {
    static const float least_cosine = 0.9f;
    const vec3 n = {surface->n[0], surface->n[1], surface->n[2]};
    return number && surface->surface == number && vec3_dot(n, normal) >= least_cosine * vec3_length(n);
}

void shared_light_add(struct shared_light *shared, size_t pixel, const struct shared_sample *samples, int count) {
    const bool batch_ends = shared->paths[pixel] > 0 && fmodf(shared->paths[pixel], SHARED_BATCH) == 0;
    shared->paths[pixel] += 1;
    for (int k = 0; k < SHARED_LAYERS && batch_ends; k++)
        if (shared->layers[k][pixel].surface) end_batch(&shared->layers[k][pixel]);
    for (int i = 0; i < count; i++) {
        int k = 0;
        while (k < SHARED_LAYERS && shared->layers[k][pixel].surface &&
               !same_surface(&shared->layers[k][pixel], samples[i].surface, samples[i].n))
            k++;
        if (k < SHARED_LAYERS && is_finite(&samples[i])) add_sample(&shared->layers[k][pixel], &samples[i]);
    }
}

void shared_light_splat(struct shared_light *shared, size_t pixel, const struct shared_splat *splat, rgb value) {
    for (int k = 0; k < SHARED_LAYERS; k++) {
        struct shared_surface *surface = &shared->layers[k][pixel];
        if (!same_surface(surface, splat->surface, splat->n)) continue;
        for (int i = 0; i < SHARED_WEIGHTS; i++) {
            const rgb product = rgb_mul(value, splat->share[i]), light = shared_ratio(product, splat->weight[i]);
            if (rgb_is_finite(light)) add_light(&surface->parts[splat->part + i], light, product);
        }
        return;
    }
}

void shared_light_variances(const struct shared_light *shared, size_t pixel, float variances[SHARED_PARTS]) {
    for (int i = 0; i < SHARED_PARTS; i++) variances[i] = 0;
    for (int k = 0; k < SHARED_LAYERS; k++) {
        const struct shared_surface *surface = &shared->layers[k][pixel];
        if (!surface->surface) break;
        for (int i = 0; i < SHARED_PARTS; i++) {
            const float *weights = surface->weights[i % SHARED_WEIGHTS];
            const float weight = rgb_luminance((rgb){weights[0], weights[1], weights[2]}) / surface->count;
            variances[i] += sqrf(weight) * sample_spread(surface, i) * surface->count / shared->paths[pixel];
        }
    }
}
