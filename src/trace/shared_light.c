#include "trace/shared_light.h"

#include <stdlib.h>

enum status shared_light_create(struct shared_light **result, int width, int height, struct error *error) {
    struct shared_light *shared = calloc(1, sizeof *shared);
    *result = shared;
    if (shared) {
        shared->width = width;
        shared->height = height;
        shared->pixels = calloc((size_t)width * (size_t)height, sizeof *shared->pixels);
    }
    if (!shared || !shared->pixels)
        return error_set(error, STATUS_MEMORY, "out of memory for the shared light of %d x %d pixels", width, height);
    return STATUS_OK;
}

void shared_light_destroy(struct shared_light *shared) {
    if (!shared) return;
    free(shared->pixels);
    free(shared);
}

static void add_to(float sums[3], float x, float y, float z) {
    sums[0] += x;
    sums[1] += y;
    sums[2] += z;
}

static void end_batch(struct shared_pixel *pixel) {
    pixel->batch_count = 0;
    for (int i = 0; i < SHARED_PARTS; i++) {
        struct shared_part *part = &pixel->parts[i];
        part->batch_squares += sqrf(part->batch);
        part->batch = 0;
    }
}

void shared_light_add(struct shared_light *shared, size_t index, const struct shared_sample *sample) {
    struct shared_pixel *pixel = &shared->pixels[index];
    if (pixel->paths > 0 && fmodf(pixel->paths, SHARED_BATCH) == 0) end_batch(pixel);
    pixel->paths += 1;
    if (!pixel->surface) pixel->surface = sample->surface;
    if (!sample->surface || pixel->surface != sample->surface) return;
    for (int i = 0; i < SHARED_PARTS; i++)
        if (!rgb_is_finite(sample->light[i]) || !rgb_is_finite(sample->weight[i])) return;
    pixel->count += 1;
    pixel->batch_count += 1;
    add_to(pixel->p, sample->p.x, sample->p.y, sample->p.z);
    add_to(pixel->n, sample->n.x, sample->n.y, sample->n.z);
    for (int i = 0; i < SHARED_PARTS; i++) {
        struct shared_part *part = &pixel->parts[i];
        const rgb light = sample->light[i], weight = sample->weight[i];
        add_to(part->light, light.r, light.g, light.b);
        add_to(part->weight, weight.r, weight.g, weight.b);
        add_to(part->product, weight.r * light.r, weight.g * light.g, weight.b * light.b);
        part->squares += rgb_luminance(rgb_mul(light, light));
        part->batch += rgb_luminance(light);
    }
}
