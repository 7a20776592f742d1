// What a pixel's neighbours predict. Of first surfaces the neighbours are sought among the first surfaces only, for
// several pixels of a row at a time: first which neighbours there are and how alike, then the sums of every plane over
// them, which stay in registers.
#include <stdlib.h>
#include <string.h>

#include "trace/shared_band.h"

// --- Several pixels of the first layer ---
struct neighbour { // of each of the pixels, at one offset
    lanes alike;
    const struct disc_offset *offset;
};
struct neighbours { // by the smallest disc that they are in
    int counts[DISCS];
    struct neighbour list[DISCS][MOST_OFFSETS];
};

struct disc_sums {
    lanes means[DISCS], tilts[TILTED][2];
};

static lanes alike_at(const struct layer *layer, size_t i, ptrdiff_t away) {
    const size_t j = i + (size_t)away;
    lanes normals = {0}, distance = {0}, out = {0};
    for (int c = 0; c < 3; c++) {
        const lanes n = lanes_load(layer->n[c] + i), m = lanes_load(layer->n[c] + j);
        const lanes apart = lanes_load(layer->p[c] + j) - lanes_load(layer->p[c] + i);
        normals += n * m;
        out += apart * n;
        distance += apart * apart;
    }
    const lanes like = lanes_min((normals - LEAST_COSINE) / (1 - LEAST_COSINE), lanes_splat(1));
    const lanes_mask same = lanes_load_bits(layer->surface + i) == lanes_load_bits(layer->surface + j);
    return lanes_keep(like, same & (like > 0) & (out * out <= OUT_OF_PLANE * OUT_OF_PLANE * distance));
}

static void find_neighbours(const struct band *band, size_t i, int above, int below, struct neighbours *found) {
    memset(found->counts, 0, sizeof found->counts);
    for (int k = 0; k < band->offset_count; k++) {
        const struct disc_offset *offset = &band->offsets[k];
        if (offset->dy < above || offset->dy > below) continue;
        const lanes alike = alike_at(&band->layers[0], i, offset->away);
        if (lanes_any(alike > 0))
            found->list[offset->disc][found->counts[offset->disc]++] = (struct neighbour){alike, offset};
    }
}

// The neighbours whose smallest disc is `disc`; inlined, so that the loops over discs vanish.
static inline __attribute__((always_inline)) void add_ring(const struct neighbours *found, const float *plane, int disc,
                                                           struct disc_sums *sums) {
    struct disc_sums s = *sums;
    for (int i = 0; i < found->counts[disc]; i++) {
        const struct disc_offset *offset = found->list[disc][i].offset;
        const lanes value = found->list[disc][i].alike * lanes_load(plane + offset->away);
        const lanes x = value * (float)offset->dx, y = value * (float)offset->dy;
        for (int d = disc; d < DISCS; d++) s.means[d] += value * offset->weights[d];
        for (int d = disc > 1 ? disc : 1; d < DISCS; d++) {
            s.tilts[d - 1][0] += x * offset->weights[d];
            s.tilts[d - 1][1] += y * offset->weights[d];
        }
    }
    *sums = s;
}

static struct disc_sums sum_plane(const struct neighbours *found, const float *plane) {
    struct disc_sums sums = {0};
    _Static_assert(DISCS == 4, "one call for each disc");
    add_ring(found, plane, 0, &sums);
    add_ring(found, plane, 1, &sums);
    add_ring(found, plane, 2, &sums);
    add_ring(found, plane, 3, &sums);
    return sums;
}

static void sum_counts(const struct band *band, const struct neighbours *found, size_t i, size_t x) {
    const float *plane = band->layers[0].count + i;
    const struct disc_sums sums = sum_plane(found, plane);
    lanes squares[TILTED][3] = {0};
    for (int disc = 0; disc < DISCS; disc++)
        for (int k = 0; k < found->counts[disc]; k++) {
            const struct disc_offset *offset = found->list[disc][k].offset;
            const lanes value = found->list[disc][k].alike * lanes_load(plane + offset->away);
            const float dx = (float)offset->dx, dy = (float)offset->dy, products[3] = {dx * dx, dx * dy, dy * dy};
            for (int d = maxi(disc, 1); d < DISCS; d++)
                for (int p = 0; p < 3; p++) squares[d - 1][p] += value * (products[p] * offset->weights[d]);
        }
    for (int d = 0; d < DISCS; d++) lanes_store(band->counts[d] + x, sums.means[d]);
    for (int t = 0; t < TILTED; t++)
        for (int m = 0; m < MOMENTS; m++)
            lanes_store(band->moments[t][m] + x, m < 2 ? sums.tilts[t][m] : squares[t][m - 2]);
}

static void sum_part(const struct part_planes *part, const struct neighbours *found, size_t i, size_t x) {
    for (int c = 0; c < 3; c++) {
        const struct disc_sums sums = sum_plane(found, part->light[c] + i);
        for (int d = 0; d < DISCS; d++) lanes_store(part->prediction[d][c] + i, sums.means[d]);
        for (int t = 0; t < TILTED; t++)
            for (int k = 0; k < 2; k++) lanes_store(part->tilt[t][c][k] + x, sums.tilts[t][k]);
    }
}

static void sum_first_layer(struct band *band, int y, int above, int below) {
    struct neighbours found;
    for (size_t x = 0; x < (size_t)band->width; x += LANE_COUNT) {
        const size_t i = band_row(band, y) + x;
        find_neighbours(band, i, above, below, &found);
        sum_counts(band, &found, i, x);
        for (int k = 0; k < SHARED_PARTS; k++)
            if (band->layers[0].parts[k].lit) sum_part(&band->layers[0].parts[k], &found, i, x);
    }
}

// --- One pixel of a later layer ---
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

// --- From sums to predictions ---
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
    const size_t size = band->stride * sizeof(float), row = band_row(band, y);
    for (int d = 0; d < DISCS; d++) memset(band->counts[d], 0, size);
    for (int i = 0; i < SHARED_PARTS; i++)
        for (int d = 0; d < DISCS; d++)
            for (int c = 0; c < 3; c++)
                memset(layer->parts[i].prediction[d][c] + row, 0, (size_t)band->width * sizeof(float));
}

static void predict_row(struct band *band, int layer_index, int y) {
    struct layer *layer = &band->layers[layer_index];
    const int above = maxi(-REACH, band->first - y), below = mini(REACH, band->last - 1 - y);
    if (layer_index == 0) {
        sum_first_layer(band, y, above, below);
    } else {
        clear_row(band, layer, y);
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
