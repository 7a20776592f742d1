// Splats are weighted by the filter's density at the pixel, which has the same mean as film_sample.h's importance
// sampling of the same filter.
#include "trace/splat.h"

#include <assert.h>
#include <stdlib.h>

#include "base/parallel.h"
#include "trace/film_sample.h"

enum { MAX_REACH = 66 }; // pixels that a filter reaches along an axis: the widest one has a radius of 32

// Densities of film_filter_offset [1/pixel] at the centres of the pixels first, first + 1, ... seen from `at`.
static void filter_densities(const struct sensor *sensor, float at, int first, int count, float *densities) {
    float r = sensor->filter_radius, s = sensor->filter_stddev, scale = 0.5f / r;
    if (sensor->filter == FILM_FILTER_TENT) scale = 1 / r;
    if (sensor->filter == FILM_FILTER_GAUSSIAN) scale = 1 / (s * sqrtf(2 * PI_F) * erff(r / (s * sqrtf(2))));
    for (int i = 0; i < count; i++) {
        float x = fabsf((float)(first + i) + 0.5f - at);
        densities[i] = x >= r ? 0 : scale;
        if (sensor->filter == FILM_FILTER_TENT) densities[i] *= 1 - x / r;
        if (sensor->filter == FILM_FILTER_GAUSSIAN) densities[i] *= expf(-0.5f * sqrf(x / s));
    }
}

static void list_push(struct splat_list *list, uint32_t pixel, rgb value) {
    if (list->count == list->capacity) {
        size_t capacity = list->capacity ? 2 * list->capacity : 1024;
        struct splat *items = realloc(list->items, capacity * sizeof *items);
        if (!items) {
            list->out_of_memory = true;
            return;
        }
        list->items = items;
        list->capacity = capacity;
    }
    list->items[list->count++] = (struct splat){pixel, list->source, value};
}

void splat_add(struct splat_list *list, const struct sensor *sensor, vec2 film, rgb value) {
    if (!rgb_is_finite(value)) {
        list->dropped++;
        return;
    }
    if (rgb_is_black(value)) return;
    float x = film.x * (float)sensor->width - (float)sensor->crop_x;
    float y = film.y * (float)sensor->height - (float)sensor->crop_y;
    if (sensor->filter == FILM_FILTER_BOX && sensor->filter_radius == 0.5f) {
        if (!(x >= 0 && y >= 0 && x < (float)sensor->crop_width && y < (float)sensor->crop_height)) return;
        list_push(list, (uint32_t)y * (uint32_t)sensor->crop_width + (uint32_t)x, value);
        return;
    }
    float r = sensor->filter_radius;
    int x0 = (int)fmaxf(ceilf(x - 0.5f - r), 0), x1 = (int)fminf(floorf(x - 0.5f + r), (float)(sensor->crop_width - 1));
    int y0 = (int)fmaxf(ceilf(y - 0.5f - r), 0),
        y1 = (int)fminf(floorf(y - 0.5f + r), (float)(sensor->crop_height - 1));
    int columns = x1 - x0 + 1, rows = y1 - y0 + 1;
    if (columns <= 0 || rows <= 0) return;
    float across[MAX_REACH], down[MAX_REACH];
    assert(columns <= MAX_REACH && rows <= MAX_REACH);
    filter_densities(sensor, x, x0, columns, across);
    filter_densities(sensor, y, y0, rows, down);
    for (int j = 0; j < rows; j++)
        for (int i = 0; i < columns; i++) {
            uint32_t pixel = (uint32_t)(y0 + j) * (uint32_t)sensor->crop_width + (uint32_t)(x0 + i);
            float w = across[i] * down[j];
            if (w > 0) list_push(list, pixel, rgb_scale(value, w));
        }
}

struct merge {
    const struct splat_list *lists;
    size_t list_count, pixel_count, band_count;
    float scale, *pixels;
};

static void merge_band(void *user, size_t band, int worker) {
    (void)worker;
    const struct merge *m = user;
    size_t begin = band * m->pixel_count / m->band_count, end = (band + 1) * m->pixel_count / m->band_count;
    for (size_t l = 0; l < m->list_count; l++) {
        const struct splat_list *list = &m->lists[l];
        for (size_t i = 0; i < list->count; i++) {
            const struct splat *splat = &list->items[i];
            if (splat->pixel < begin || splat->pixel >= end) continue;
            float *pixel = m->pixels + 3 * (size_t)splat->pixel;
            pixel[0] += m->scale * splat->value.r;
            pixel[1] += m->scale * splat->value.g;
            pixel[2] += m->scale * splat->value.b;
        }
    }
}

void splat_merge(const struct splat_list *lists, size_t list_count, float scale, float *pixels, size_t pixel_count,
                 int threads) {
    struct merge merge = {lists, list_count, pixel_count, (size_t)threads, scale, pixels};
    parallel_for(threads, merge.band_count, merge_band, &merge);
}

void splat_list_clear(struct splat_list *list) {
    list->count = 0;
    list->dropped = 0;
}

void splat_list_fini(struct splat_list *list) {
    free(list->items);
    *list = (struct splat_list){0};
}
