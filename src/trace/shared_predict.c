#include "trace/shared_predict.h"

#include <stdlib.h>
#include <string.h>

enum {
    LAYER_PLANES = 1 + 3 + 3 + SHARED_PARTS * (3 + 1 + 2), // the own variances are each layer's
    PART_PLANES = 3 * PREDICTIONS + PREDICTIONS,
    PLANES = SHARED_LAYERS * LAYER_PLANES + SHARED_PARTS * PART_PLANES + 1,
    ROWS = 1 + DISCS + TILTED * 5 + SHARED_PARTS * TILTED * 3 * 2
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
            for (int c = 0; c < 3; c++) take(part->tilt[t][c], 2, next, (size_t)band->width);
        for (int k = 1; k < SHARED_LAYERS; k++) {
            struct part_planes *other = &band->layers[k].parts[i];
            memcpy(other->prediction, part->prediction, sizeof part->prediction);
            memcpy(other->errors, part->errors, PREDICTIONS * sizeof *part->errors);
        }
    }
}

bool band_init(struct band *band, const struct shared_light *shared, const struct excess_list *outliers,
               float least_level) {
    const size_t width = (size_t)shared->width, size = width * MOST_ROWS;
    *band = (struct band){.shared = shared, .outliers = outliers, .width = shared->width, .least_level = least_level};
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
            take(layer->parts[i].light, 3, &next, size);
            take(&layer->parts[i].weight, 1, &next, size);
            take(layer->parts[i].errors + OWN_SAMPLES, 2, &next, size);
        }
    }
    take_predictions(band, &next, size);
    take(&band->level, 1, &next, size);
    take(&band->alike, 1, &next, width);
    take(band->counts, DISCS, &next, width);
    for (int t = 0; t < TILTED; t++) take(band->moments[t], 5, &next, width);
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

void band_fill(struct band *band, int first, int last) {
    const size_t size = (size_t)band->width * MOST_ROWS;
    band->first = first;
    band->last = last;
    memset(band->memory, 0, SHARED_LAYERS * LAYER_PLANES * size * sizeof *band->memory);
    memset(band->surfaces, 0, SHARED_LAYERS * size * sizeof *band->surfaces);
    for (int k = 0; k < SHARED_LAYERS; k++) {
        band->layers[k].met = false;
        for (int i = 0; i < SHARED_PARTS; i++) band->layers[k].parts[i].lit = false;
    }
    for (int y = first; y < last; y++) fill_row(band, y);
    for (int b = first / BAND; b * BAND < last; b++)
        for (size_t i = 0; i < band->outliers[b].count; i++) take_out(band, &band->outliers[b].items[i]);
}

// --- What its neighbours predict ---
// The likeness of a row of pixels to their neighbours at one offset, in columns x0 to x1, between the first layers.
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

struct offset { // from a row of pixels to their neighbours
    int dx, dy;
    ptrdiff_t away, x0, x1;
};

static void add_neighbours(const struct band *band, const float *plane, float *sum, float weight,
                           const struct offset *offset) {
    const float *restrict alike = band->alike, *restrict from = plane + offset->away;
    float *restrict to = sum;
    if (weight == 0) return;
    for (ptrdiff_t x = offset->x0; x < offset->x1; x++) to[x] += weight * alike[x] * from[x];
}

static void add_tilts(struct band *band, const struct offset *offset, size_t row, int t, float weight) {
    const struct layer *layer = &band->layers[0];
    const float x = weight * (float)offset->dx, y = weight * (float)offset->dy;
    const float moments[5] = {x, y, x * (float)offset->dx, x * (float)offset->dy, y * (float)offset->dy};
    for (int k = 0; k < 5; k++) add_neighbours(band, layer->count + row, band->moments[t][k], moments[k], offset);
    for (int i = 0; i < SHARED_PARTS; i++)
        for (int c = 0; c < 3 && layer->parts[i].lit; c++)
            for (int k = 0; k < 2; k++)
                add_neighbours(band, layer->parts[i].light[c] + row, layer->parts[i].tilt[t][c][k], moments[k], offset);
}

static void add_offset(struct band *band, int y, int dx, int dy) {
    const struct offset offset = {dx, dy, (ptrdiff_t)dy * band->width + dx, dx < 0 ? -dx : 0,
                                  dx > 0 ? band->width - dx : band->width};
    const size_t row = band_row(band, y);
    const struct layer *layer = &band->layers[0];
    if ((dx == 0 && dy == 0) || disc_kernel(WIDEST, dx, dy) <= 0 || offset.x0 >= offset.x1) return;
    compare(band, row, offset.away, offset.x0, offset.x1);
    for (int d = WIDEST; d >= 0 && disc_kernel(d, dx, dy) > 0; d--) {
        const float weight = disc_kernel(d, dx, dy);
        add_neighbours(band, layer->count + row, band->counts[d], weight, &offset);
        for (int i = 0; i < SHARED_PARTS; i++) {
            const struct part_planes *part = &layer->parts[i];
            for (int c = 0; c < 3 && part->lit; c++)
                add_neighbours(band, part->light[c] + row, part->prediction[d][c] + row, weight, &offset);
        }
        if (d > 0) add_tilts(band, &offset, row, d - 1, weight);
    }
}

static vec3 planes_at(float *const planes[3], size_t i) { return (vec3){planes[0][i], planes[1][i], planes[2][i]}; }

// For one pixel of a later layer, a neighbour in any.
static void add_neighbour(struct band *band, struct layer *layer, const struct layer *from, int x, int y, int dx,
                          int dy) {
    const size_t i = band_row(band, y) + (size_t)x, j = band_row(band, y + dy) + (size_t)(x + dx);
    if (layer->surface[i] != from->surface[j]) return;
    const float alike =
        likeness(planes_at(layer->p, i), planes_at(layer->n, i), planes_at(from->p, j), planes_at(from->n, j));
    for (int d = WIDEST; d >= 0 && alike > 0 && disc_kernel(d, dx, dy) > 0; d--) {
        const float weight = alike * disc_kernel(d, dx, dy);
        band->counts[d][x] += weight * from->count[j];
        for (int k = 0; k < SHARED_PARTS; k++)
            for (int c = 0; c < 3; c++) layer->parts[k].prediction[d][c][i] += weight * from->parts[k].light[c][j];
    }
}

static void add_neighbours_of(struct band *band, struct layer *layer, int x, int y, int dy) {
    for (int dx = maxi(-x, -REACH); dx <= REACH && x + dx < band->width; dx++)
        for (int k = 0; k < SHARED_LAYERS && (dx || dy); k++)
            add_neighbour(band, layer, &band->layers[k], x, y, dx, dy);
}

// Of the sums over a disc, of light and of light times columns and rows, the least squares' value here.
struct fit {
    float sum, columns, rows; // weights
};
static struct fit fit_plane(const struct band *band, int t, int x) {
    static const float least_spread = 0.01f; // of the moments, in terms of the count: pixels all in one row
    static const float least_sure = 0.05f; // below it the plane says little here
    const float count = band->counts[t + 1][x], mx = band->moments[t][0][x], my = band->moments[t][1][x];
    const float xx = band->moments[t][2][x] + least_spread * count, xy = band->moments[t][3][x];
    const float yy = band->moments[t][4][x] + least_spread * count, determinant = xx * yy - xy * xy;
    if (!(determinant > 0)) return (struct fit){1 / count, 0, 0};
    const float u = (mx * yy - my * xy) / determinant, v = (my * xx - mx * xy) / determinant;
    const float sure = count - u * mx - v * my;
    if (!(sure > least_sure * count)) return (struct fit){1 / count, 0, 0};
    return (struct fit){1 / sure, -u / sure, -v / sure};
}

static float nearest_level(const struct band *band, int x, int y) {
    float sum = 0;
    for (int v = maxi(y - 1, band->first); v <= y + 1 && v < band->last; v++)
        for (int u = maxi(x - 1, 0); u <= x + 1 && u < band->width; u++)
            sum += band->level[band_row(band, v) + (size_t)u];
    return sum / 9;
}

// Sums to values.
static void end_sums(const struct band *band, int layer_index, struct part_planes *part, size_t i, int x,
                     const struct fit fits[TILTED]) {
    for (int c = 0; c < 3; c++) {
        for (int t = 0; t < TILTED; t++) {
            const struct fit *fit = &fits[t];
            float value = fit->sum * part->prediction[t + 1][c][i];
            if (layer_index == 0) value += fit->columns * part->tilt[t][c][0][x] + fit->rows * part->tilt[t][c][1][x];
            part->prediction[DISCS + t][c][i] = maxf(value, 0);
        }
        for (int d = 0; d < DISCS; d++) part->prediction[d][c][i] /= band->counts[d][x];
    }
}

static void end_prediction(struct band *band, int layer_index, int x, int y) {
    struct layer *layer = &band->layers[layer_index];
    const size_t i = band_row(band, y) + (size_t)x;
    const float relative = 1 / sqrf(nearest_level(band, x, y) + band->least_level);
    const float factor = band->counts[0][x] > 0 ? relative : 0; // the other discs are larger
    struct fit fits[TILTED];
    for (int t = 0; t < TILTED; t++)
        fits[t] = layer_index == 0 ? fit_plane(band, t, x) : (struct fit){1 / band->counts[t + 1][x], 0, 0};
    for (int k = 0; k < SHARED_PARTS; k++) {
        struct part_planes *part = &layer->parts[k];
        if (!part->lit) continue;
        part->weight[i] *= factor;
        part->errors[OWN_SAMPLES][i] *= factor;
        part->errors[OWN_BATCHES][i] *= factor;
        if (!(part->weight[i] > 0)) continue;
        end_sums(band, layer_index, part, i, x, fits);
        for (int d = 0; d < PREDICTIONS; d++) {
            float apart[3];
            for (int c = 0; c < 3; c++)
                apart[c] = sqrf(part->prediction[d][c][i] - part->light[c][i] / layer->count[i]);
            part->errors[d][i] = part->weight[i] * rgb_luminance((rgb){apart[0], apart[1], apart[2]});
        }
    }
}

static void clear_row(struct band *band, struct layer *layer, int y) {
    const size_t size = (size_t)band->width * sizeof(float), row = band_row(band, y);
    for (int d = 0; d < DISCS; d++) memset(band->counts[d], 0, size);
    for (int t = 0; t < TILTED; t++)
        for (int k = 0; k < 5; k++) memset(band->moments[t][k], 0, size);
    for (int i = 0; i < SHARED_PARTS; i++) {
        struct part_planes *part = &layer->parts[i];
        for (int d = 0; d < DISCS; d++)
            for (int c = 0; c < 3; c++) memset(part->prediction[d][c] + row, 0, size);
        for (int t = 0; t < TILTED && layer == band->layers; t++)
            for (int c = 0; c < 3; c++)
                for (int k = 0; k < 2; k++) memset(part->tilt[t][c][k], 0, size);
    }
}

static void predict_row(struct band *band, int layer_index, int y) {
    struct layer *layer = &band->layers[layer_index];
    const int above = maxi(-REACH, band->first - y), below = mini(REACH, band->last - 1 - y);
    clear_row(band, layer, y);
    if (layer_index == 0) {
        for (int dy = above; dy <= below; dy++)
            for (int dx = -REACH; dx <= REACH; dx++) add_offset(band, y, dx, dy);
    } else {
        for (int x = 0; x < band->width; x++)
            for (int dy = above; dy <= below && layer->surface[band_row(band, y) + (size_t)x]; dy++)
                add_neighbours_of(band, layer, x, y, dy);
    }
    for (int x = 0; x < band->width; x++)
        if (layer->surface[band_row(band, y) + (size_t)x]) end_prediction(band, layer_index, x, y);
}

void band_predict(struct band *band, int layer, int first, int last) {
    for (int y = first; y < last; y++) predict_row(band, layer, y);
}
