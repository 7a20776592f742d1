// Single bright paths. One that brings a hundred times what is usual would be smeared over the neighbours that learn
// from its pixel, as a spot, and would hide how well they predict each other. So before anything else is made of the
// light, what it brings above its surroundings is taken out, and spread over the widest disc in the end. It is told
// from a true bright spot by its distance from the surroundings, which is then no more than its samples vary: the more
// samples, the fewer pixels are outliers.
#include <stdlib.h>

#include "trace/shared_filter.h"

enum { NEAR = 2 }; // pixels
static const float outlying = 9; // its variance, in terms of the typical one around it
static const float least_neighbours = 3;
static const float doubt = 2; // variances: an outlier lies no further away

void excess_add(struct excess_list *list, const struct excess *excess) {
    if (list->count == list->capacity) {
        const size_t capacity = list->capacity ? 2 * list->capacity : 256;
        struct excess *items = realloc(list->items, capacity * sizeof *items);
        if (!items) {
            list->out_of_memory = true;
            return;
        }
        list->items = items;
        list->capacity = capacity;
    }
    list->items[list->count++] = *excess;
}

struct search {
    const struct shared_light *shared;
    int part, first, last; // rows of the planes
    float *deviations[SHARED_LAYERS];
    bool *suspects[SHARED_LAYERS];
};

struct surroundings { // of a pixel's surface, without it
    float count, samples, deviation; // neighbours; their paths; mean
    rgb light; // sum
};

static size_t place_of(const struct search *search, int x, int y) {
    return (size_t)(y - search->first) * (size_t)search->shared->width + (size_t)x;
}

static struct surroundings look_around(const struct search *search, int layer, int x, int y, bool no_suspects) {
    const struct shared_light *shared = search->shared;
    const uint32_t surface = shared->layers[layer][(size_t)y * (size_t)shared->width + (size_t)x].surface;
    struct surroundings around = {0};
    for (int v = maxi(y - NEAR, search->first); v <= y + NEAR && v < search->last; v++)
        for (int u = maxi(x - NEAR, 0); u <= x + NEAR && u < shared->width; u++)
            for (int k = 0; k < SHARED_LAYERS && (u != x || v != y); k++) {
                const struct shared_surface *other = &shared->layers[k][(size_t)v * (size_t)shared->width + (size_t)u];
                const size_t j = place_of(search, u, v);
                if (other->surface != surface || (no_suspects && search->suspects[k][j])) continue;
                const float *light = other->parts[search->part].light;
                around.count += 1;
                around.samples += other->count;
                around.deviation += search->deviations[k][j];
                around.light = rgb_add(around.light, (rgb){light[0], light[1], light[2]});
            }
    around.deviation /= maxf(around.count, 1);
    return around;
}

static void examine(const struct search *search, int layer, int x, int y, struct excess_list *found) {
    const size_t pixel = (size_t)y * (size_t)search->shared->width + (size_t)x;
    const struct shared_surface *surface = &search->shared->layers[layer][pixel];
    const struct surroundings around = look_around(search, layer, x, y, true);
    if (around.count < least_neighbours || !(around.samples > 0) || !vec3_is_finite(mean_normal(surface))) return;
    const float *light = surface->parts[search->part].light;
    const rgb usual = rgb_scale(around.light, surface->count / around.samples);
    const rgb excess = rgb_sub((rgb){light[0], light[1], light[2]}, usual);
    const float distance = rgb_luminance(rgb_mul(excess, excess)) / sqrf(surface->count);
    if (distance > doubt * sqrf(search->deviations[layer][place_of(search, x, y)]) || rgb_luminance(excess) <= 0)
        return;
    excess_add(found, &(struct excess){.pixel = (uint32_t)pixel,
                                       .layer = (uint8_t)layer,
                                       .part = (uint8_t)search->part,
                                       .disc = WIDEST,
                                       .light = {excess.r, excess.g, excess.b},
                                       .variance = sqrf(around.deviation)});
}

static bool is_suspect(const struct search *search, int layer, int x, int y) {
    const float variance = sqrf(search->deviations[layer][place_of(search, x, y)]);
    if (!(variance > 0)) return false;
    const struct surroundings around = look_around(search, layer, x, y, false);
    return around.count >= least_neighbours && variance > outlying * sqrf(around.deviation);
}

static void measure_row(struct search *search, int y) {
    const struct shared_light *shared = search->shared;
    for (int x = 0; x < shared->width; x++)
        for (int k = 0; k < SHARED_LAYERS; k++) {
            const struct shared_surface *surface = &shared->layers[k][(size_t)y * (size_t)shared->width + (size_t)x];
            const float variance = surface->surface ? sample_variance(surface, search->part) : 0;
            search->deviations[k][place_of(search, x, y)] = sqrtf(variance);
        }
}

void shared_find_outliers(const struct shared_light *shared, int begin, int end, struct excess_list *found) {
    const int first = maxi(begin - 2 * NEAR, 0), last = mini(end + 2 * NEAR, shared->height);
    const size_t size = (size_t)(last - first) * (size_t)shared->width;
    struct search search = {shared, 0, first, last, {0}, {0}};
    float *deviations = calloc(SHARED_LAYERS * size, sizeof *deviations);
    bool *suspects = calloc(SHARED_LAYERS * size, sizeof *suspects);
    found->out_of_memory = !deviations || !suspects;
    for (size_t k = 0; k < SHARED_LAYERS && !found->out_of_memory; k++) {
        search.deviations[k] = deviations + k * size;
        search.suspects[k] = suspects + k * size;
    }
    for (search.part = 0; search.part < SHARED_PARTS && !found->out_of_memory; search.part++) {
        for (int y = first; y < last; y++) measure_row(&search, y);
        for (int y = maxi(begin - NEAR, 0); y < mini(end + NEAR, shared->height); y++)
            for (int x = 0; x < shared->width; x++)
                for (int k = 0; k < SHARED_LAYERS; k++)
                    search.suspects[k][place_of(&search, x, y)] = is_suspect(&search, k, x, y);
        for (int y = begin; y < end; y++)
            for (int x = 0; x < shared->width; x++)
                for (int k = 0; k < SHARED_LAYERS; k++)
                    if (search.suspects[k][place_of(&search, x, y)]) examine(&search, k, x, y, found);
    }
    free(deviations);
    free(suspects);
}

// --- What is given away ---
struct share {
    size_t pixel;
    int layer;
    float weight;
};
enum { MOST_SHARES = (2 * REACH + 1) * (2 * REACH + 1) * SHARED_LAYERS };

static int find_shares(const struct shared_light *shared, const struct excess *excess,
                       struct share shares[MOST_SHARES]) {
    const struct shared_surface *surface = &shared->layers[excess->layer][excess->pixel];
    const vec3 p = mean_point(surface), n = mean_normal(surface);
    const int x = (int)(excess->pixel % (size_t)shared->width), y = (int)(excess->pixel / (size_t)shared->width);
    const int reach = disc_radii[excess->disc];
    int count = 0;
    for (int v = maxi(y - reach, 0); v <= y + reach && v < shared->height; v++)
        for (int u = maxi(x - reach, 0); u <= x + reach && u < shared->width; u++) {
            const float kernel = disc_kernel(excess->disc, u - x, v - y);
            const size_t j = (size_t)v * (size_t)shared->width + (size_t)u;
            for (int k = 0; k < SHARED_LAYERS && kernel > 0; k++) {
                const struct shared_surface *other = &shared->layers[k][j];
                if (other->surface != surface->surface) continue;
                const float weight = kernel * likeness(p, n, mean_point(other), mean_normal(other));
                if (weight > 0) shares[count++] = (struct share){j, k, weight};
            }
        }
    return count;
}

static int compare_excess(const void *a, const void *b) {
    const struct excess *x = a, *y = b;
    if (x->pixel != y->pixel) return x->pixel < y->pixel ? -1 : 1;
    if (x->layer != y->layer) return x->layer < y->layer ? -1 : 1;
    if (x->disc != y->disc) return x->disc < y->disc ? -1 : 1;
    return (x->part > y->part) - (x->part < y->part);
}

void excess_sort(struct excess_list *list) {
    if (list->count) qsort(list->items, list->count, sizeof *list->items, compare_excess);
}

static bool same_neighbours(const struct excess *a, const struct excess *b) {
    return a && a->pixel == b->pixel && a->layer == b->layer && a->disc == b->disc;
}

void shared_spread(const struct shared_light *shared, float passes, const struct excess_list *list, int begin, int end,
                   struct image *image) {
    static const float nothing[3];
    const size_t width = (size_t)shared->width;
    struct share shares[MOST_SHARES];
    const struct excess *before = NULL;
    int count = 0;
    for (size_t i = 0; i < list->count; i++) {
        const struct excess *excess = &list->items[i];
        const int y = (int)(excess->pixel / width);
        if (y < begin - disc_radii[excess->disc] || y >= end + disc_radii[excess->disc]) continue;
        if (!same_neighbours(before, excess)) count = find_shares(shared, excess, shares);
        before = excess;
        float sum = 0;
        for (int k = 0; k < count; k++)
            sum += shares[k].weight * shared->layers[shares[k].layer][shares[k].pixel].count;
        for (int k = 0; k < count; k++) {
            const float part = shares[k].weight / sum;
            const float light[3] = {excess->light[0] * part, excess->light[1] * part, excess->light[2] * part};
            const int row = (int)(shares[k].pixel / width);
            if (row >= begin && row < end)
                image_add_light(image, shared, passes, shares[k].pixel, shares[k].layer, excess->part, light, nothing);
        }
    }
}
