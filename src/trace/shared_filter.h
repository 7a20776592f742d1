// What the files of shared_filter.c have in common: neighbours of a pixel, and light that it gives away.
#pragma once

#include <stdbool.h>

#include "math/lanes.h"
#include "trace/shared_light.h"

// Discs around a pixel, from the smallest to the widest.
enum { DISCS = 4, WIDEST = DISCS - 1, REACH = 7 }; // [pixels]
static const int disc_radii[DISCS] = {1, 2, 4, REACH}; // [pixels]
static inline float disc_kernel(int disc, int dx, int dy) {
    return 1 - (float)(dx * dx + dy * dy) / sqrf((float)disc_radii[disc] + 0.5f); // 0 and less: beyond the disc
}

// How much a neighbour at q with normal m counts at p with normal n, on one surface.
#define LEAST_COSINE 0.9f // at it they count nothing
#define OUT_OF_PLANE 0.1f // of their distance: how far the neighbour may lie from the pixel's plane
static inline float likeness(vec3 p, vec3 n, vec3 q, vec3 m) {
    const vec3 apart = vec3_sub(q, p);
    const bool in_plane = sqrf(vec3_dot(apart, n)) <= sqrf(OUT_OF_PLANE) * vec3_dot(apart, apart);
    return in_plane ? minf(maxf((vec3_dot(n, m) - LEAST_COSINE) / (1 - LEAST_COSINE), 0), 1) : 0;
}

static inline vec3 mean_point(const struct shared_surface *surface) {
    return vec3_scale((vec3){surface->p[0], surface->p[1], surface->p[2]}, 1 / surface->count);
}

static inline vec3 mean_normal(const struct shared_surface *surface) { // not finite if there is none
    return vec3_normalize((vec3){surface->n[0], surface->n[1], surface->n[2]});
}

// Of the luminance of a part's samples, about their mean.
static inline float sample_spread(const struct shared_surface *surface, int part) {
    const struct shared_part *sums = &surface->parts[part];
    const float inverse = 1 / surface->count;
    const rgb mean = rgb_scale((rgb){sums->light[0], sums->light[1], sums->light[2]}, inverse);
    return maxf(sums->squares * inverse - rgb_luminance(rgb_mul(mean, mean)), 0);
}

// Of the luminance of a part's mean, by its samples.
static inline float sample_variance(const struct shared_surface *surface, int part) {
    return sample_spread(surface, part) / maxf(surface->count - 1, 1);
}

// Adds to the picture a part's mean light at a pixel's surface, less the sums of what it holds of it already.
static inline void image_add_light(struct image *image, const struct shared_light *shared, float passes, size_t pixel,
                                   int layer, int part, const float light[3], const float products[3]) {
    const float *weights = shared->layers[layer][pixel].weights[part % SHARED_WEIGHTS];
    const float inverse = 1 / maxf(passes, shared->paths[pixel]);
    float *channels = &image->pixels[pixel * (size_t)image->channels];
    for (int c = 0; c < 3; c++) {
        const float change = (weights[c] * light[c] - products[c]) * inverse;
        channels[c] = maxf(channels[c] + change, minf(channels[c], 0)); // no less than 0 by rounding
    }
}

// Light that a pixel gives away to those around it.
struct excess {
    uint32_t pixel;
    uint8_t layer, part, disc;
    float light[3]; // of the sum
    float variance; // of the mean without it; of an outlier only
};
struct excess_list { // zeroed: empty
    struct excess *items;
    size_t count, capacity;
    bool out_of_memory;
};
void excess_add(struct excess_list *list, const struct excess *excess);
void excess_sort(struct excess_list *list); // by pixel

// Outliers: means far above what the pixels around would suggest because of few bright samples, in rows begin to end.
// Each keeps what its neighbours get in the mean, and gives away the rest.
void shared_find_outliers(const struct shared_light *shared, int begin, int end, struct excess_list *found);
// What a list's pixels give to rows begin to end of the picture: in proportion to the samples there, so none is lost.
void shared_spread(const struct shared_light *shared, float passes, const struct excess_list *list, int begin, int end,
                   struct image *image);
