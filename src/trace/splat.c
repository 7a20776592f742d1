// Splats are weighted by the filter's density at the pixel, which has the same mean as film_sample.h's importance
// sampling of the same filter.
#include "trace/splat.h"

#include <stdlib.h>

#include "base/parallel.h"
#include "trace/film_sample.h"

static float filter_density(const struct sensor *sensor, float offset) { // of film_filter_offset [1/pixel]
    float r = sensor->filter_radius, x = fabsf(offset);
    if (x >= r) return 0;
    switch (sensor->filter) {
    case FILM_FILTER_TENT:
        return (1 - x / r) / r;
    case FILM_FILTER_GAUSSIAN: {
        float s = sensor->filter_stddev, norm = s * sqrtf(2 * PI_F) * erff(r / (s * sqrtf(2)));
        return expf(-0.5f * sqrf(x / s)) / norm;
    }
    default:
        return 0.5f / r;
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
    list->items[list->count++] = (struct splat){pixel, value};
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
    for (int j = y0; j <= y1; j++) {
        float wy = filter_density(sensor, (float)j + 0.5f - y);
        for (int i = x0; i <= x1; i++) {
            float w = wy * filter_density(sensor, (float)i + 0.5f - x);
            if (w > 0) list_push(list, (uint32_t)j * (uint32_t)sensor->crop_width + (uint32_t)i, rgb_scale(value, w));
        }
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
