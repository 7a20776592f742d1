#include "trace/shared_band.h"

#include <stdlib.h>
#include <string.h>

enum {
    LAYER_PLANES = 1 + 3 + 3 + SHARED_PARTS * (3 + 1 + 2), // the own variances are each layer's
    PART_PLANES = 3 * PREDICTIONS + PREDICTIONS,
    PLANES = SHARED_LAYERS * LAYER_PLANES + SHARED_PARTS * PART_PLANES + 1,
    ROWS = DISCS + TILTED * MOMENTS + SHARED_PARTS * TILTED * 3 * 2
};

static void take(float **planes, size_t count, float **next, size_t size) {
    for (size_t i = 0; i < count; i++, *next += size) planes[i] = *next;
}

// Predictions, distances and tilts of all layers lie in one place.
static void take_predictions(struct band *band, float **next, size_t size) {
    for (int i = 0; i < SHARED_PARTS; i++) {
        struct part_planes *part = &band->layers[0].parts[i];
        for (int d = 0; d < PREDICTIONS; d++) take(part->prediction[d], 3, next, size);
        take(part->errors, PREDICTIONS, next, size);
        for (int t = 0; t < TILTED; t++)
            for (int c = 0; c < 3; c++) take(part->tilt[t][c], 2, next, band->stride);
        for (int k = 1; k < SHARED_LAYERS; k++) {
            struct part_planes *other = &band->layers[k].parts[i];
            memcpy(other->prediction, part->prediction, sizeof part->prediction);
            memcpy(other->errors, part->errors, PREDICTIONS * sizeof *part->errors);
        }
    }
}

static void find_offsets(struct band *band) {
    for (int dy = -REACH; dy <= REACH; dy++)
        for (int dx = -REACH; dx <= REACH; dx++) {
            if ((dx == 0 && dy == 0) || disc_kernel(WIDEST, dx, dy) <= 0) continue;
            struct disc_offset *offset = &band->offsets[band->offset_count++];
            *offset = (struct disc_offset){dx, dy, WIDEST, dy * (ptrdiff_t)band->stride + dx, {0}};
            while (offset->disc > 0 && disc_kernel(offset->disc - 1, dx, dy) > 0) offset->disc--;
            for (int d = offset->disc; d < DISCS; d++) offset->weights[d] = disc_kernel(d, dx, dy);
        }
}

bool band_init(struct band *band, const struct shared_light *shared, const struct excess_list *outliers,
               float least_level) {
    const size_t stride = ((size_t)shared->width + LANE_COUNT - 1) / LANE_COUNT * LANE_COUNT + 2 * EDGE,
                 size = stride * MOST_ROWS;
    *band = (struct band){
        .shared = shared, .outliers = outliers, .width = shared->width, .stride = stride, .least_level = least_level};
    find_offsets(band);
    float *next = band->memory = malloc((PLANES * size + ROWS * stride) * sizeof *band->memory);
    band->surfaces = malloc(SHARED_LAYERS * size * sizeof *band->surfaces);
    if (!next || !band->surfaces) return false;
    for (size_t k = 0; k < SHARED_LAYERS; k++) {
        struct layer *layer = &band->layers[k];
        layer->surface = band->surfaces + k * size;
        take(&layer->count, 1, &next, size);
        take(layer->p, 3, &next, size);
        take(layer->n, 3, &next, size);
        for (int i = 0; i < SHARED_PARTS; i++) {
            take(layer->parts[i].light, 3, &next, size);
            take(&layer->parts[i].weight, 1, &next, size);
            take(layer->parts[i].errors + OWN_SAMPLES, 2, &next, size);
        }
    }
    take_predictions(band, &next, size);
    take(&band->level, 1, &next, size);
    take(band->counts, DISCS, &next, stride);
    for (int t = 0; t < TILTED; t++) take(band->moments[t], MOMENTS, &next, stride);
    return true;
}

void band_fini(struct band *band) {
    free(band->memory);
    free(band->surfaces);
}

// --- What is known of each pixel ---
static void fill_part(struct part_planes *planes, size_t i, const struct shared_surface *surface, int part,
                      float paths) {
    const struct shared_part *sums = &surface->parts[part];
    const float *weights = surface->weights[part % SHARED_WEIGHTS];
    const float weight = sqrf(rgb_luminance((rgb){weights[0], weights[1], weights[2]}) / paths);
    const float total = rgb_luminance((rgb){sums->light[0], sums->light[1], sums->light[2]});
    for (int c = 0; c < 3; c++) planes->light[c][i] = sums->light[c];
    planes->lit |= total > 0;
    planes->weight[i] = weight;
    planes->errors[OWN_SAMPLES][i] = planes->errors[OWN_BATCHES][i] = weight * sample_variance(surface, part);
    if (paths < 2 * SHARED_BATCH) return;
    // The paths are whole batches and the running one, which is not empty.
    const float batches = ceilf(paths / SHARED_BATCH) - 1, running = paths - SHARED_BATCH * batches;
    const float mean = total / paths, full = mean * SHARED_BATCH;
    const float squares = sums->batch_squares - 2 * full * (total - sums->batch) + batches * sqrf(full);
    const float independent = 1 - (batches * SHARED_BATCH * SHARED_BATCH + sqrf(running)) / sqrf(paths);
    const float variance = (maxf(squares, 0) + sqrf(sums->batch - running * mean)) / independent;
    planes->errors[OWN_BATCHES][i] = weight * variance / sqrf(surface->count);
}

static void fill_pixel(struct layer *layer, size_t i, const struct shared_surface *surface, float paths) {
    const vec3 p = mean_point(surface), n = mean_normal(surface);
    if (!vec3_is_finite(n)) return;
    layer->met = true;
    layer->surface[i] = surface->surface;
    layer->count[i] = surface->count;
    layer->p[0][i] = p.x, layer->p[1][i] = p.y, layer->p[2][i] = p.z;
    layer->n[0][i] = n.x, layer->n[1][i] = n.y, layer->n[2][i] = n.z;
    for (int k = 0; k < SHARED_PARTS; k++) fill_part(&layer->parts[k], i, surface, k, paths);
}

float pixel_level(const struct shared_light *shared, size_t pixel) {
    float sum = 0;
    for (int k = 0; k < SHARED_LAYERS; k++) {
        for (int i = 0; i < SHARED_PARTS; i++) {
            const float *product = shared->layers[k][pixel].parts[i].product;
            sum += rgb_luminance((rgb){product[0], product[1], product[2]});
        }
    }
    return shared->paths[pixel] > 0 ? sum / shared->paths[pixel] : 0;
}

static void fill_row(struct band *band, int y) {
    for (size_t x = 0; x < (size_t)band->width; x++) {
        const size_t pixel = (size_t)y * (size_t)band->width + x, i = band_row(band, y) + x;
        band->level[i] = pixel_level(band->shared, pixel);
        for (int k = 0; k < SHARED_LAYERS; k++) {
            const struct shared_surface *surface = &band->shared->layers[k][pixel];
            if (surface->surface) fill_pixel(&band->layers[k], i, surface, band->shared->paths[pixel]);
        }
    }
}

static void take_out(struct band *band, const struct excess *outlier) {
    const int y = (int)(outlier->pixel / (size_t)band->width);
    if (y < band->first || y >= band->last) return;
    const size_t i = band_row(band, y) + outlier->pixel % (size_t)band->width;
    struct part_planes *part = &band->layers[outlier->layer].parts[outlier->part];
    for (int c = 0; c < 3; c++) part->light[c][i] -= outlier->light[c];
    part->errors[OWN_SAMPLES][i] = part->errors[OWN_BATCHES][i] = part->weight[i] * outlier->variance;
}

void band_fill(struct band *band, int first, int last, size_t first_list, size_t lists) {
    const size_t size = band->stride * MOST_ROWS;
    band->first = first;
    band->last = last;
    memset(band->memory, 0, SHARED_LAYERS * LAYER_PLANES * size * sizeof *band->memory);
    memset(band->surfaces, 0, SHARED_LAYERS * size * sizeof *band->surfaces);
    for (int k = 0; k < SHARED_LAYERS; k++) {
        band->layers[k].met = false;
        for (int i = 0; i < SHARED_PARTS; i++) band->layers[k].parts[i].lit = false;
    }
    for (int y = first; y < last; y++) fill_row(band, y);
    for (size_t b = first_list; b < first_list + lists; b++)
        for (size_t i = 0; i < band->outliers[b].count; i++) take_out(band, &band->outliers[b].items[i]);
}
