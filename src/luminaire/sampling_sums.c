// The images of a sampling density. A distance is chosen freely for every line in every distance bin: the point there
// on the line is a shading point that sees it, so the sums of a cell are proportional to L, whatever the cell's size.
// A pixel is one density, so where its light varies the least variance has not the mean but the root of the mean square
// of L (the minimum of the sum of E[L^2] / p over pixels of one size whose p sum to one).
#include "luminaire/sampling_sums.h"

#include <stdlib.h>

#include "base/parallel.h"
#include "math/sampler.h"
#include "math/warp.h"

static const double spread_lines = 100; // among the pixels of a cell
static const float distance_low[DISTANCE_BINS] = {1.01f, 1.4f, 2.5f}, distance_high[DISTANCE_BINS] = {1.4f, 2.5f, 8};

enum status sampling_sums_init(struct sampling_sums *sums, struct sampling_density *density, struct error *error) {
    const size_t cells = sampling_cell_count(density);
    *sums = (struct sampling_sums){.density = density};
    sums->light = calloc(cells * MAP_PIXELS, sizeof *sums->light);
    sums->squares = calloc(cells * MAP_PIXELS, sizeof *sums->squares);
    sums->anchors = calloc(cells, sizeof *sums->anchors);
    sums->measure = calloc(cells, sizeof *sums->measure);
    sums->weights = calloc(cells, sizeof *sums->weights);
    if (sums->light && sums->squares && sums->anchors && sums->measure && sums->weights) return STATUS_OK;
    sampling_sums_fini(sums);
    return error_set(error, STATUS_MEMORY, "out of memory for the images of a sampling density");
}

void sampling_sums_fini(struct sampling_sums *sums) {
    free(sums->light);
    free(sums->squares);
    free(sums->anchors);
    free(sums->measure);
    free(sums->weights);
    *sums = (struct sampling_sums){0};
}

float sampling_mean(const float channels[3]) {
    const float mean = (channels[0] + channels[1] + channels[2]) / 3;
    return mean > 0 && isfinite(mean) ? mean : 0;
}

// --- Anchors ---
int sampling_nearest_anchor(const struct sampling_density *density, vec3 point, vec3 w, float *distance) {
    float best = INFINITY;
    int nearest = -1;
    for (int i = 0; i < density->anchor_count; i++) {
        const float *anchor = density->anchors[i];
        vec3 d = vec3_sub(point, vec3_from(anchor));
        vec3 across = vec3_mad(w, -vec3_dot(d, w), d);
        float d2 = vec3_dot(across, across);
        if (d2 < best) best = d2, nearest = i;
    }
    *distance = sqrtf(best);
    return nearest;
}

int sampling_anchor_of(const struct sampling_density *density, vec3 point, vec3 w) {
    float distance;
    const int anchor = sampling_nearest_anchor(density, point, w, &distance);
    return distance <= density->cone_radius[CONE_COUNT - 1] ? anchor : -1;
}

void sampling_add_intensity(struct sampling_density *density, const struct sampling_line *line) {
    vec2 square = octahedral_from_direction(line->w);
    int x = (int)(square.x * INTENSITY_SIDE), y = (int)(square.y * INTENSITY_SIDE);
    x = x < INTENSITY_SIDE ? x : INTENSITY_SIDE - 1, y = y < INTENSITY_SIDE ? y : INTENSITY_SIDE - 1;
    density->intensity[line->anchor * INTENSITY_CELLS + y * INTENSITY_SIDE + x] += line->flux;
}

void sampling_end_intensities(struct sampling_density *density) {
    const int count = density->anchor_count * INTENSITY_CELLS;
    double total = 0;
    for (int i = 0; i < count; i++) total += (double)density->intensity[i];
    // A tenth of the mean everywhere: no direction of an anchor goes unsampled.
    const float floor_value = count ? (float)(0.1 * total / count) : 0;
    for (int i = 0; i < count; i++)
        density->intensity[i] = (density->intensity[i] + floor_value) / (float)(total > 0 ? total : 1);
}

// --- Images ---
static void splat(struct sampling_sums *sums, const struct sampling_line *line, vec3 s, float flux) {
    struct sampling_view view = sampling_view_make(sums->density, s);
    vec2 p;
    if (!sampling_image_from_direction(&view, vec3_neg(line->w), &p)) return;
    if (line->radiance > 0) sums->measure[view.cell] += (double)(flux / line->radiance);
    if (line->anchor >= 0) {
        sums->anchors[view.cell] += (double)flux;
        return;
    }
    int x = (int)(p.x * MAP_SIDE), y = (int)(p.y * MAP_SIDE);
    x = x < MAP_SIDE ? x : MAP_SIDE - 1, y = y < MAP_SIDE ? y : MAP_SIDE - 1;
    const size_t pixel = view.cell * MAP_PIXELS + (size_t)(y * MAP_SIDE + x);
    sums->light[pixel] += flux;
    sums->squares[pixel] += flux * line->radiance;
    sums->weights[view.cell] += (double)flux * (double)flux;
}

struct adding {
    struct sampling_sums *sums;
    const struct sampling_line *lines;
    size_t count, first;
    int repeats;
    uint64_t seed;
};

// One distance bin (DISTANCE_BINS: the inside): its cells are written by this call alone.
static void add_to_bin(void *user, size_t bin, int worker) {
    (void)worker;
    const struct adding *adding = user;
    const struct sampling_density *density = adding->sums->density;
    const float radius2 = density->radius * density->radius;
    for (size_t i = 0; i < adding->count; i++) {
        const struct sampling_line *line = &adding->lines[i];
        struct sampler sampler = sampler_make(adding->seed, 0x73616d70 + bin, adding->first + i);
        const vec3 w = line->w, p = vec3_sub(line->point, density->center);
        const float along = vec3_dot(p, w);
        const vec3 q = vec3_mad(w, -along, p);
        const float q2 = vec3_dot(q, q);
        if (!(q2 < radius2)) continue;
        for (int k = 0; k < adding->repeats; k++) {
            float u = sampler_1d(&sampler);
            if (bin == DISTANCE_BINS) { // anywhere on the chord, by its length
                float half = sqrtf(radius2 - q2);
                vec3 s = vec3_add(density->center, vec3_mad(w, half * (2 * u - 1), q));
                splat(adding->sums, line, s, line->flux * half);
            } else { // a sphere of this radius is crossed at a cosine: fluence is flux over it
                float distance =
                    density->radius * (distance_low[bin] * powf(distance_high[bin] / distance_low[bin], u));
                float t = sqrtf(distance * distance - q2);
                splat(adding->sums, line, vec3_add(density->center, vec3_mad(w, t, q)), line->flux * distance / t);
            }
        }
    }
}

void sampling_sums_add(struct sampling_sums *sums, const struct sampling_line *lines, size_t count, size_t first,
                       int repeats, uint64_t seed, int threads) {
    struct adding adding = {sums, lines, count, first, repeats, seed};
    parallel_for(threads, DISTANCE_BINS + 1, add_to_bin, &adding);
}

// What a pixel is worth, of the unit of `light`; returns the sum.
static double weigh_pixels(const struct sampling_sums *sums, size_t cell, float worth[MAP_PIXELS]) {
    const float *light = sums->light + cell * MAP_PIXELS, *squares = sums->squares + cell * MAP_PIXELS;
    const float measure = (float)(sums->measure[cell] / MAP_PIXELS);
    double sum = 0, all = 0;
    for (int i = 0; i < MAP_PIXELS; i++) {
        worth[i] = fmaxf(sqrtf(squares[i] * measure), light[i]);
        all += (double)light[i];
        sum += (double)worth[i];
    }
    // Where few lines are known, chance alone would leave pixels dark that are not: as if a few more were known, spread
    // evenly.
    const double known = sums->weights[cell] > 0 ? all * all / sums->weights[cell] : 0;
    const float spread = (float)(sum * spread_lines / ((known + 1) * MAP_PIXELS));
    for (int i = 0; i < MAP_PIXELS; i++) worth[i] += spread;
    return sum;
}

void sampling_sums_encode(const struct sampling_sums *sums) {
    struct sampling_density *density = sums->density;
    for (size_t cell = 0; cell < sampling_cell_count(density); cell++) {
        float worth[MAP_PIXELS], largest = 0;
        const double sum = weigh_pixels(sums, cell, worth);
        for (int i = 0; i < MAP_PIXELS; i++) largest = fmaxf(largest, worth[i]);
        for (int i = 0; i < MAP_PIXELS; i++) {
            int code = worth[i] > 0 ? (int)lrintf(15 * sqrtf(worth[i] / largest)) : 0;
            code = worth[i] > 0 && code == 0 ? 1 : code;
            density->codes[cell * MAP_BYTES + (size_t)i / 2] |= (uint8_t)(code << (i & 1 ? 4 : 0));
        }
        double total = sum + sums->anchors[cell], share = total > 0 ? sum / total : 0.5;
        density->residual_share[cell] = (uint8_t)lrint(255 * (share < 0.03 ? 0.03 : share > 0.97 ? 0.97 : share));
    }
    sampling_derive(density);
}
