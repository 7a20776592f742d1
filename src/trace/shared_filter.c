// What the picture gets of the light that pixels share. A pixel's neighbours predict it: a mean over a disc, of the
// pixels in it that see the same surface and lie in its plane, without the pixel itself. The squared distance between
// the prediction and the pixel's own mean is then the sum of the errors of both, which are independent; less the
// variance of the own mean, it is the error of the prediction (leave-one-out cross-validation). Averaged over a window
// around the pixel it chooses the disc, and own mean and prediction are mixed by the inverse of their errors. So what
// the samples can tell apart stays apart, and the more samples, the less is shared.
// The picture is made in bands of rows, each with planes of one float a pixel for itself and the rows around it.
#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "base/parallel.h"
#include "trace/shared_light.h"

enum { DISCS = 4, REACH = 7, WINDOW = 3, BAND = 32 }; // [pixels] but the first
static const float radii[DISCS] = {1, 2, 4, REACH};
static const float least_cosine = 0.9f; // between neighbours' normals; at it they count nothing
static const float out_of_plane = 0.1f; // of a neighbour's distance: how far it may lie from the pixel's plane
// An error that is far above what the window expects is the pixel's own: beside this number of variances, over the
// nearest nine pixels and at the pixel alone.
static const float doubt_near = 2, doubt_here = 4;
static const float dark = 0.05f; // of the mean level: errors at much lower ones are not counted the more for it

enum estimate { OWN_SAMPLES = DISCS, OWN_BATCHES, ESTIMATES }; // after the discs
struct part_planes {
    bool lit; // else there is nothing to share
    float *light[3]; // sums
    float *weight; // squared luminance of the mean weight; in the end relative, as the errors
    float *prediction[DISCS][3];
    // As the picture would have them, in the end relative to its level there: squared distances from the discs'
    // predictions to the own mean; the variance of that by its samples and by its batches, of which either may be too
    // large.
    float *errors[ESTIMATES];
};

struct band {
    const struct shared_light *shared;
    struct image *image;
    float passes;
    int width, first, last; // rows that it holds
    uint32_t *surface; // 0: shares nothing
    float *count, *p[3], *n[3];
    float *level; // luminance of all that is shared
    float least_level; // is added to it
    struct part_planes parts[SHARED_PARTS];
    float *sums[ESTIMATES]; // of one part's errors, along rows
    float *alike, *counts[DISCS]; // one row
    float *memory; // of all
};
enum {
    PART_PLANES = 3 + 1 + 3 * DISCS + ESTIMATES,
    PLANES = 1 + 3 + 3 + 1 + SHARED_PARTS * PART_PLANES + ESTIMATES,
    ROWS = 1 + DISCS
};

static void take(float **planes, size_t count, float **next, size_t size) {
    for (size_t i = 0; i < count; i++, *next += size) planes[i] = *next;
}

enum { HALO = WINDOW + REACH, MOST_ROWS = BAND + 2 * HALO };

static bool band_init(struct band *band, const struct shared_light *shared, struct image *image, size_t passes,
                      float least_level) {
    const size_t width = (size_t)shared->width, size = width * MOST_ROWS;
    *band = (struct band){
        .shared = shared, .image = image, .passes = (float)passes, .width = shared->width, .least_level = least_level};
    float *next = band->memory = malloc((PLANES * size + ROWS * width) * sizeof *band->memory);
    band->surface = malloc(size * sizeof *band->surface);
    if (!next || !band->surface) return false;
    take(&band->count, 1, &next, size);
    take(band->p, 3, &next, size);
    take(band->n, 3, &next, size);
    take(&band->level, 1, &next, size);
    take(band->sums, ESTIMATES, &next, size);
    for (int i = 0; i < SHARED_PARTS; i++) {
        struct part_planes *part = &band->parts[i];
        take(part->light, 3, &next, size);
        take(&part->weight, 1, &next, size);
        for (int k = 0; k < DISCS; k++) take(part->prediction[k], 3, &next, size);
        take(part->errors, ESTIMATES, &next, size);
    }
    take(&band->alike, 1, &next, width);
    take(band->counts, DISCS, &next, width);
    return true;
}

static void band_clear(struct band *band) {
    const size_t width = (size_t)band->width, size = width * MOST_ROWS;
    memset(band->memory, 0, (PLANES * size + ROWS * width) * sizeof *band->memory);
    memset(band->surface, 0, size * sizeof *band->surface);
    for (int i = 0; i < SHARED_PARTS; i++) band->parts[i].lit = false;
}

static size_t row_at(const struct band *band, int y) { return (size_t)(y - band->first) * (size_t)band->width; }

// --- What is known of each pixel ---
static void fill_part(struct part_planes *planes, size_t i, const struct shared_pixel *pixel,
                      const struct shared_part *part) {
    const float inverse = 1 / pixel->count;
    const rgb sum = {part->light[0], part->light[1], part->light[2]}, own = rgb_scale(sum, inverse);
    const float weight = sqrf(rgb_luminance((rgb){part->weight[0], part->weight[1], part->weight[2]}) / pixel->paths);
    const float spread = maxf(part->squares * inverse - rgb_luminance(rgb_mul(own, own)), 0);
    const float batches = ceilf(pixel->paths / SHARED_BATCH) - 1, batched = pixel->count - pixel->batch_count;
    for (int c = 0; c < 3; c++) planes->light[c][i] = part->light[c];
    planes->lit |= rgb_luminance(sum) > 0;
    planes->weight[i] = weight;
    planes->errors[OWN_SAMPLES][i] = weight * spread / maxf(pixel->count - 1, 1);
    planes->errors[OWN_BATCHES][i] = planes->errors[OWN_SAMPLES][i];
    if (batches < 2 || !(batched > 0)) return;
    const float mean = (rgb_luminance(sum) - part->batch) / batches;
    const float variance = maxf(part->batch_squares / batches - mean * mean, 0) / (batches - 1);
    planes->errors[OWN_BATCHES][i] = weight * variance * sqrf(batches / batched);
}

static float pixel_level(const struct shared_pixel *pixel) {
    float sum = 0;
    for (int i = 0; i < SHARED_PARTS; i++) {
        const float *product = pixel->parts[i].product;
        sum += rgb_luminance((rgb){product[0], product[1], product[2]});
    }
    return sum / pixel->paths;
}

static void fill_row(struct band *band, int y) {
    const size_t row = row_at(band, y);
    for (size_t x = 0; x < (size_t)band->width; x++) {
        const struct shared_pixel *pixel = &band->shared->pixels[(size_t)y * (size_t)band->width + x];
        if (!(pixel->count > 0)) continue;
        const float inverse = 1 / pixel->count;
        const vec3 n = vec3_normalize((vec3){pixel->n[0], pixel->n[1], pixel->n[2]});
        if (!vec3_is_finite(n)) continue;
        band->surface[row + x] = pixel->surface;
        band->count[row + x] = pixel->count;
        band->level[row + x] = pixel_level(pixel);
        for (int c = 0; c < 3; c++) band->p[c][row + x] = pixel->p[c] * inverse;
        band->n[0][row + x] = n.x;
        band->n[1][row + x] = n.y;
        band->n[2][row + x] = n.z;
        for (int i = 0; i < SHARED_PARTS; i++) fill_part(&band->parts[i], row + x, pixel, &pixel->parts[i]);
    }
}

// --- What its neighbours predict ---
// How much the neighbours at an offset count for the pixels in columns x0 to x1 of a row.
static void compare(const struct band *band, size_t row, ptrdiff_t away, ptrdiff_t x0, ptrdiff_t x1) {
    const uint32_t *restrict surface = band->surface + row;
    const float *restrict px = band->p[0] + row, *restrict py = band->p[1] + row, *restrict pz = band->p[2] + row;
    const float *restrict nx = band->n[0] + row, *restrict ny = band->n[1] + row, *restrict nz = band->n[2] + row;
    float *restrict alike = band->alike;
    for (ptrdiff_t x = x0; x < x1; x++) {
        const float cosine = nx[x] * nx[x + away] + ny[x] * ny[x + away] + nz[x] * nz[x + away];
        const float u = px[x + away] - px[x], v = py[x + away] - py[x], w = pz[x + away] - pz[x];
        const float height = u * nx[x] + v * ny[x] + w * nz[x];
        const bool in_plane = height * height <= out_of_plane * out_of_plane * (u * u + v * v + w * w);
        const float fit = minf(maxf((cosine - least_cosine) / (1 - least_cosine), 0), 1);
        alike[x] = in_plane && surface[x] == surface[x + away] ? fit : 0;
    }
}

static void add_neighbours(const struct band *band, const float *plane, float *sum, float kernel, ptrdiff_t away,
                           ptrdiff_t x0, ptrdiff_t x1) {
    const float *restrict alike = band->alike, *restrict from = plane + away;
    float *restrict to = sum;
    for (ptrdiff_t x = x0; x < x1; x++) to[x] += kernel * alike[x] * from[x];
}

static void add_offset(struct band *band, int y, int dx, int dy) {
    const float apart2 = (float)(dx * dx + dy * dy);
    const ptrdiff_t away = (ptrdiff_t)dy * band->width + dx;
    const ptrdiff_t x0 = dx < 0 ? -dx : 0, x1 = dx > 0 ? band->width - dx : band->width;
    const size_t row = row_at(band, y);
    if (apart2 == 0 || apart2 >= sqrf(REACH + 0.5f) || x0 >= x1) return;
    compare(band, row, away, x0, x1);
    for (int k = DISCS - 1; k >= 0 && apart2 < sqrf(radii[k] + 0.5f); k--) {
        const float kernel = 1 - apart2 / sqrf(radii[k] + 0.5f);
        add_neighbours(band, band->count + row, band->counts[k], kernel, away, x0, x1);
        for (int i = 0; i < SHARED_PARTS; i++) {
            const struct part_planes *part = &band->parts[i];
            for (int c = 0; c < 3 && part->lit; c++)
                add_neighbours(band, part->light[c] + row, part->prediction[k][c] + row, kernel, away, x0, x1);
        }
    }
}

static float nearest_mean(const struct band *band, const float *plane, int x, int y) {
    float sum = 0;
    for (int v = y - 1; v <= y + 1; v++)
        for (int u = x - 1; u <= x + 1; u++)
            if (v >= band->first && v < band->last && u >= 0 && u < band->width)
                sum += plane[row_at(band, v) + (size_t)u];
    return sum / 9;
}

static void predict_row(struct band *band, int y) {
    const size_t row = row_at(band, y);
    for (int k = 0; k < DISCS; k++) memset(band->counts[k], 0, (size_t)band->width * sizeof(float));
    for (int dy = -REACH; dy <= REACH; dy++)
        for (int dx = -REACH; dx <= REACH && y + dy >= band->first && y + dy < band->last; dx++)
            add_offset(band, y, dx, dy);
    for (int i = 0; i < SHARED_PARTS; i++) {
        struct part_planes *part = &band->parts[i];
        for (size_t x = 0; x < (size_t)band->width && part->lit; x++) {
            const float relative = 1 / sqrf(nearest_mean(band, band->level, (int)x, y) + band->least_level);
            const float factor = band->counts[0][x] > 0 ? relative : 0; // the other discs are larger
            part->weight[row + x] *= factor;
            part->errors[OWN_SAMPLES][row + x] *= factor;
            part->errors[OWN_BATCHES][row + x] *= factor;
            for (int k = 0; part->weight[row + x] > 0 && k < DISCS; k++) {
                float apart[3];
                for (int c = 0; c < 3; c++) {
                    float *prediction = &part->prediction[k][c][row + x];
                    *prediction /= band->counts[k][x];
                    apart[c] = sqrf(*prediction - part->light[c][row + x] / band->count[row + x]);
                }
                part->errors[k][row + x] = part->weight[row + x] * rgb_luminance((rgb){apart[0], apart[1], apart[2]});
            }
        }
    }
}

// --- What is made of both ---
static void sum_along(const struct band *band, const struct part_planes *part, int y) {
    const size_t row = row_at(band, y);
    const int width = band->width;
    for (int k = 0; k < ESTIMATES; k++) {
        const float *from = part->errors[k] + row;
        for (int x = 0; x < width; x++) {
            float sum = 0;
            for (int u = x > WINDOW ? x - WINDOW : 0; u <= x + WINDOW && u < width; u++) sum += from[u];
            band->sums[k][row + (size_t)x] = sum;
        }
    }
}

// Mean over the window, but for rows and columns beyond the picture, which count as 0.
static float window_mean(const struct band *band, int estimate, int x, int y) {
    float sum = 0;
    for (int v = y - WINDOW; v <= y + WINDOW; v++)
        if (v >= band->first && v < band->last) sum += band->sums[estimate][row_at(band, v) + (size_t)x];
    return sum / ((2 * WINDOW + 1) * (2 * WINDOW + 1));
}

// The share of the pixel's own mean, and the disc for the rest.
static float own_share(const struct band *band, const struct part_planes *part, int x, int y, int *disc) {
    const size_t i = row_at(band, y) + (size_t)x;
    float distance = INFINITY;
    for (int k = 0; k < DISCS; k++) {
        const float mean = window_mean(band, k, x, y);
        if (mean >= distance) continue;
        distance = mean;
        *disc = k;
    }
    const float variance = minf(window_mean(band, OWN_SAMPLES, x, y), window_mean(band, OWN_BATCHES, x, y));
    const float near = maxf(variance, nearest_mean(band, part->errors[OWN_SAMPLES], x, y));
    const float here = maxf(near, part->errors[OWN_SAMPLES][i]);
    const float *distances = part->errors[*disc];
    float error = maxf(distance - variance, 0);
    error = maxf(error, nearest_mean(band, distances, x, y) - doubt_near * near);
    error = maxf(error, distances[i] - doubt_here * here);
    const float share = error / (error + variance);
    return variance > 0 && share < 1 ? share : 1; // 1 if anything has overflown
}

static void mix_row(const struct band *band, int part_index, int y) {
    const struct part_planes *part = &band->parts[part_index];
    const size_t row = row_at(band, y);
    for (int x = 0; x < band->width; x++) {
        const size_t i = row + (size_t)x, index = (size_t)y * (size_t)band->width + (size_t)x;
        if (!(part->weight[i] > 0)) continue;
        int disc = 0;
        const float own = own_share(band, part, x, y, &disc);
        const struct shared_pixel *pixel = &band->shared->pixels[index];
        const struct shared_part *sums = &pixel->parts[part_index];
        float *channels = &band->image->pixels[index * (size_t)band->image->channels];
        for (int c = 0; c < 3; c++) {
            const float light = own * part->light[c][i] / pixel->count + (1 - own) * part->prediction[disc][c][i];
            const float change = (sums->weight[c] * light - sums->product[c]) / maxf(band->passes, pixel->paths);
            channels[c] = maxf(channels[c] + change, minf(channels[c], 0)); // no less than 0 by rounding
        }
    }
}

static void make_band(void *user, size_t index, int worker) {
    struct band *band = (struct band *)user + worker;
    const int height = band->shared->height, begin = (int)index * BAND;
    const int end = begin + BAND < height ? begin + BAND : height;
    const int first = begin > WINDOW ? begin - WINDOW : 0, last = end + WINDOW < height ? end + WINDOW : height;
    band->first = begin > HALO ? begin - HALO : 0;
    band->last = end + HALO < height ? end + HALO : height;
    band_clear(band);
    for (int y = band->first; y < band->last; y++) fill_row(band, y);
    for (int y = first; y < last; y++) predict_row(band, y);
    for (int i = 0; i < SHARED_PARTS; i++) {
        if (!band->parts[i].lit) continue;
        for (int y = first; y < last; y++) sum_along(band, &band->parts[i], y);
        for (int y = begin; y < end; y++) mix_row(band, i, y);
    }
}

static float mean_level(const struct shared_light *shared) {
    double sum = 0;
    const size_t count = (size_t)shared->width * (size_t)shared->height;
    for (size_t i = 0; i < count; i++)
        if (shared->pixels[i].paths > 0) sum += (double)pixel_level(&shared->pixels[i]);
    return (float)(sum / (double)count);
}

enum status shared_light_apply(const struct shared_light *shared, size_t passes, struct image *image, int threads,
                               struct error *error) {
    const size_t count = (size_t)(shared->height + BAND - 1) / BAND;
    if (threads < 1) threads = 1;
    if ((size_t)threads > count) threads = (int)count;
    const float least_level = dark * mean_level(shared);
    struct band *bands = calloc((size_t)threads, sizeof *bands);
    bool ready = bands;
    for (int i = 0; ready && i < threads; i++) ready = band_init(&bands[i], shared, image, passes, least_level);
    if (ready) parallel_for(threads, count, make_band, bands);
    for (int i = 0; bands && i < threads; i++) {
        free(bands[i].memory);
        free(bands[i].surface);
    }
    free(bands);
    if (ready) return STATUS_OK;
    return error_set(error, STATUS_MEMORY, "out of memory for sharing light between %d x %d pixels", shared->width,
                     shared->height);
}
