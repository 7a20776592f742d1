// What the picture gets of the light that pixels share. A pixel's neighbours predict it: a mean over a disc, of the
// pixels in it that see the same surface and lie in its plane, without the pixel itself. The squared distance between
// the prediction and the pixel's own mean is then the sum of the errors of both, which are independent; less the
// variance of the own mean, it is the error of the prediction (leave-one-out cross-validation). Averaged over a window
// around the pixel it chooses the disc, and own mean and prediction are mixed by the inverse of their errors. So what
// the samples can tell apart stays apart, and the more samples, the less is shared.
// The picture is made in bands of rows, each with planes of one float a pixel for itself and the rows around it, in two
// layers: the surface that a pixel has met first, whose neighbours are sought among the first surfaces only, all pixels
// of a row at a time; and another at an edge or behind a gloss that mirrors, with neighbours in both layers.
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

struct layer {
    uint32_t *surface; // 0: shares nothing
    float *count, *p[3], *n[3];
    struct part_planes parts[SHARED_PARTS];
    bool met; // else there is nothing in it
};

struct band {
    const struct shared_light *shared;
    struct image *image;
    float passes;
    int width, first, last; // rows that it holds
    struct layer layers[SHARED_LAYERS];
    float *level; // luminance of all that is shared
    float least_level; // is added to it
    float *sums[ESTIMATES]; // of one part's errors, along rows
    float *alike, *counts[DISCS]; // one row
    float *memory; // of all but the surfaces
    uint32_t *surfaces;
};
enum {
    PART_PLANES = 3 + 1 + 3 * DISCS + ESTIMATES,
    LAYER_PLANES = 1 + 3 + 3 + SHARED_PARTS * PART_PLANES,
    PLANES = SHARED_LAYERS * LAYER_PLANES + 1 + ESTIMATES,
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
    band->surfaces = malloc(SHARED_LAYERS * size * sizeof *band->surfaces);
    if (!next || !band->surfaces) return false;
    for (size_t k = 0; k < SHARED_LAYERS; k++) {
        struct layer *layer = &band->layers[k];
        layer->surface = band->surfaces + k * size;
        take(&layer->count, 1, &next, size);
        take(layer->p, 3, &next, size);
        take(layer->n, 3, &next, size);
        for (int i = 0; i < SHARED_PARTS; i++) {
            struct part_planes *part = &layer->parts[i];
            take(part->light, 3, &next, size);
            take(&part->weight, 1, &next, size);
            for (int d = 0; d < DISCS; d++) take(part->prediction[d], 3, &next, size);
            take(part->errors, ESTIMATES, &next, size);
        }
    }
    take(&band->level, 1, &next, size);
    take(band->sums, ESTIMATES, &next, size);
    take(&band->alike, 1, &next, width);
    take(band->counts, DISCS, &next, width);
    return true;
}

static void band_clear(struct band *band) {
    const size_t width = (size_t)band->width, size = width * MOST_ROWS;
    memset(band->memory, 0, (PLANES * size + ROWS * width) * sizeof *band->memory);
    memset(band->surfaces, 0, SHARED_LAYERS * size * sizeof *band->surfaces);
    for (int k = 0; k < SHARED_LAYERS; k++) {
        band->layers[k].met = false;
        for (int i = 0; i < SHARED_PARTS; i++) band->layers[k].parts[i].lit = false;
    }
}

static size_t row_at(const struct band *band, int y) { return (size_t)(y - band->first) * (size_t)band->width; }

// --- What is known of each pixel ---
static void fill_part(struct part_planes *planes, size_t i, const struct shared_surface *surface,
                      const struct shared_part *part, const float weights[3], float paths) {
    const float inverse = 1 / surface->count;
    const rgb sum = {part->light[0], part->light[1], part->light[2]}, own = rgb_scale(sum, inverse);
    const float weight = sqrf(rgb_luminance((rgb){weights[0], weights[1], weights[2]}) / paths);
    const float spread = maxf(part->squares * inverse - rgb_luminance(rgb_mul(own, own)), 0);
    for (int c = 0; c < 3; c++) planes->light[c][i] = part->light[c];
    planes->lit |= rgb_luminance(sum) > 0;
    planes->weight[i] = weight;
    planes->errors[OWN_SAMPLES][i] = weight * spread / maxf(surface->count - 1, 1);
    planes->errors[OWN_BATCHES][i] = planes->errors[OWN_SAMPLES][i];
    // The paths told so far are whole batches and the running one, none of them empty.
    const float batches = ceilf(paths / SHARED_BATCH) - 1, running = paths - SHARED_BATCH * batches;
    if (paths < 2 * SHARED_BATCH) return;
    const float total = rgb_luminance(sum), share = total / paths, full = share * SHARED_BATCH;
    const float squares = part->batch_squares - 2 * full * (total - part->batch) + batches * sqrf(full);
    const float independent = 1 - (batches * SHARED_BATCH * SHARED_BATCH + sqrf(running)) / sqrf(paths);
    const float variance = (maxf(squares, 0) + sqrf(part->batch - running * share)) / independent;
    planes->errors[OWN_BATCHES][i] = weight * variance * sqrf(inverse);
}

static void fill_pixel(struct layer *layer, size_t i, const struct shared_surface *surface, float paths) {
    const float inverse = 1 / surface->count;
    const vec3 n = vec3_normalize((vec3){surface->n[0], surface->n[1], surface->n[2]});
    if (!vec3_is_finite(n)) return;
    layer->met = true;
    layer->surface[i] = surface->surface;
    layer->count[i] = surface->count;
    for (int c = 0; c < 3; c++) layer->p[c][i] = surface->p[c] * inverse;
    layer->n[0][i] = n.x;
    layer->n[1][i] = n.y;
    layer->n[2][i] = n.z;
    for (int k = 0; k < SHARED_PARTS; k++) fill_part(&layer->parts[k], i, surface, &surface->parts[k], surface->weights[k % SHARED_WEIGHTS], paths);
}

static float pixel_level(const struct shared_light *shared, size_t pixel) {
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
        const size_t pixel = (size_t)y * (size_t)band->width + x, i = row_at(band, y) + x;
        band->level[i] = pixel_level(band->shared, pixel);
        for (int k = 0; k < SHARED_LAYERS; k++) {
            const struct shared_surface *surface = &band->shared->layers[k][pixel];
            if (surface->surface) fill_pixel(&band->layers[k], i, surface, band->shared->paths[pixel]);
        }
    }
}

// --- What its neighbours predict ---
static float kernel(int disc, int dx, int dy) {
    return 1 - (float)(dx * dx + dy * dy) / sqrf(radii[disc] + 0.5f); // 0 and less: beyond the disc
}

// How much a neighbour at q with normal m counts at p with normal n, on one surface.
static inline float likeness(vec3 p, vec3 n, vec3 q, vec3 m) {
    const vec3 apart = vec3_sub(q, p);
    const bool in_plane = sqrf(vec3_dot(apart, n)) <= sqrf(out_of_plane) * vec3_dot(apart, apart);
    return in_plane ? minf(maxf((vec3_dot(n, m) - least_cosine) / (1 - least_cosine), 0), 1) : 0;
}

// The same for a row of pixels and their neighbours at one offset, in columns x0 to x1, between the first layers.
static void compare(const struct band *band, size_t row, ptrdiff_t away, ptrdiff_t x0, ptrdiff_t x1) {
    const struct layer *layer = &band->layers[0];
    const uint32_t *restrict surface = layer->surface + row;
    const float *restrict px = layer->p[0] + row, *restrict py = layer->p[1] + row, *restrict pz = layer->p[2] + row;
    const float *restrict nx = layer->n[0] + row, *restrict ny = layer->n[1] + row, *restrict nz = layer->n[2] + row;
    float *restrict alike = band->alike;
    for (ptrdiff_t x = x0; x < x1; x++) {
        const ptrdiff_t i = x + away;
        const float like = likeness((vec3){px[x], py[x], pz[x]}, (vec3){nx[x], ny[x], nz[x]},
                                    (vec3){px[i], py[i], pz[i]}, (vec3){nx[i], ny[i], nz[i]});
        alike[x] = surface[x] == surface[i] ? like : 0;
    }
}

static void add_neighbours(const struct band *band, const float *plane, float *sum, float weight, ptrdiff_t away,
                           ptrdiff_t x0, ptrdiff_t x1) {
    const float *restrict alike = band->alike, *restrict from = plane + away;
    float *restrict to = sum;
    for (ptrdiff_t x = x0; x < x1; x++) to[x] += weight * alike[x] * from[x];
}

static void add_offset(struct band *band, int y, int dx, int dy) {
    const ptrdiff_t away = (ptrdiff_t)dy * band->width + dx;
    const ptrdiff_t x0 = dx < 0 ? -dx : 0, x1 = dx > 0 ? band->width - dx : band->width;
    const size_t row = row_at(band, y);
    const struct layer *layer = &band->layers[0];
    if ((dx == 0 && dy == 0) || kernel(DISCS - 1, dx, dy) <= 0 || x0 >= x1) return;
    compare(band, row, away, x0, x1);
    for (int d = DISCS - 1; d >= 0 && kernel(d, dx, dy) > 0; d--) {
        const float weight = kernel(d, dx, dy);
        add_neighbours(band, layer->count + row, band->counts[d], weight, away, x0, x1);
        for (int i = 0; i < SHARED_PARTS; i++) {
            const struct part_planes *part = &layer->parts[i];
            for (int c = 0; c < 3 && part->lit; c++)
                add_neighbours(band, part->light[c] + row, part->prediction[d][c] + row, weight, away, x0, x1);
        }
    }
}

static vec3 planes_at(float *const planes[3], size_t i) { return (vec3){planes[0][i], planes[1][i], planes[2][i]}; }

// For one pixel of a later layer, a neighbour in any.
static void add_neighbour(struct band *band, struct layer *layer, const struct layer *from, int x, int y, int dx,
                          int dy) {
    const size_t i = row_at(band, y) + (size_t)x, j = row_at(band, y + dy) + (size_t)(x + dx);
    if (layer->surface[i] != from->surface[j]) return;
    const float alike =
        likeness(planes_at(layer->p, i), planes_at(layer->n, i), planes_at(from->p, j), planes_at(from->n, j));
    for (int d = DISCS - 1; d >= 0 && alike > 0 && kernel(d, dx, dy) > 0; d--) {
        const float weight = alike * kernel(d, dx, dy);
        band->counts[d][x] += weight * from->count[j];
        for (int k = 0; k < SHARED_PARTS; k++)
            for (int c = 0; c < 3; c++) layer->parts[k].prediction[d][c][i] += weight * from->parts[k].light[c][j];
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

// Sums to means, and how far they are off.
static void end_prediction(struct band *band, struct layer *layer, int x, int y) {
    const size_t i = row_at(band, y) + (size_t)x;
    const float relative = 1 / sqrf(nearest_mean(band, band->level, x, y) + band->least_level);
    const float factor = band->counts[0][x] > 0 ? relative : 0; // the other discs are larger
    for (int k = 0; k < SHARED_PARTS; k++) {
        struct part_planes *part = &layer->parts[k];
        if (!part->lit) continue;
        part->weight[i] *= factor;
        part->errors[OWN_SAMPLES][i] *= factor;
        part->errors[OWN_BATCHES][i] *= factor;
        for (int d = 0; part->weight[i] > 0 && d < DISCS; d++) {
            float apart[3];
            for (int c = 0; c < 3; c++) {
                float *prediction = &part->prediction[d][c][i];
                *prediction /= band->counts[d][x];
                apart[c] = sqrf(*prediction - part->light[c][i] / layer->count[i]);
            }
            part->errors[d][i] = part->weight[i] * rgb_luminance((rgb){apart[0], apart[1], apart[2]});
        }
    }
}

static void add_neighbours_of(struct band *band, struct layer *layer, int x, int y, int dy) {
    const int begin = x < REACH ? -x : -REACH, end = x + REACH < band->width ? REACH : band->width - 1 - x;
    for (int dx = begin; dx <= end; dx++)
        for (int k = 0; k < SHARED_LAYERS && (dx || dy); k++)
            add_neighbour(band, layer, &band->layers[k], x, y, dx, dy);
}

static void predict_row(struct band *band, int layer_index, int y) {
    struct layer *layer = &band->layers[layer_index];
    const int above = y - REACH > band->first ? -REACH : band->first - y;
    const int below = y + REACH < band->last ? REACH : band->last - 1 - y;
    for (int d = 0; d < DISCS; d++) memset(band->counts[d], 0, (size_t)band->width * sizeof(float));
    if (layer_index == 0) {
        for (int dy = above; dy <= below; dy++)
            for (int dx = -REACH; dx <= REACH; dx++) add_offset(band, y, dx, dy);
    } else {
        for (int x = 0; x < band->width; x++)
            for (int dy = above; dy <= below && layer->surface[row_at(band, y) + (size_t)x]; dy++)
                add_neighbours_of(band, layer, x, y, dy);
    }
    for (int x = 0; x < band->width; x++)
        if (layer->surface[row_at(band, y) + (size_t)x]) end_prediction(band, layer, x, y);
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

static void mix_row(const struct band *band, int layer_index, int part_index, int y) {
    const struct layer *layer = &band->layers[layer_index];
    const struct part_planes *part = &layer->parts[part_index];
    const size_t row = row_at(band, y);
    for (int x = 0; x < band->width; x++) {
        const size_t i = row + (size_t)x, index = (size_t)y * (size_t)band->width + (size_t)x;
        if (!(part->weight[i] > 0)) continue;
        int disc = 0;
        const float own = own_share(band, part, x, y, &disc);
        const struct shared_surface *surface = &band->shared->layers[layer_index][index];
        const float *weights = surface->weights[part_index % SHARED_WEIGHTS];
        const float *products = surface->parts[part_index].product;
        const float passes = maxf(band->passes, band->shared->paths[index]);
        float *channels = &band->image->pixels[index * (size_t)band->image->channels];
        for (int c = 0; c < 3; c++) {
            const float light = own * part->light[c][i] / layer->count[i] + (1 - own) * part->prediction[disc][c][i];
            const float change = (weights[c] * light - products[c]) / passes;
            channels[c] = maxf(channels[c] + change, minf(channels[c], 0)); // no less than 0 by rounding
        }
    }
}

struct job {
    struct band *bands; // one a worker
    size_t done; // of the picture's
};

static void make_band(void *user, size_t index, int worker) {
    const struct job *job = user;
    struct band *band = &job->bands[worker];
    const int height = band->shared->height, begin = (int)(job->done + index) * BAND;
    const int end = begin + BAND < height ? begin + BAND : height;
    const int first = begin > WINDOW ? begin - WINDOW : 0, last = end + WINDOW < height ? end + WINDOW : height;
    band->first = begin > HALO ? begin - HALO : 0;
    band->last = end + HALO < height ? end + HALO : height;
    band_clear(band);
    for (int y = band->first; y < band->last; y++) fill_row(band, y);
    for (int k = 0; k < SHARED_LAYERS && band->layers[k].met; k++) {
        for (int y = first; y < last; y++) predict_row(band, k, y);
        for (int i = 0; i < SHARED_PARTS; i++) {
            const struct part_planes *part = &band->layers[k].parts[i];
            for (int y = first; y < last && part->lit; y++) sum_along(band, part, y);
            for (int y = begin; y < end && part->lit; y++) mix_row(band, k, i, y);
        }
    }
}

static float mean_level(const struct shared_light *shared) {
    double sum = 0;
    const size_t count = (size_t)shared->width * (size_t)shared->height;
    for (size_t i = 0; i < count; i++) sum += (double)pixel_level(shared, i);
    return (float)(sum / (double)count);
}

enum status shared_light_apply(const struct shared_light *shared, size_t passes, struct image *image,
                               const struct run *run, struct error *error) {
    enum { bands_at_once = 4, patience_s = 1 };
    const size_t count = (size_t)(shared->height + BAND - 1) / BAND;
    const size_t threads = run->threads < 1 ? 1 : (size_t)run->threads < count ? (size_t)run->threads : count;
    const float least_level = dark * mean_level(shared);
    const double begin_s = clock_wall_s();
    struct job job = {.bands = calloc(threads, sizeof *job.bands)};
    bool ready = job.bands;
    for (size_t i = 0; ready && i < threads; i++) ready = band_init(&job.bands[i], shared, image, passes, least_level);
    for (size_t some; ready && job.done < count; job.done += some) {
        const size_t left = count - job.done;
        some = left < bands_at_once * threads ? left : bands_at_once * threads;
        parallel_for((int)threads, some, make_band, &job);
        const double elapsed_s = clock_wall_s() - begin_s;
        if (elapsed_s > patience_s)
            run_progress(run, "sharing", (double)(job.done + some) / (double)count, elapsed_s, NULL);
    }
    for (size_t i = 0; job.bands && i < threads; i++) {
        free(job.bands[i].memory);
        free(job.bands[i].surfaces);
    }
    free(job.bands);
    if (ready) return STATUS_OK;
    return error_set(error, STATUS_MEMORY, "out of memory for sharing light between %d x %d pixels", shared->width,
                     shared->height);
}
