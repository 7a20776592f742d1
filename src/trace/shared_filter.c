// What the picture gets of the light that pixels share. A pixel's neighbours predict it: by a mean over a disc, of the
// pixels in it that see the same surface and lie in its plane, without the pixel itself; or by the plane that fits
// their light best. The squared distance between the prediction and the pixel's own mean is then the sum of the errors
// of both, which are independent; less the variance of the own mean, it is the error of the prediction (leave-one-out
// cross-validation). Averaged over the pixels of the surface around it chooses the prediction, and that and the own
// mean are mixed by the inverse of their errors. So what the samples can tell apart stays apart, and the more samples,
// the less is shared.
// Own means that vary more than those around them, by a few bright samples, count less; what is taken from them goes to
// their neighbours, so that no light is lost. Outliers have been dealt with before (shared_outlier.c).
// The picture is made in bands of rows, each with planes of one float a pixel for itself and the rows around it, in
// layers: the surface that a pixel has met first, whose neighbours are sought among the first surfaces only, all pixels
// of a row at a time; and others at an edge or behind a gloss that mirrors, with neighbours in all layers.
#include <math.h>
#include <stdlib.h>

#include "base/parallel.h"
#include "trace/shared_band.h"

// An error that is far above what the window expects is the pixel's own: beside this number of variances, over the
// nearest nine pixels and at the pixel alone.
static const float doubt_near = 2, doubt_here = 9;
static const float dark = 0.05f; // of the mean level: errors at much lower ones are not counted the more for it
static const float noisy = 2; // own means of so many times the variance around them count less

struct mix {
    float own, taken; // share of the own mean; how much less than if it varied as those around it
    int prediction; // for the rest
};

// For some pixels of a row, means of the errors over the pixels of one surface in the window, and of those next to
// each.
struct averages {
    float window[ESTIMATES][LANE_COUNT], near[ESTIMATES][LANE_COUNT];
};

static struct averages average(const struct band *band, const struct layer *layer, const struct part_planes *part,
                               size_t x, int y) {
    const lanes_mask surface = lanes_load_bits(layer->surface + band_row(band, y) + x);
    lanes count = {0}, near_count = {0}, window[ESTIMATES] = {{0}}, near[ESTIMATES] = {{0}};
    for (int v = maxi(y - WINDOW, band->first); v <= y + WINDOW && v < band->last; v++)
        for (int dx = -WINDOW; dx <= WINDOW; dx++) {
            const size_t j = band_row(band, v) + x + (size_t)(ptrdiff_t)dx;
            const lanes_mask same =
                (lanes_load_bits(layer->surface + j) == surface) & (lanes_load(part->weight + j) > 0);
            const bool is_near = abs(dx) <= 1 && abs(v - y) <= 1;
            count += lanes_keep(lanes_splat(1), same);
            for (int k = 0; k < ESTIMATES; k++) window[k] += lanes_keep(lanes_load(part->errors[k] + j), same);
            if (!is_near) continue;
            near_count += lanes_keep(lanes_splat(1), same);
            for (int k = 0; k < ESTIMATES; k++) near[k] += lanes_keep(lanes_load(part->errors[k] + j), same);
        }
    struct averages averages;
    for (int k = 0; k < ESTIMATES; k++) {
        lanes_store(averages.window[k], window[k] / count);
        lanes_store(averages.near[k], near[k] / near_count);
    }
    return averages;
}

static struct mix choose(const struct part_planes *part, size_t i, const struct averages *averages, size_t lane) {
    float window[ESTIMATES], near[ESTIMATES];
    for (int k = 0; k < ESTIMATES; k++) {
        window[k] = averages->window[k][lane];
        near[k] = averages->near[k][lane];
    }
    int best = 0;
    for (int k = 1; k < PREDICTIONS; k++)
        if (window[k] < window[best]) best = k;
    const float variance = minf(window[OWN_SAMPLES], window[OWN_BATCHES]), own_variance = part->errors[OWN_SAMPLES][i];
    const float near_variance = maxf(variance, near[OWN_SAMPLES]);
    float error = maxf(window[best] - variance, 0);
    error = maxf(error, near[best] - doubt_near * near_variance);
    error = maxf(error, part->errors[best][i] - doubt_here * maxf(near_variance, own_variance));
    const float share = error / (error + variance);
    if (!(variance > 0 && share < 1)) return (struct mix){.own = 1}; // or anything has overflown
    const float own = own_variance > noisy * variance ? error / (error + own_variance) : share;
    return (struct mix){.own = own, .taken = share - own, .prediction = best};
}

static void give_away(const struct layer *layer, const struct part_planes *part, size_t i, const struct mix *mix,
                      struct excess excess, struct excess_list *list) {
    for (int c = 0; c < 3; c++)
        excess.light[c] = mix->taken * (part->light[c][i] - part->prediction[mix->prediction][c][i] * layer->count[i]);
    excess_add(list, &excess);
}

struct mixing { // of one part
    const struct band *band;
    int layer, part;
    float passes;
    struct image *image;
    struct excess_list *taken;
};

static void mix_pixel(const struct mixing *m, size_t i, size_t pixel, const struct mix *mix) {
    enum { disc = 2 };
    const struct layer *layer = &m->band->layers[m->layer];
    const struct part_planes *part = &layer->parts[m->part];
    float light[3];
    for (int c = 0; c < 3; c++)
        light[c] = mix->own * part->light[c][i] / layer->count[i] +
                   (mix->own < 1 ? (1 - mix->own) * part->prediction[mix->prediction][c][i] : 0);
    image_add_light(m->image, m->band->shared, m->passes, pixel, m->layer, m->part, light,
                    m->band->shared->layers[m->layer][pixel].parts[m->part].product);
    const struct excess excess = {
        .pixel = (uint32_t)pixel, .layer = (uint8_t)m->layer, .part = (uint8_t)m->part, .disc = disc};
    if (mix->taken > 0) give_away(layer, part, i, mix, excess, m->taken);
}

static void mix_row(const struct mixing *m, int y) {
    const struct layer *layer = &m->band->layers[m->layer];
    const struct part_planes *part = &layer->parts[m->part];
    const size_t row = band_row(m->band, y), width = (size_t)m->band->width;
    for (size_t x = 0; x < width; x += LANE_COUNT) {
        if (!lanes_any(lanes_load(part->weight + row + x) > 0)) continue;
        const struct averages averages = average(m->band, layer, part, x, y);
        for (size_t lane = 0; lane < LANE_COUNT && x + lane < width; lane++) {
            const size_t i = row + x + lane;
            if (!(part->weight[i] > 0)) continue;
            const struct mix mix = choose(part, i, &averages, lane);
            mix_pixel(m, i, (size_t)y * width + x + lane, &mix);
        }
    }
}

struct job {
    const struct shared_light *shared;
    struct image *image;
    float passes;
    struct band *bands; // one a worker
    struct excess_list *outliers, *taken; // of each band of the picture
    size_t done, count; // of the picture's bands
    int rows; // of a band, but perhaps of the last
};

static int band_begin(const struct job *job, size_t index) { return (int)index * job->rows; }
static int band_end(const struct job *job, size_t index) {
    return mini(band_begin(job, index + 1), job->shared->height);
}

static void find_outliers(void *user, size_t index, int worker) {
    (void)worker;
    const struct job *job = user;
    shared_find_outliers(job->shared, band_begin(job, index), band_end(job, index), &job->outliers[index]);
    excess_sort(&job->outliers[index]);
}

static void make_band(void *user, size_t index, int worker) {
    const struct job *job = user;
    struct band *band = &job->bands[worker];
    index += job->done;
    const int height = job->shared->height, begin = band_begin(job, index), end = band_end(job, index);
    const int first = maxi(begin - HALO, 0), last = mini(end + HALO, height);
    const size_t first_list = (size_t)(first / job->rows), last_list = (size_t)((last - 1) / job->rows);
    band_fill(band, first, last, first_list, last_list + 1 - first_list);
    for (int k = 0; k < SHARED_LAYERS && band->layers[k].met; k++) {
        band_predict(band, k, maxi(begin - WINDOW, 0), mini(end + WINDOW, height));
        for (int i = 0; i < SHARED_PARTS; i++) {
            const struct mixing mixing = {band, k, i, job->passes, job->image, &job->taken[index]};
            for (int y = begin; y < end && band->layers[k].parts[i].lit; y++) mix_row(&mixing, y);
        }
    }
    excess_sort(&job->taken[index]);
}

static void spread_in_band(void *user, size_t index, int worker) {
    (void)worker;
    const struct job *job = user;
    const int begin = band_begin(job, index), end = band_end(job, index);
    for (size_t i = index > 0 ? index - 1 : 0; i <= index + 1 && i < job->count; i++) { // of more rows than REACH
        shared_spread(job->shared, job->passes, &job->outliers[i], begin, end, job->image);
        shared_spread(job->shared, job->passes, &job->taken[i], begin, end, job->image);
    }
}

static float mean_level(const struct shared_light *shared) {
    double sum = 0;
    const size_t count = (size_t)shared->width * (size_t)shared->height;
    for (size_t i = 0; i < count; i++) sum += (double)pixel_level(shared, i);
    return (float)(sum / (double)count);
}

// False: out of memory.
static bool make_picture(struct job *job, size_t threads, const struct run *run) {
    enum { bands_at_once = 4, patience_s = 1 };
    const float least_level = dark * mean_level(job->shared);
    const double begin_s = clock_wall_s();
    bool ready = true;
    parallel_for((int)threads, job->count, find_outliers, job);
    for (size_t i = 0; ready && i < threads; i++)
        ready = band_init(&job->bands[i], job->shared, job->outliers, least_level);
    for (size_t some; ready && job->done < job->count; job->done += some) {
        const size_t left = job->count - job->done;
        some = left < bands_at_once * threads ? left : bands_at_once * threads;
        parallel_for((int)threads, some, make_band, job);
        const double elapsed_s = clock_wall_s() - begin_s;
        if (elapsed_s > patience_s)
            run_progress(run, "sharing", (double)(job->done + some) / (double)job->count, elapsed_s, NULL);
    }
    if (ready) parallel_for((int)threads, job->count, spread_in_band, job);
    for (size_t i = 0; i < job->count; i++)
        ready = ready && !job->outliers[i].out_of_memory && !job->taken[i].out_of_memory;
    return ready;
}

enum status shared_light_apply(const struct shared_light *shared, size_t passes, struct image *image,
                               const struct run *run, struct error *error) {
    // Some, of even work for the threads, and independent of their number.
    const int some = 4 * ((shared->height + 4 * BAND - 1) / (4 * BAND));
    const int rows = maxi((shared->height + some - 1) / some, REACH + 1);
    const size_t count = (size_t)((shared->height + rows - 1) / rows);
    const size_t threads = run->threads < 1 ? 1 : (size_t)run->threads < count ? (size_t)run->threads : count;
    struct job job = {.shared = shared, .image = image, .passes = (float)passes, .count = count, .rows = rows};
    job.bands = calloc(threads, sizeof *job.bands);
    job.outliers = calloc(count, sizeof *job.outliers);
    job.taken = calloc(count, sizeof *job.taken);
    const bool ready = job.bands && job.outliers && job.taken && make_picture(&job, threads, run);
    for (size_t i = 0; job.bands && i < threads; i++) band_fini(&job.bands[i]);
    for (size_t i = 0; job.outliers && i < count; i++) free(job.outliers[i].items);
    for (size_t i = 0; job.taken && i < count; i++) free(job.taken[i].items);
    free(job.bands);
    free(job.outliers);
    free(job.taken);
    if (ready) return STATUS_OK;
    return error_set(error, STATUS_MEMORY, "out of memory for sharing light between %d x %d pixels", shared->width,
                     shared->height);
}
