// The pattern of light on a wall: the lamp's particles are caught on it, the luminaire lights it as a renderer would,
// by samples of its density. Both are noisy at this resolution (a pixel is 1/64 radius wide), so both come as two
// independent halves, and products of differences of different halves have the squared error as their mean. FLIP knows
// no such way: it sees both maps through a Gaussian of 2 pixels and is extrapolated to no noise.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/parallel.h"
#include "bake/evaluate_private.h"

enum { PIXELS = EVALUATION_PIXELS, REACH = 4 };
static const float distance_radii = 2, half_width_radii = 2;
static const double floor_relative = 1e-3; // of the squared mean, added to the squared reference in relMSE

enum status wall_init(struct wall *wall, const struct lamp *lamp, struct error *error) {
    const float *center = lamp->proxy.center;
    *wall = (struct wall){.center = {center[0], center[1], center[2]}, .radius = lamp->proxy.radius};
    return image_pair_init(&wall->exits, error);
}

void wall_fini(struct wall *wall) { image_pair_fini(&wall->exits); }

// The wall faces the lamp from +x; rows follow -z, columns y.
void wall_add(struct wall *wall, const struct exit_list *list, int half) {
    float *pixels = wall->exits.half[half].pixels;
    const float distance = distance_radii * wall->radius, scale = 0.5f * PIXELS / (half_width_radii * wall->radius);
    for (size_t i = 0; i < list->count; i++) {
        const struct line_exit *exit = &list->exits[i];
        if (!(exit->w[0] > 0)) continue;
        float t = (distance - (exit->point[0] - wall->center.x)) / exit->w[0];
        float column = (exit->point[1] + t * exit->w[1] - wall->center.y) * scale + 0.5f * PIXELS;
        float row = 0.5f * PIXELS - (exit->point[2] + t * exit->w[2] - wall->center.z) * scale;
        if (!(column >= 0 && column < PIXELS && row >= 0 && row < PIXELS)) continue;
        float *pixel = pixels + 3 * ((size_t)row * PIXELS + (size_t)column);
        for (int c = 0; c < 3; c++) pixel[c] += exit->flux[c];
    }
    wall->emitted[half] += list->emitted;
}

struct wall_job {
    const struct wall *wall;
    const struct luminaire *luminaire;
    uint64_t seed;
    size_t samples; // of each half of a pixel
    struct image_pair *model;
    float (*scratch)[13]; // of each worker: s, u, direction, radiance, pdf
};

static void light_row(void *user, size_t row, int worker) {
    const struct wall_job *job = user;
    const struct wall *wall = job->wall;
    const size_t n = job->samples;
    float *block = job->scratch[(size_t)worker * n];
    float(*s)[3] = (float(*)[3])block, (*u)[3] = s + n, (*direction)[3] = u + n, (*radiance)[3] = direction + n;
    float *pdf = block + 12 * n;
    const float step = 2 * half_width_radii * wall->radius / PIXELS;
    for (size_t column = 0; column < PIXELS; column++)
        for (int half = 0; half < 2; half++) {
            uint64_t stream =
                (uint64_t)STREAM_EVALUATION << 56 | 4ull << 48 | (uint64_t)half << 40 | row << 20 | column;
            for (size_t i = 0; i < n; i++) {
                struct sampler sampler = sampler_make(job->seed, stream, i);
                vec2 at = sampler_2d(&sampler);
                s[i][0] = wall->center.x + distance_radii * wall->radius;
                s[i][1] = wall->center.y + ((float)column + at.x - 0.5f * PIXELS) * step;
                s[i][2] = wall->center.z - ((float)row + at.y - 0.5f * PIXELS) * step;
                vec2 first = sampler_2d(&sampler);
                u[i][0] = first.x, u[i][1] = first.y, u[i][2] = sampler_1d(&sampler);
            }
            luminaire_sample(job->luminaire, n, (const float(*)[3])s, (const float(*)[3])u, direction, pdf);
            for (size_t i = 0; i < n; i++)
                for (int a = 0; a < 3; a++) u[i][a] = -direction[i][a];
            luminaire_eval(job->luminaire, n, (const float(*)[3])s, (const float(*)[3])u, radiance);
            double sum[3] = {0, 0, 0};
            for (size_t i = 0; i < n; i++) {
                float weight = fmaxf(0, -direction[i][0]) / pdf[i];
                for (int c = 0; c < 3; c++) sum[c] += (double)(radiance[i][c] * weight);
            }
            float *pixel = job->model->half[half].pixels + 3 * (row * PIXELS + column);
            for (int c = 0; c < 3; c++) pixel[c] = (float)(sum[c] / (double)n);
        }
}

static void smooth_rows(const float *from, float *to, size_t step, size_t stride) { // `step` between pixels of a row
    static const float weights[] = {0.2042f, 0.1802f, 0.1238f, 0.0663f, 0.0276f}; // Gaussian of standard deviation 2
    for (size_t row = 0; row < PIXELS; row++)
        for (int i = 0; i < PIXELS; i++)
            for (size_t c = 0; c < 3; c++) {
                float sum = 0, total = 0;
                for (int k = -4; k <= 4; k++) {
                    if (i + k < 0 || i + k >= PIXELS) continue;
                    float weight = weights[k < 0 ? -k : k];
                    sum += weight * from[row * stride + (size_t)(i + k) * step + c];
                    total += weight;
                }
                to[row * stride + (size_t)i * step + c] = sum / total;
            }
}

static enum status smooth_pair(struct image_pair *pair, struct error *error) {
    struct image rows = {0};
    enum status status = image_init(&rows, PIXELS, PIXELS, 3, error);
    for (int h = 0; h < 2 && status == STATUS_OK; h++) {
        smooth_rows(pair->half[h].pixels, rows.pixels, 3, 3 * PIXELS);
        smooth_rows(rows.pixels, pair->half[h].pixels, 3 * PIXELS, 3);
    }
    image_fini(&rows);
    return status;
}

static enum status light_wall(const struct wall *wall, const struct luminaire *luminaire, const struct lamp *lamp,
                              int samples, struct image_pair *model, struct error *error) {
    size_t n = samples < 2 ? 1 : (size_t)samples / 2;
    struct wall_job job = {wall, luminaire, lamp->seed,
                           n,    model,     malloc((size_t)lamp->threads * n * sizeof *job.scratch)};
    if (!job.scratch) return error_set(error, STATUS_MEMORY, "out of memory for the evaluation");
    parallel_for(lamp->threads, PIXELS, light_row, &job);
    free(job.scratch);
    return STATUS_OK;
}

// The flux that was caught, as irradiance; both maps in units of the reference's mean.
static void normalise(struct wall *wall, struct image_pair *model) {
    const double area = pow(2 * (double)(half_width_radii * wall->radius) / PIXELS, 2);
    double mean = 0;
    for (int h = 0; h < 2; h++) {
        double scale = 1 / (area * (double)wall->emitted[h]);
        for (size_t i = 0; i < 3 * PIXELS * PIXELS; i++) {
            float *value = &wall->exits.half[h].pixels[i];
            *value = (float)((double)*value * scale);
            mean += (double)*value / (2.0 * 3 * PIXELS * PIXELS);
        }
    }
    if (!(mean > 0)) return;
    for (int h = 0; h < 2; h++)
        for (size_t i = 0; i < 3 * PIXELS * PIXELS; i++) {
            wall->exits.half[h].pixels[i] = (float)((double)wall->exits.half[h].pixels[i] / mean);
            model->half[h].pixels[i] = (float)((double)model->half[h].pixels[i] / mean);
        }
}

// Mean of the reference over the pixels within REACH: a denominator whose noise is small.
static double smooth_reference(const struct wall *wall, int row, int column, int c) {
    double sum = 0;
    int count = 0;
    for (int y = row - REACH < 0 ? 0 : row - REACH; y <= row + REACH && y < PIXELS; y++)
        for (int x = column - REACH < 0 ? 0 : column - REACH; x <= column + REACH && x < PIXELS; x++, count++)
            for (int h = 0; h < 2; h++) sum += (double)wall->exits.half[h].pixels[3 * (y * PIXELS + x) + c];
    return sum / (2 * count);
}

enum status wall_compare(struct wall *wall, const struct luminaire *luminaire, const struct lamp *lamp, int samples,
                         struct evaluation *evaluation, struct error *error) {
    struct image_pair model;
    enum status status = image_pair_init(&model, error);
    if (status == STATUS_OK) status = light_wall(wall, luminaire, lamp, samples, &model, error);
    if (status == STATUS_OK) {
        normalise(wall, &model);
        double squared = 0, noise = 0, flip, flip_noise, black;
        for (int row = 0; row < PIXELS; row++)
            for (int column = 0; column < PIXELS; column++)
                for (int c = 0; c < 3; c++) {
                    size_t i = 3 * (size_t)(row * PIXELS + column) + (size_t)c;
                    double a0 = (double)model.half[0].pixels[i], a1 = (double)model.half[1].pixels[i];
                    double r0 = (double)wall->exits.half[0].pixels[i], r1 = (double)wall->exits.half[1].pixels[i];
                    double r = smooth_reference(wall, row, column, c), weight = 1 / (r * r + floor_relative);
                    squared += (a0 - r0) * (a1 - r1) * weight;
                    noise += 0.25 * ((a0 - a1) * (a0 - a1) + (r0 - r1) * (r0 - r1)) * weight;
                }
        evaluation->wall_relmse = (float)(squared / (3.0 * PIXELS * PIXELS));
        evaluation->wall_relmse_noise = (float)(noise / (3.0 * PIXELS * PIXELS));
        status = smooth_pair(&model, error);
        if (status == STATUS_OK) status = smooth_pair(&wall->exits, error);
        if (status == STATUS_OK) status = image_pair_flip(&model, &wall->exits, &flip, &flip_noise, &black, error);
        evaluation->wall_flip = (float)flip;
        evaluation->wall_flip_noise = (float)flip_noise;
        evaluation->wall_measured = status == STATUS_OK;
    }
    image_pair_fini(&model);
    return status;
}
