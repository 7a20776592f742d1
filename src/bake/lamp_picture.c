// Each sample of a pixel is one line, the same for all three pictures.
#include "bake/lamp_picture.h"

#include <math.h>
#include <string.h>

#include "base/parallel.h"
#include "math/warp.h"
#include "trace/hull_look.h"

enum { BLOCK = 64, MAX_DEPTH = 100, GLIMPSES = 1 << MAX_SPLITS };

struct block { // one sample of neighbouring pixels of a row
    int count;
    float at[BLOCK][3], along[BLOCK][3]; // the lines
    struct sampler samplers[BLOCK]; // after the place in the pixel was drawn
};

static void place_lines(const struct lamp_picture *picture, int row, int column, size_t sample, struct block *block) {
    const struct lamp *lamp = picture->lamp;
    const vec3 center = {lamp->proxy.center[0], lamp->proxy.center[1], lamp->proxy.center[2]};
    const struct frame frame = frame_from_normal(picture->w);
    const int pixels = picture->reference->width;
    const float step = 2 * lamp->proxy.radius / (float)pixels;
    for (int i = 0; i < block->count; i++) {
        uint64_t stream = picture->stream | (uint64_t)row << 20 | (uint64_t)(column + i);
        struct sampler sampler = sampler_make(lamp->seed, stream, sample);
        vec2 u = sampler_2d(&sampler);
        float x = ((float)(column + i) + u.x - 0.5f * (float)pixels) * step;
        float y = (0.5f * (float)pixels - (float)row - u.y) * step;
        vec3 p = vec3_mad(frame.s, x, vec3_mad(frame.t, y, center));
        p = vec3_mad(picture->w, 1.001f * lamp->proxy.radius, p);
        memcpy(block->at[i], &(float[3]){p.x, p.y, p.z}, sizeof block->at[i]);
        memcpy(block->along[i], &(float[3]){picture->w.x, picture->w.y, picture->w.z}, sizeof block->along[i]);
        block->samplers[i] = sampler;
    }
}

static struct ray look_along(const struct lamp_picture *picture, const float at[3]) {
    return (struct ray){{at[0], at[1], at[2]}, vec3_neg(picture->w), 0, INFINITY};
}

static void add(float *pixel, const float radiance[3], float share) {
    for (int c = 0; c < 3; c++) pixel[c] += radiance[c] * share;
}

static void add_traced(const struct lamp_picture *picture, const struct block *block, float *pixels, float share) {
    const struct lamp *lamp = picture->lamp;
    for (int i = 0; i < block->count; i++) {
        struct ray ray = look_along(picture, block->at[i]);
        struct sampler sampler = block->samplers[i];
        struct line_hit hit;
        trace_line_radiance_split(lamp->scene, &ray, &sampler, lamp->aims, lamp->aim_count, MAX_DEPTH, MAX_SPLITS,
                                  &hit);
        add(pixels + 3 * i, (float[3]){hit.radiance.r, hit.radiance.g, hit.radiance.b}, share);
    }
}

static void add_model(const struct lamp_picture *picture, const struct block *block, float *pixels, float share) {
    float radiance[BLOCK][3];
    luminaire_eval(picture->luminaire, (size_t)block->count, block->at, block->along, radiance);
    for (int i = 0; i < block->count; i++)
        if (luminaire_seen(picture->luminaire, block->at[i], block->along[i])) add(pixels + 3 * i, radiance[i], share);
}

// Absorption in the hull's glass is left out.
static void add_surface(const struct lamp_picture *picture, const struct block *block, float *pixels, float share) {
    struct hull_glimpse seen[GLIMPSES];
    struct view_point points[BLOCK * GLIMPSES];
    float radiance[BLOCK * GLIMPSES][3], weights[BLOCK * GLIMPSES];
    int columns[BLOCK * GLIMPSES];
    size_t count = 0;
    const struct hull *hull = luminaire_hull(picture->luminaire);
    for (int i = 0; i < block->count; i++) {
        struct ray ray = look_along(picture, block->at[i]);
        struct sampler sampler = block->samplers[i];
        const size_t ways = hull_trace(picture->hull, hull, &ray, &sampler, MAX_SPLITS, seen);
        for (size_t k = 0; k < ways; k++, count++) {
            points[count] = seen[k].at;
            weights[count] = seen[k].weight;
            columns[count] = i;
        }
    }
    if (count) luminaire_view(picture->luminaire, count, points, radiance);
    for (size_t k = 0; k < count; k++) add(pixels + 3 * columns[k], radiance[k], share * weights[k]);
}

static void take_row(void *user, size_t row, int worker) {
    (void)worker;
    const struct lamp_picture *picture = user;
    const int pixels = picture->reference->width;
    const float share = 1 / (float)picture->samples;
    for (int column = 0; column < pixels; column += BLOCK)
        for (size_t k = 0; k < picture->samples; k++) {
            struct block block = {.count = pixels - column < BLOCK ? pixels - column : BLOCK};
            const size_t first = 3 * (row * (size_t)pixels + (size_t)column);
            place_lines(picture, (int)row, column, k, &block);
            add_traced(picture, &block, picture->reference->pixels + first, share);
            add_model(picture, &block, picture->model->pixels + first, share);
            if (picture->hull) add_surface(picture, &block, picture->surface->pixels + first, share);
        }
}

void lamp_picture_take(const struct lamp_picture *picture) {
    parallel_for(picture->lamp->threads, (size_t)picture->reference->height, take_row, (void *)picture);
}
